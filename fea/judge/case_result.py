"""Results of load cases: fields on the whole rod, their extremes, and the case that governs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.base.material import Material
from fea.contact.assembly_state import AssemblyState, PinContact, SeatFields
from fea.judge.case_error import CaseError
from fea.judge.safety_factor import SafetyFactor
from fea.judge.sharp_places import SharpPlace, SharpPlaces, mattering
from fea.judge.verdict import CAP, ConvergenceVerdict, Peak, element_largest, peak, safety_factor, widened
from fea.solid.stress import principal, von_mises
from geometry.arrays import Floats, Mask, vector
from geometry.surfaces import INTERFACES, Surface
from loads.instants import Instants
from mesh.tetmesh import TetMesh

# Least error of the stress at the ends of the bores, over it: where a pin's pressure stops, peaks on meshes
# of the same fineness scatter by as much, which no estimate from one mesh shows.
RIM_SHARE = 0.015
# Share of the estimated error on meshes of second order that are refined where it is large: elements of even
# size recover stress better than those that geometry alone has sized. On rods from CAD files, whose faces are
# of all kinds, it is larger, and peaks scatter by the last share of the stress at least.
REFINED_SHARE, FILE_SHARE, LEAST_OF_FILE = 0.58, 0.72, 0.005
# Surfaces that pins and other parts press on; of two that meet, the one that counts comes later.
_PRESSED = (Surface.SMALL_END_BORE, Surface.BIG_END_BORE, *chain.from_iterable(reversed(INTERFACES)))


@dataclass(frozen=True, kw_only=True)
class CaseFields:
    """Solution of one load case on the whole rod."""

    displacement: Floats  #: (n_nodes, 3), mm, relative to the bores
    error: CaseError  #: estimated errors of the fields
    #: Pressures on the bores, on either side of interfaces and on the seats of bolts; empty where the pins'
    #: pressure is prescribed
    seats: Mapping[Surface, SeatFields] = field(default_factory=dict)
    #: (n_nodes,) between separate parts, mm, 0 elsewhere; None for a rod of one piece
    gap: Floats | None = None
    assembly: AssemblyState | None = None  #: bolts and interfaces of a rod of separate parts
    #: Where the pins touch the bores; empty where their pressure is prescribed
    touch: Mapping[Surface, PinContact] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class CaseResult(CaseFields):
    """Fields of one load case on the whole rod, and what follows from them."""

    load: Instants
    mesh: TetMesh  #: of the whole rod
    stress: Floats  #: (n_nodes, 6), MPa, components XX YY ZZ XY YZ XZ
    von_mises: Floats  #: (n_nodes,), MPa
    principal: Floats  #: (n_nodes, 3), MPa, largest first
    safety_factor: Floats  #: (n_nodes,) against yielding
    #: (n_nodes,) the same of rod and cap, by which the case is judged; the largest factor in linings of bores
    of_rod: Floats
    #: Per part (n_nodes,), MPa, NaN at nodes outside the part. At an interface the fields above are those of
    #: the part that is closer to yielding.
    part_von_mises: tuple[Floats, ...]
    von_mises_error: Floats  #: (n_nodes,) estimated error of `von_mises`, MPa
    #: (n_nodes, 3) displacement at which the bores of a rod of separate parts were made round, mm
    bore_datum: Floats | None = None
    #: The rod's sharp re-entrant edges, the worst first; empty where it has none
    sharp: tuple[SharpPlace, ...] = ()

    @property
    def finite(self) -> bool:
        """Whether every value is finite."""
        return bool(np.isfinite(self.stress).all() and np.isfinite(self.displacement).all())

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress away from singular places, MPa."""
        return self.peak.value

    @property
    def at(self) -> Floats:
        """Place (3,) of the largest von Mises stress, mm."""
        return np.asarray(self.mesh.points[self.peak.node])

    @property
    def min_safety_factor(self) -> SafetyFactor:
        """Smallest safety factor against yielding, away from singular places, with the case's error bar."""
        return SafetyFactor.of_stress(1 / self.worst.value, self.error_percent, instant=self.load.name)

    @property
    def sharp_mattering(self) -> tuple[SharpPlace, ...]:
        """The sharp edges that matter beside the rest of the rod, the worst first."""
        diverging = self.peak.diverges or self.worst.diverges
        return mattering(self.sharp, self.min_safety_factor, diverging=diverging)

    @property
    def sharp_governing(self) -> tuple[SharpPlace, ...]:
        """Those of them whose structural stress matters: elements beside them should be small."""
        return mattering(self.sharp, self.min_safety_factor, diverging=False) if self.sharp else ()

    @property
    def max_principal(self) -> float:
        """Largest principal stress away from singular places, MPa."""
        return float(self.principal[self.counts, 0].max())

    @property
    def min_principal(self) -> float:
        """Least principal stress away from singular places, MPa."""
        return float(self.principal[self.counts, 2].min())

    @property
    def max_displacement(self) -> float:
        """The largest displacement, mm."""
        return float(np.linalg.norm(self.displacement, axis=1).max())

    @property
    def distortion(self) -> Floats:
        """Displacement (n_nodes, 3) since the bores were made, mm."""
        return self.displacement if self.bore_datum is None else self.displacement - self.bore_datum

    @property
    def counts(self) -> Mask:
        """Nodes (n_nodes,) that count for the figures: those away from singular places, if there are any."""
        masked = self.error.masked
        return ~masked if not masked.all() else masked

    @property
    def contact_pressure(self) -> Floats | None:
        """Of the pins and between separate parts, (n_nodes,), MPa, 0 elsewhere.

        A node has one: where the joint meets a bore or another interface, that of the joint. None where the
        pins' pressure is prescribed.
        """
        pressure = np.zeros(len(self.mesh.points))
        for surface in _PRESSED:
            if surface in self.seats:
                pressure[self.seats[surface].nodes] = self.seats[surface].pressure
        return pressure if self.seats else None

    def point_data(self) -> dict[str, npt.NDArray[Any]]:
        """Arrays at the nodes, by their names in the VTU file."""
        fields = self.displacement, self.stress, self.von_mises, self.principal, self.safety_factor
        optional = {"contact_pressure": self.contact_pressure, "gap": self.gap}
        contact = {name: values for name, values in optional.items() if values is not None}
        return nodal_arrays(*fields) | contact | masked_array(self.counts)

    def cell_data(self, materials: Sequence[Material]) -> dict[str, npt.NDArray[Any]]:
        """Arrays of the elements, by their names in the VTU file: the worst nodal value of each element."""
        mesh = self.mesh
        largest, factor = np.empty((2, len(mesh.tets)))
        for number, (equivalent, material) in enumerate(zip(self.part_von_mises, materials, strict=True)):
            elements = slice(None) if mesh.part is None else mesh.part == number
            largest[elements] = element_largest(equivalent, mesh.tets[elements])
            factor[elements] = safety_factor(largest[elements], material.yield_strength)
        arrays = {
            "von_mises_max": largest,
            "safety_factor": factor,
            "error_percent": self.error.element_percent,
        }
        return arrays if mesh.part is None else arrays | {"part": mesh.part.astype(np.uint8)}

    @property
    def judged(self) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """Von Mises stress, and utilisation (one over the safety factor), each (n_nodes,) with its error."""
        utilisation = 1 / self.of_rod
        free = self.of_rod < CAP  # a capped factor does not depend on the stress
        ratio = np.divide(utilisation, self.von_mises, out=np.zeros_like(utilisation), where=free)
        return (self.von_mises, self.von_mises_error), (utilisation, self.von_mises_error * ratio)

    @cached_property
    def peak(self) -> Peak:
        """The largest von Mises stress, MPa."""
        return peak(*self.judged[0], self.error.masked)

    @cached_property
    def worst(self) -> Peak:
        """The largest utilisation."""
        return peak(*self.judged[1], self.error.masked)

    @property
    def error_percent(self) -> float:
        """Error bar of the largest von Mises stress or of the smallest safety factor, whichever is larger."""
        return max(self.peak.error_percent, self.worst.error_percent)

    def verdict(self, tolerance_percent: float | None = None) -> ConvergenceVerdict:
        """The worse of the verdicts on the largest von Mises stress and on the smallest safety factor."""
        verdicts = [extreme.verdict(tolerance_percent) for extreme in (self.peak, self.worst)]
        return max(verdicts, key=list(ConvergenceVerdict).index)


