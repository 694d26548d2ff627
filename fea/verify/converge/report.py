"""The comparison on the terminal, and as a Markdown report with its plot."""

import math
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from rich.console import Console

from fea.output.plots.figure import new_figure
from fea.verify.converge.converge import LONG, PROBLEMS, QUANTITY, RUNS, Comparison
from fea.verify.converge.measurement import ConvergenceRow
from fea.verify.converge.series import FLOOR, GOAL, EqualError, advice, equal_error, equal_time, pareto
from fea.verify.layout import markdown, narrow_table, write_document

_TOOL = 12  # length of the longest word in a tool's name


def print_comparison(rows: Sequence[ConvergenceRow], advised: Sequence[str]) -> None:
    """Print one line per computation, and the advice."""
    table = narrow_table()
    table.add_column("problem", no_wrap=True)
    table.add_column("tool", min_width=_TOOL)
    for name in ("size\nmm", "dofs", "time\ns", "MiB", "MPa", "error\n%"):
        table.add_column(name, justify="right", no_wrap=True)
    for row in rows:
        found, what = row.measured, row.computation
        table.add_row(
            *(what.problem, f"{what.name}, {what.element}", f"{found.size:.3g}", str(found.dofs)),
            *(f"{found.seconds:.2f}", f"{found.peak_memory:.0f}", f"{found.value:.1f}"),
            f"{row.error_percent:+.2f}",
        )
    console = Console(highlight=False)
    console.print(table)
    for line in advised:
        console.print(line, markup=False)


_READING = f"""\
*Seconds* is the time of the whole run, from drawing the solid to the recovered stress, in a separate process
with the libraries already loaded. *Memory* is the peak memory of that process. *fea* recovers the stress on
the boundary from surface strain and known traction; *fea, mean* averages over elements; *fea, whole* does not
use mirror planes; *fea --tolerance* refines the mesh where its error bars require it. The time of a
computation that takes less than {LONG:g} s is the median of {RUNS} runs. CalculiX solves the same meshes as
*fea* (for the rod: *fea, whole*) with the same number of threads; drawing, meshing and loads are counted for
both programs.

Errors are signed. They are relative to the exact value or, for the rod, to a Richardson extrapolation of
meshes whose elements all shrink in proportion and are by far the smallest at the peak; none of these meshes
is among those compared. An error in parentheses is smaller than the uncertainty of the reference, so that its
value is not meaningful. In the plot a yellow band joins the computations that are fastest for their error.
"""
_AGAINST = """\
For each program the fastest of its series counts. The error of a mesh is here the largest error of that and
all finer meshes, so that a mesh that is right by accident does not count; the error of the finest mesh counts
as at least the previous one reduced at twice the theoretical rate. Between meshes, times are interpolated
logarithmically in time and error. "> x" is the time of CalculiX's slowest mesh if it did not reach the error.
"""


def write_report(path: Path, comparison: Comparison, command: str) -> None:
    """Write the report, which the `command` makes, with its plot next to it."""
    plot = path.with_suffix(".png")
    advised = advice(comparison.of("rod"), _floor("rod", comparison))
    parts = [
        "# Error against run time",
        f"Made by `{command}`.",
        "\n".join(f"- {line}" for line in advised),
        _READING,
        f"![error against total seconds]({plot.name})",
        *_against(comparison),
        *(part for problem in PROBLEMS for part in _section(problem, comparison)),
    ]
    write_document(path, parts)
    _draw(comparison, plot)


def _floor(problem: str, comparison: Comparison) -> float:
    return max(FLOOR, comparison.references[problem].uncertainty_percent)


