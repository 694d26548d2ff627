"""Plot error against run time, both on logarithmic scales."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from fea.verify.converge.converge import PROBLEMS, QUANTITY, Comparison
from fea.verify.converge.front import FLOOR, pareto
from fea.verify.converge.row import Row

_COLOURS = {
    "fea": "tab:blue",
    "fea, mean": "tab:orange",
    "fea, whole": "tab:green",
    "fea --tolerance": "tab:red",
    "CalculiX": "0.45",
}
_COARSE = "tab:purple"  # a tolerance reached from a coarse mesh, whose name contains the size


def draw(comparison: Comparison, path: Path) -> None:
    """Draw one panel per problem; the Pareto front is shaded."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a report draws
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(13, 5), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, problem in zip(figure.subplots(1, len(PROBLEMS)), PROBLEMS, strict=True):
        rows = [row for row in comparison.rows if row.computation.problem == problem]
        floor = max(FLOOR, comparison.references[problem].uncertainty_percent)
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


def _points(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    return [row.measured.seconds for row in rows], [max(abs(row.error_percent), FLOOR / 2) for row in rows]
