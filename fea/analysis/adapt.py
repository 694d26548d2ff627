"""Remesh where the estimate says, until the smallest safety factor is known to the tolerance."""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fea.analysis.figures import PassFigures
from fea.analysis.meshing import adaptive_mesh
from fea.analysis.prepare import PreparedRod, prepare
from fea.analysis.speed import SpeedResult, solve_speed, with_cycle, with_film
from fea.analysis.wanted_size import Judged, predicted_elements, size_ratio, wanted_sizes
from fea.base.note import Note, doubt
from fea.judge.case_result import CaseResult, Governing
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import Peak, peak
from fea.machine.clock import Clock, Listener
from fea.rod.discretise import drawn_once
from fea.rod.meshed_rod import MeshedRod
from fea.solid.stress import von_mises
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import GeometryError
from mesh.sizing import SizeField, Sizing
from mesh.tetmesh import MeshError

# Of many speeds this many, evenly spread, decide on the mesh: between them the shape of the stress changes
# little.
MOST_SPEEDS = 5
# The last pass gives the answer; those before it should not cost more than one and a half times as much.
MAX_PASSES = 4
# About ten gigabytes and some minutes with a direct solver on a quarter of the rod.
MAX_ELEMENTS = 600_000
# What a coarse mesh asks for is vague: a mesh of more elements than this that has so many times those of the
# last one is approached by one with half the change of size (by its logarithm).
_MANY, _LEAP = 200_000, 6.0
# Over all speeds, nodes whose fields stay in memory until they are asked for, at about a kilobyte each; the
# last mesh is solved once more for further speeds.
MAX_KEPT_NODES = 1_000_000


@dataclass(frozen=True)
class Adapted:
    """The rod on its last mesh, and how that came about."""

    rod: PreparedRod  #: of the last pass
    passes: tuple[PassFigures, ...] = ()  #: all of them; none where no tolerance was asked for
    shortfall: Note | None = None  #: why the tolerance is not met; None where it is
    #: By speed, as far as they are kept
    results: Mapping[float | None, SpeedResult] = field(default_factory=dict)

    def at(self, rpm: float | None) -> SpeedResult:
        """Solve the load cases of one speed (rpm); None for given forces."""
        result = self.results.get(rpm) or solve_speed(self.rod, rpm)
        if self.rod.options.cycle:
            result = with_cycle(self.rod, result)
        if self.rod.options.needs_film:
            result = with_film(self.rod, result)
        if self.shortfall is None:
            return result
        return dataclasses.replace(result, notes=(*result.notes, self.shortfall))


