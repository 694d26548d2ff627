"""The job behind `fea report`: the report of a run that is on disk."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from fea.analysis.cycle_figures import EnvelopeFigures
from fea.analysis.motion import Known, agreeing, motion
from fea.analysis.summary_file import SUMMARY
from fea.machine.clock import Clock
from fea.output.left_run import LeftRun
from fea.output.pictures.child import ready_to_draw
from fea.output.report.left import reported_left
from fea.output.report.name import REPORT
from fea.output.report.reported import Reported
from fea.output.report.sections import marks
from fea.output.report.write import leave
from fea.runs.repeated import prepared_again, require_same_loads
from fea.solid.errors import ContactError, SingularMatrixError, SolverUnavailableError, UnderconstrainedError
from fea.units import DEG
from geometry.invalid import InvalidValue, require
from mesh.errors import MeshError

# What may keep the cycle from being solved again; the rest of a report does without.
_REFUSALS = (
    InvalidValue, MeshError, ContactError, SingularMatrixError, SolverUnavailableError, UnderconstrainedError,
)  # fmt: skip


def report_run(folder: Path, listener: Callable[[str], None] | None = None) -> list[Path]:
    """Write the report of a run into its folder, or of each run of one at several speeds.

    Parameters
    ----------
    folder
        That `fea run` has written.
    listener
        Told the name of each stage as it begins.

    Returns
    -------
    list of Path
        The reports.

    Raises
    ------
    InvalidValue
        The folder is not that of a run, or its files are damaged.
    StorageError
        The disk, a permission or the file system refused.
    """
    require(folder.is_dir(), "RUN", str(folder), "is not a directory", "Name a folder that fea run wrote.")
    clock = Clock(listener)
    speeds = sorted({place.parent for place in folder.glob(f"*/{SUMMARY}")})
    with ready_to_draw():
        if (folder / SUMMARY).is_file() or not speeds:
            return [_report(folder, clock)]
        return [_report(speed, clock) for speed in speeds]


def _report(folder: Path, clock: Clock) -> Path:
    with clock("read"):
        run, left = reported_left(folder)
    if left is not None and run.cycle is not None:
        run = _with_motion(run, left, run.cycle, clock)
    with clock("report"):
        leave(folder / REPORT, run)
    return folder / REPORT


def _with_motion(run: Reported, left: LeftRun, cycle: EnvelopeFigures, clock: Clock) -> Reported:
    """The run with its cycle, solved again on the run's own mesh: unit solutions are not kept on disk."""
    try:
        with clock("cycle"):
            rod = prepared_again(left, run.study)
            require_same_loads(left, rod.loading.at(rod.mass, run.summary.rpm).cases)
            found = motion(rod, run.summary.rpm or 0.0, cycle.max_von_mises_MPa)
    except _REFUSALS as error:
        return replace(run, without_motion=f"the cycle could not be solved again: {error}")
    same, why = agreeing(found, _known(run))
    return replace(run, motion=same, without_motion=f"solved again, {why}" if why else "")


def _known(run: Reported) -> Iterator[Known]:
    """The load cases of the run that are instants of the cycle."""
    for name, angle in marks(run.summary).items():
        yield Known(angle * DEG, run.cases[name]["von_mises"], run.cases[name]["displacement"])
