"""Extreme cases as a Markdown report with plots."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from fea.output.stability_table import HEADER, cells, counts
from fea.output.text import make_directory, write_text
from fea.verify.stability.row import ExtremeRow, Verdict

_READING = """\
*Right*: within its tolerance of the exact answer. *Marked*: a check of `fea run` fails there, so that the
result is written with `trusted: false` and the exit code is 5, right or not. *Refused*: an error instead of
an answer. *Wrong*: off, and nothing says so; there must be none.

*Backward error* is ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖) in maximum norms: it stays at rounding whatever the case, and
alone proves nothing. *Condition* is that of the stiffness after Jacobi scaling, by power steps. *Energy
error* is |uᵀKu − uᵀf| / uᵀf: it grows with the condition, and is what notices a solution that has lost
digits. *Error* is that of the result against the exact one.

Displacement elements do not hold nearly incompressible materials: those of first order lock, and the mean
stress of both oscillates. Beyond ν = 0.4 a run with those of second order gives each such part a pressure of
its own (p2/p1, Taylor and Hood's pair), whose errors do not depend on ν; the rows of p2 beyond it show what
that spares one. A run with p1 is marked beyond it.
"""
_COLOR = {
    Verdict.RIGHT: "tab:green",
    Verdict.MARKED: "tab:orange",
    Verdict.REFUSED: "tab:gray",
    Verdict.WRONG: "red",
}


def write_report(path: Path, rows: Sequence[ExtremeRow], command: str) -> None:
    """Write the report, and its plot beside it.

    Parameters
    ----------
    path
        The .md file.
    rows
        What was computed.
    command
        The command that makes the report.

    Raises
    ------
    StorageError
        The system refused.
    """
    make_directory(path.parent)
    plot = path.with_suffix(".png")
    draw(rows, plot)
    parts = [
        "# Stiff and extreme cases",
        f"Made by `{command}`.",
        f"**{counts(rows)}**",
        _READING,
        f"![error against the extreme parameter]({plot.name})",
        _table(rows),
    ]
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def _table(rows: Sequence[ExtremeRow]) -> str:
    lines = [HEADER, ("---", *("---:",) * (len(HEADER) - 2), "---"), *map(cells, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def draw(rows: Sequence[ExtremeRow], path: Path) -> None:
    """Draw the error of the result and of the energy over each case's parameter."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a report needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    cases = {name: list(own) for name, own in groupby(rows, key=lambda row: row.case)}
    columns = 3
    lines = -(-len(cases) // columns)
    figure = Figure(figsize=(4 * columns, 2.7 * lines), layout="constrained")
    FigureCanvasAgg(figure)
    for place, (name, own) in enumerate(cases.items(), 1):
        axes = figure.add_subplot(lines, columns, place)
        _draw_case(axes, name, own)
    figure.savefig(path, dpi=80)


def _draw_case(axes: Any, name: str, rows: Sequence[ExtremeRow]) -> None:
    places = range(len(rows))
    errors = [max(row.result_error_percent or 0.0, 1e-16) for row in rows]
    axes.semilogy(places, errors, "-", color="0.7", zorder=1)
    axes.scatter(places, errors, c=[_COLOR[row.verdict] for row in rows], zorder=2, label="result, %")
    if rows[0].energy_error is not None:
        energies = [100 * max(row.energy_error or 0.0, 1e-18) for row in rows]
        axes.semilogy(places, energies, ":", color="tab:blue", label="energy, %")
        axes.legend(fontsize=7)
    axes.set_title(name, fontsize=9)
    axes.set_xlabel(rows[0].parameter, fontsize=8)
    axes.set_xticks(list(places), [f"{row.value:g}" for row in rows], fontsize=7)
    axes.tick_params(axis="y", labelsize=7)
