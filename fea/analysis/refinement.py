"""How well a mesh resolves the peaks of the stress, and the element sizes that a tolerance asks for."""

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary_figures import PassFigures
from fea.judge.case_result import CaseResult, Governing
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.judge.sharp_places import FINE_WITHIN, SharpPlace, worst_of_edges
from fea.judge.verdict import Peak, peak
from fea.rod.meshed_rod import MeshedRod
from fea.solid.stress import von_mises
from geometry.arrays import Floats, Mask
from mesh.sizing import SizeField, Sizing
from mesh.tetmesh import EDGES, TetMesh

# The error of the stress falls with this power of the element size, by element order.
_RATE = {1: 1.0, 2: 2.2}
# Where an earlier pass refined without success the stress is less smooth (at the ends of fillets the
# curvature jumps): the rate is lower there, and elements shrink by this ratio to make a pass worth while.
_ROUGH_RATE, _ROUGH_RATIO = 1.5, 0.6
# Share of the tolerance that is aimed at: predictions scatter, most those of a first mesh; a pass more costs
# a whole solution, smaller elements at the peaks little. Errors of a first mesh of second order are counted
# for more than they will be on the refined one (`REFINED_SHARE`), so that 0.65 leads to 0.4 of the tolerance.
_AIM, _FIRST_AIM = 0.5, 0.65
# Under refinement the stress of other places than the peak rises by about this share of their error.
_RISE = 0.4
# Beside sharp edges elements are so many times those with which the structural stress is known best: its
# first point of reading, 0.4 t from the edge, still lies beyond the elements that touch the edge.
_COARSE_EDGES = 3.0
# Edges that use less of their strength than the worst place of the rod over this do not get elements.
_EDGES_WITHIN = 1.6
# No element shrinks more than this in one pass: error estimates are too vague to extrapolate further.
LEAST_RATIO = 0.2
# Beyond this error in the energy norm a whole rod is too coarse for any peak to be trusted; elements with
# more than their share of it shrink (Zienkiewicz & Zhu 1987, eq. 21), and no further than by half.
ENERGY_PERCENT = 20.0
_LEAST_ENERGY_RATIO = 0.5
# Mean length of the edges that gmsh makes, over the size it was asked for.
REALISED = 1.25
# Stands for "no size is wanted here": larger than any element, mm.
_NO_WISH = 1e6
# The last pass gives the answer; those before it should not cost more than one and a half times as much.
MAX_PASSES = 4
# About ten gigabytes and some minutes with a direct solver on a quarter of the rod.
MAX_ELEMENTS = 600_000
# What a coarse mesh asks for is vague: a mesh of more elements than this that has so many times those of the
# last one is approached by one with half the change of size (by its logarithm).
_MANY, _LEAP = 200_000, 6.0
# A field (n_nodes,) whose peak is judged, and its error.
Judged = tuple[Floats, Floats]


class ErrorBar(NamedTuple):
    """The error bar that must reach the tolerance: percent, its load case, and the place that sets it, mm."""

    percent: float = 0.0
    case: str = ""
    place: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """The bar in words."""
        x, y, z = (f"{coordinate:.1f}" for coordinate in self.place)
        return f"±{self.percent:.2g} % in {self.case}, because of ({x}, {y}, {z}) mm"


class NextMesh(NamedTuple):
    """What the errors of a mesh ask for."""

    sizes: SizeField | None = None  #: of the next mesh; None where there is none
    obstacle: str = ""  #: why there is none; empty where the tolerance is met
    draft: str = ""  #: progress line after the first mesh, with what the next one will be


