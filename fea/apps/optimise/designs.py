"""Designs of a rod that a search tries, the mesh of one moved to the next, and what limits each."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count

import numpy as np

from fea.analysis.adapt import Adapted, adapt_mesh
from fea.analysis.buckling import buckling_report
from fea.analysis.moving import MovingRod
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult
from fea.apps.optimise.record import Record
from fea.apps.optimise.variables import Variables
from fea.base.choices import CONVERGED_PERCENT
from fea.base.units import KG
from fea.machine.clock import Clock
from fea.output.json_file import JsonObject
from fea.study.option_tables import OptimiseTable
from fea.study.study import Study
from geometry.arrays import Floats, Mask
from geometry.errors import GeometryError
from mesh.tetmesh import MeshError

YIELDING, FATIGUE, BUCKLING = "yielding", "fatigue", "buckling"
_PLACES = ("big end", "shank", "small end")


def required(study: Study) -> dict[str, float]:
    """Return the safety factors, less their error bars, that a study asks for, by mode of failure."""
    table, usual = study.optimise or OptimiseTable(), study.analysis.min_safety or 1.0
    asked = (table.min_yield_safety, table.min_fatigue_safety, table.min_buckling_safety)
    return {mode: own or usual for mode, own in zip((YIELDING, FATIGUE, BUCKLING), asked, strict=True)}


@dataclass(frozen=True)
class Limit:
    """A limit on a rod, by mode of failure and place: ``"fatigue, shank"``.

    `factor` is the smallest safety factor there over all speeds, `error_percent` the error bar of the stress
    behind it, `required` what the factor less its bar must reach.
    """

    name: str
    factor: float
    error_percent: float
    required: float

    @property
    def low(self) -> float:
        """The factor if the stress is higher by its error bar."""
        return self.factor / (1 + self.error_percent / 100)

    @property
    def margin(self) -> float:
        """Share of what the rod may bear that is left, at most 1; linear in the stress, so smooth."""
        return 1 - self.required / self.low


def limits(rod: PreparedRod, results: Sequence[SpeedResult], asked: Mapping[str, float]) -> tuple[Limit, ...]:
    """Return the limits of a rod that is solved at all speeds; each is the worst of them.

    Stress limits the rod in both ends and in the shank, each by itself: the largest stress of one place
    changes smoothly with the dimensions, that of the whole rod has a kink wherever the place changes. Raises
    `SingularMatrixError`: see `fea.analysis.buckling.buckling_report`.
    """
    worst: dict[str, Limit] = {}
    for result in results:
        for limit in (*_of_stress(rod, result, asked), *_of_buckling(rod, result, asked)):
            if limit.name not in worst or limit.margin < worst[limit.name].margin:
                worst[limit.name] = limit
    return tuple(worst.values())


def _of_stress(rod: PreparedRod, result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    bar = max(case.error_percent for case in result.cases.values())
    if result.cycle is None:
        counts = np.all([case.counts for case in result.cases.values()], axis=0)
        factors = {YIELDING: np.min([case.safety_factor for case in result.cases.values()], axis=0)}
    else:
        counts, envelope = result.cycle.counts, result.cycle.envelope
        factors = {YIELDING: 1 / np.maximum(envelope.usage, 1e-300)}
        if envelope.fatigue_factor is not None:
            factors[FATIGUE] = np.where(np.isnan(envelope.fatigue_factor), np.inf, envelope.fatigue_factor)
    limits_here = []
    for place, own in zip(_PLACES, _places(rod), strict=True):
        here = own & counts
        for mode, factor in factors.items():
            least = float(factor[here].min(initial=np.inf))
            if np.isfinite(least):
                limits_here.append(Limit(f"{mode}, {place}", least, bar, asked[mode]))
    return [*limits_here, *_of_edges(result, asked)]


def _of_edges(result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    edges = [edge for case in result.cases.values() for edge in case.sharp_mattering]
    if not edges:
        return []
    worst = min(edges, key=lambda edge: edge.safety_factor / (1 + edge.error_percent / 100))
    return [Limit(f"{YIELDING}, sharp edge", worst.safety_factor, worst.error_percent, asked[YIELDING])]


def _places(rod: PreparedRod) -> tuple[Mask, Mask, Mask]:
    """Nodes (n_nodes,) of big end, shank and small end."""
    x, bores = rod.mesh.whole.points[:, 0], rod.mesh.bores
    shape = rod.study.rod.dimensions
    if shape is None:
        raise ValueError("only a rod with dimensions has places")
    big, small = x <= shape.big_end_radius, x >= bores.rod_length - shape.small_end_radius
    return big, ~(big | small), small


def _of_buckling(rod: PreparedRod, result: SpeedResult, asked: Mapping[str, float]) -> list[Limit]:
    figures = buckling_report(rod, result).figures
    column = [
        Limit(f"{BUCKLING}, {plane.replace('_', ' ')}", one.safety_factor, 0.0, asked[BUCKLING])
        for plane, one in figures.column.planes.items()
        if one.safety_factor is not None
    ]
    modes = [mode.factor for own in (figures.modes or {}).values() for mode in own]
    return (
        [*column, Limit(f"{BUCKLING}, of the solid", min(modes), 0.0, asked[BUCKLING])] if modes else column
    )


# Of the way from a rod that can be meshed to one that cannot, after which a search goes less far.
_SHORTER = 0.5
_TRIES = 3
# Meshes that others are moved from.
_KEPT = 8


@dataclass(frozen=True)
class Design:
    """A rod that was tried."""

    x: Floats  #: (n,) its free dimensions, scaled to 0 … 1 between their bounds
    mass_kg: float
    limits: tuple[Limit, ...]
    #: scaled distance from the rod that was asked for, which cannot be drawn, to this one; 0 where it can
    infeasibility: float = 0.0
    remeshed: bool = False  #: whether its mesh was made for it, rather than moved from another rod's
    mesh: int = 0  #: number of the mesh that was made for it or that its own was moved from

    @property
    def margin(self) -> float:
        """The least margin of all limits."""
        return min(limit.margin for limit in self.limits)

    @property
    def lacking(self) -> float:
        """What it lacks of all limits together, 0 where it holds."""
        return -sum(min(0.0, limit.margin) for limit in self.limits)

    @property
    def governing(self) -> Limit:
        """The limit with the least margin."""
        return min(self.limits, key=lambda limit: limit.margin)


@dataclass
class _Made:
    """A mesh that others are moved from; that of a resumed search's design is made when first needed."""

    x: Floats
    number: int
    coarsest: float
    moving: MovingRod | None = None


