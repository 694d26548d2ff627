"""Fretting of a rod in parts over a crank cycle: what rubs in its joint and seats.

Of the parts on both sides, the stress of rod or cap counts, as a crack in a lining does not end the rod.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from fea.analysis.bolt_seats import bolt_seats
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.surface_stress import TouchingPlaces, surface_stress
from fea.analysis.cycle.unit_solutions import distinct
from fea.analysis.fretting_figures import (
    BoltSeatFigures,
    FrettingChangeFigures,
    FrettingFigures,
    FrettingPairFigures,
    FrettingPlaceFigures,
)
from fea.analysis.prepared_rod import PreparedRod
from fea.base.note import Note, omission, warning
from fea.base.units import DEG, KN, UM
from fea.contact.assembled import InterfaceVertices
from fea.contact.fretting import Rubbing, facets_across
from fea.judge.safety_factor import without_bar
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.arrays import Floats, Ints, Mask, vector
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from mesh.tetmesh import MirroredMesh

# The pairs that touch with friction, by the first surface.
PAIRS = {
    Surface.JOINT: "joint",
    Surface.BUSHING_SEAT: "seat of the bushing",
    Surface.SHELL_SEAT: "seat of the shells",
}
# Facets that must span a zone of slip for a factor; places named of each pair.
FEWEST_FACETS, _PLACES = 4, 3
# Share of the largest slip of a pair beyond which a place belongs to the zone of slip.
_SLIPS = 0.01
# Slip that is left after the last cycle, over the largest, beyond which it has not settled.
_CREEPS = 0.1
# Friction of dry steel that has rubbed, and by how much more crush helps or not.
_DRY, _CRUSHED = 0.7, 1.2
AS_GIVEN = "as it is"
_PRESSED_IN = omission(
    "fretting of the pin that is pressed in",
    "of a pin in contact only the radial displacement is solved, and its slip is that of both surfaces",
)


@dataclass(frozen=True)
class FrettingResult:
    """What rubs at k places of the whole rod's half z ≥ 0, n instants, and the stress of rod or cap there."""

    rubbing: Rubbing
    vertices: InterfaceVertices  #: the places
    surfaces: tuple[Surface, ...]  #: first one of each pair
    angles: Floats  #: (n,) rad
    parts: tuple[str, ...]  #: names
    part: Ints  #: (k,) number of the part whose stress it is
    tension: Floats  #: (k, n) largest stress along the surface, MPa
    factor: Floats  #: (k,) by Crossland; NaN where strengths are not known or nothing slips
    radius: Floats  #: (k,) of the half ball that stress is averaged over, mm
    whole: MirroredMesh  #: the whole rod
    counts: Mask  #: (k,) which are away from stress singularities
    changes: Mapping[str, Rubbing] = field(default_factory=dict)  #: what else was solved, in words
    bolt_seats: Mapping[str, BoltSeatFigures] = field(default_factory=dict)  #: of heads and nuts
    proven: float | None = None  #: σ τδ that has served, MPa²·mm
    power: Floats | None = None  #: (k,) mean over the duty of the study, W/mm²

    @cached_property
    def across(self) -> Ints:
        """Facets (k,) that span the zone of slip."""
        return facets_across(self.slips, self.vertices.facets)

    @cached_property
    def slips(self) -> Mask:
        """Which places (k,) slip by more than a share of what their pair does at most."""
        most = np.zeros(len(self.surfaces))
        np.maximum.at(most, self.vertices.face, self.rubbing.range)
        return np.asarray(self.rubbing.range > _SLIPS * most[self.vertices.face])

    @cached_property
    def ruiz_2(self) -> Floats:
        """Ruiz's second parameter σ_T τ δ (k, n), MPa²·mm."""
        return np.asarray(np.maximum(self.tension, 0.0) * self.rubbing.work)

    def figures(self, rod_length: float) -> FrettingFigures:
        """Return the figures; places, the worst first, by the second parameter."""
        pairs = {PAIRS[surface]: self._pair(number) for number, surface in enumerate(self.surfaces)}
        every = [place for number in range(len(self.surfaces)) for place in self._places(number, rod_length)]
        changes = {
            words: {
                PAIRS[surface]: self._change(other, number) for number, surface in enumerate(self.surfaces)
            }
            for words, other in self.changes.items()
        }
        return FrettingFigures(
            friction=self.rubbing.friction,
            proven_ruiz_2=self.proven,
            pairs=pairs,
            places=tuple(sorted(every, key=lambda place: -place.ruiz_2)),
            changes=changes or None,
            bolt_seats=self.bolt_seats or None,
        )

    def _pair(self, number: int) -> FrettingPairFigures:
        mine, rub, area = self.vertices.face == number, self.rubbing, self.vertices.area
        tension = np.where(mine & self.counts, self.tension.max(axis=1), -np.inf)
        worst, most = int(tension.argmax()), int(np.where(mine, rub.energy, -1.0).argmax())
        counts = bool((mine & self.counts).any())
        return FrettingPairFigures(
            slip_um=float(rub.range[mine].max()) / UM,
            slipping_percent=100 * float(area[mine & self.slips].sum() / area[mine].sum()),
            creep_um=float(rub.creep[mine].max()) / UM,
            energy_mJ=float(rub.energy[mine] @ area[mine]),
            duty_W=None if self.power is None else float(self.power[mine] @ area[mine]),
            most_energy_mJ=float(rub.energy[most]),
            most_energy_at_mm=vector(self.vertices.place[most]),
            tension_MPa=float(tension[worst]) if counts else None,
            tension_at_mm=vector(self.vertices.place[worst]) if counts else None,
        )

    def _places(self, number: int, rod_length: float) -> Iterator[FrettingPlaceFigures]:
        rub, mine = self.rubbing, (self.vertices.face == number) & self.counts
        severity = np.where(mine, self.ruiz_2.max(axis=1), 0.0)
        for k in distinct(self.vertices.place, -severity, rod_length)[:_PLACES]:
            if severity[k] <= 0:
                continue
            instant, factor = int(self.ruiz_2[k].argmax()), float(self.factor[k])
            judged = self.across[k] >= FEWEST_FACETS and not np.isnan(factor)
            yield FrettingPlaceFigures(
                pair=PAIRS[self.surfaces[number]],
                part=self.parts[self.part[k]],
                at_mm=vector(self.vertices.place[k]),
                crank_deg=float(self.angles[instant] / DEG),
                slip_um=float(rub.range[k]) / UM,
                pressure_MPa=float(rub.pressure[k, instant]),
                shear_MPa=float(rub.shear[k, instant]),
                tension_MPa=float(self.tension[k, instant]),
                energy_mJ=float(rub.energy[k]),
                ruiz_1=float(rub.work[k].max()),
                ruiz_2=float(severity[k]),
                factor=without_bar(factor) if judged else None,
                facets_across=int(self.across[k]),
                averaged_mm=float(self.radius[k]),
            )

    def _change(self, other: Rubbing, number: int) -> FrettingChangeFigures:
        mine, area = self.vertices.face == number, self.vertices.area
        return FrettingChangeFigures(
            slip_um=float(other.range[mine].max()) / UM,
            energy_mJ=float(other.energy[mine] @ area[mine]),
            ruiz_1=float(other.work[mine & self.counts].max(initial=0.0)),
        )

    @cached_property
    def drawn(self) -> "RubbedSurfaces":
        """The fields on the first surface of each pair of the whole rod."""
        whole = self.whole
        points, triangles, rows, pairs, count = [], [], [], [], 0
        for number, surface in enumerate(self.surfaces):
            nodes, corners = np.unique(whole.mesh.facets[surface][:, :3], return_inverse=True)
            mine = np.flatnonzero(self.vertices.face == number)
            keys = 2 * self.vertices.node[mine] + self.vertices.image[mine]
            order, mirrored = np.argsort(keys), whole.sign[nodes, 1] < 0
            wanted = 2 * whole.source[nodes] + (mirrored & self.vertices.image.any())
            rows.append(mine[order[np.searchsorted(keys[order], wanted)]])
            points.append(whole.mesh.points[nodes])
            triangles.append(count + corners.reshape(-1, 3))
            pairs.append(np.full(len(triangles[-1]), number))
            count += len(nodes)
        row, rub = np.concatenate(rows), self.rubbing
        fields = {
            "slip_um": rub.range / UM,
            "pressure": rub.pressure.max(axis=1),
            "shear": rub.shear.max(axis=1),
            "tension": self.tension.max(axis=1),
            "energy": rub.energy,
            "ruiz_1": rub.work.max(axis=1),
            "ruiz_2": np.where(self.counts, self.ruiz_2.max(axis=1), 0.0),
            "masked": np.where(self.counts, 0.0, 1.0),
        }
        return RubbedSurfaces(
            np.concatenate(points),
            np.concatenate(triangles),
            {name: values[row] for name, values in fields.items()},
            np.concatenate(pairs),
            self.surfaces,
        )


