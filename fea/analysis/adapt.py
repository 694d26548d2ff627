"""Remesh where the estimate says, until every peak is within the tolerance."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fea.analysis.figures import PassFigures
from fea.analysis.meshing import adaptive_mesh
from fea.analysis.prepare import PreparedRod, prepare
from fea.analysis.speed import SpeedResult, solve_speed, with_cycle
from fea.analysis.wanted_size import predicted_elements, size_ratio, wanted_sizes
from fea.base.note import Note, doubt
from fea.judge.case_result import CaseResult
from fea.machine.clock import Clock
from fea.rod.meshed_rod import MeshedRod
from fea.study.study import Study
from geometry.arrays import Floats
from mesh.sizing import SizeField, Sizing

# Of many speeds this many, evenly spread, decide on the mesh: between them the shape of the stress changes
# little.
MOST_SPEEDS = 5
# The last pass gives the answer; those before it should not cost more than one and a half times as much.
MAX_PASSES = 4
# About ten gigabytes and some minutes with a direct solver on a quarter of the rod.
MAX_ELEMENTS = 600_000
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
        if self.shortfall is None:
            return result
        return dataclasses.replace(result, notes=(*result.notes, self.shortfall))


def adapt_mesh(
    study: Study,
    speeds: Sequence[float | None],
    clock: Clock,
    listener: Callable[[str], None] | None = None,
    mesh: MeshedRod | None = None,
    *,
    movable: bool = False,
) -> Adapted:
    """Prepare the rod of a study, on ever better meshes where a tolerance is asked for.

    The tolerance, `Study.tolerance_percent`, is met for every load case at `speeds`, rpm (None for given
    forces), and at those of the study's duty. `mesh` is the first one, where it is there already (see
    `fea.analysis.meshing.adaptive_mesh`); `movable` tells whether the last one is to follow other dimensions.

    Raises
    ------
    GeometryError, MeshError, InvalidValue, …
        See `fea.analysis.prepare.prepare`.
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
        widest, ratio, results = _solved(rod, deciding, tolerance, again=bool(fields))
        passes.append(_pass(rod, widest.percent, clock.total - sum(item.seconds for item in passes)))
        if listener:
            listener(passes[-1].text(len(passes)))
        met, wanted = widest.percent <= tolerance, wanted_sizes(rod.mesh, ratio)
        obstacle = "" if met else _obstacle(rod, wanted, len(passes))
        if met or wanted is None or obstacle:
            break
        fields.append(wanted)
        del rod, results  # their memory is the next mesh's
        mesh = adaptive_mesh(study, clock, fields, movable=movable)
    unmet = f"the tolerance of {tolerance:g} % is not met ({widest.text}): {obstacle}"
    shortfall = doubt(unmet) if obstacle else None
    return Adapted(rod, tuple(passes), shortfall, results)


class _Widest(NamedTuple):
    """The largest error bar of all load cases: percent, the case, and the place that sets the bar, mm."""

    percent: float = 0.0
    case: str = ""
    place: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """The bar, its case and its place."""
        x, y, z = (f"{coordinate:.1f}" for coordinate in self.place)
        return f"±{self.percent:.2g} % in {self.case}, because of ({x}, {y}, {z}) mm"


def _deciding(speeds: Sequence[float | None]) -> Sequence[float | None]:
    """Return the speeds that decide on the mesh: the lowest, the highest and some between."""
    if len(speeds) <= MOST_SPEEDS:
        return speeds
    rising = sorted(rpm or 0.0 for rpm in speeds)
    return [rising[index] for index in np.linspace(0, len(rising) - 1, MOST_SPEEDS).round().astype(int)]


def _solved(
    rod: PreparedRod, speeds: Sequence[float | None], tolerance: float, *, again: bool
) -> tuple[_Widest, Floats, dict[float | None, SpeedResult]]:
    """Solve some speeds: the largest bar, factors (n_nodes,) on the size, and the results kept."""
    mesh = rod.mesh.whole
    widest, ratio = _Widest(), np.ones(len(mesh.points))
    most = max(1, MAX_KEPT_NODES // len(mesh.points))
    results: dict[float | None, SpeedResult] = {}
    for rpm in speeds:
        result = solve_speed(rod, rpm)
        cases = tuple(result.cases.values())
        widest = max(widest, *map(_bar, cases))
        wanted = size_ratio(mesh, cases, tolerance, again=again, fatigue=rod.options.cycle)
        ratio = np.minimum(ratio, wanted)
        if len(results) < most:
            results[rpm] = result
    return widest, ratio, results


def _bar(case: CaseResult) -> _Widest:
    """Return the larger bar of a case: of its peak, or of its least safety factor.

    Stresses beside sharp edges get small elements too, but are not waited for: those of short flanks would
    take the finest meshes.
    """
    widest = max(case.peak, case.worst, key=lambda peak: peak.error_percent)
    place = tuple(case.mesh.points[widest.bar_node].tolist())
    return _Widest(widest.error_percent, case.load.name, place)


def _pass(rod: PreparedRod, error_percent: float, seconds: float) -> PassFigures:
    mesh = rod.mesh.whole
    return PassFigures(
        elements=len(mesh.tets), nodes=len(mesh.points), error_percent=error_percent, seconds=seconds
    )


def _obstacle(rod: PreparedRod, wanted: SizeField | None, n_passes: int) -> str:
    """Why there is no further pass; empty where one is possible."""
    if wanted is None or n_passes == MAX_PASSES:
        meshes = "1 mesh was" if n_passes == 1 else f"{n_passes} meshes were"
        return f"{meshes} tried; start from a smaller --size"
    elements = predicted_elements(rod.mesh, wanted, Sizing(rod.mesh.meshing.size).growth)
    if elements > MAX_ELEMENTS:
        return f"it would take {elements:.2g} elements, and the limit is {MAX_ELEMENTS}"
    return ""
