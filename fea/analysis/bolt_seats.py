"""Fretting under the heads and nuts of bolts, where no friction is solved: an estimate.

A head is taken as rigid, and its pressure as even. Friction makes it follow its seat, which bends the bolt.
With the shear V that this takes, of range 2 V_a over the cycle, and the least force F of the bolt, a head
whose friction bears more than V_a comes to rest. Below that it slides, to and fro in each cycle, by the share
1 − μ F/V_a of what it would slide without friction (a slider in series with a spring, settled).
The seat also stretches under the head: by its displacement along itself, less the rigid motion that is
nearest in the least squares. All of that counts as slip, though friction makes a head stretch with its seat.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.surface_stress import TouchingPlaces, surface_stress
from fea.analysis.fretting_figures import BoltSeatFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.base.units import DEG, UM
from fea.contact.assembly_state import bolt_forces
from fea.contact.fretting import Rubbing, extent
from fea.contact.interfaces import Multipliers, uniform
from fea.pins.assembly import AssemblyPins
from geometry.arrays import Floats, Ints, linked_groups, vector
from geometry.assembly import BoltAxis
from geometry.holes import Axis
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh.tetmesh import FACET_EDGES, TetMesh

# Instants whose displacement is worked out at once.
_AT_ONCE = 16
_ROUNDING = 1e-6  # of places, mm
_NO_SHEAR = 1e-3  # over what friction bears: none


@dataclass(frozen=True)
class SeatSurface:
    """One seat of a bolt on the whole rod."""

    nodes: Ints  #: (k,) its vertices
    points: Floats  #: (k, 3) mm
    area: Floats  #: (k,) that belongs to each, mm²
    bolt: BoltAxis  #: the one that presses on it

    @property
    def tangents(self) -> Floats:
        """Two unit vectors (2, 3) along the seat: in the plane of motion, and across it."""
        axis = np.array(self.bolt.direction)
        in_plane = np.cross([0.0, 0.0, 1.0], axis)
        return np.stack([in_plane, np.cross(axis, in_plane)])

    def stretched(self, displacement: Floats) -> Floats:
        """Displacement (k, 2, n) along it, less the nearest rigid motion, of the whole (k, 3, n), mm."""
        along = np.einsum("td,kdn->ktn", self.tangents, displacement)
        x, y = self.tangents @ (self.points - self.area @ self.points / self.area.sum()).T
        one, none, weight = np.ones(len(x)), np.zeros(len(x)), np.sqrt(self.area)[:, None]
        rigid = np.stack([np.stack([one, none, -y], axis=1), np.stack([none, one, x], axis=1)], axis=1)
        weighted = (weight[..., None] * rigid).reshape(-1, 3), weight[..., None] * along
        amounts = np.linalg.lstsq(weighted[0], weighted[1].reshape(2 * len(x), -1))[0]
        return np.asarray(along - np.einsum("ktm,mn->ktn", rigid, amounts))


def seats(mesh: TetMesh, surface: Surface, bolts: tuple[BoltAxis, ...]) -> Iterator[SeatSurface]:
    """Yield the seats of a surface of the whole rod."""
    pressed = Multipliers.of(mesh, surface, uniform(np.zeros(3)))
    nodes, area = pressed.nodes, pressed.weights
    group = linked_groups(len(nodes), *pressed.corners[:, FACET_EDGES].reshape(-1, 2).T)
    axes = [Axis(center=np.array(bolt.point), direction=np.array(bolt.direction)) for bolt in bolts]
    for number in range(group.max() + 1):
        mine = group == number
        points = mesh.points[nodes[mine]]
        bolt = bolts[int(np.argmin([axis.beside(points).mean() for axis in axes]))]
        yield SeatSurface(nodes[mine], points, area[mine], bolt)


def sliding(shear: Floats, shift: Floats, bears: Floats) -> tuple[Floats, Floats]:
    """What friction bears (k,), N, over half the range of shear, and the range of slip that is left, mm.

    Of paths (k, 2, n) over a cycle of the shear while heads hold, and of the shift of heads that nothing
    holds. A slider in series with a spring slides by the range of its ends less 2 μ F/k, once it has settled.
    """
    always = np.ones((len(shear), shear.shape[2]), dtype=bool)
    half_range = extent(shear, always) / 2
    reserve = bears / np.maximum(half_range, _NO_SHEAR * bears.max(initial=1.0))
    return reserve, np.maximum(1 - reserve, 0.0) * extent(shift, always)


def bolt_seats(
    rod: PreparedRod, pins: AssemblyPins, cycle: CrankCycle, found: CycleResult, degrees: Ints
) -> dict[str, BoltSeatFigures]:
    """Return what rubs under heads, and under nuts, at these degrees of a cycle that was solved."""
    instants, bolts = cycle.degrees[degrees], rod.mesh.bolts
    if rod.assembling is None or not bolts:
        return {}
    friction = rod.assembling.bolt.bolt.head_friction
    held = [pins.assembly.sums.held(state) for state in pins.states(instants, cycle)]
    shear, shift = (np.stack(each, axis=-1) for each in zip(*held, strict=True))
    force = bolt_forces([found.states[degree] for degree in degrees])
    reserve, slides = sliding(shear, shift, friction * force.min(axis=1))
    kinds = {"heads": Surface.BOLT_HEAD} | ({} if bolts[0].engaged else {"nuts": Surface.BOLT_THREAD})
    places = [(name, seat) for name, on in kinds.items() for seat in seats(rod.mesh.whole, on, bolts)]
    nodes = np.unique(np.concatenate([seat.nodes for _, seat in places]))
    displaced = _displaced(rod, instants, cycle, nodes)
    at = np.array([bolt.at for bolt in found.states[0].bolts])  # one of each pair about z = 0
    worst = dict[str, BoltSeatFigures]()
    for name, seat in places:
        away, mirrored = (np.linalg.norm(at * [1, 1, z] - seat.bolt.point, axis=1) for z in (1, -1))
        number = int(np.minimum(away, mirrored + _ROUNDING).argmin())
        pressure = np.tile(force[number] / seat.area.sum(), (len(seat.nodes), 1))
        slip = seat.stretched(displaced[np.searchsorted(nodes, seat.nodes)])
        rubbing = Rubbing(slip, friction * pressure, pressure, friction)
        tension, head = _tension(rod, found, degrees, seat), (float(reserve[number]), float(slides[number]))
        own = _figures(seat, rubbing, tension, head, found.angles[degrees])
        before = worst.setdefault(name, own)
        worst[name] = max(before, own, key=lambda each: (each.ruiz_2 or 0.0, each.ruiz_1))
    return worst


def _displaced(rod: PreparedRod, instants: Instants, cycle: CrankCycle, nodes: Ints) -> Floats:
    """Displacement (k, 3, n) of nodes of the whole rod at instants of a cycle, mm."""
    parts = [instants[first : first + _AT_ONCE] for first in range(0, len(instants), _AT_ONCE)]
    found = [rod.fields.displaced(rod.equilibrium(part, cycle))[nodes] for part in parts]
    return np.concatenate(found, axis=2)


def _tension(rod: PreparedRod, found: CycleResult, degrees: Ints, seat: SeatSurface) -> Floats:
    """Largest stress (k, n) along a seat, MPa; NaN near stress singularities."""
    whole = rod.mesh.mirrored
    cell, image = whole.source[seat.nodes], whole.sign[seat.nodes, 1] < 0
    normal = np.where(image[:, None], [1.0, -1.0, 1.0], 1.0) * seat.bolt.direction  # at the nodes of the cell
    places, nowhere = TouchingPlaces(cell, image, normal), np.zeros(len(cell), dtype=bool)
    tension = surface_stress(rod.cycle, found.weights.at(degrees), places, nowhere).tension
    return np.where(rod.cycle.counts[cell][:, None], tension, np.nan)


def _figures(
    seat: SeatSurface, rubbing: Rubbing, tension: Floats, head: tuple[float, float], angles: Floats
) -> BoltSeatFigures:
    """The figures of a seat where σ τδ is largest, or τδ where there is no tension; `head`: see `sliding`."""
    reserve, slides = head
    slip = rubbing.range + slides
    work = rubbing.shear * slip[:, None]
    ruiz_2 = np.maximum(np.nan_to_num(tension), 0.0) * work
    severity = ruiz_2 if ruiz_2.any() else work
    place, instant = np.unravel_index(int(severity.argmax()), severity.shape)
    along = float(tension[place, instant])
    return BoltSeatFigures(
        friction=rubbing.friction,
        reserve=reserve,
        slides_um=slides / UM,
        at_mm=vector(seat.points[place]),
        crank_deg=float(angles[instant] / DEG),
        slip_um=float(slip[place]) / UM,
        pressure_MPa=float(rubbing.pressure[place, instant]),
        tension_MPa=None if np.isnan(along) else along,
        ruiz_1=float(work.max()),
        ruiz_2=None if np.isnan(tension).all() else float(ruiz_2.max()),
    )
