"""The benchmark problems as a Markdown report."""

from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path

from fea.output.text import make_directory, write_text
from fea.verify.benchmark import Row
from fea.verify.terminal import verdict
from fea.verify.verification_plot import draw_convergence
from fea.verify.verify import benchmark, computed_rows

# Element sizes relative to the one at which a case must meet its goals.
COARSER = (2.8, 2.0, 1.4)

_READING = """\
Every problem is solved with the elements, the assembly, the solver and the stress recovery of `fea run`, on
geometry and meshes made by the same code as those of a rod. *Error* is relative to the target. *Seconds* is
the time of the whole case: drawing, meshing, solving and stress recovery.
"""

_PLOT = """\
Errors decrease with the number of degrees of freedom until they reach the accuracy of the target itself: a
target with three digits is accurate to 0.1 to 1 %, and the chart for the plate to 0.5 %. Errors at single
nodes scatter, because the meshes are irregular and not nested.
"""


def write_report(
    path: Path, rows: Sequence[Row], command: str, listener: Callable[[str], None] | None = None
) -> None:
    """Write the report, with its plot next to it; for the plot, the cases are solved on coarser meshes too.

    Parameters
    ----------
    path
        The .md file.
    rows
        The results.
    command
        The command that makes the report.
    listener
        Called with the name of each case before it is computed.
    """
    make_directory(path.parent)
    parts = ["# Benchmark problems", f"Made by `{command}`.", f"**{verdict(rows)}**", _READING, _table(rows)]
    coarser = _coarser(dict.fromkeys(row.case for row in rows), listener)
    if coarser:
        plot = path.with_name(f"{path.stem}-convergence.png")
        converging = {row.case for row in coarser}
        draw_convergence([*coarser, *(row for row in rows if row.case in converging)], plot)
        parts += ["## Convergence", _PLOT, f"![error against degrees of freedom]({plot.name})"]
    parts.append("## Sources, and reasons for the tolerances")
    parts += [_case(name, list(own)) for name, own in groupby(rows, key=lambda row: row.case)]
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def _coarser(names: Sequence[str] | dict[str, None], listener: Callable[[str], None] | None) -> list[Row]:
    rows: list[Row] = []
    for name in names:
        case = benchmark(name)
        if case.converges:
            if listener:
                listener(f"{name}, coarser")
            rows += [row for factor in COARSER for row in computed_rows(name, case, factor * case.size)]
    return rows


def _table(rows: Sequence[Row]) -> str:
    header = ("case", "quantity", "unit", "target", "computed", "error %", "limit %", "dofs", "seconds", "")
    lines = [header, ("---", "---", "---", *("---:",) * 6, "---"), *(_line(row) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _line(row: Row) -> tuple[str, ...]:
    numbers = (f"{row.goal.target:.6g}", f"{row.computed:.6g}", f"{row.error_percent:.2g}")
    cost = (f"{row.goal.tolerance_percent:.2g}", str(row.dofs), f"{row.seconds:.1f}")
    shown = tuple(text.replace("-", "−") for text in numbers)
    passed = "pass" if row.passed else "**FAIL**"
    return (row.case, row.goal.quantity, row.goal.unit, *shown, *cost, passed)


def _case(name: str, rows: Sequence[Row]) -> str:
    case = benchmark(name)
    lines = [f"### {name}", f"{case.title}. Target: {case.source}."]
    reasons = dict.fromkeys(row.goal.why for row in rows)
    for why in reasons:
        same = [row.goal for row in rows if row.goal.why == why]
        limits = "; ".join(f"{goal.quantity}: {goal.tolerance_percent:.2g} %" for goal in same)
        lines.append(f"- {limits} – {why}.")
    return "\n\n".join(lines[:2]) + "\n\n" + "\n".join(lines[2:])