@drawn_once()
def adapt_mesh(
    study: Study,
    speeds: Sequence[float | None],
    clock: Clock,
    listener: Listener | None = None,
    mesh: MeshedRod | None = None,
    *,
    movable: bool = False,
) -> Adapted:
    """Prepare the rod of a study, on ever better meshes where a tolerance is asked for.

    The tolerance, `Study.tolerance_percent`, is met for the smallest safety factor at each of the `speeds`,
    rpm (None for given forces), and of the study's duty: against yielding, and with a cycle against fatigue.
    With `AnalysisTable.all_cases` it is met for every load case. `mesh` is the first one, where it is there
    already (see `fea.analysis.meshing.adaptive_mesh`); `movable` tells whether the last one is to follow
    other dimensions. Raises `GeometryError`, `MeshError`, `InvalidValue`, …: see
    `fea.analysis.prepare.prepare`. Where a finer mesh cannot be made, the last one gives the answer.
    """
    mesh = adaptive_mesh(study, clock, movable=movable) if mesh is None else mesh
    tolerance = study.tolerance_percent
    if tolerance is None:
        return Adapted(prepare(study, clock, mesh=mesh))
    of_duty = () if study.duty is None else study.duty.speeds
    deciding = _deciding(tuple(dict.fromkeys((*speeds, *of_duty))))
    passes, fields = list[PassFigures](), list[SizeField]()
    while True:
        rod = prepare(study, clock, mesh=mesh)
        widest, ratio, results, draft = _solved(rod, deciding, tolerance, again=bool(fields))
        whole, seconds = rod.mesh.whole, clock.total - sum(item.seconds for item in passes)
        size = {"elements": len(whole.tets), "nodes": len(whole.points)}
        passes.append(PassFigures(**size, error_percent=widest.percent, seconds=seconds))
        met, wanted = widest.percent <= tolerance, wanted_sizes(rod.mesh, ratio)
        growth = Sizing(rod.mesh.meshing.size).growth
        further = wanted is not None and not met and not rod.options.draft and len(passes) < MAX_PASSES
        elements = predicted_elements(rod.mesh, wanted, growth) if wanted and further else 0.0
        if elements > max(_MANY, _LEAP * len(whole.tets)) and (wanted := wanted_sizes(rod.mesh, ratio**0.5)):
            elements = predicted_elements(rod.mesh, wanted, growth)
        obstacle = "" if met else _obstacle(rod, elements, len(passes))
        if listener:
            listener(passes[-1].text(len(passes)))
            if len(passes) == 1 and not (met or obstacle):
                listener(
                    f"draft: safety factor {draft.text}; "
                    f"refining, to about {float(f'{elements:.2g}'):.0f} elements"
                )
        if met or wanted is None or obstacle:
            break
        fields.append(wanted)
        try:
            mesh = adaptive_mesh(study, clock, fields, movable=movable)
        except (GeometryError, MeshError) as error:
            obstacle = f"no finer mesh could be made. {error}"
            break
        del rod, results  # their memory is that of the next ones
    unmet = f"the tolerance of {tolerance:g} % is not met ({widest.text}): {obstacle}"
    return Adapted(rod, tuple(passes), doubt(unmet) if obstacle else None, results)


class _Widest(NamedTuple):
    """The error bar that must reach the tolerance: percent, its load case, and the place that sets it, mm."""

    percent: float = 0.0
    case: str = ""
    place: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        x, y, z = (f"{coordinate:.1f}" for coordinate in self.place)
        return f"±{self.percent:.2g} % in {self.case}, because of ({x}, {y}, {z}) mm"


def _deciding(speeds: Sequence[float | None]) -> Sequence[float | None]:
    if len(speeds) <= MOST_SPEEDS:
        return speeds
    rising = sorted(rpm or 0.0 for rpm in speeds)
    return [rising[index] for index in np.linspace(0, len(rising) - 1, MOST_SPEEDS).round().astype(int)]