class Designs:
    """Computes designs: `tried` holds all, in order; `count` is the number of meshes that were solved.

    The listener is called with each design that is computed, the count, and how many of these meshes were
    solved now. With `morphing`, the mesh of one rod is moved to the next, where it can be. Designs that the
    record knows are not computed again.
    """

    def __init__(
        self,
        variables: Variables,
        listener: Callable[[Design, int, int], None] = lambda _design, _count, _now: None,
        *,
        morphing: bool = True,
        record: Record | None = None,
    ) -> None:
        self.variables = variables
        self.tried: list[Design] = []
        self.count = 0
        self._listener, self._morphing, self._record = listener, morphing, record
        self._required = required(variables.study)
        self._made: deque[_Made] = deque(maxlen=_KEPT)
        self._meshes, self._now = 0, 0
        self._feasible = variables.start
        self._coarsest = CONVERGED_PERCENT

    def begin(self, x: Floats) -> Design:
        """Compute a design on a mesh of its own, refined as its study asks for; others follow from that mesh.

        The first mesh, with which the search covers most of the way, need only be converged. Raises
        `GeometryError`, `MeshError`: the rod cannot be drawn or meshed.
        """
        if self._made:
            self._coarsest = 0.0
        self._made.clear()
        self._feasible = x
        known = self._recorded("begin", x)
        if known is not None:
            return known
        before, (adapted, mesh) = self.count, self._meshed(x)
        return self._computed("begin", adapted, x, x, mesh=mesh, remeshed=True, before=before)

    def at(self, x: Floats) -> Design:
        """Compute a design on the mesh of another, moved; of a rod that cannot be drawn, the nearest one.

        Raises `GeometryError`, `MeshError`: not even rods much closer to the last one begun can be drawn or
        meshed.
        """
        known, before = self._recorded("at", x), self.count
        if known is not None:
            return known
        near = self.variables.nearest_feasible(x, self._feasible)
        for tries in count(1):
            try:
                adapted, mesh, remeshed = self._rod(near)
            except (GeometryError, MeshError):
                if tries == _TRIES:
                    raise
                near = near + _SHORTER * (self._feasible - near)
            else:
                return self._computed("at", adapted, near, x, mesh=mesh, remeshed=remeshed, before=before)
        raise AssertionError  # the loop has no end

    def nearest(self, x: Floats, sound: Floats) -> Floats:
        """Return the last design (n,) that can be drawn on the way to `x` from another that can."""
        return self.variables.nearest_feasible(x, sound)

    def _rod(self, x: Floats) -> tuple[Adapted, int, bool]:
        """The rod on the nearest mesh moved, else its own; the mesh's number, and whether it is its own."""
        if self._morphing:
            study = self.variables.study_at(x)
            base = min(self._made, key=lambda made: float(np.linalg.norm(made.x - x)))
            if base.moving is None:
                base.moving = MovingRod(self._adapted(base.x, base.coarsest).rod.mesh)
            for other in self._made:  # of the factors only one is kept
                if other.moving is not None and other is not base:
                    other.moving.forget()
            mesh = base.moving.mesh(study)
            if mesh is not None:
                return Adapted(base.moving.prepared(study, mesh)), base.number, False
        return *self._meshed(x), True

    def _meshed(self, x: Floats) -> tuple[Adapted, int]:
        adapted = self._adapted(x, self._coarsest)
        self._meshes += 1
        self._made.append(_Made(x, self._meshes, self._coarsest, MovingRod(adapted.rod.mesh)))
        self.count += max(1, len(adapted.passes)) - 1  # the last one counts with its design
        return adapted, self._meshes

    def _adapted(self, x: Floats, coarsest: float) -> Adapted:
        study = self.variables.study_at(x)
        tolerance = study.tolerance_percent
        if tolerance is not None:
            tolerance = max(tolerance, coarsest)
            study = replace(study, analysis=replace(study.analysis, tolerance_percent=tolerance))
        return adapt_mesh(study, study.speeds(), Clock(), movable=self._morphing)

    def _computed(
        self, kind: str, adapted: Adapted, x: Floats, asked: Floats, *, mesh: int, remeshed: bool, before: int
    ) -> Design:
        results = [adapted.at(rpm) for rpm in self.variables.study.speeds()]
        margins = limits(adapted.rod, results, self._required)
        infeasibility = float(np.linalg.norm(asked - x))
        design = Design(x, adapted.rod.mass.mass / KG, margins, infeasibility, remeshed, mesh)
        self.tried.append(replace(design, infeasibility=0.0))
        self.count += 1
        self._now += self.count - before
        if self._record is not None:
            known = asdict(design) | {"x": x.tolist()}
            self._record.add({"kind": kind, "asked": asked.tolist(), "count": self.count, "design": known})
        self._listener(design, self.count, self._now)
        return design

    def _recorded(self, kind: str, asked: Floats) -> Design | None:
        entry: JsonObject | None = None if self._record is None else self._record.next(kind, asked)
        if entry is None:
            return None
        known = entry["design"]
        own = {"x": np.array(known["x"]), "limits": tuple(Limit(**limit) for limit in known["limits"])}
        design = Design(**known | own)
        if design.remeshed:
            self._meshes = design.mesh
            self._made.append(_Made(design.x, design.mesh, self._coarsest))
        self.tried.append(replace(design, infeasibility=0.0))
        self.count = entry["count"]
        return design
