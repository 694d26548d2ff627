"""All extreme cases by name; their rows on the terminal and in a Markdown report with plots."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from fea.machine.clock import Listener
from fea.output.plots.figure import new_figure
from fea.verify.benchmark import compute_rows
from fea.verify.layout import explanation, markdown, print_table, write_document
from fea.verify.stability import bodies, runs
from fea.verify.stability.outcome import ExtremeRow, Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_IN_ORDER = (
    *(bodies.contrast, bodies.liner, bodies.slender, bodies.ring, bodies.grading, bodies.slivers),
    *(bodies.bending, bodies.incompressible, bodies.membrane, bodies.scaling),
    *(runs.engines, runs.rods),
)
CASES: dict[str, Callable[[], Iterable[ExtremeRow]]] = {case.__name__: case for case in _IN_ORDER}


def stability(names: Sequence[str] = (), listener: Listener | None = None) -> list[ExtremeRow]:
    """Compute some of `CASES`, or all, as `compute_rows`."""
    return compute_rows(CASES, "an extreme case", names, listener)


_HEADER = ("case", "value", "backward error", "condition", "energy error", "error %", "verdict")
_STYLE = {Outcome.WRONG: "bold red", Outcome.MARKED: "yellow", Outcome.REFUSED: "yellow"}


def print_stability(rows: Sequence[ExtremeRow]) -> None:
    """Print one line per row, and the counts of the outcomes."""
    lines = [(_cells(row), _STYLE.get(row.verdict, "")) for row in rows]
    print_table(_HEADER, lines, words=_HEADER[:2], end=[counts(rows)])


def _cells(row: ExtremeRow, digits: int = 0) -> tuple[str, ...]:
    quality = (row.backward_error, row.condition_estimate, row.energy_error, row.result_error_percent)
    shown = ("–" if value is None else f"{value:.{digits}e}" for value in quality)
    return (row.case, f"{row.parameter} = {row.value:g}", *shown, row.verdict.value)


def counts(rows: Sequence[ExtremeRow]) -> str:
    """Return the counts of the outcomes as a sentence."""
    by_verdict = Counter(row.verdict for row in rows)
    each = ", ".join(f"{by_verdict[verdict]} {verdict.value}" for verdict in Outcome)
    return f"{len(rows)} extreme cases: {each}."


def write_report(path: Path, rows: Sequence[ExtremeRow], command: str) -> None:
    """Write the report, which the `command` makes, with its plot next to it; raises `StorageError`."""
    plot = path.with_suffix(".png")
    lines = ((*_cells(row, digits=1), ", ".join(row.noticed_by)) for row in rows)
    parts = [
        f"**{counts(rows)}**",
        explanation("stability"),
        f"![error against the extreme parameter]({plot.name})",
        markdown((*_HEADER, "noticed by"), lines, "lrrrrr"),
    ]
    write_document(path, "Ill-conditioned and extreme cases", command, parts)
    _draw(rows, plot)


_COLOR = {
    Outcome.RIGHT: "tab:green",
    Outcome.MARKED: "tab:orange",
    Outcome.REFUSED: "tab:gray",
    Outcome.WRONG: "red",
}
# Number of values from which labels must be rotated to fit side by side.
_MANY = 8
# Replaces zero on a logarithmic axis.
_LEAST = 1e-18


def _draw(rows: Sequence[ExtremeRow], path: Path) -> None:
    """Draw the error of the result and of the energy over each case's parameter."""
    cases = {name: list(same) for name, same in groupby(rows, key=lambda row: row.case)}
    columns = 4
    lines = -(-len(cases) // columns)
    figure = new_figure(3.4 * columns, 2.6 * lines + 0.5)
    for place, (name, of_case) in enumerate(cases.items(), 1):
        _draw_case(figure.add_subplot(lines, columns, place), name, of_case)
    key = {
        label: artist
        for axes in figure.axes
        for artist, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(key.values(), key.keys(), loc="outside upper center", ncols=7, fontsize=8)
    figure.savefig(path, dpi=80)


def _draw_case(axes: "Axes", name: str, rows: Sequence[ExtremeRow]) -> None:
    shown = [(place, row) for place, row in enumerate(rows) if row.result_error_percent is not None]
    at = [place for place, _ in shown]
    errors = [max(row.result_error_percent or 0.0, _LEAST) for _, row in shown]
    axes.semilogy(at, errors, "-", color="0.7", zorder=1)
    for place, error in zip(at, errors, strict=True):
        verdict = rows[place].verdict
        axes.scatter(place, error, color=_COLOR[verdict], zorder=2, label=f"{verdict.value}: error, %")
    if any(row.energy_error is not None for row in rows):
        energies = [100 * max(row.energy_error or 0.0, _LEAST) for _, row in shown]
        axes.semilogy(at, energies, ":", color="tab:blue", label="energy error, %")
    if rows[0].tolerance_percent is not None:
        axes.axhline(rows[0].tolerance_percent, ls="--", color="0.4", lw=1, label="tolerance")
    for place, row in enumerate(rows):
        if row.verdict in (Outcome.MARKED, Outcome.REFUSED):
            label = "reported by fea run"
            axes.axvspan(place - 0.5, place + 0.5, color="#fdebd0", zorder=0, label=label)
    axes.set_title(name, fontsize=9)
    axes.set_xlabel(rows[0].parameter, fontsize=8)
    axes.set_xticks(range(len(rows)), [f"{row.value:g}" for row in rows], fontsize=7)
    if len(rows) >= _MANY:
        axes.set_xticklabels(axes.get_xticklabels(), rotation=35, ha="right", rotation_mode="anchor")
    axes.set_xlim(-0.5, len(rows) - 0.5)
    axes.tick_params(axis="y", labelsize=7)
