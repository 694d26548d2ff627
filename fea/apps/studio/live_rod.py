"""A rod that answers at once while its design and operating point change, and exactly where they rest."""

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from fea.analysis.pipeline import MovingRod, refined_rod, solve_speed, with_cycle
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.apps.studio.figures import (
    LARGEST_OF_CASES,
    ContactCorrection,
    Label,
    StudioFrame,
    figures,
    triangles,
)
from fea.apps.studio.operating_point import (
    Control,
    OperatingPoint,
    SliderRange,
    applied,
    dimensions,
    fault,
    feasible,
)
from fea.apps.studio.sampled_designs import LARGEST_ERROR, UNIT, DesignLoad, SampledDesigns, TrackedNodes
from fea.base.choices import CONTACT
from fea.machine.clock import Clock
from fea.output.report.surface import NumberedSurface
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import BOLT
from fea.study.changes import load_cases_alone
from fea.study.pin_models import FILM, PRESCRIBED
from fea.study.rod_table import RodTable
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import GeometryError

Dimensions = Mapping[str, float]  # mm, by key
# Shares of a slider's way at which designs are sampled, beside its ends and its position (Chebyshev).
_INNER = (0.146, 0.854)
_KEPT = 4  # moved meshes
_TRIES = 4  # at distances that are halved, to find what a moved mesh reaches


def live_study(study: Study) -> Study:
    """Return the study that is solved at once: in one piece and without oil film."""
    pressure = CONTACT if study.analysis.pressure == FILM else study.analysis.pressure
    assembled = study.assembly is not None
    parts = {name: table for name, table in study.part_material.items() if name != BOLT and not assembled}
    alone = load_cases_alone(study, pressure=pressure, film=False, buckling=False)
    return replace(alone, part_material=parts, assembly=None)