class MeshErrors:
    """The errors of a mesh over the load cases of some speeds, which are included one after another.

    `refined`: whether the mesh has been refined for this tolerance already. Attributes: `bar`: the widest
    error bar; `smallest`: the smallest safety factor.
    """

    def __init__(self, rod: PreparedRod, tolerance_percent: float, *, refined: bool) -> None:
        self._rod, self._tolerance, self._refined = rod, tolerance_percent, refined
        self._ratio = np.ones(len(rod.mesh.whole.points))
        self._growth = Sizing(rod.mesh.meshing.size).growth
        self.bar, self.smallest = ErrorBar(), SafetyFactor(np.inf)

    def include(self, results: Mapping[str, CaseResult]) -> None:
        """Include the load cases of a speed."""
        rod, mesh, cases = self._rod, self._rod.mesh.whole, tuple(results.values())
        all_cases, masked = rod.options.all_cases, cases[0].error.masked
        fatigue, fields = list[Peak](), list[Judged]()
        tested = rod.study.forces is not None and rod.study.forces.ratio is not None
        if (rod.options.cycle or tested) and len(cases) > 1:
            if (used := usage(rod, cases)) is not None:
                fatigue.append(peak(*used, masked))
                fields.append(used)
            fields.append(amplitude(cases))
        self.bar = max(self.bar, *_bars(cases, fatigue, all_cases=all_cases))
        self.smallest = min(self.smallest, *_factors(cases, fatigue), key=lambda factor: factor.low)
        ratio = size_ratio(
            mesh, cases, self._tolerance, again=self._refined, all_cases=all_cases, fatigue=fields
        )
        self._ratio = np.minimum(self._ratio, ratio)

    def figures(self, seconds: float) -> PassFigures:
        """Return the figures of this pass of the refinement, which took so many seconds."""
        whole = self._rod.mesh.whole
        return PassFigures(
            elements=len(whole.tets),
            nodes=len(whole.points),
            error_percent=self.bar.percent,
            seconds=seconds,
        )

    def next_mesh(self, n_passes: int) -> NextMesh:
        """Return the mesh that the tolerance asks for after so many passes."""
        mesh = self._rod.mesh
        if self.bar.percent <= self._tolerance:
            return NextMesh()
        if self._rod.options.draft:
            return NextMesh(obstacle="this is a draft; without --draft the mesh is refined")
        wanted, elements = wanted_sizes(mesh, self._ratio), 0.0
        if wanted is not None and n_passes < MAX_PASSES:
            elements = predicted_elements(mesh, wanted, self._growth)
        if elements > max(_MANY, _LEAP * len(mesh.whole.tets)):
            wanted = wanted_sizes(mesh, self._ratio**0.5)
            elements = 0.0 if wanted is None else predicted_elements(mesh, wanted, self._growth)
        if not elements:
            meshes = "1 mesh was" if n_passes == 1 else f"{n_passes} meshes were"
            return NextMesh(obstacle=f"{meshes} tried; start from a smaller --size")
        count = f"{float(f'{elements:.2g}'):.0f} elements"
        if elements > MAX_ELEMENTS:
            return NextMesh(obstacle=f"it would take {count}, and the limit is {MAX_ELEMENTS}")
        draft = f"draft: safety factor {self.smallest.text}; refining, to about {count}"
        return NextMesh(wanted, draft=draft)


def size_ratio(
    mesh: TetMesh,
    cases: Sequence[CaseResult],
    tolerance_percent: float,
    *,
    again: bool = False,
    all_cases: bool = False,
    fatigue: Iterable[Judged] = (),
) -> Floats:
    """Factor (n_nodes,) on the elements' size that brings the smallest safety factor within a tolerance.

    `tolerance_percent`: of the smallest factor of the cases, or with `all_cases` of the largest von Mises
    stress and the smallest factor of each; `again`: whether the mesh has been refined for this tolerance
    already; `fatigue`: further fields whose peaks must be as well known (`usage` and `amplitude`).
    """
    masked, governing = cases[0].error.masked, Governing.of(cases)
    peaks = [(judged, tolerance_percent) for judged in fatigue]
    for case in cases:
        needed = tolerance_percent if all_cases else governing.needed(case, tolerance_percent)
        peaks += [(judged, needed) for judged in case.judged[0 if all_cases else 1 :]]
    ratio = np.ones(len(mesh.points))
    for (value, error), needed in peaks:
        ratio = np.minimum(ratio, _nodal_ratio(value, error, masked, mesh, needed / 100, again=again))
    for place in worst_of_edges(case.sharp_governing for case in cases):
        used = 1 / place.safety_factor
        if all_cases or _EDGES_WITHIN * used >= governing.utilisation:
            loose = place.error_percent > tolerance_percent
            decides = all_cases or place.highest > governing.utilisation
            size = place.element_size * (1.0 if all_cases else _COARSE_EDGES)
            ratio = np.minimum(ratio, _sharp_ratio(place, mesh, size, shrink=loose and decides))
    for case in cases:
        np.minimum.at(ratio, mesh.tets, _energy_ratio(case, mesh, _RATE[mesh.order])[:, None])
    return ratio