class RubbedSurfaces(NamedTuple):
    """The first surfaces of the pairs."""

    points: Floats  #: (n, 3) mm
    triangles: Ints  #: (m, 3)
    fields: dict[str, npt.NDArray[np.float64]]  #: (n,) by the names of the arrays in the VTU file
    pair: Ints  #: (m,) number of the pair
    surfaces: tuple[Surface, ...]  #: of the pairs


def fretting(
    rod: PreparedRod, cycle: CrankCycle, found: CycleResult
) -> tuple[FrettingResult | None, tuple[Note, ...]]:
    """Work out what rubs over a cycle that was solved, and what would under other assumptions."""
    pins = rod.assembly_contact
    if pins is None or pins.assembly.assembled.vertices.shear.max(initial=-1) < 0:
        return None, (omission("fretting", "no parts of the rod touch with friction ([assembly])"),)
    faces, vertices = pins.assembly.problem.faces, pins.assembly.assembled.vertices
    rubbing, normal = pins.rubbing(cycle), np.zeros(vertices.place.shape)
    degrees = np.round(cycle.increments.crank_angle / DEG).astype(int) % (len(found.angles) - 1)
    degrees = np.append(degrees, degrees[0])  # whole ones
    for number, face in enumerate(faces):
        mine = vertices.face == number
        normal[mine] = face.pressing.direction(rod.mesh.cell.points[vertices.node[mine]])
    sides = [
        surface_stress(
            rod.cycle,
            found.weights.at(degrees),
            TouchingPlaces(nodes, vertices.image, normal),
            rubbing.range > 0,
        )
        for nodes in (vertices.node, vertices.mate)
    ]
    lining = np.array([material.lining for material in rod.materials])
    severity = [(np.maximum(side.tension, 0.0) * rubbing.work).max(axis=1) for side in sides]
    judged = [np.where(lining[side.part], -1.0, own) for side, own in zip(sides, severity, strict=True)]
    second = judged[1] > judged[0]
    changes, notes = _changes(pins, cycle)
    duty = () if rod.life is None or rod.life.operation is None else rod.life.operation.entries
    an_hour = [each.rate * pins.rubbing(each.cycle).energy for each in duty]
    result = FrettingResult(
        rubbing=rubbing,
        vertices=vertices,
        surfaces=tuple(Surface(face.name) for face in faces),
        angles=found.angles[degrees],
        parts=tuple(rod.mesh.parts),
        part=np.where(second, sides[1].part, sides[0].part),
        tension=np.where(second[:, None], sides[1].tension, sides[0].tension),
        factor=np.where(second, sides[1].factor, sides[0].factor),
        radius=np.where(second, sides[1].radius, sides[0].radius),
        whole=rod.mesh.mirrored,
        counts=rod.cycle.counts[vertices.node] & rod.cycle.counts[vertices.mate],
        changes={AS_GIVEN: rubbing} | changes,
        bolt_seats=bolt_seats(rod, pins, cycle, found, degrees),
        proven=rod.options.proven_ruiz_2,
        power=np.sum(an_hour, axis=0) / 3.6e6 if an_hour else None,
    )
    return result, (*_not_resolved(pins, found), *notes, *_unsettled(result))


