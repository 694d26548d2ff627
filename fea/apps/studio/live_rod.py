"""A rod that answers at once while its dimensions and its operation change, and exactly where they rest."""

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import numpy.typing as npt

from fea.analysis.pipeline import MovingRod, refined_rod, solve_speed, with_cycle
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.studio.anchors import UNIT, VAGUE, Anchors, Followed, Loaded
from fea.apps.studio.correction import Correction
from fea.apps.studio.frame import LARGEST_OF_CASES, Figures, Frame, Label, figures, solved, triangles
from fea.apps.studio.operation import Control, Operation, Range, applied, dimensions, fault, feasible
from fea.apps.studio.stars import Star
from fea.base.choices import CONTACT
from fea.machine.clock import Clock
from fea.output.report.surface import NumberedSurface
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import BOLT
from fea.study.option_tables import OutputTable
from fea.study.pin_models import FILM, PRESCRIBED
from fea.study.rod_table import RodTable
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import GeometryError

Design = Mapping[str, float]
# Shares of the way along a slider at which anchors are, beside its ends and where it stands (Chebyshev).
_INNER = (0.146, 0.854)
# An interpolation whose estimated error is below this is good enough.
_ENOUGH_PERCENT = 0.1
_DISTINCT = 0.1  # scaled distance of anchors that tell a curvature
_KEPT = 4  # moved meshes
_TRIES = 4  # at distances that are halved, to find what a moved mesh reaches


def live_study(study: Study) -> Study:
    """Return a study as it is solved where the hand rests: in one piece and without oil film."""
    options = study.analysis
    pressure = CONTACT if options.pressure == FILM else options.pressure
    quick = replace(options, pressure=pressure, cycle=False, film=False, buckling=False)
    parts = {name: table for name, table in study.part_material.items() if name != BOLT}
    if study.assembly is not None:
        parts = {}
    return replace(
        study,
        analysis=quick,
        part_material=parts,
        assembly=None,
        duty=None,
        optimise=None,
        output=OutputTable(),
    )


