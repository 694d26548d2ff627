"""From the journal of a sweep to its report."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from fea.apps.sweep.journal import Journal, State
from fea.apps.sweep.plan import study_of
from fea.apps.sweep.samples import MASS, Samples, pareto_front, samples_of
from fea.apps.sweep.sensitivity import Influence, Sensitivity
from fea.apps.sweep.statistics import Statistics, statistics
from fea.apps.sweep.sweep_file import Sweep
from fea.apps.sweep.table import failures
from fea.output.sweep_report.drawings import Influenced, Swept
from fea.output.sweep_report.write import write_sweep_report

FACTOR = "factor"
# Designs that the page holds; beyond, evenly chosen ones.
_MOST = 1000


def report_sweep(path: Path, sweep: Sweep, journal: Journal) -> Statistics:
    """Write the report of a sweep, and return what it tells.

    Raises
    ------
    StorageError
        The disk, a permission or the file system refuses.
    """
    samples = samples_of(journal.entries())
    found = statistics(sweep, samples)
    write_sweep_report(path, _swept(sweep, journal, samples, found))
    return found


def _swept(sweep: Sweep, journal: Journal, samples: Samples, found: Statistics) -> Swept:
    shown = samples.part(_shown(samples))
    counts = journal.counts()
    return Swept(
        title=sweep.name,
        counts=_counts(counts, samples, shown),
        keys={key: shown.column(key) for key in shown.numeric},
        figures=shown.values,
        rows=shown.rows,
        studies=[_study(sweep, journal, row) for row in shown.rows],
        front=_front(shown),
        probabilities=[
            (
                one.name,
                f"{one.estimate:.3g}",
                f"{one.low:.3g} to {one.high:.3g}",
                f"{one.rods}",
                f"{one.missing}",
            )
            for one in found.probabilities
        ],
        influences=[_influenced(one) for one in found.sensitivities],
        failures=failures(journal.entries()),
    )


def _counts(counts: Mapping[State, int], samples: Samples, shown: Samples) -> str:
    """What became of the rows, and what is not drawn, in words."""
    states = ", ".join(f"{counts[state]} {state}" for state in State if counts[state])
    said = [f"Rows of the table: {states}."]
    if not len(shown.rows):
        return f"{said[0]} No rod has a result that can be trusted, so there is nothing to draw."
    if len(shown.rows) < len(samples.rows):
        said.append(f"{len(shown.rows)} of {len(samples.rows)} designs are drawn.")
    words = [key for key in samples.keys if any(isinstance(one[key], str | bool) for one in samples.designs)]
    if words:
        said.append(f"In the table alone, as they are not numbers: {', '.join(words)}.")
    return " ".join(said)


def _shown(samples: Samples) -> Sequence[int]:
    """Numbers of the designs that the page holds, those of the front among them."""
    known = np.flatnonzero(samples.complete)
    some = known[np.linspace(0, len(known) - 1, min(len(known), _MOST)).round().astype(int)]
    chosen: list[int] = np.union1d(some, _front(samples)).astype(int).tolist()
    return chosen


def _front(samples: Samples) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    if MASS not in samples.values or FACTOR not in samples.values:
        return np.zeros(0, np.int64)
    return np.asarray(pareto_front(samples.values[MASS], samples.values[FACTOR]), np.int64)


def _study(sweep: Sweep, journal: Journal, row: int) -> str:
    entry = next(journal.entries(row))
    return study_of(sweep, entry.design, [entry.rpm]).text()


def _influenced(one: Sensitivity) -> Influenced:
    columns = {"first": "first-order index", "total": "total index", "regression": "standardised slope"}
    known = [name for name in columns if getattr(one.influences[0], name) is not None]
    share = (
        "" if one.linear_share is None else f"A linear regression explains {100 * one.linear_share:.3g} %. "
    )
    length = next((name for name in ("total", "first", "regression") if name in known), "first")
    bars = [abs(getattr(item, length) or 0.0) for item in one.influences]
    return Influenced(
        figure=one.figure,
        columns=tuple(columns[name] for name in known),
        rows=tuple((item.key, tuple(_cell(item, name) for name in known)) for item in one.influences),
        bars=tuple(min(bar, 1.0) for bar in bars),
        note=f"{share}{one.without_total[:1].upper()}{one.without_total[1:]}",
    )


def _cell(item: Influence, name: str) -> str:
    bar = getattr(item, f"{name}_bar", None)
    text = f"{round(getattr(item, name), 2) + 0.0:.2f}" + ("" if bar is None else f" ± {bar:.2f}")
    return text.replace("-", "−")
