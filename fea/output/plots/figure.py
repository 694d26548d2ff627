"""An empty figure of matplotlib, which is loaded with it, and its file."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fea.output.folder import PictureError
from fea.output.pictures.scale import round_up
from fea.output.units import in_heading, scale_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_STEPS = 5  # of an axis in other units


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure, inches."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - only a plot needs it

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: "Figure", path: Path, dpi: int = 110) -> None:
    """Write a figure; raises `PictureError`: the system refuses, or matplotlib cannot write the suffix."""
    try:
        figure.savefig(path, dpi=dpi)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise PictureError(f"{path} could not be written: {reason}. Choose another file.") from error


def label_axes(axes: Any, across: str, up: str) -> None:
    """Label axes, whose values are in the units of these headings, with ticks in the units that are shown."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator  # noqa: PLC0415 - only a plot needs it

    axes.set(xlabel=in_heading(across), ylabel=in_heading(up))
    for axis, factor in ((axes.xaxis, scale_of(across)), (axes.yaxis, scale_of(up))):
        if factor != 1:
            low, high = axis.get_view_interval()
            axis.set_major_locator(MultipleLocator(round_up(factor * (high - low) / _STEPS) / factor))
            axis.set_major_formatter(FuncFormatter(lambda at, _, factor=factor: f"{factor * at:.4g}"))


# Decades of a logarithmic axis that leave room for ticks at 2 and 5 too, and for plain numbers.
_FEW, _SOME = 2.0, 4.0


def log_ticks(axes: Any) -> None:
    """Label decades of both logarithmic axes, and 2 and 5 where there are few, so that no labels overlap."""
    from matplotlib import ticker  # noqa: PLC0415 - only a plot needs it

    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        decades = math.log10(high / low)
        plain = ticker.FuncFormatter(lambda at, _: f"{at:g}")
        axis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0) if decades <= _FEW else (1.0,)))
        axis.set_major_formatter(plain if decades <= _SOME else ticker.LogFormatterMathtext())
        axis.set_minor_formatter(ticker.NullFormatter())


def crank_angle(last: int) -> str:
    """Return the name of the axis of crank angles in a cycle that ends at the last one, degrees."""
    return f"crank angle, ° (firing TDC at {'360' if last > 360 else '0'}°)"