def _against(comparison: Comparison) -> list[str]:
    """The tables of equal error and equal time; none without CalculiX."""
    of_problem = {problem: (comparison.of(problem), _floor(problem, comparison)) for problem in PROBLEMS}
    equal = [
        _equal_error_cells(problem, at) for problem, rows in of_problem.items() for at in equal_error(*rows)
    ]
    if not equal:
        return []
    timed = [
        (problem, f"{at.seconds:g}", f"{at.ours:.2g}", f"{at.theirs:.2g}", f"{at.theirs / at.ours:.1f}")
        for problem, rows in of_problem.items()
        for at in equal_time(*rows)
    ]
    seconds = ("fea s", "fea, whole s", "CalculiX s", "CalculiX / fea")
    errors = ("fea error %", "CalculiX error %", "CalculiX / fea")
    return [
        "## Against CalculiX",
        _AGAINST,
        markdown(("problem", "within %", *seconds, f"{GOAL:g} or more"), equal, "lrrrrr"),
        markdown(("problem", "after s", *errors), timed, "lrrrr"),
    ]


def _equal_error_cells(problem: str, at: EqualError) -> tuple[str, ...]:
    reached = math.isfinite(at.theirs)
    theirs = _seconds(at.theirs) if reached else f"> {_seconds(at.longest)}"
    ratio = "–" if math.isnan(at.ratio) else f"{'' if reached else '> '}{at.ratio:.1f}"
    open_ended = "no" if reached else "not known"
    goal = "yes" if at.goal_met else open_ended
    return (problem, f"{at.percent:g}", _seconds(at.ours), _seconds(at.whole), theirs, ratio, goal)


def _seconds(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def _section(problem: str, comparison: Comparison) -> tuple[str, str, str]:
    rows, reference = comparison.of(problem), comparison.references[problem]
    front = pareto(rows, _floor(problem, comparison))
    known = f" ± {reference.uncertainty_percent:.2g} %" if reference.uncertainty_percent else ", exact"
    lines = []
    for row in rows:
        it, error = row.measured, f"{row.error_percent:.2f}".replace("-", "−")
        if abs(row.error_percent) < reference.uncertainty_percent:
            error = f"({error})"
        numbers = (f"{it.size:.3g}", str(it.dofs), f"{it.seconds:.2f}", f"{it.peak_memory:.0f}")
        name, element = row.computation.name, row.computation.element.upper()
        best = "**yes**" if row in front else ""
        lines.append((name, element, *numbers, f"{it.value:.2f}", error, best))
    header = ("tool", "element", "size mm", "dofs", "seconds", "MiB", "MPa", "error %", "front")
    table = markdown(header, lines, "llrrrrrr")
    return f"## {QUANTITY[problem]}", f"Reference: {reference.value:.2f} MPa{known}.", table


_COLOURS = {
    "fea": "tab:blue",
    "fea, mean": "tab:orange",
    "fea, whole": "tab:green",
    "fea --tolerance": "tab:red",
    "CalculiX": "0.45",
}
_COARSE = "tab:purple"  # a tolerance reached from a coarse mesh, whose name contains the size


def _draw(comparison: Comparison, path: Path) -> None:
    """Draw one panel per problem; the Pareto front is shaded."""
    figure = new_figure(13, 5)
    for axes, problem in zip(figure.subplots(1, len(PROBLEMS)), PROBLEMS, strict=True):
        rows, floor = comparison.of(problem), _floor(problem, comparison)
        for (_, tool, element), same in groupby(rows, key=lambda row: row.computation.series):
            x, y = _points(list(same))
            style = "-o" if element == "p2" else "--^"
            label = f"{tool}, {element.upper()}"
            axes.loglog(
                x, y, style, color=_COLOURS.get(tool, _COARSE), markersize=4, linewidth=1, label=label
            )
        front = _points(pareto(rows, floor))
        axes.loglog(*front, color="gold", linewidth=7, alpha=0.4, zorder=0, label="fastest for its error")
        if floor > FLOOR and floor < 100:
            axes.axhspan(FLOOR / 2, floor, color="0.9", zorder=-1, label="below the reference's uncertainty")
        axes.set(title=QUANTITY[problem], xlabel="total seconds", ylabel="error, %")
        axes.grid(alpha=0.3, which="both")
        axes.legend(fontsize=7, frameon=False)
    figure.savefig(path, dpi=100)


def _points(rows: Sequence[ConvergenceRow]) -> tuple[list[float], list[float]]:
    return [row.measured.seconds for row in rows], [max(abs(row.error_percent), FLOOR / 2) for row in rows]
