"""Designs of a rod that a search tries, the mesh of one moved to the next, and their record in a file."""

import hashlib
import json
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from fea.analysis.film import film_at
from fea.analysis.pipeline import MovingRod, RefinedRod, refined_rod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.optimise.problem import FILM, DesignConstraint, MinimumFilm, Variables, constraints, required
from fea.apps.sweep.sweep_file import digest, files_of
from fea.base.choices import CONVERGED_PERCENT
from fea.base.units import KG
from fea.base.version import __version__
from fea.machine.clock import Clock
from fea.machine.system import saying
from fea.output.folder import ANOTHER_OUT, near, owned, reported
from fea.output.json_file import JsonObject, json_lines
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import GeometryError, require
from mesh.tetmesh import MeshError

# Share of the way from a rod that can be meshed to one that cannot that a search tries next.
_SHORTER = 0.5
_TRIES = 3
# Meshes that others are moved from.
_KEPT = 8
SUFFIX = ".unfinished"


@dataclass(frozen=True)
class Design:
    """A rod that was tried."""

    x: Floats  #: (n,) its free dimensions, scaled to 0 … 1 between their bounds
    mass_kg: float
    constraints: tuple[DesignConstraint, ...]
    remeshed: bool = False  #: whether its mesh was made for it, rather than moved from another rod's
    mesh: int = 0  #: number of the mesh that was made for it or that its own was moved from
    #: for each speed, ratio of the smallest film on the fine grid to that on the coarse one, on that mesh,
    #: and its error, percent
    film_corrections: Sequence[tuple[float, float]] = ()

    @property
    def margin(self) -> float:
        """The least margin of all constraints."""
        return self.governing.margin

    @property
    def violation(self) -> float:
        """Sum of all negative margins, as a positive number; 0 where it holds."""
        return -sum(min(0.0, constraint.margin) for constraint in self.constraints)

    @property
    def governing(self) -> DesignConstraint:
        """The constraint with the least margin."""
        return min(self.constraints, key=lambda constraint: constraint.margin)


class Record:
    """The designs that a search asked for, in a file; the same search asks for the same ones again.

    `count` is the number of designs from an interrupted search; `empty` says whether there is none yet.
    """

    def __init__(self, path: Path, identity: str) -> None:
        self.path = path
        self._file = path.open("r+b")
        lines = list(json_lines(self._file.read()))
        same = bool(lines) and lines[0][0] == {"search": identity}
        self._entries, self._end = (lines[1:], lines[0][1]) if same else ([], 0)
        self.count = len(self._entries)
        if not same:
            self.add({"search": identity})
        self.empty = not self.count

    def next(self, kind: str, wanted: Floats) -> JsonObject | None:
        """Return the next entry if it is of the wanted design (n,); else None, and forget the rest."""
        if self._entries:
            entry, end = self._entries.pop(0)
            if (entry["kind"], entry["wanted"]) == (kind, wanted.tolist()):
                self._end = end
                return entry
            self._entries = []
        return None

    def add(self, entry: JsonObject) -> None:
        """Write an entry behind those that were returned; raises `StorageError` if the system refuses."""
        with reported(self.path, ANOTHER_OUT):
            self._file.seek(self._end)
            self._file.truncate()
            self._file.write(json.dumps(entry).encode() + b"\n")
            self._file.flush()
        self._end, self.empty = self._file.tell(), False

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@contextmanager
def record(folder: Path, study: Study) -> Iterator[Record]:
    """Yield the record of a search beside its folder; it is removed with the block, but not by an interrupt.

    Raises `OccupiedError`: another search is at work there; `StorageError`: the disk, a permission or the
    file system refuses.
    """
    place = folder.resolve()
    path = place.with_name(place.name + SUFFIX)
    with reported(path, ANOTHER_OUT):
        place.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    with owned(path, folder, "fea optimise", "wait for it, or choose --out"):
        with reported(path, ANOTHER_OUT):
            kept = Record(path, _identity(study))
        done = False
        try:
            with saying(f"interrupted; the same command resumes from the designs in {near(path)}"):
                yield kept
            done = True
        finally:
            kept.close()
            if done or kept.empty:
                with suppress(OSError):
                    path.unlink()


def _identity(study: Study) -> str:
    table = study.optimise
    same = replace(study, optimise=None if table is None else replace(table, evaluations=None))
    files = [digest(path) for path in files_of(same.as_dict())]
    return hashlib.sha256(json.dumps([__version__, same.text(), files]).encode()).hexdigest()


@dataclass
class _BaseMesh:
    """A mesh that others are moved from; that of a resumed search's design is made when first needed."""

    x: Floats
    number: int
    coarsest: float
    moving: MovingRod | None = None
    film_corrections: Sequence[tuple[float, float]] = ()