def case_result(
    load: Instants,
    mesh: TetMesh,
    fields: CaseFields,
    stresses: Sequence[Floats],
    *,
    materials: Sequence[Material],
    rims: Mask,
    from_file: bool = False,
    refined: bool = False,
    bore_datum: Floats | None = None,
    sharp: SharpPlaces | None = None,
) -> CaseResult:
    """Return the result of a case from its fields and each part's stress (n_nodes, 6), NaN outside it.

    `rims` (n_nodes,) are the `bore_ends` of the mesh, the same for all of its cases; the errors of a rod
    that is read `from_file` are `widened`; `refined` meshes have less.
    """
    masked = fields.error.masked
    equivalents = tuple(von_mises(stress) for stress in stresses)
    factor, equivalent, stress, error = of_weakest(
        materials, equivalents, stresses, fields.error.part_von_mises
    )
    if refined and mesh.order == 2:
        error = error * (FILE_SHARE if from_file else REFINED_SHARE)
    error = np.where(rims, np.maximum(error, RIM_SHARE * equivalent), error)
    if from_file:
        error = widened(equivalent, np.maximum(error, LEAST_OF_FILE * equivalent), masked)
    error = error + fields.error.of_facets * equivalent  # which no finer element reduces
    lasting = [part for part in zip(materials, equivalents, strict=True) if not part[0].lining]
    of_rod = factor
    if 0 < len(lasting) < len(materials):
        of_rod = np.nan_to_num(of_weakest(*zip(*lasting, strict=True))[0], nan=CAP)
    result = CaseResult(
        **vars(fields),
        load=load,
        mesh=mesh,
        stress=stress,
        von_mises=equivalent,
        principal=principal(stress),
        safety_factor=factor,
        of_rod=of_rod,
        part_von_mises=equivalents,
        von_mises_error=error,
        bore_datum=bore_datum,
    )
    if sharp is None:
        return result
    return replace(result, sharp=sharp(stress, error, factor, result.min_safety_factor))


