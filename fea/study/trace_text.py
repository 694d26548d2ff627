"""The text of a file with measurements, whatever encoding it was exported in."""

import codecs
import re
from pathlib import Path

from fea.study.paths import require_size
from geometry.invalid import InvalidValue, require

LARGEST_TRACE = 2**24  # bytes: a hundred cycles in steps of a tenth of a degree
_WIDE = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
# Characters below a space, except tab, line feed, form feed and carriage return.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f]")


def read_text(path: Path, remedy: str) -> str:
    """Read a text file in UTF-8, UTF-16 with a byte-order mark, or Latin-1.

    Parameters
    ----------
    path
        The file.
    remedy
        What the file should contain, for messages.

    Raises
    ------
    InvalidValue
        The file cannot be read, is too large, or is not text.
    """
    try:
        require_size("engine.gas", path, LARGEST_TRACE)
        raw = path.read_bytes()
    except OSError as error:
        raise InvalidValue("engine.gas", str(path), f"cannot be read ({error.strerror})", remedy) from error
    text = _decoded(raw)
    is_text = text is not None and _CONTROL.search(text) is None
    require(is_text, "engine.gas", str(path), "cannot be read (it is not a text file)", remedy)
    return text or ""


def _decoded(raw: bytes) -> str | None:
    """Return the text, None where no encoding fits."""
    wide = _WIDE.get(raw[:2])
    try:
        if wide is not None:
            return raw.decode(wide)
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Latin-1 gives every byte a meaning: a degree sign of an older export is right, binary data is
        # refused for its control characters.
        return None if wide is not None else raw.decode("latin-1")
