"""The job behind `fea sweep`: resume where the journal ends, and leave the tables and the report."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from fea.analysis.figures import Figures
from fea.apps.sweep.journal import CSV, PARQUET, SCHEMA, Journal, RodResult, failures, write_tables
from fea.apps.sweep.report import report_sweep
from fea.apps.sweep.statistics import Statistics
from fea.apps.sweep.sweep_file import RowState, Sweep, SweepRow, rows
from fea.apps.sweep.workers import DEFAULT_MINUTES, EVALUATE, Task, cluster, compute_pending
from fea.base.version import __version__
from fea.machine.clock import duration, progress_line
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
    compute: str = EVALUATE,
) -> SweepReport:
    """Compute the rods of a sweep that its journal does not have yet, and write the tables and the report.

    The folder is new, empty, or that of the same sweep; `workers` and `address` are those of `cluster`. A rod
    that takes longer than `minutes` has failed. `compute` is that of `Task`. Raises `InvalidValue`: a
    value breaks a rule, or the folder holds the journal of another sweep or version; `OccupiedError`: it
    holds something else, or another process is at work in it; `StorageError`: the disk, a permission or the
    file system refuses; `ClusterError`, `VersionError`: the scheduler or a worker cannot be used.
    """
    rule = f"must be above 0 and at most {_A_YEAR}"
    require(0 < minutes <= _A_YEAR, "--limit-minutes", minutes, rule)
    resume = f"interrupted; the same command resumes with the rods that are not in {near(folder / JOURNAL)}"
    with journal_of(sweep, folder) as journal, saying(resume):
        if retry_failed:
            journal.retry()
        progress = Progress(len(journal.pending()))
        try:
            if progress.total:
                first = "starting the workers"
                with progress_line(first, silent=silent) as show, cluster(workers, address) as started:
                    # The mesh of a rod depends on rounding, and that on the threads: the table must not on
                    # the workers.
                    common = Task(
                        sweep.base, sweep.outputs, seconds=60 * minutes, threads=threads(1), compute=compute
                    )
                    compute_pending(journal, started, common, progress.shown_by(show))
        except BaseException:
            with suppress(StorageError):  # on a full disk the journal comes first
                write_tables(folder, journal.rows())
            raise
        write_tables(folder, journal.rows())
        figures = report_sweep(folder / REPORT, sweep, journal)
        counts = journal.counts()
        return SweepReport(
            folder=folder,
            computed=progress.done,
            done=counts[RowState.DONE],
            failed=counts[RowState.FAILED],
            untrusted=sum(row.figures.get("trusted") is False for row in journal.rows()),
            reasons={reason: count for _, reason, count in failures(journal.rows())},
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
    # Errors in the rows are reported before anything is written.
    new = None if (folder / JOURNAL).exists() else rows(sweep)
    make_directory(folder)
    with (
        owned(folder, folder, "fea sweep", "wait for it, or choose --out"),
        closing(Journal(folder / JOURNAL)) as journal,
    ):
        _settle(sweep, folder, journal, new)
        yield journal


def _settle(sweep: Sweep, folder: Path, journal: Journal, new: list[SweepRow] | None) -> None:
    """Enter the rows of a new sweep, or those by which a sweep has become longer."""
    meta, wanted = journal.meta, {"schema": SCHEMA, "version": __version__, "sweep": sweep.identity}
    where, remedy = str(near(folder)), "Choose another directory with --out, or remove this one."
    if not meta:
        journal.enter(wanted, rows(sweep) if new is None else new)
        return
    schema, version = meta.get("schema"), meta.get("version")
    require(schema == SCHEMA, "--out", where, f"holds a journal of another kind, {schema!r}", remedy)
    rule = f"holds a sweep by version {version}, and this is {__version__}: rows would not compare"
    require(version == __version__, "--out", where, rule, remedy)
    if meta["sweep"] == sweep.identity:
        return
    longer, keys = rows(sweep), journal.keys()
    rule = "holds the journal of another sweep: other keys, values, files, seed or study"
    same = len(longer) > len(keys) and [row.key for row in longer[: len(keys)]] == keys
    require(same, "--out", where, rule, remedy)
    journal.enter(wanted, longer[len(keys) :])


class Progress:
    """Counts the rods that came back, of a total to compute now."""

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.total, self.done = total, 0
        self._clock = clock
        # The rate is that of the last results: the first ones wait for libraries to load.
        self._times: deque[tuple[float, int]] = deque([(clock(), 0)], maxlen=50)

    def add(self, count: int) -> None:
        """Count rods that came back."""
        if count:
            self.done += count
            self._times.append((self._clock(), self.done))

    def text(self, threads: int) -> str:
        """Return the progress, the pace and the time left, in a line."""
        share = f"{self.done} of {self.total} rods"
        if threads == 0:
            return f"{share}; waiting for a worker"
        (start, before), now = self._times[0], self._clock()
        if self.done == before or now <= start:
            return f"{share}, {threads} at a time"
        rate = (self.done - before) / (now - start)
        pace = f"{rate:.2g} a second" if rate >= 1 else f"{60 * rate:.2g} a minute"
        return f"{share}, {pace}, {duration((self.total - self.done) / rate)} left"

    def shown_by(self, show: Callable[..., None]) -> Callable[[Sequence[RodResult], int], None]:
        """Return a listener of `compute_pending` that shows progress, and the cost after the first rods."""

        def listener(results: Sequence[RodResult], threads: int) -> None:
            first = self.done == 0
            self.add(len(results))
            if results and first and threads and self.done < self.total:
                each = sum(rod.seconds for rod in results) / len(results)
                about = duration(each * (self.total - self.done) / min(threads, self.total))
                show(
                    f"about {about} for {self.total} rods of {each:.2g} s, {threads} at a time", lasting=True
                )
            show(self.text(threads))

        return listener
