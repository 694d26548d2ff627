"""The comparison as a Markdown report."""

import math
from pathlib import Path

from fea.output.text import make_directory, write_text
from fea.verify.converge.advice import advice
from fea.verify.converge.converge import LONG, PROBLEMS, QUANTITY, RUNS, Comparison
from fea.verify.converge.front import FLOOR, pareto
from fea.verify.converge.plot import draw
from fea.verify.converge.row import Row
from fea.verify.converge.versus import GOAL, EqualError, equal_error, equal_time

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
    """Write the report, with its plot next to it.

    Parameters
    ----------
    path
        The .md file.
    comparison
        The results.
    command
        The command that makes the report.
    """
    make_directory(path.parent)
    plot = path.with_suffix(".png")
    draw(comparison, plot)
    rod = _of("rod", comparison)
    parts = [
        "# Error against run time",
        f"Made by `{command}`.",
        "\n".join(f"- {line}" for line in advice(rod, _floor("rod", comparison))),
    ]
    parts += [_READING, f"![error against total seconds]({plot.name})", *_against(comparison)]
    parts += [_section(problem, comparison) for problem in PROBLEMS]
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def _floor(problem: str, comparison: Comparison) -> float:
    return max(FLOOR, comparison.references[problem].uncertainty_percent)


def _of(problem: str, comparison: Comparison) -> list[Row]:
    return [row for row in comparison.rows if row.computation.problem == problem]


def _against(comparison: Comparison) -> list[str]:
    """The tables of equal error and equal time; none without CalculiX."""
    equal = [
        _equal_error_row(problem, found)
        for problem in PROBLEMS
        for found in equal_error(_of(problem, comparison), _floor(problem, comparison))
    ]
    if not equal:
        return []
    head = f"| problem | within % | fea s | fea, whole s | CalculiX s | CalculiX / fea | {GOAL:g} or more |"
    timed = [
        f"| {problem} | {at.seconds:g} | {at.ours:.2g} | {at.theirs:.2g} | {at.theirs / at.ours:.1f} |"
        for problem in PROBLEMS
        for at in equal_time(_of(problem, comparison), _floor(problem, comparison))
    ]
    return [
        "## Against CalculiX",
        _AGAINST,
        "\n".join([head, "| --- | ---: | ---: | ---: | ---: | ---: | --- |", *equal]),
        "\n".join(
            [
                "| problem | after s | fea error % | CalculiX error % | CalculiX / fea |",
                "| --- | ---: | ---: | ---: | ---: |",
                *timed,
            ]
        ),
    ]


def _equal_error_row(problem: str, found: EqualError) -> str:
    reached = math.isfinite(found.theirs)
    theirs = _seconds(found.theirs) if reached else f"> {_seconds(found.longest)}"
    ratio = "–" if math.isnan(found.ratio) else f"{'' if reached else '> '}{found.ratio:.1f}"
    open_ended = "not known" if not reached else "no"
    goal = "yes" if found.goal_met else open_ended
    ours, whole = _seconds(found.ours), _seconds(found.whole)
    return f"| {problem} | {found.percent:g} | {ours} | {whole} | {theirs} | {ratio} | {goal} |"


def _seconds(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def _section(problem: str, comparison: Comparison) -> str:
    rows, reference = _of(problem, comparison), comparison.references[problem]
    floor = _floor(problem, comparison)
    front = pareto(rows, floor)
    known = f" ± {reference.uncertainty_percent:.2g} %" if reference.uncertainty_percent else ", exact"
    lines = [
        "| tool | element | size mm | dofs | seconds | MiB | MPa | error % | front |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for row in rows:
        found = row.measured
        error = f"{row.error_percent:.2f}".replace("-", "−")
        if abs(row.error_percent) < reference.uncertainty_percent:
            error = f"({error})"
        cells = (
            *(row.computation.name, row.computation.element.upper(), f"{found.size:.3g}", str(found.dofs)),
            *(f"{found.seconds:.2f}", f"{found.peak_memory:.0f}", f"{found.value:.2f}", error),
            "**yes**" if row in front else "",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return f"## {QUANTITY[problem]}\n\nReference: {reference.value:.2f} MPa{known}.\n\n" + "\n".join(lines)
