"""The extreme cases as a Markdown report with plots."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from fea.output.text import make_directory, write_text
from fea.verify.stability.row import ExtremeRow, Verdict
from fea.verify.stability.terminal import HEADER, cells, counts

_READING = """\
*Right*: the result is within its tolerance of the exact answer. *Marked*: `fea run` reports a problem,
whether or not the result is right: either a check fails, so that the result is written with `trusted: false`
and the exit code is 5, or the peak is called *not converged*, with its error bar. The last column tells
which. *Refused*: an error message instead of a result. *Wrong*: the result is wrong and nothing reports it;
this must never happen. For a peak that is *not converged*, the error bar may be smaller than the error, as in
the thinnest rings.

*Backward error* is ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖) in maximum norms: it stays at the level of rounding in every
case, so that it proves nothing on its own. *Condition* is the condition number of the stiffness after Jacobi
scaling, estimated with a probe that is solved together with the loads; above 4.5·10¹² rounding may change the
displacement by a thousandth, and every run checks this. *Energy error* is |uᵀKu − uᵀf| / uᵀf: it grows with
the condition number and detects a solution that has lost digits. *Error* is the error of the result relative
to the exact answer.

Displacement elements are not suitable for nearly incompressible materials: first-order elements lock, and the
mean stress of both orders oscillates. Above ν = 0.4 a run with second-order elements therefore uses a
separate pressure field in such parts (p2/p1, Taylor–Hood elements), whose errors do not depend on ν; the rows
of p2 above 0.4 show the errors that this avoids. A run with p1 is marked above ν = 0.4.
"""
_COLOR = {
    Verdict.RIGHT: "tab:green",
    Verdict.MARKED: "tab:orange",
    Verdict.REFUSED: "tab:gray",
    Verdict.WRONG: "red",
}
_NOTICED = "#fdebd0"
# Number of values from which labels must be rotated to fit side by side.
_MANY = 8
# Replaces zero on a logarithmic axis.
_LEAST = 1e-18


def write_report(path: Path, rows: Sequence[ExtremeRow], command: str) -> None:
    """Write the report, with its plot next to it.

    Parameters
    ----------
    path
        The .md file.
    rows
        The results.
    command
        The command that makes the report.

    Raises
    ------
    StorageError
        The files cannot be written.
    """
    make_directory(path.parent)
    plot = path.with_suffix(".png")
    draw(rows, plot)
    parts = [
        "# Ill-conditioned and extreme cases",
        f"Made by `{command}`.",
        f"**{counts(rows)}**",
        _READING,
        f"![error against the extreme parameter]({plot.name})",
        _table(rows),
    ]
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def _table(rows: Sequence[ExtremeRow]) -> str:
    header = (*HEADER, "noticed by")
    lines = [header, ("---", *("---:",) * (len(header) - 3), "---", "---")]
    lines += [(*cells(row, digits=1), ", ".join(row.noticed_by)) for row in rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def draw(rows: Sequence[ExtremeRow], path: Path) -> None:
    """Draw the error of the result and of the energy over each case's parameter."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a report needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    cases = {name: list(own) for name, own in groupby(rows, key=lambda row: row.case)}
    columns = 4
    lines = -(-len(cases) // columns)
    figure = Figure(figsize=(3.4 * columns, 2.6 * lines + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    for place, (name, own) in enumerate(cases.items(), 1):
        axes = figure.add_subplot(lines, columns, place)
        _draw_case(axes, name, own)
    figure.legend(handles=_key(), loc="outside upper center", ncols=7, fontsize=8)
    figure.savefig(path, dpi=80)


def _key() -> list[Any]:
    from matplotlib.lines import Line2D  # noqa: PLC0415
    from matplotlib.patches import Patch  # noqa: PLC0415

    dots = [
        Line2D([], [], marker="o", ls="", color=color, label=f"{name.value}: error, %")
        for name, color in _COLOR.items()
    ]
    return [
        *dots,
        Line2D([], [], ls=":", color="tab:blue", label="energy error, %"),
        Line2D([], [], ls="--", color="0.4", label="tolerance"),
        Patch(color=_NOTICED, label="reported by fea run"),
    ]


def _draw_case(axes: Any, name: str, rows: Sequence[ExtremeRow]) -> None:
    places = list(range(len(rows)))
    _shade(axes, rows)
    shown = [
        (place, row) for place, row in zip(places, rows, strict=True) if row.result_error_percent is not None
    ]
    errors = [max(row.result_error_percent or 0.0, _LEAST) for _, row in shown]
    axes.semilogy([place for place, _ in shown], errors, "-", color="0.7", zorder=1)
    axes.scatter([place for place, _ in shown], errors, c=[_COLOR[row.verdict] for _, row in shown], zorder=2)
    if any(row.energy_error is not None for row in rows):
        energies = [100 * max(row.energy_error or 0.0, _LEAST) for _, row in shown]
        axes.semilogy([place for place, _ in shown], energies, ":", color="tab:blue")
    if rows[0].tolerance_percent is not None:
        axes.axhline(rows[0].tolerance_percent, ls="--", color="0.4", lw=1)
    axes.set_title(name, fontsize=9)
    axes.set_xlabel(rows[0].parameter, fontsize=8)
    turned = {"rotation": 35, "ha": "right", "rotation_mode": "anchor"} if len(rows) >= _MANY else {}
    axes.set_xticks(places, [f"{row.value:g}" for row in rows], fontsize=7, **turned)
    axes.set_xlim(-0.5, len(rows) - 0.5)
    axes.tick_params(axis="y", labelsize=7)


def _shade(axes: Any, rows: Sequence[ExtremeRow]) -> None:
    """Shade the cases in which a run would mark its result as not to be trusted, or refuse."""
    for place, row in enumerate(rows):
        if row.verdict in (Verdict.MARKED, Verdict.REFUSED):
            axes.axvspan(place - 0.5, place + 0.5, color=_NOTICED, zorder=0)
