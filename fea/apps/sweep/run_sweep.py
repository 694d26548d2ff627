"""The job behind `fea sweep`: go on where the journal ends, and leave the tables."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from fea.analysis.figures import Figures
from fea.apps.sweep.cluster import Engine, cluster
from fea.apps.sweep.journal import CSV, PARQUET, SCHEMA, Journal, Progress, State, failures, write_tables
from fea.apps.sweep.report import report_sweep
from fea.apps.sweep.statistics import Statistics
from fea.apps.sweep.sweep_file import PlannedRow, Sweep, rows
from fea.apps.sweep.work import DEFAULT_MINUTES, Rod, Task
from fea.base.version import __version__
from fea.machine.clock import progress_line
from fea.machine.system import saying
from fea.machine.threads import threads
from fea.output.folder import REPORT, owned
from fea.output.target import OccupiedError, StorageError, near
from fea.output.text import make_directory
from geometry.errors import require

JOURNAL = "sweep.sqlite"
_A_YEAR = 365 * 24 * 60
_OURS = {JOURNAL, f"{JOURNAL}-wal", f"{JOURNAL}-shm", CSV, PARQUET, REPORT}


class SweepReport(Figures):
    """The result of a sweep: rods computed by this call, and rows of the table by their state.

    Untrusted rows are among the done ones. `reasons` has the number of failed rows by their reason, that of
    the first where only numbers differ.
    """

    folder: Path
    computed: int
    done: int
    failed: int
    untrusted: int
    reasons: dict[str, int]
    statistics: Statistics


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    workers: int | None = None,
    address: str | None = None,
    retry_failed: bool = False,
    minutes: float = DEFAULT_MINUTES,
    silent: bool = True,
    compute: Callable[..., Any] | None = None,
) -> SweepReport:
    """Compute the rods of a sweep that its journal does not have yet, and write the tables and the report.

    The folder is new, empty, or that of the same sweep; `workers` and `address` are those of `cluster`. A rod
    that takes longer than `minutes` has failed. `compute` replaces the analysis in tests: it takes a study
    and the extras. Raises `InvalidValue`: the folder holds the journal of another sweep or
    version, or a value breaks a rule; `OccupiedError`: the folder holds something else, or another process is
    at work in it; `StorageError`: the disk, a permission or the file system refuses; `ClusterError`,
    `VersionError`: the scheduler or a worker cannot be used.
    """
    rule = f"must be above 0 and at most {_A_YEAR}"
    require(0 < minutes <= _A_YEAR, "--limit-minutes", minutes, rule)
    going_on = f"interrupted; the same command resumes with the rods that are not in {near(folder / JOURNAL)}"
    with journal_of(sweep, folder) as journal, saying(going_on):
        if retry_failed:
            journal.retry()
        progress = Progress(len(journal.pending()))
        try:
            if progress.total:
                first = "starting the workers"
                with progress_line(first, silent=silent) as show, cluster(workers, address) as client:
                    task = partial(_task, sweep, journal, minutes)
                    Engine(journal, client, task, compute).run(progress.shown_by(show))
        except BaseException:
            with suppress(StorageError):  # on a full disk the journal comes first
                write_tables(folder, journal.entries())
            raise
        write_tables(folder, journal.entries())
        figures = report_sweep(folder / REPORT, sweep, journal)
        counts = journal.counts()
        untrusted = sum(entry.figures.get("trusted") is False for entry in journal.entries())
        return SweepReport(
            folder=folder,
            computed=progress.done,
            done=counts[State.DONE],
            failed=counts[State.FAILED],
            untrusted=untrusted,
            reasons={reason: count for _, reason, count in failures(journal.entries())},
            statistics=figures,
        )


@contextmanager
def journal_of(sweep: Sweep, folder: Path) -> Iterator[Journal]:
    """Open the journal of a sweep, or begin one; errors as `run_sweep`."""
    if folder.exists() and not folder.is_dir():
        raise OccupiedError(f"{near(folder)} is a file: --out must name a directory.")
    others = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
    others = [name for name in others if name not in _OURS and not name.startswith(".")]
    if others:
        raise OccupiedError(
            f"{near(folder)} contains {others[0]}, which is not from a sweep: choose another --out."
        )
    # What is wrong with the rows is told before anything is written.
    new = None if (folder / JOURNAL).exists() else rows(sweep)
    make_directory(folder)
    with (
        owned(folder, folder, "fea sweep", "wait for it, or choose --out"),
        closing(Journal(folder / JOURNAL)) as journal,
    ):
        _settle(sweep, folder, journal, new)
        yield journal


def _settle(sweep: Sweep, folder: Path, journal: Journal, new: list[PlannedRow] | None) -> None:
    meta, asked = journal.meta, {"schema": SCHEMA, "version": __version__, "sweep": sweep.identity}
    where, remedy = str(near(folder)), "Choose another directory with --out, or remove this one."
    if not meta:
        journal.enter(asked, rows(sweep) if new is None else new)
        return
    schema = meta.get("schema")
    require(schema == SCHEMA, "--out", where, f"holds a journal of another kind, {schema!r}", remedy)
    rule = (
        f"holds a sweep by version {meta['version']}, and this is {asked['version']}: rows would not compare"
    )
    require(meta["version"] == asked["version"], "--out", where, rule, remedy)
    if meta["sweep"] == asked["sweep"]:
        return
    wanted, known = rows(sweep), journal.keys()
    rule = "holds the journal of another sweep: other keys, values, files, seed or study"
    same = len(wanted) > len(known) and [row.key for row in wanted[: len(known)]] == known
    require(same, "--out", where, rule, remedy)
    journal.enter(asked, wanted[len(known) :])


def _task(sweep: Sweep, journal: Journal, minutes: float, jobs: Sequence[str]) -> Task:
    rods = tuple(Rod(job, *journal.asked(job)) for job in jobs)
    # The mesh of a rod depends on rounding, and that on the threads: the table must not on the workers.
    return Task(rods, sweep.base, sweep.extras, __version__, 60 * minutes, threads(default=1))