def _not_resolved(pins: AssemblyPins, found: CycleResult) -> Iterator[Note]:
    """Say where nothing is solved that could rub."""
    cut = max((bolt.shear for state in found.states for bolt in state.bolts), default=0.0)
    if cut > 0:
        text = f"bolts bear on their holes by up to {cut / KN:.2g} kN, and where along the hole is not solved"
        yield omission("fretting in bolt holes", text)
    if pins.fits.small_clearance < 0:
        yield _PRESSED_IN


def _unsettled(result: FrettingResult) -> Iterator[Note]:
    """Say which pairs still creep."""
    for number, surface in enumerate(result.surfaces):
        mine = result.vertices.face == number
        slip, creep = (float(each[mine].max()) for each in (result.rubbing.range, result.rubbing.creep))
        if creep > _CREEPS * slip:
            left = f"the last cycle that was followed left {creep / UM:.2g} µm of {slip / UM:.2g} µm"
            yield warning(f"slip of the {PAIRS[surface]} has not settled: {left}", "fretting")


def _changes(pins: AssemblyPins, cycle: CrankCycle) -> tuple[dict[str, Rubbing], list[Note]]:
    """Solve the contact of the cycle with the friction of dry steel, and with more crush, if there is any."""
    assembled, faces = pins.assembly.assembled, pins.assembly.problem.faces
    now = float(assembled.system.places.friction.max())
    asked = {f"friction {_DRY:g} of dry steel (assumed)": (_DRY, 1.0)}
    if any(face.interference > 0 for face in faces):
        asked[f"{100 * (_CRUSHED - 1):.0f} % more crush"] = (now, _CRUSHED)
    found, notes = dict[str, Rubbing](), list[Note]()
    for words, changed in asked.items():
        try:
            found[words] = pins.rubbing(cycle, changed)
        except ContactError as error:
            notes.append(omission(f"fretting with {words}", str(error)))
    return found, notes
