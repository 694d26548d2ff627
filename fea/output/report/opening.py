"""Open a report in the browser of this machine."""

import webbrowser
from pathlib import Path

from fea.output.errors import PictureError
from geometry.invalid import require

_MARK = '<meta name="generator" content="conrod-fea">'
_HEAD = 4096  # characters within which the mark stands


def open_report(file: Path) -> None:
    """Open a report.

    Raises
    ------
    InvalidValue
        There is no such file, or it is no report of this program.
    PictureError
        There is no browser.
    """
    require(file.is_file(), "FILE", str(file), "is not a file", "Name a report.html that fea wrote.")
    with file.open(encoding="utf-8", errors="replace") as text:
        ours = _MARK in text.read(_HEAD)
    require(ours, "FILE", str(file), "is not a report of fea", "Name a report.html that fea wrote.")
    if not webbrowser.open(file.resolve().as_uri()):
        raise PictureError(
            f"No browser was found to open {file}: open it by hand, or copy it to a machine with one."
        )
