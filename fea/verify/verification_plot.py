"""Plot how the errors of the benchmark problems decrease with the number of degrees of freedom."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from fea.verify.benchmark import Row

_DISPLACEMENTS = ("mm", "rad")  # units; everything else is stress


def draw_convergence(rows: Sequence[Row], path: Path) -> None:
    """Plot error against degrees of freedom, separately for stresses and displacements.

    Parameters
    ----------
    rows
        Rows of each quantity for several element sizes.
    path
        The .png file.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a report draws
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(11, 6), layout="constrained")
    FigureCanvasAgg(figure)
    moved = [row for row in rows if row.goal.unit in _DISPLACEMENTS]
    strained = [row for row in rows if row not in moved]
    panels = [panel for panel in (("stress", strained, 2), ("displacement", moved, 3)) if panel[1]]
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _panel(axes, *panel)
    figure.savefig(path, dpi=100)


def _panel(axes: Any, title: str, rows: Sequence[Row], order: int) -> None:
    by_quantity = sorted(rows, key=lambda row: (row.case, row.goal.quantity, row.dofs))
    for number, ((case, quantity), same) in enumerate(
        groupby(by_quantity, key=lambda row: (row.case, row.goal.quantity))
    ):
        curve = list(same)
        errors = [max(abs(row.error_percent), 1e-7) for row in curve]
        label = f"{case}: {quantity}"
        axes.loglog(
            [row.dofs for row in curve], errors, marker="osv^D"[number % 5], markersize=4, label=label
        )
    dofs = np.array([min(row.dofs for row in rows), max(row.dofs for row in rows)], dtype=float)
    slope = 3 * (dofs / dofs[0]) ** (-order / 3)
    axes.loglog(dofs, slope, color="0.5", linestyle=":", label=f"order {order} in element length")
    axes.set(title=f"{title}, error against the target", xlabel="degrees of freedom", ylabel="error, %")
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=7, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.12))