def _solved(
    rod: PreparedRod, speeds: Sequence[float | None], tolerance: float, *, again: bool
) -> tuple[_Widest, Floats, dict[float | None, SpeedResult], SafetyFactor]:
    """Solve some speeds: the bar, factors (n_nodes,) on the size, the results kept, the smallest factor."""
    mesh, all_cases = rod.mesh.whole, rod.options.all_cases
    widest, ratio = _Widest(), np.ones(len(mesh.points))
    most = max(1, MAX_KEPT_NODES // len(mesh.points))
    results: dict[float | None, SpeedResult] = {}
    factors: list[SafetyFactor] = []
    for rpm in speeds:
        result = solve_speed(rod, rpm)
        cases = tuple(result.cases.values())
        fatigue = _fatigue(rod, cases)
        used = [peak(*field, cases[0].error.masked) for field in fatigue[:-1]]
        widest = max(widest, *_bars(cases, used, all_cases=all_cases))
        factors += _factors(cases, used)
        wanted = size_ratio(mesh, cases, tolerance, again=again, all_cases=all_cases, fatigue=fatigue)
        ratio = np.minimum(ratio, wanted)
        if len(results) < most:
            results[rpm] = result
    return widest, ratio, results, min(factors, key=lambda factor: factor.low)


def _fatigue(rod: PreparedRod, cases: Sequence[CaseResult]) -> list[Judged]:
    """Where a cycle is asked for, what the cases tell of fatigue: utilisation, if known, and amplitude."""
    if not rod.options.cycle or len(cases) < 2:
        return []
    used = usage(rod, cases)
    return [*([] if used is None else [used]), amplitude(cases)]


def _bars(cases: Sequence[CaseResult], fatigue: Sequence[Peak], *, all_cases: bool) -> Iterator[_Widest]:
    """Yield the bars that must reach the tolerance at one speed.

    Stresses beside sharp edges get small elements too, but are not waited for: those of short flanks would
    take the finest meshes.
    """
    points, governing = cases[0].mesh.points, Governing.of(cases)
    yield _Widest(governing.percent, governing.case, governing.place)
    judged = [("fatigue", each) for each in fatigue]
    if all_cases:
        judged += [(case.load.name, each) for case in cases for each in (case.peak, case.worst)]
    for name, each in judged:
        yield _Widest(each.error_percent, name, tuple(points[each.bar_node].tolist()))


def _factors(cases: Sequence[CaseResult], fatigue: Sequence[Peak]) -> Iterator[SafetyFactor]:
    for case in cases:
        yield SafetyFactor.of_stress(case.min_safety_factor, case.worst.error_percent, instant=case.load.name)
        for edge in case.sharp_governing:
            edge_of = {"instant": case.load.name, "place": "sharp edge"}
            yield SafetyFactor.of_stress(edge.safety_factor, edge.error_percent, **edge_of)
    for used in fatigue:
        yield SafetyFactor.of_stress(1 / used.value, used.error_percent, mode="fatigue")


def _obstacle(rod: PreparedRod, elements: float, n_passes: int) -> str:
    if rod.options.draft:
        return "this is a draft; without --draft the mesh is refined"
    if not elements:
        meshes = "1 mesh was" if n_passes == 1 else f"{n_passes} meshes were"
        return f"{meshes} tried; start from a smaller --size"
    if elements > MAX_ELEMENTS:
        return f"it would take {float(f'{elements:.2g}'):.0f} elements, and the limit is {MAX_ELEMENTS}"
    return ""


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


def usage(rod: PreparedRod, cases: Sequence[CaseResult]) -> tuple[Floats, Floats] | None:
    """One over the safety factor against fatigue between the cases (n_nodes,), and its error.

    Mean and amplitude are those of the signed equivalent stress, as over a cycle. Parts of which a strength
    that the criterion needs is not known are left out; None where it is known of none.
    """
    mesh, criterion = rod.mesh.whole, rod.options.fatigue
    rows = np.arange(len(mesh.points))
    signed = signed_equivalent(deviatoric(np.stack([case.stress for case in cases], axis=-1)))
    off = np.stack([case.von_mises_error for case in cases], axis=-1)
    highest, lowest = signed.argmax(axis=1), signed.argmin(axis=1)
    mean = (signed[rows, highest] + signed[rows, lowest]) / 2
    half = (signed[rows, highest] - signed[rows, lowest]) / 2
    error = (off[rows, highest] + off[rows, lowest]) / 2
    used, more = np.zeros((2, len(rows)))
    for number, material in enumerate(rod.materials):
        of_part = rows if mesh.part is None else np.unique(mesh.tets[mesh.part == number])
        surface = rod.regions.at(of_part).factors(material)
        at = mean[of_part], half[of_part], error[of_part]
        now = fatigue_factor(criterion, at[0], at[1], material, surface)
        worse = fatigue_factor(criterion, at[0] + at[2], at[1] + at[2], material, surface)
        if now is None or worse is None:
            continue
        own = 1 / now
        larger = own > used[of_part]
        used[of_part[larger]], more[of_part[larger]] = own[larger], (1 / worse - own)[larger]
    return (used, more) if used.any() else None
