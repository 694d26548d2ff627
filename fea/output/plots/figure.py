"""An empty figure of matplotlib, which is loaded with it, and its file."""

from pathlib import Path
from typing import TYPE_CHECKING

from fea.output.target import PictureError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure, inches."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - only a plot needs it

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: "Figure", path: Path, dpi: int = 110) -> None:
    """Write a figure.

    Raises
    ------
    PictureError
        The system refuses, or matplotlib cannot write the suffix.
    """
    try:
        figure.savefig(path, dpi=dpi)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise PictureError(f"{path} could not be written: {reason}. Choose another file.") from error
