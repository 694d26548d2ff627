"""Save a figure of matplotlib."""

from pathlib import Path
from typing import Any

from fea.output.errors import PictureError


def save(figure: Any, path: Path, dpi: int) -> None:
    """Write a figure.

    Raises
    ------
    PictureError
        The file could not be written.
    """
    try:
        figure.savefig(path, dpi=dpi)
    except OSError as error:
        reason = error.strerror or str(error)
        raise PictureError(f"{path} could not be written: {reason}. Choose another directory.") from error