def of_weakest(
    materials: Sequence[Material], equivalents: Sequence[Floats], *fields: Sequence[Floats]
) -> list[Floats]:
    """Safety factor (n_nodes,) of the part that is closest to yielding at each node, and its fields there.

    Von Mises stress (n_nodes,) and the fields (n_nodes, …) are given for each part, NaN outside it. They
    follow the factor in this order.
    """
    factors = [
        safety_factor(equivalent, material.yield_strength)
        for equivalent, material in zip(equivalents, materials, strict=True)
    ]
    of_parts = (factors, equivalents, *fields)
    if len(factors) == 1:
        return [np.asarray(field[0]) for field in of_parts]
    weakest = np.nan_to_num(np.stack(factors), nan=np.inf).argmin(axis=0)
    return [np.stack(field)[weakest, np.arange(len(weakest))] for field in of_parts]


def nodal_arrays(
    displacement: Floats, stress: Floats, equivalent: Floats, principals: Floats, factor: Floats
) -> dict[str, npt.NDArray[np.float64]]:
    """Return the arrays that every instant has, by their names in a VTU file."""
    return {
        "displacement": displacement,
        "stress": stress,
        "von_mises": equivalent,
        **{f"principal_{k + 1}": principals[:, k] for k in range(3)},
        "safety_factor_node": factor,
    }


def masked_array(counts: Mask) -> dict[str, npt.NDArray[np.uint8]]:
    """Return the array of a VTU file that is 1 at the nodes that figures leave out; nothing if none is."""
    return {} if counts.all() else {"masked": (~counts).astype(np.uint8)}


def bore_ends(mesh: TetMesh) -> Mask:
    """Whether each node (n_nodes,) is in an element that touches the end of a bore."""
    ends = np.zeros(len(mesh.points), dtype=bool)
    free = mesh.facets.get(Surface.FREE, np.zeros((0, 3), dtype=np.int64))
    for bore in (Surface.SMALL_END_BORE, Surface.BIG_END_BORE):
        if bore in mesh.facets:
            ends[np.intersect1d(mesh.facets[bore], free)] = True
    ends[mesh.tets[ends[mesh.tets].any(axis=1)]] = True
    return ends


# A case that cannot govern is refined to at most so many times the tolerance: 15 % for 5 %.
MOST_RELAXED = 3.0


@dataclass(frozen=True)
class Governing:
    """The largest utilisation of the load cases at one speed, away from singular places.

    The verdict on a rod needs its smallest factor. The largest utilisation (one over the factor) of all cases
    is not above the largest sum of utilisation and error over them: a case whose sum stays below that of the
    governing one cannot change the factor, however wide its bar is.
    """

    utilisation: float
    highest: float  #: largest sum of utilisation and error
    #: case, place: that sum's load case and place, mm
    case: str
    place: tuple[float, float, float]

    @classmethod
    def of(cls, cases: Sequence[CaseResult]) -> "Governing":
        """Find the governing utilisation among the cases of one speed."""
        utilisation = max(case.worst.value for case in cases)
        upper = max(cases, key=lambda case: case.worst.highest)
        place = vector(upper.mesh.points[upper.worst.bar_node])
        return cls(utilisation, upper.worst.highest, upper.load.name, place)

    @property
    def percent(self) -> float:
        """Error bar of the smallest safety factor."""
        return 100 * (self.highest / self.utilisation - 1) if self.utilisation > 0 else 0.0

    def needed(self, case: CaseResult, tolerance_percent: float) -> float:
        """Error bar, percent, that a case needs for the smallest factor to be within a tolerance."""
        share = case.worst.value / self.utilisation if self.utilisation > 0 else 1.0
        return tolerance_percent / max(share, 1 / MOST_RELAXED)

    def covers(self, case: CaseResult, tolerance_percent: float) -> bool:
        """Whether a case, with its error bar, cannot change the smallest factor by more than a tolerance."""
        return case.worst.highest <= self.utilisation * (1 + tolerance_percent / 100)

    def verdict(self, case: CaseResult, tolerance_percent: float) -> ConvergenceVerdict:
        """Return the verdict on a case; one that cannot govern may have a wide bar."""
        verdict = case.verdict(tolerance_percent)
        spare = verdict is ConvergenceVerdict.NOT_CONVERGED and self.covers(case, tolerance_percent)
        return ConvergenceVerdict.SUFFICIENT if spare else verdict
