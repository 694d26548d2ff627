"""The job behind `fea sweep`: resume where the journal ends, and leave the tables and the report.

The report is one HTML page with its drawings, each point linked to its study.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.analysis.figures import Figures
from fea.apps.sweep.journal import CSV, PARQUET, SCHEMA, Journal, RodResult, failures, write_tables
from fea.apps.sweep.statistics import FACTOR, MASS, Samples, Statistics, statistics
from fea.apps.sweep.sweep_file import RowState, Sweep, SweepRow, rows
from fea.apps.sweep.workers import DEFAULT_MINUTES, EVALUATE, Task, cluster, compute_pending
from fea.base.version import __version__
from fea.machine.clock import duration, progress_line
from fea.machine.system import saying
from fea.machine.threads import threads
from fea.output.folder import REPORT, OccupiedError, StorageError, make_directory, near, owned, write_text
from fea.output.html import embedded_json, html_page, page_file
from fea.output.pictures.scale import round_up
from fea.output.units import in_unit, named, unit
from geometry.arrays import Floats, Ints
from geometry.errors import require

# More points than these cannot be told apart, and make a page slow; and designs that the page holds.
_MOST_POINTS, _MOST_LINES, _MOST = 2000, 500, 1000
_MOST_AXES = 6
# A mean over fewer rods than these shows their scatter rather than the effect of a key.
_BINS, _LEAST_IN_BIN = 8, 5
# Left, right, bottom and top of drawings.
_WIDE = (60.0, 580.0, 300.0, 16.0)
_SMALL = (48.0, 230.0, 170.0, 8.0)
_TICKS = 4


@dataclass(frozen=True, kw_only=True)
class SweepPage:
    """The contents of the page."""

    title: str
    counts: str  #: rows by their state, in words
    samples: Samples  #: the designs that are drawn
    studies: Sequence[str]  #: their study files
    statistics: Statistics
    failures: Sequence[tuple[int, str, int]] = ()  #: row, reason, count

    @cached_property
    def keys(self) -> dict[str, Floats]:
        """Values (n,) of the varied keys that are numbers, in the units that are shown."""
        return {key: in_unit(self.samples.column(key), named(key)[1]) for key in self.samples.numeric}

    @cached_property
    def figures(self) -> dict[str, Floats]:
        """Mass and factors (n,) in the units that are shown, NaN where there is none."""
        return {name: in_unit(values, named(name)[1]) for name, values in self.samples.values.items()}

    @property
    def columns(self) -> dict[str, Floats]:
        """Keys and figures (n,)."""
        return self.keys | self.figures

    @property
    def axes(self) -> list[str]:
        """The first keys, mass and the least factor."""
        outcome = [name for name in (MASS, FACTOR) if name in self.figures]
        return [*list(self.keys)[: _MOST_AXES - len(outcome)], *outcome]


def _spread(samples: Samples, figure: str, most: int) -> Ints:
    """Numbers of the designs that have a figure, at most so many of them, evenly chosen."""
    numbers = np.flatnonzero(samples.known(figure))
    return np.asarray(numbers[np.linspace(0, len(numbers) - 1, min(len(numbers), most)).round().astype(int)])


def label(name: str) -> str:
    """Return the name of a key or a column with its unit: ``web thickness (mm)``.

    The table of a key is left out where it is that of the rod.
    """
    words, named_unit = named(name.removeprefix("rod."))
    words = words.replace(".", " ")
    return f"{words} ({unit(named_unit)})" if named_unit else {FACTOR: "least factor"}.get(words, words)


Ticks = tuple[tuple[float, str], ...]


class ScatterPlot(NamedTuple):
    """A drawing for the template."""

    x: str
    y: str
    points: tuple[tuple[float, float, int], ...]  #: places with the number of their design
    line: str
    x_ticks: Ticks
    y_ticks: Ticks
    limit: float | None  #: height of the line factor = 1, if it is in the picture
    size: tuple[float, float]


def _scatter(
    page: SweepPage,
    names: tuple[str, str],
    chosen: Ints,
    line: Floats | None = None,
    frame: tuple[float, float, float, float] = _SMALL,
) -> ScatterPlot:
    """Draw one column against another: points of the chosen designs, and a line (m, 2)."""
    left, right, bottom, top = frame
    across, up = (page.columns[name][chosen] for name in names)
    x, _, x_ticks = _axis(across, left, right)
    y, (low, high), y_ticks = _axis(up, bottom, top)
    both = np.isfinite(across) & np.isfinite(up)
    points = zip(x(across[both]), y(up[both]), chosen[both].tolist(), strict=True)
    path = () if line is None else zip(x(line[:, 0]), y(line[:, 1]), strict=True)
    return ScatterPlot(
        label(names[0]),
        label(names[1]),
        tuple(points),
        " ".join(f"{a:g},{b:g}" for a, b in path),
        x_ticks,
        y_ticks,
        y(np.ones(1))[0] if names[1].endswith("factor") and low < 1 < high else None,
        (right, bottom),
    )


def _axis(
    values: Floats, first: float, last: float
) -> tuple[Callable[[Floats], list[float]], tuple[float, float], Ticks]:
    """Return the map from values (n,) to places on an axis, its ends with some room, and its ticks."""
    finite = values[np.isfinite(values)]
    low, high = float(finite.min()), float(finite.max())
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    low, high = low - room, high + room

    def places(at: Floats) -> list[float]:
        return [round(place, 1) for place in (first + (last - first) * (at - low) / (high - low)).tolist()]

    step = round_up((high - low) / _TICKS)
    marks = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
    labels = (f"{mark:.5g}".replace("-", "−") for mark in marks)
    return places, (low, high), tuple(zip(places(marks), labels, strict=True))


def pareto(page: SweepPage) -> ScatterPlot | None:
    """Mass against the factor, with the front."""
    both = [page.figures[name] for name in (MASS, FACTOR) if name in page.figures]
    if len(both) < 2 or not np.isfinite(both[1]).any():
        return None
    chosen = np.union1d(_spread(page.samples, FACTOR, _MOST_POINTS), page.samples.front).astype(int)
    front = np.stack([values[page.samples.front] for values in both], axis=1)
    return _scatter(page, (MASS, FACTOR), chosen, front, _WIDE)


def matrix(page: SweepPage) -> list[ScatterPlot]:
    """Every pair of the first keys, of mass and of the factor."""
    chosen, axes = _spread(page.samples, FACTOR, _MOST_LINES), page.axes
    pairs = [(x, y) for k, y in enumerate(axes) for x in axes[:k]] if len(chosen) > 1 else []
    return [_scatter(page, pair, chosen) for pair in pairs]


def main_effects(page: SweepPage) -> list[ScatterPlot]:
    """The mean factor against each key: at each of its values, or over equal numbers of rods."""
    chosen = _spread(page.samples, FACTOR, len(page.samples.rows))
    if not len(chosen):
        return []
    drawn, factors = [], page.figures[FACTOR][chosen]
    for key, values in page.keys.items():
        means = _means(values[chosen], factors, alone=len(page.keys) == 1)
        drawn.append(_scatter(page, (key, FACTOR), chosen, means))
    return drawn


def _means(x: Floats, y: Floats, *, alone: bool) -> Floats | None:
    """Return (m, 2) means of x and y; None for too few rods. `alone`: no other key varies."""
    distinct = np.unique(x)
    if alone or (len(distinct) <= _BINS and len(distinct) < len(x)):
        return np.array([(value, y[x == value].mean()) for value in distinct])
    bins = min(_BINS, len(x) // _LEAST_IN_BIN)
    if bins < 2:
        return None
    groups = np.array_split(np.argsort(x, kind="stable"), bins)
    return np.array([(x[group].mean(), y[group].mean()) for group in groups])


_COLUMNS = (
    ("first", "first-order index"), ("total", "total index"), ("regression", "standardised slope"),
)  # fmt: skip


def sweep_page(page: SweepPage) -> str:
    """Return the report of a sweep as HTML."""
    # The studies, whose lines are mostly alike: each line once, and its numbers in each study.
    numbers: dict[str, int] = {}
    studies = [
        [numbers.setdefault(line, len(numbers)) for line in text.splitlines()] for text in page.studies
    ]
    values = [
        {name: float(f"{column[n]:.6g}") for name, column in page.columns.items() if column[n] == column[n]}
        for n in range(len(page.samples.rows))
    ]  # fmt: skip
    return html_page(
        "sweep_report",
        "sweep.html.jinja",
        page_file("report", "report.css") + page_file("sweep_report", "sweep.css"),
        page_file("sweep_report", "sweep.js"),
        page=page,
        columns=_COLUMNS,
        pareto=pareto(page),
        matrix=matrix(page),
        effects=main_effects(page),
        fails={n for n, factor in enumerate(page.figures.get(FACTOR, ())) if factor < 1},
        data=embedded_json(
            {"rows": page.samples.rows, "lines": list(numbers), "studies": studies, "values": values}
        ),
    )


def report_sweep(path: Path, sweep: Sweep, journal: Journal) -> Statistics:
    """Write the report of a sweep, and return its statistics. Raises `StorageError`: it cannot be written."""
    samples = Samples.of(journal.rows())
    results = statistics(sweep, samples)
    shown = samples.part(np.union1d(_spread(samples, MASS, _MOST), samples.front).astype(int).tolist())
    rows = [next(journal.rows(number)) for number in shown.rows]
    page = SweepPage(
        title=sweep.name,
        counts=_counts(journal, samples, shown),
        samples=shown,
        studies=[sweep.base.study(row.design, [row.rpm]).text() for row in rows],
        statistics=results,
        failures=failures(journal.rows()),
    )
    write_text(path, sweep_page(page))
    return results


def _counts(journal: Journal, samples: Samples, shown: Samples) -> str:
    counts = journal.counts()
    states = ", ".join(f"{counts[state]} {state}" for state in RowState if counts[state])
    sentences = [f"Rows of the table: {states}."]
    if not len(shown.rows):
        return f"{sentences[0]} No rod has a result that can be trusted, so there is nothing to draw."
    if len(shown.rows) < len(samples.rows):
        sentences.append(f"{len(shown.rows)} of {len(samples.rows)} designs are drawn.")
    words = [key for key in samples.keys if any(isinstance(one[key], str | bool) for one in samples.designs)]
    if words:
        sentences.append(f"In the table alone, as they are not numbers: {', '.join(words)}.")
    return " ".join(sentences)


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