class LiveRod:
    """A rod whose design changes.

    Its mesh is made once, as `fea run` would make it, and moved to every other design. Where it cannot
    follow, `exact` makes another, and `base`, the number of the mesh, rises: `triangles` are new then. Raises
    `InvalidValue`, `GeometryError`, `MeshError`, `UnderconstrainedError`, `SingularMatrixError`: as `fea run`
    of the study.
    """

    def __init__(self, study: Study) -> None:
        self.study, self.operation = study, OperatingPoint.of(study)
        self.dimensions: tuple[Control, ...] = dimensions(study)
        self.base_design = {each.key: each.value for each in self.dimensions}
        self.base = -1
        self._load: tuple[OperatingPoint, DesignLoad] | None = None
        self._samples: SampledDesigns | None = None  # none until a rod is solved under a prescribed pressure
        self._first: tuple[Study, PreparedRod, SpeedResult] | None = None  # solved on the mesh
        self._correction: ContactCorrection | None = None
        self._meshes: deque[tuple[RodTable, MeshedRod | None]] = deque()
        self._reach: dict[str, tuple[float, float]] = {}  # of the moved mesh, where it is known
        self._make_mesh(self.base_design, self.operation)

    @property
    def triangles(self) -> npt.NDArray[np.int32]:
        """Triangles (t, 3) of the rod's surface, by the numbers of the points of its frames."""
        return triangles(self.surface)

    def study_at(self, design: Dimensions, operation: OperatingPoint) -> Study:
        """Return the study that is solved for a design. Raises `InvalidValue`: a rule is broken."""
        return live_study(applied(self.study, self._full(design), operation))

    def ranges(self, design: Dimensions) -> dict[str, SliderRange]:
        """Return how far each dimension can go from a design while the others stay."""
        design, found = self._full(design), dict[str, SliderRange]()
        stencil = None if self._samples is None else self._samples.stencil(self._scaled(design))
        for number, (name, value) in enumerate(design.items()):
            shown = feasible(self.study, design, name, value)
            if stencil is not None and number in stencil.lines:
                low, high = (self._value(name, end) for end in stencil.lines[number].ends)
                shown = replace(shown, covered_low=low, covered_high=high)
            if name in self._reach:
                low, high = self._reach[name]
                shown = replace(shown, reach_low=low, reach_high=high)
            found[name] = shown
        return found

    def touch(self, name: str, design: Dimensions, operation: OperatingPoint) -> Iterator[float]:
        """Sample what the interpolation along a dimension needs; yields its share that is done.

        It yields several times for each rod, so that other requests can be answered meanwhile. Raises
        `InvalidValue`: the design breaks a rule.
        """
        design = self._full(design)
        if self._samples is None:
            for _ in self.exact(design, operation):
                yield 0.0
        load = self._loaded(operation)
        low, high = self._ends(name, design)
        values = (design[name], *(low + share * (high - low) for share in (0.0, 1.0, *_INNER)))
        for done, value in enumerate(values, 1):
            there = {**design, name: value}
            known = self._sampled.at(self._scaled(there), load)
            if known is None or not known.sampled:
                yield from self._sample(there, operation, (done - 1) / len(values))
            yield done / len(values)

    def _sample(
        self, design: dict[str, float], operation: OperatingPoint, progress: float
    ) -> Iterator[float]:
        """Solve a design under a prescribed pressure and keep it, where it can be solved.

        It yields between the steps; a design that is abandoned there is not kept.
        """
        if fault(self.study, design):
            return
        study = self.study_at(design, operation)
        mesh = self._moved(study)
        yield progress
        if mesh is None:
            return
        if self._in_contact:
            study = replace(study, analysis=replace(study.analysis, pressure=PRESCRIBED))
        rod = self._moving.prepared(study, mesh)
        result = solve_speed(rod, operation.rpm)
        yield progress
        self._keep(design, operation, rod, result)

    def frame(
        self, design: Dimensions, operation: OperatingPoint, fields: str = LARGEST_OF_CASES
    ) -> StudioFrame:
        """Return what is interpolated; no figures beyond the sampled designs or in another elasticity.

        It is interpolated under a prescribed pressure; where the pins are in contact, factors are corrected
        by the effect of contact in the design that was solved last.
        """
        design = self._full(design)
        frame = self._frame(operation, Label.INTERPOLATED, fields)
        x, load = self._scaled(design), self._loaded(operation)
        known = None if self._samples is None else self._samples.at(x, load)
        uncorrected = self._in_contact and self._correction is None
        if known is None or uncorrected or known.largest_error > LARGEST_ERROR:
            return frame
        shown, (points, values) = known.figures, known.drawn(fields)
        if self._correction is not None:
            shown = self._correction.corrected(shown, UNIT * x, load.key)
        return replace(frame, figures=shown, points=points, values=values, corrected=self._in_contact)

    def exact(
        self, design: Dimensions, operation: OperatingPoint, fields: str = LARGEST_OF_CASES
    ) -> Iterator[StudioFrame]:
        """Solve a design, then its fatigue. Raises `InvalidValue`, `GeometryError`, `MeshError`."""
        design = self._full(design)
        study = self.study_at(design, operation)
        mesh = self._moved(study)
        new = mesh is None
        if mesh is None:
            self._make_mesh(design, operation)
            mesh = self._mesh
        frame = replace(self._frame(operation, Label.EXACT, fields), new_mesh=new)
        if self._first is not None and self._first[0] == study:
            _, rod, result = self._first
        else:
            rod = self._moving.prepared(study, mesh)
            result = solve_speed(rod, operation.rpm)
        yield frame.solved(rod, result, self.surface)
        final = result
        if study.engine is not None:
            final = with_cycle(rod, result)
            yield frame.solved(rod, final, self.surface)
        if not self._in_contact:
            self._keep(design, operation, rod, result)
        else:
            prescribed = rod.under_prescribed()
            self._keep(design, operation, prescribed, solve_speed(prescribed, operation.rpm))
            x, load = self._scaled(design), self._loaded(operation)
            known = self._sampled.at(x, load)
            if known is not None:
                contact = figures(rod, final)
                self._correction = ContactCorrection.between(known.figures, contact, UNIT * x, load.key)

    @property
    def _sampled(self) -> SampledDesigns:
        if self._samples is None:
            raise ValueError("no rod was solved yet")
        return self._samples

    def _full(self, design: Dimensions) -> dict[str, float]:
        return {**self.base_design, **design}

    def _scaled(self, design: Dimensions) -> Floats:
        """Dimensions (n,) relative to those of the study, in units of the interpolation."""
        return np.array([(design[name] / value - 1) / UNIT for name, value in self.base_design.items()])

    def _value(self, name: str, scaled: float) -> float:
        """The value, mm, of a dimension that is scaled."""
        return float((1 + UNIT * scaled) * self.base_design[name])

    def _loaded(self, operation: OperatingPoint) -> DesignLoad:
        if self._load is None or self._load[0] != operation:
            study = self.study_at({}, operation)
            self._load = operation, DesignLoad(study, operation.rpm, study.materials(self._mesh.parts))
        return self._load[1]

    def _ends(self, name: str, design: dict[str, float]) -> tuple[float, float]:
        """How far a dimension is sampled to either side: as far as it is feasible and the mesh follows."""
        value, ends = design[name], list[float]()
        bounds = feasible(self.study, design, name, value)

        def follows(away: float) -> bool:
            study = self.study_at({**design, name: value + away}, self.operation)
            return self._moved(study) is not None

        for side, share in enumerate((-UNIT, UNIT)):
            away = min(max(share * value, bounds.low - value), bounds.high - value)
            reached = next(filter(follows, (away / 2**halved for halved in range(_TRIES))), None)
            if reached != away:
                reach = list(self._reach.get(name, (bounds.low, bounds.high)))
                reach[side] = value + (away / 2**_TRIES if reached is None else reached)
                self._reach[name] = reach[0], reach[1]
            ends.append(value + (reached or 0.0))
        return ends[0], ends[1]

    def _moved(self, study: Study) -> MeshedRod | None:
        """Move the mesh to a study's rod; None where it cannot follow."""
        for rod, mesh in self._meshes:
            if rod == study.rod:
                return mesh
        try:
            mesh = self._moving.mesh(study)
        except GeometryError:  # `exact` draws it again and reports the reason
            mesh = None
        self._meshes.append((study.rod, mesh))
        return mesh

    def _make_mesh(self, design: Dimensions, operation: OperatingPoint) -> None:
        study = self.study_at(design, operation)
        adapted = refined_rod(study, (operation.rpm,), Clock(), movable=bool(self.dimensions))
        rod, result = adapted.rod, adapted.at(operation.rpm)
        self._mesh = rod.mesh
        self._meshes = deque([(study.rod, self._mesh)], maxlen=_KEPT)
        self.surface = NumberedSurface.of(self._mesh.whole)
        self.base += 1
        self._reach.clear()
        self._moving = MovingRod(rod.mesh, rod)
        self._first = study, rod, result
        self._load = self._samples = self._correction = None
        self._pins = rod.structure.pressure  # where contact is not possible, a prescribed pressure
        self._in_contact = rod.prescribed is not rod.pins
        if not self._in_contact:
            self._keep(self._full(design), operation, rod, result)

    def _keep(
        self, design: Dimensions, operation: OperatingPoint, rod: PreparedRod, result: SpeedResult
    ) -> None:
        """Keep a design that is solved under a prescribed pressure."""
        load = self._loaded(operation)
        if self._samples is None:
            self._samples = SampledDesigns(TrackedNodes(rod, result, self.surface), load.elasticity)
        if load.elasticity != self._samples.elasticity:
            self._samples = SampledDesigns(self._samples.tracked, load.elasticity)
        self._samples.add(self._samples.tracked.sampled(self._scaled(design), load, rod, result))

    def _frame(self, operation: OperatingPoint, label: Label, shown: str) -> StudioFrame:
        return StudioFrame(
            operation=operation,
            label=label,
            base=self.base,
            shown=shown,
            pins=self._pins,
            one_piece=self.study.assembly is not None,
        )


def fresh(study: Study) -> StudioFrame:
    """Solve a study on a mesh of its own, refined and with pins as in `fea run --cycle`, with its errors."""
    operation = OperatingPoint.of(study)
    study = replace(study, analysis=replace(study.analysis, cycle=study.engine is not None))
    adapted = refined_rod(study, (operation.rpm,), Clock())
    surface = NumberedSurface.of(adapted.rod.mesh.whole)
    frame = StudioFrame(
        operation=operation,
        label=Label.CONVERGED,
        pins=adapted.rod.structure.pressure,
        new_mesh=True,
        triangles=triangles(surface),
    )
    return frame.solved(adapted.rod, adapted.at(operation.rpm), surface)
