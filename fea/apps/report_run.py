"""The job behind `fea report`: the report of a run that is on disk."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fea.analysis.figures import EnvelopeFigures
from fea.analysis.motion import Known, agreeing, motion
from fea.analysis.prepare import PreparedRod, prepare
from fea.base.choices import UnitSystem
from fea.base.units import DEG
from fea.machine.clock import Clock
from fea.output.folder import REPORT, SUMMARY
from fea.output.pictures.process import ready_to_draw
from fea.output.report.page import write_report
from fea.output.report.sections import marks
from fea.output.stored_run import StoredRun, read_run
from fea.output.units import shown_in
from fea.rod.given import PART, meshed_rod
from fea.solid.errors import ContactError, SingularMatrixError, SolverUnavailableError, UnderconstrainedError
from fea.study.option_tables import PINS
from fea.study.study import Study
from geometry.errors import InvalidValue, require
from loads.instants import Instants
from mesh.files.given import named_mesh
from mesh.tetmesh import MeshError

# Largest relative difference between the forces of a run and those worked out again.
_SAME_FORCES = 1e-6
_OF_ASSEMBLY = (
    "Export its results as .vtu or .med instead of a deck; fea run study.toml --cycle --report writes a "
    "report with its cycle."
)


def prepared_again(run: StoredRun) -> PreparedRod:
    """Prepare the study of a run on the run's own mesh.

    Raises `InvalidValue`: the rod is an assembly: a run's mesh does not say where its parts touch;
    `MeshError`: the bores of the run's mesh were not found.
    """
    study, rule = run.study, "holds a rod of separate parts, and its mesh does not say where they touch"
    require(study.assembly is None, "RUN", str(run.folder), rule, _OF_ASSEMBLY)
    dimensions = study.rod.dimensions
    known = (None, None) if dimensions is None else (dimensions.big_end_bore, dimensions.small_end_bore)
    mesh, bores = named_mesh(run.mesh, known)
    names = _part_names(study, 1 if mesh.part is None else int(mesh.part.max()) + 1)
    return prepare(study, mesh=meshed_rod(mesh, bores, names))


def _part_names(study: Study, count: int) -> Sequence[str]:
    if count == 1:
        return [next(iter(sorted(study.part_material.keys() - PINS)), PART)]
    if study.rod.cad is None:
        return ["rod", "bushing"]
    from fea.analysis.forces import drawn_solid  # noqa: PLC0415 - only several parts need their solid

    return [part.name for part in drawn_solid(study.rod).parts]


def require_same_loads(run: StoredRun, cases: Iterable[Instants]) -> Mapping[str, Instants]:
    """Return load cases by their names, if their loads are those of the run.

    Raises `InvalidValue`: they are not.
    """
    again = {case.name: case for case in cases}
    remedy = "Repeat the run: fea run study.toml."
    told = run.summary.loads
    rule = f"holds the cases {', '.join(told)}, but its study gives {', '.join(again)}"
    require(set(told) == set(again), "RUN", str(run.folder), rule, remedy)
    for name, case in again.items():
        then = np.array([told[name].pin_axial_N, told[name].crank_axial_N])
        now = np.array([case.pin_axial, case.crank_axial])
        if np.abs(then - now).max() > _SAME_FORCES * case.largest_force:
            rule = f"was loaded with {then[0]:.6g} N at the pin in {name}, but its study gives {now[0]:.6g} N"
            raise InvalidValue("RUN", str(run.folder), rule, remedy)
    return again


# What may keep the cycle from being solved again; the rest of a report does without.
_REFUSALS = (
    InvalidValue, MeshError, ContactError, SingularMatrixError, SolverUnavailableError, UnderconstrainedError,
)  # fmt: skip


def report_run(
    folder: Path, listener: Callable[[str], None] | None = None, units: UnitSystem | None = None
) -> list[Path]:
    """Write the report of a run into its folder, or of each run of one at several speeds; return their files.

    The listener is told the name of each stage as it begins. The figures are in the given units, or in those
    of the run. Raises `InvalidValue`: the folder is not that of a run, or its files are damaged;
    `StorageError`: the disk, a permission or the file system refused.
    """
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", "Name a folder that fea run wrote.")
    clock = Clock(listener)
    speeds = sorted({place.parent for place in folder.glob(f"*/{SUMMARY}")})
    with ready_to_draw():
        if (folder / SUMMARY).is_file() or not speeds:
            return [_report(folder, clock, units)]
        return [_report(speed, clock, units) for speed in speeds]


def _report(folder: Path, clock: Clock, units: UnitSystem | None) -> Path:
    with clock("read"):
        run = read_run(folder)
        cycle = run.summary.cycle if run.fields else None
    if cycle is not None:
        run = _with_motion(run, cycle, clock)
    with clock("report"), shown_in(units or run.study.output.units):
        write_report(folder / REPORT, run)
    return folder / REPORT


def _with_motion(run: StoredRun, cycle: EnvelopeFigures, clock: Clock) -> StoredRun:
    """The run with its cycle, solved again on the run's own mesh: unit solutions are not kept on disk."""
    try:
        with clock("cycle"):
            rod = prepared_again(run)
            require_same_loads(run, rod.loading.at(rod.mass, run.summary.rpm).cases)
            again = motion(rod, run.summary.rpm or 0.0, cycle.max_von_mises_MPa)
    except _REFUSALS as error:
        return replace(run, without_motion=f"the cycle could not be solved again: {error}")
    same, why = agreeing(again, _known(run))
    return replace(run, motion=same, without_motion=f"solved again, {why}" if why else "")


def _known(run: StoredRun) -> Iterator[Known]:
    for name, angle in marks(run.summary).items():
        yield Known(angle * DEG, run.fields[name]["von_mises"], run.fields[name]["displacement"])
