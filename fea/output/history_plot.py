"""Stress against crank angle at the worst places of a rod."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.output.errors import PictureError
from fea.units import DEG

Floats = npt.NDArray[np.float64]


def plot_histories(
    path: Path,
    title: str,
    angles: Floats,
    histories: Sequence[tuple[Sequence[float], Floats]],
    marks: Mapping[str, float],
) -> None:
    """Draw one curve a place.

    Parameters
    ----------
    path
        The file to write.
    title
        Above the plot.
    angles
        (n,) crank angles, rad.
    histories
        Place (x, y, z), mm, and signed von Mises stress (n,), MPa.
    marks
        Crank angles to be marked, rad, by the name of their case.

    Raises
    ------
    PictureError
        The file could not be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a plot needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(10, 5.5))
    FigureCanvasAgg(figure)
    panel = figure.add_axes((0.08, 0.1, 0.9, 0.83))
    for place, signed in histories:
        x, y, z = (coordinate + 0.0 for coordinate in np.round(place, 1))
        panel.plot(angles / DEG, signed, lw=1.5, label=f"({x:g}, {y:g}, {z:g}) mm")
    panel.axhline(0, color="0.5", lw=0.8)
    _mark(panel, marks)
    panel.set_xlim(0, 720)
    panel.set_xticks(range(0, 721, 90))
    panel.grid(alpha=0.3)
    panel.set_xlabel("crank angle, ° (firing TDC at 360°)")
    panel.set_ylabel("signed von Mises stress, MPa")
    panel.set_title(title, fontsize=11)
    panel.legend(frameon=False, fontsize=9, title="hottest places", ncols=2)
    try:
        figure.savefig(path, dpi=110)
    except OSError as error:
        reason = error.strerror or str(error)
        raise PictureError(f"{path} could not be written: {reason}.") from error


def _mark(panel: Any, marks: Mapping[str, float]) -> None:
    """Mark the peak cases; names that would overlap stand one below the other."""
    last, level = -np.inf, 0
    for name, angle in sorted(marks.items(), key=lambda item: item[1]):
        degrees = angle / DEG
        level = (level + 1) % 4 if degrees - last < 90 else 0
        last = degrees
        panel.axvline(degrees, color="0.4", lw=0.9, ls=":")
        panel.text(
            degrees + 3,
            0.02 + 0.045 * level,
            name,
            transform=panel.get_xaxis_transform(),
            fontsize=8,
            color="0.3",
        )