def wanted_sizes(mesh: MeshedRod, ratio: Floats) -> SizeField | None:
    """Sizes on what gmsh meshed, from a factor at each node of the whole; None where no factor is below 1."""
    drawn = mesh.drawn
    on_drawn = np.ones(len(drawn.points))
    np.minimum.at(on_drawn, mesh.drawn_node, ratio)
    # The elements around a node decide its error: all their vertices get the size, or none would.
    np.minimum.at(on_drawn, drawn.tets[:, :4], on_drawn[drawn.tets].min(axis=1)[:, None])
    if not (on_drawn < 1).any():
        return None
    size = np.where(on_drawn < 1, on_drawn * edge_length(drawn) / REALISED, np.inf)
    return SizeField(drawn.points, drawn.tets[:, :4], np.minimum(size, _NO_WISH))


def _nodal_ratio(
    value: Floats, own_error: Floats, masked: Mask, mesh: TetMesh, tolerance: float, *, again: bool
) -> Floats:
    """Factor on the size at each node of the whole, for the bar of a field's peak."""
    if masked.all():
        return np.ones(len(value))
    error = np.where(masked, 0.0, own_error)
    hottest = int(np.where(masked, -np.inf, value).argmax())
    aim = (_FIRST_AIM if mesh.order == 2 and not again else _AIM) * tolerance * value[hottest]
    # A node counts as far as its stress and error together reach beyond the peak's bar.
    allowed = np.maximum(value[hottest] - value - _RISE * error + aim, aim)
    factor = np.divide(allowed, error, out=np.ones_like(error), where=~masked & (error > 0))
    ratio = np.minimum(1.0, factor ** (1 / (_ROUGH_RATE if again else _RATE[mesh.order])))
    if again:
        ratio[ratio < 1] = np.minimum(ratio[ratio < 1], _ROUGH_RATIO)
    return np.asarray(np.maximum(ratio, LEAST_RATIO))


def _sharp_ratio(place: SharpPlace, mesh: TetMesh, size: float, *, shrink: bool) -> Floats:
    """Factor on the size at each node, for elements of a size, mm, beside a sharp edge and its images.

    They are smaller than before in any case where they are to `shrink`.
    """
    apart = np.linalg.norm(np.abs(mesh.points) * [0, 1, 1] - np.abs(place.at) * [0, 1, 1], axis=1)
    near = np.hypot(apart, mesh.points[:, 0] - place.at[0]) <= FINE_WITHIN * place.thickness
    length = edge_length(mesh)
    factor = REALISED * size / length
    if shrink:
        factor = np.minimum(factor, _ROUGH_RATIO)
    return np.where(near & np.isfinite(length), np.clip(factor, LEAST_RATIO, 1.0), 1.0)


def _energy_ratio(case: CaseResult, mesh: TetMesh, rate: float) -> Floats:
    """Factor on the size of each element, for the error in the energy norm."""
    share = case.error.element_percent
    if case.error.energy_percent <= ENERGY_PERCENT:
        return np.ones_like(share)
    permitted = ENERGY_PERCENT / np.sqrt(share.size)
    factor = (permitted / np.maximum(share, permitted)) ** (1 / (rate + 1.5))  # volume counts as h^(3/2)
    smooth = ~case.error.masked[mesh.tets].any(axis=1)
    return np.where(smooth, np.maximum(factor, _LEAST_ENERGY_RATIO), 1.0)


def edge_length(mesh: TetMesh) -> Floats:
    """Mean length (n_nodes,) of the edges at each vertex, mm; infinite at other nodes."""
    total, count = np.zeros((2, len(mesh.points)))
    for a, b in EDGES:
        length = np.linalg.norm(mesh.points[mesh.tets[:, a]] - mesh.points[mesh.tets[:, b]], axis=1)
        for end in (a, b):
            total += np.bincount(mesh.tets[:, end], length, minlength=total.size)
            count += np.bincount(mesh.tets[:, end], minlength=total.size)
    return np.divide(total, count, out=np.full_like(total, np.inf), where=count > 0)