class Designs:
    """Computes designs: `tried` holds all, in order; `count` is the number of meshes that were solved.

    The listener is called with each design, the count, and how many of these meshes were solved now: none
    before the first design that the record does not have. The mesh of one rod is moved to the next, where it
    can be. Designs in the record are not computed again.
    """

    def __init__(
        self,
        variables: Variables,
        listener: Callable[[Design, int, int], None] = lambda _design, _count, _now: None,
        *,
        record: Record | None = None,
    ) -> None:
        # Films are computed apart, on the coarse grid where that will do.
        options = replace(variables.study.analysis, film=False)
        self.variables = replace(variables, study=replace(variables.study, analysis=options))
        self.tried: list[Design] = []
        self.count = 0
        self._listener, self._record = listener, record
        self._required = required(variables.study)
        self._bases: deque[_BaseMesh] = deque(maxlen=_KEPT)
        self._meshes, self._now = 0, 0
        self._feasible = variables.start
        self._coarsest = CONVERGED_PERCENT

    def begin(self, x: Floats) -> Design:
        """Compute a design on a mesh of its own, refined as its study asks for; others follow from that mesh.

        The first mesh, with which the search covers most of the way, need only be converged. Raises
        `GeometryError`, `MeshError`: the rod cannot be drawn or meshed.
        """
        if self._bases:
            self._coarsest = 0.0
        self._bases.clear()
        self._feasible = x
        recorded = self._recorded("begin", x)
        return recorded or self._computed("begin", x, x, *self._meshed(x), remeshed=True)

    def at(self, x: Floats) -> Design:
        """Compute a design on the mesh of another, moved; of a rod that cannot be drawn, the nearest one.

        Raises `GeometryError`, `MeshError`: not even rods much closer to the last one begun can be drawn or
        meshed.
        """
        recorded = self._recorded("at", x)
        if recorded is not None:
            return recorded
        near, tries = self.nearest(x, self._feasible), 1
        while True:
            try:
                adapted, base, remeshed = self._rod(near)
                break
            except (GeometryError, MeshError):
                if tries == _TRIES:
                    raise
                near, tries = near + _SHORTER * (self._feasible - near), tries + 1
        return self._computed("at", x, near, adapted, base, remeshed=remeshed)

    def nearest(self, x: Floats, sound: Floats) -> Floats:
        """Return the last design (n,) that can be drawn on the way to `x` from another that can."""
        return self.variables.nearest_feasible(x, sound)

    def _rod(self, x: Floats) -> tuple[RefinedRod, _BaseMesh, bool]:
        """The rod on the nearest mesh, moved, or else on its own; that mesh, and whether it is its own."""
        study = self.variables.study_at(x)
        base = min(self._bases, key=lambda base: float(np.linalg.norm(base.x - x)))
        if base.moving is None:
            base.moving = MovingRod(self._adapted(base.x, base.coarsest).rod.mesh)
        for other in self._bases:  # of the factors only one is kept
            if other.moving is not None and other is not base:
                other.moving.forget()
        mesh = base.moving.mesh(study)
        if mesh is not None:
            return RefinedRod(base.moving.prepared(study, mesh)), base, False
        return *self._meshed(x), True

    def _meshed(self, x: Floats) -> tuple[RefinedRod, _BaseMesh]:
        adapted = self._adapted(x, self._coarsest)
        self._meshes += 1
        self._bases.append(_BaseMesh(x, self._meshes, self._coarsest, MovingRod(adapted.rod.mesh)))
        self._count(max(1, len(adapted.passes)) - 1)  # the last one counts with its design
        return adapted, self._bases[-1]

    def _count(self, meshes: int) -> None:
        self.count += meshes
        self._now += meshes

    def _adapted(self, x: Floats, coarsest: float) -> RefinedRod:
        study = self.variables.study_at(x)
        tolerance = study.tolerance_percent
        if tolerance is not None:
            tolerance = max(tolerance, coarsest)
            study = replace(study, analysis=replace(study.analysis, tolerance_percent=tolerance))
        return refined_rod(study, study.speeds(), Clock(), movable=True)

    def _computed(
        self, kind: str, wanted: Floats, x: Floats, adapted: RefinedRod, base: _BaseMesh, *, remeshed: bool
    ) -> Design:
        results = [adapted.at(rpm) for rpm in self.variables.study.speeds()]
        films = self._films(adapted.rod, results, base.film_corrections) if FILM in self._required else []
        base.film_corrections = [film.correction for film in films]
        margins = constraints(adapted.rod, results, self._required, films)
        mass = adapted.rod.mass.mass / KG
        design = Design(x, mass, margins, remeshed, base.number, base.film_corrections)
        self.tried.append(design)
        self._count(1)
        if self._record is not None:
            plain = asdict(design) | {"x": x.tolist()}
            self._record.add({"kind": kind, "wanted": wanted.tolist(), "count": self.count, "design": plain})
        self._listener(design, self.count, self._now)
        return design

    def _films(
        self, rod: PreparedRod, results: Sequence[SpeedResult], corrections: Sequence[tuple[float, float]]
    ) -> list[MinimumFilm]:
        """The film at each speed: whole on a mesh's first rod; of others on the coarse grid, corrected.

        Raises `InvalidValue`: the film of the first rod starves or overheats.
        """
        speeds = [result.rpm or 0.0 for result in results]
        if corrections:
            pairs = zip(speeds, corrections, strict=True)
            return [MinimumFilm.corrected(rod, rpm, correction) for rpm, correction in pairs]
        films = [result.film or film_at(rod, result.rpm or 0.0) for result in results]
        for rpm, film in zip(speeds, films, strict=True):
            rule = f"cannot be sought: the film of the rod as it is, at {rpm:g} rpm, is {film.verdict}"
            remedy = "Look at it with fea run --film; change [film], or the speeds."
            sought = film.sound or bool(self.tried)
            require(sought, "optimise.min_film_um", self._required[FILM], rule, remedy)
        return [MinimumFilm.of(film) for film in films]

    def _recorded(self, kind: str, wanted: Floats) -> Design | None:
        entry = None if self._record is None else self._record.next(kind, wanted)
        if entry is None:
            return None
        plain = entry["design"]
        limits = tuple(DesignConstraint(**constraint) for constraint in plain["constraints"])
        design = Design(**plain | {"x": np.array(plain["x"]), "constraints": limits})
        if design.remeshed:
            self._meshes = design.mesh
            base = _BaseMesh(design.x, design.mesh, self._coarsest, film_corrections=design.film_corrections)
            self._bases.append(base)
        self.tried.append(design)
        self.count = entry["count"]
        self._listener(design, self.count, self._now)
        return design
