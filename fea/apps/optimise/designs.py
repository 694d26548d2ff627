"""Designs of a rod that a search tries, and the mesh of one moved to the next."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count

import numpy as np

from fea.analysis.film import film_at
from fea.analysis.pipeline import MovingRod, RefinedRod, refined_rod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.optimise.limits import FILM, Limit, Thinnest, limits, required
from fea.apps.optimise.record import Record
from fea.apps.optimise.variables import Variables
from fea.base.choices import CONVERGED_PERCENT
from fea.base.units import KG
from fea.machine.clock import Clock
from fea.output.json_file import JsonObject
from geometry.arrays import Floats
from geometry.errors import GeometryError, require
from mesh.tetmesh import MeshError

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
    remeshed: bool = False  #: whether its mesh was made for it, rather than moved from another rod's
    mesh: int = 0  #: number of the mesh that was made for it or that its own was moved from
    #: of each speed, the smallest film on the fine grid over that on the coarse one, on that mesh
    finer: Sequence[tuple[float, float]] = ()

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
    finer: Sequence[tuple[float, float]] = ()


class Designs:
    """Computes designs: `tried` holds all, in order; `count` is the number of meshes that were solved.

    The listener is called with each design, the count, and how many of these meshes were solved now: none
    before the first design that the record does not have. The mesh of one rod is moved to the next, where it
    can be. Designs that the record has are not computed again.
    """

    def __init__(
        self,
        variables: Variables,
        listener: Callable[[Design, int, int], None] = lambda _design, _count, _now: None,
        *,
        record: Record | None = None,
    ) -> None:
        # What limits a design takes of its film is computed apart, on the coarse grid where that will do.
        options = replace(variables.study.analysis, film=False)
        self.variables = replace(variables, study=replace(variables.study, analysis=options))
        self.tried: list[Design] = []
        self.count = 0
        self._listener, self._record = listener, record
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

    def _rod(self, x: Floats) -> tuple[RefinedRod, int, bool]:
        """The rod on the nearest mesh moved, else its own; the mesh's number, and whether it is its own."""
        study = self.variables.study_at(x)
        base = min(self._made, key=lambda made: float(np.linalg.norm(made.x - x)))
        if base.moving is None:
            base.moving = MovingRod(self._adapted(base.x, base.coarsest).rod.mesh)
        for other in self._made:  # of the factors only one is kept
            if other.moving is not None and other is not base:
                other.moving.forget()
        mesh = base.moving.mesh(study)
        if mesh is not None:
            return RefinedRod(base.moving.prepared(study, mesh)), base.number, False
        return *self._meshed(x), True

    def _meshed(self, x: Floats) -> tuple[RefinedRod, int]:
        adapted = self._adapted(x, self._coarsest)
        self._meshes += 1
        self._made.append(_Made(x, self._meshes, self._coarsest, MovingRod(adapted.rod.mesh)))
        self.count += max(1, len(adapted.passes)) - 1  # the last one counts with its design
        return adapted, self._meshes

    def _adapted(self, x: Floats, coarsest: float) -> RefinedRod:
        study = self.variables.study_at(x)
        tolerance = study.tolerance_percent
        if tolerance is not None:
            tolerance = max(tolerance, coarsest)
            study = replace(study, analysis=replace(study.analysis, tolerance_percent=tolerance))
        return refined_rod(study, study.speeds(), Clock(), movable=True)

    def _computed(
        self,
        kind: str,
        adapted: RefinedRod,
        x: Floats,
        asked: Floats,
        *,
        mesh: int,
        remeshed: bool,
        before: int,
    ) -> Design:
        results = [adapted.at(rpm) for rpm in self.variables.study.speeds()]
        made = next(made for made in self._made if made.number == mesh)
        films = self._films(adapted.rod, results, made.finer) if FILM in self._required else []
        made.finer = [film.finer for film in films]
        margins = limits(adapted.rod, results, self._required, films)
        design = Design(x, adapted.rod.mass.mass / KG, margins, remeshed, mesh, finer=made.finer)
        self.tried.append(design)
        self.count += 1
        self._now += self.count - before
        if self._record is not None:
            known = asdict(design) | {"x": x.tolist()}
            self._record.add({"kind": kind, "asked": asked.tolist(), "count": self.count, "design": known})
        self._listener(design, self.count, self._now)
        return design

    def _films(
        self, rod: PreparedRod, results: Sequence[SpeedResult], finer: Sequence[tuple[float, float]]
    ) -> list[Thinnest]:
        """The film at each speed: whole on a mesh's first rod; of others on the coarse grid, corrected.

        Raises `InvalidValue`: the film of the rod that was asked for starves or overheats.
        """
        speeds = [result.rpm or 0.0 for result in results]
        if finer:
            return [Thinnest.like(rod, rpm, ratio) for rpm, ratio in zip(speeds, finer, strict=True)]
        found = [result.film or film_at(rod, result.rpm or 0.0) for result in results]
        for rpm, film in zip(speeds, found, strict=True):
            rule = f"cannot be sought: the film of the rod as it is, at {rpm:g} rpm, is {film.verdict}"
            remedy = "Look at it with fea run --film; change [film], or the speeds."
            first = not self.tried
            require(film.sound or not first, "optimise.min_film_um", self._required[FILM], rule, remedy)
        return [Thinnest.of(film) for film in found]

    def _recorded(self, kind: str, asked: Floats) -> Design | None:
        entry: JsonObject | None = None if self._record is None else self._record.next(kind, asked)
        if entry is None:
            return None
        known = entry["design"]
        own = {"x": np.array(known["x"]), "limits": tuple(Limit(**limit) for limit in known["limits"])}
        design = Design(**known | own)
        if design.remeshed:
            self._meshes = design.mesh
            self._made.append(_Made(design.x, design.mesh, self._coarsest, finer=design.finer))
        self.tried.append(design)
        self.count = entry["count"]
        self._listener(design, self.count, self._now)
        return design
