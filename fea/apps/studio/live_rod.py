"""A rod that answers at once while its dimensions and its operation change, and exactly where they rest."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from time import perf_counter

import numpy as np
import numpy.typing as npt

from fea.analysis.adapt import adapt_mesh
from fea.analysis.prepare import prepare
from fea.analysis.speed import solve_speed, with_cycle
from fea.apps.studio.dimensions import LiveDimension, Range, dimensions, feasible
from fea.apps.studio.frame import LARGEST_OF_CASES, Frame, Label, solved, triangles
from fea.apps.studio.operation import Operation, applied
from fea.base.choices import CONTACT
from fea.machine.clock import Clock
from fea.output.report.surface import Surface
from fea.rod.discretise import moved
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import BOLT
from fea.study.option_tables import OutputTable
from fea.study.pin_models import PRESCRIBED
from fea.study.study import Study

Design = Mapping[str, float]


def live_study(study: Study) -> Study:
    """Return a study as it is solved while it changes: in one piece, the load of its pins prescribed."""
    options = study.analysis
    pressure = PRESCRIBED if options.in_contact else options.pressure
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
    follow, `exact` makes another, and `base`, the number of the mesh, rises: `triangles` are new then.

    Raises
    ------
    InvalidValue, GeometryError, MeshError, UnderconstrainedError, SingularMatrixError
        As `fea run` of the study.
    """

    def __init__(self, study: Study) -> None:
        self.study, self.operation = study, Operation.of(study)
        self.dimensions: tuple[LiveDimension, ...] = dimensions(study)
        self.base_design = {each.name: each.value for each in self.dimensions}
        self.base = -1
        self._meshed(self.base_design, self.operation)

    @property
    def triangles(self) -> npt.NDArray[np.int32]:
        """Triangles (t, 3) of the rod's surface, by the numbers of the points of its frames."""
        return triangles(self.surface)

    def study_at(self, design: Design, operation: Operation) -> Study:
        """Return the study that is solved where the hand rests.

        Raises
        ------
        InvalidValue
            A value breaks a rule.
        """
        return live_study(applied(self.study, {**self.base_design, **design}, operation))

    def ranges(self, design: Design) -> dict[str, Range]:
        """Return how far each dimension can go from a design while the others stay."""
        design = {**self.base_design, **design}
        return {name: feasible(self.study, design, name, value) for name, value in design.items()}

    def touch(self, name: str, design: Design, operation: Operation) -> Iterator[float]:  # noqa: ARG002
        """Solve what the interpolation along a dimension needs; yields its share that is done."""
        yield 1.0

    def frame(self, design: Design, operation: Operation, fields: str = LARGEST_OF_CASES) -> Frame:
        """Return what is known at once."""
        return self._frame(design, operation, Label.INTERPOLATED, fields)

    def exact(self, design: Design, operation: Operation, fields: str = LARGEST_OF_CASES) -> Iterator[Frame]:
        """Solve a design: first its load cases with all checks, then its fatigue over the cycle.

        Raises
        ------
        InvalidValue, GeometryError, MeshError
            The design breaks a rule, or cannot be drawn or meshed.
        """
        began = perf_counter()
        study = self.study_at(design, operation)
        mesh = self._moved(study)
        new = mesh is None
        if mesh is None:
            self._meshed(design, operation)
            mesh = self._mesh
        frame = replace(self._frame(design, operation, Label.EXACT, fields), new_mesh=new)
        rod = prepare(study, mesh=mesh)
        result = solve_speed(rod, operation.rpm)
        yield solved(frame, rod, result, self.surface, began)
        if study.engine is not None:
            result = with_cycle(rod, result)
            yield solved(frame, rod, result, self.surface, began)

    def _moved(self, study: Study) -> MeshedRod | None:
        if study.rod == self._of:
            return self._mesh
        return moved(self._mesh, study.rod)

    def _meshed(self, design: Design, operation: Operation) -> None:
        """Make the mesh that others are moved from."""
        study = self.study_at(design, operation)
        adapted = adapt_mesh(study, (operation.rpm,), Clock(), movable=bool(self.dimensions))
        self._mesh, self._of = adapted.rod.mesh, study.rod
        self.surface = Surface.of(self._mesh.whole)
        self.base += 1

    def _frame(self, design: Design, operation: Operation, label: Label, shown: str) -> Frame:
        return Frame(
            design={**self.base_design, **design},
            operation=operation,
            label=label,
            base=self.base,
            shown=shown,
            pins=PRESCRIBED,
        )


def fresh(study: Study, fields: str = LARGEST_OF_CASES) -> Frame:
    """Solve a study on a mesh of its own, refined as `fea run` does, its pins in contact where it says so.

    Raises
    ------
    InvalidValue, GeometryError, MeshError, …
        As `fea run`.
    """
    began, operation = perf_counter(), Operation.of(study)
    adapted = adapt_mesh(study, (operation.rpm,), Clock())
    result = adapted.at(operation.rpm)
    if result.cycle is None and study.engine is not None:
        result = with_cycle(adapted.rod, result)
    surface = Surface.of(adapted.rod.mesh.whole)
    frame = Frame(
        design={each.name: each.value for each in dimensions(study)},
        operation=operation,
        label=Label.CONVERGED,
        shown=fields,
        pins=CONTACT if adapted.rod.options.in_contact else adapted.rod.structure.pressure,
        new_mesh=True,
        triangles=triangles(surface),
    )
    return solved(frame, adapted.rod, result, surface, began)
