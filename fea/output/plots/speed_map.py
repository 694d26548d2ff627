"""The speed map: as CSV, and as a plot of safety factors against speed."""

import csv
import io
from pathlib import Path

import numpy as np

from fea.output.plots.forces import save
from fea.output.text import write_text
from fea.run.speed_map import MODES, SpeedMap, rounded

_COLOURS = {"yield": "C0", "fatigue": "C3", "crossland": "C2"}
_HIGHEST = 5.0  # upper end of the plot: larger factors are safe


def write_speed_map(path: Path, found: SpeedMap) -> None:
    """Write one row per speed; unknown values are blank.

    Raises
    ------
    StorageError
        The file could not be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(found.columns)
    for row in zip(*found.columns.values(), strict=True):
        writer.writerow(["" if np.isnan(value) else f"{value + 0.0:.7g}" for value in row])
    write_text(path, text.getvalue())


def plot_speed_map(path: Path, study: str, found: SpeedMap) -> None:
    """Draw the smallest safety factors against speed, with the speeds at which they fall below 1.

    Raises
    ------
    PictureError
        The file could not be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a plot needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(9, 5), layout="constrained")
    FigureCanvasAgg(figure)
    panel = figure.subplots()
    rpm = found.columns["rpm"]
    for mode, colour in _COLOURS.items():
        factor = found.columns[MODES[mode]]
        if np.isnan(factor).all():
            continue
        critical = found.critical.get(mode)
        label = mode if critical is None else f"{mode}: below 1 from {rounded(critical)} rpm"
        panel.plot(rpm, factor, color=colour, marker=".", label=label)
        if critical is not None:
            panel.axvline(critical, color=colour, lw=0.9, ls=":")
    panel.axhline(1, color="0.3", lw=1)
    panel.set_ylim(0, min(_HIGHEST, panel.get_ylim()[1]))
    panel.set_xlabel("engine speed, rpm")
    panel.set_ylabel("smallest safety factor of the cycle")
    panel.set_title(study, fontsize=11)
    panel.grid(alpha=0.3)
    panel.legend(frameon=False)
    save(figure, path, 110)