class LiveRod:
    """A rod under one's hands.

    Its mesh is made once, as `fea run` would make it, and moved to every other design. Where it cannot
    follow, `exact` makes another, and `base`, the number of the mesh, rises: `triangles` are new then. Raises
    `InvalidValue`, `GeometryError`, `MeshError`, `UnderconstrainedError`, `SingularMatrixError`: as `fea run`
    of the study.
    """

    def __init__(self, study: Study) -> None:
        self.study, self.operation = study, Operation.of(study)
        self.dimensions: tuple[Control, ...] = dimensions(study)
        self.base_design = {each.key: each.value for each in self.dimensions}
        self.base = -1
        self._last: tuple[Operation, Loaded] | None = None
        self._anchors: Anchors | None = None  # none until a rod is solved under a prescribed pressure
        self._solved_first: tuple[Study, PreparedRod, SpeedResult] | None = None  # of the mesh
        self._correction: Correction | None = None
        self._meshes: deque[tuple[RodTable, MeshedRod | None]] = deque()
        self._unreached: dict[str, tuple[float, float]] = {}
        self._meshed(self.base_design, self.operation)

    @property
    def triangles(self) -> npt.NDArray[np.int32]:
        """Triangles (t, 3) of the rod's surface, by the numbers of the points of its frames."""
        return triangles(self.surface)

    def study_at(self, design: Design, operation: Operation) -> Study:
        """Return the study solved for a design under the pointer. Raises `InvalidValue`: a rule is broken."""
        return live_study(applied(self.study, self._full(design), operation))

    def ranges(self, design: Design) -> dict[str, Range]:
        """Return how far each dimension can go from a design while the others stay."""
        design, found = self._full(design), dict[str, Range]()
        star = self._star(design)
        for number, (name, value) in enumerate(design.items()):
            own = feasible(self.study, design, name, value)
            if star is not None and number in star.lines:
                least, most = (self._value(name, end) for end in star.lines[number].ends)
                own = replace(own, covered_low=least, covered_high=most)
            if name in self._unreached:
                own = replace(own, reach_low=self._unreached[name][0], reach_high=self._unreached[name][1])
            found[name] = own
        return found

    def touch(self, name: str, design: Design, operation: Operation) -> Iterator[float]:
        """Solve what the interpolation along a dimension needs; yields its share that is done.

        It yields several times for each rod, so that others can be answered meanwhile; what is abandoned is
        no anchor. Raises `InvalidValue`: the design breaks a rule.
        """
        design = self._full(design)
        if self._anchors is None:
            for _ in self.exact(design, operation):
                yield 0.0
        anchors, loaded = self._anchored, self._loaded(operation)
        low, high = self._ends(name, design)
        shares = (None, 0.0, 1.0, *_INNER)
        for done, share in enumerate(shares, 1):
            value = design[name] if share is None else low + share * (high - low)
            there = {**design, name: value}
            between = anchors.at(self._scaled(there), loaded)
            known = between is not None and (
                between.solved or (100 * between.worst_gap <= _ENOUGH_PERCENT and self._lined(name, there))
            )
            if not known and not fault(self.study, there):
                study = self.study_at(there, operation)
                mesh = self._moved(study)
                yield (done - 0.8) / len(shares)
                if mesh is not None:
                    rod, result = self._pressed(study, mesh, operation)
                    yield (done - 0.3) / len(shares)
                    self._anchor(there, operation, rod, result)
            yield done / len(shares)

    def cross(self, design: Design, operation: Operation) -> Iterator[float]:
        """Solve what every two of the dimensions that were touched here change together; see `touch`."""
        design = self._full(design)
        star = self._star(design)
        if star is None or star.changed(self._scaled(design)).size:
            return
        pairs = list(combinations(star.lines, 2))
        for done, pair in enumerate(pairs):
            corners = product(*(star.lines[number].ends[::-1] for number in pair))
            for corner in () if pair in star.corners else corners:
                names = [list(design)[number] for number in pair]
                there = {
                    **design,
                    **{name: self._value(name, end) for name, end in zip(names, corner, strict=True)},
                }
                if fault(self.study, there):
                    continue
                study = self.study_at(there, operation)
                mesh = self._moved(study)
                yield done / len(pairs)
                if mesh is not None:
                    rod, result = self._pressed(study, mesh, operation)
                    yield done / len(pairs)
                    self._anchor(there, operation, rod, result)
                    break

    def frame(self, design: Design, operation: Operation, fields: str = LARGEST_OF_CASES) -> Frame:
        """Return what is interpolated; no figures beyond the anchors or in another elasticity.

        It is interpolated under a prescribed pressure; where the pins are in contact, factors are corrected
        by what contact changed in the design that was solved last.
        """
        design = self._full(design)
        frame = self._frame(design, operation, Label.INTERPOLATED, fields)
        x, loaded = self._scaled(design), self._loaded(operation)
        between = None if self._anchors is None else self._anchors.at(x, loaded)
        unknown = self._in_contact and self._correction is None
        if between is None or unknown or between.worst_gap > VAGUE:
            return frame
        shown, (points, values) = between.figures, between.drawn(fields)
        if self._correction is not None:
            shown = self._correction.of(shown, x, loaded.key)
        return replace(frame, figures=shown, points=points, values=values, corrected=self._in_contact)

    def exact(self, design: Design, operation: Operation, fields: str = LARGEST_OF_CASES) -> Iterator[Frame]:
        """Solve a design, then its fatigue. Raises `InvalidValue`, `GeometryError`, `MeshError`."""
        design = self._full(design)
        study = self.study_at(design, operation)
        mesh = self._moved(study)
        new = mesh is None
        if mesh is None:
            self._meshed(design, operation)
            mesh = self._mesh
        frame = replace(self._frame(design, operation, Label.EXACT, fields), new_mesh=new)
        first = self._solved_first
        if first is not None and first[0] == study:
            _, rod, result = first
        else:
            rod = self._moving.prepared(study, mesh)
            result = solve_speed(rod, operation.rpm)
        yield solved(frame, rod, result, self.surface)
        final = result
        if study.engine is not None:
            final = with_cycle(rod, result)
            yield solved(frame, rod, final, self.surface)
        if not self._in_contact:
            self._anchor(design, operation, rod, result)
        else:
            pressed = rod.under_prescribed()
            self._anchor(design, operation, pressed, solve_speed(pressed, operation.rpm))
            self._correct(design, operation, figures(rod, final))

    def _pressed(
        self, study: Study, mesh: MeshedRod, operation: Operation
    ) -> tuple[PreparedRod, SpeedResult]:
        """Solve a study on a moved mesh under a prescribed pressure, also where its pins are in contact."""
        if self._in_contact:
            study = replace(study, analysis=replace(study.analysis, pressure=PRESCRIBED))
        rod = self._moving.prepared(study, mesh)
        return rod, solve_speed(rod, operation.rpm)

    def _correct(self, design: Design, operation: Operation, known: Figures) -> None:
        """Take from a design that was solved what contact changes in the factors that are interpolated."""
        x, loaded = self._scaled(design), self._loaded(operation)
        between = self._anchored.at(x, loaded)
        if between is not None:
            self._correction = Correction.between(between.figures, known, x, loaded.key)

    @property
    def _anchored(self) -> Anchors:
        if self._anchors is None:
            raise ValueError("no rod was solved yet")
        return self._anchors

    def _star(self, design: Design) -> Star | None:
        return None if self._anchors is None else self._anchors.star(self._scaled(design))

    def _full(self, design: Design) -> dict[str, float]:
        return {**self.base_design, **design}

    def _scaled(self, design: Design) -> Floats:
        """Dimensions (n,) relative to those of the study, in units of the interpolation."""
        own = [(design[name] - value) / (UNIT * value) for name, value in self.base_design.items()]
        return np.array(own)

    def _value(self, name: str, scaled: float) -> float:
        """The value, mm, of a dimension that is scaled."""
        return float((1 + UNIT * scaled) * self.base_design[name])

    def _loaded(self, operation: Operation) -> Loaded:
        if self._last is None or self._last[0] != operation:
            study = self.study_at({}, operation)
            self._last = operation, Loaded(study, operation.rpm, study.materials(self._mesh.parts))
        return self._last[1]

    def _lined(self, name: str, design: dict[str, float]) -> bool:
        """Whether so many anchors lie on the line of a dimension that they tell how it is curved."""
        number, x = list(design).index(name), self._scaled(design)
        on_line = [one.x[number] for one in self._anchored.every if not np.delete(one.x - x, number).any()]
        return len(on_line) > 2 and float(np.diff(np.sort(on_line)).min()) > _DISTINCT

    def _ends(self, name: str, design: dict[str, float]) -> tuple[float, float]:
        """How far a dimension is solved to either side: as far as it is feasible and the mesh follows."""
        own, ends = feasible(self.study, design, name, design[name]), list[float]()
        for end, share in ((own.low, -UNIT), (own.high, UNIT)):
            away = share * design[name]
            away = max(away, end - design[name]) if share < 0 else min(away, end - design[name])
            for _ in range(_TRIES):
                study = self.study_at({**design, name: design[name] + away}, self.operation)
                if self._moved(study) is not None:
                    break
                away /= 2
                reach = self._unreached.get(name, (own.low, own.high))
                near = design[name] + away
                self._unreached[name] = (near, reach[1]) if share < 0 else (reach[0], near)
            else:
                away = 0.0
            ends.append(design[name] + away)
        return ends[0], ends[1]

    def _moved(self, study: Study) -> MeshedRod | None:
        for rod, mesh in self._meshes:
            if rod == study.rod:
                return mesh
        try:
            mesh = self._moving.mesh(study)
        except GeometryError:  # `exact` draws it again, and says so
            mesh = None
        self._meshes.append((study.rod, mesh))
        return mesh

    def _meshed(self, design: Design, operation: Operation) -> None:
        study = self.study_at(design, operation)
        adapted = refined_rod(study, (operation.rpm,), Clock(), movable=bool(self.dimensions))
        self._mesh = adapted.rod.mesh
        self._meshes = deque([(study.rod, self._mesh)], maxlen=_KEPT)
        self.surface = NumberedSurface.of(self._mesh.whole)
        self.base += 1
        self._last = None
        self._unreached.clear()
        rod, result = adapted.rod, adapted.at(operation.rpm)
        self._moving = MovingRod(rod.mesh, rod)
        self._solved_first, self._anchors, self._correction = (study, rod, result), None, None
        self._pins = rod.structure.pressure  # where contact is not possible, a prescribed pressure
        self._in_contact = rod.prescribed is not rod.pins
        if not self._in_contact:
            self._anchor(self._full(design), operation, rod, result)

    def _anchor(self, design: Design, operation: Operation, rod: PreparedRod, result: SpeedResult) -> None:
        """Keep a design that is solved under a prescribed pressure."""
        loaded = self._loaded(operation)
        if self._anchors is None:
            self._anchors = Anchors(Followed(rod, result, self.surface), loaded.elastic)
        if loaded.elastic != self._anchors.elastic:
            self._anchors = Anchors(self._anchors.followed, loaded.elastic)
        x = self._scaled(design)
        self._anchors.add(self._anchors.followed.anchor(x, loaded, rod, result))

    def _frame(self, design: Design, operation: Operation, label: Label, shown: str) -> Frame:
        return Frame(
            design=design,
            operation=operation,
            label=label,
            base=self.base,
            shown=shown,
            pins=self._pins,
            one_piece=self.study.assembly is not None,
        )


def fresh(study: Study) -> Frame:
    """Solve a study on a mesh of its own, refined and with pins as in `fea run --cycle`, with its errors."""
    operation = Operation.of(study)
    study = replace(study, analysis=replace(study.analysis, cycle=study.engine is not None))
    adapted = refined_rod(study, (operation.rpm,), Clock())
    result = adapted.at(operation.rpm)
    surface = NumberedSurface.of(adapted.rod.mesh.whole)
    frame = Frame(
        design={each.key: each.value for each in dimensions(study)},
        operation=operation,
        label=Label.CONVERGED,
        pins=adapted.rod.structure.pressure,
        new_mesh=True,
        triangles=triangles(surface),
    )
    return solved(frame, adapted.rod, result, surface)