def predicted_elements(mesh: MeshedRod, wanted: SizeField, growth: float) -> float:
    """How many elements of the whole rod the wanted sizes will make."""
    graded = wanted.graded(growth)
    tets = mesh.drawn.tets[:, :4]
    expected = REALISED * graded.size[tets].mean(axis=1)
    ratio = np.minimum(1.0, expected / edge_length(mesh.drawn)[tets].mean(axis=1))
    return float((ratio**-3.0).sum()) * len(mesh.whole.tets) / len(tets)


def _bars(cases: Sequence[CaseResult], fatigue: Sequence[Peak], *, all_cases: bool) -> Iterator[ErrorBar]:
    """Yield the bars that must reach the tolerance at one speed.

    Stresses beside sharp edges get small elements too, but are not waited for: those of short flanks would
    take the finest meshes.
    """
    points, governing = cases[0].mesh.points, Governing.of(cases)
    yield ErrorBar(governing.percent, governing.case, governing.place)
    judged = [("fatigue", each) for each in fatigue]
    if all_cases:
        judged += [(case.load.name, each) for case in cases for each in (case.peak, case.worst)]
    for name, each in judged:
        yield ErrorBar(each.error_percent, name, tuple(points[each.bar_node].tolist()))


def _factors(cases: Sequence[CaseResult], fatigue: Sequence[Peak]) -> Iterator[SafetyFactor]:
    for case in cases:
        yield case.min_safety_factor
        for edge in case.sharp_governing:
            yield edge.safety_factor.against("yielding", case.load.name, "sharp edge")
    for used in fatigue:
        yield SafetyFactor.of_stress(1 / used.value, used.error_percent, mode="fatigue")


def amplitude(cases: Sequence[CaseResult]) -> tuple[Floats, Floats]:
    """Largest amplitude of the von Mises stress between any two cases (n_nodes,), and its error, MPa."""
    pairs = [
        (von_mises(one.stress - other.stress) / 2, (one.von_mises_error + other.von_mises_error) / 2)
        for one, other in itertools.combinations(cases, 2)
    ]
    value, error = pairs[0]
    for other, its_error in pairs[1:]:
        larger = other > value
        value, error = np.where(larger, other, value), np.where(larger, its_error, error)
    return value, error


def usage(
    rod: PreparedRod, cases: Sequence[CaseResult], *, with_support: bool = False
) -> tuple[Floats, Floats] | None:
    """One over the safety factor against fatigue between the cases (n_nodes,), and its error.

    Mean and amplitude are those of the signed equivalent stress, as over a cycle. Parts of which a strength
    that the criterion needs is not known are left out; None where it is known of none. `with_support`: by
    the gradient of the amplitude, as over a cycle.
    """
    mesh, criterion = rod.mesh.whole, rod.options.fatigue
    rows, (mean, half, error) = np.arange(len(mesh.points)), between(cases)
    used, more = np.zeros((2, len(rows)))
    regions = rod.regions.supported(mesh, half, cases[0].error.masked) if with_support else rod.regions
    for number, material in enumerate(rod.materials):
        of_part = rows if mesh.part is None else np.unique(mesh.tets[mesh.part == number])
        surface = regions.at(of_part).factors(material)
        at = mean[of_part], half[of_part], error[of_part]
        now = fatigue_factor(criterion, at[0], at[1], material, surface)
        worse = fatigue_factor(criterion, at[0] + at[2], at[1] + at[2], material, surface)
        if now is None or worse is None:
            continue
        own = 1 / now
        larger = own > used[of_part]
        used[of_part[larger]], more[of_part[larger]] = own[larger], (1 / worse - own)[larger]
    return (used, more) if used.any() else None


def between(cases: Sequence[CaseResult]) -> tuple[Floats, Floats, Floats]:
    """Mean and amplitude (n_nodes,) of the signed equivalent stress between cases, and their error, MPa."""
    rows = np.arange(len(cases[0].stress))
    signed = signed_equivalent(deviatoric(np.stack([case.stress for case in cases], axis=-1)))
    off = np.stack([case.von_mises_error for case in cases], axis=-1)
    highest, lowest = signed.argmax(axis=1), signed.argmin(axis=1)
    mean = (signed[rows, highest] + signed[rows, lowest]) / 2
    half = (signed[rows, highest] - signed[rows, lowest]) / 2
    return mean, half, (off[rows, highest] + off[rows, lowest]) / 2
