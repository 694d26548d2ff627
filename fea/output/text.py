"""Write small text files, and create directories for them."""

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fea.base.note import Note
from fea.machine.system import replaced
from fea.output.target import reported
from geometry.arrays import Floats


@contextmanager
def stored(path: Path) -> Iterator[Path]:
    """Yield a place to write a file, as `replaced` does; raises `StorageError`, which says what to do."""
    with reported(path, "Choose another path, or free disk space."), replaced(path) as place:
        yield place


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text with unchanged newlines, completely or not at all; raises `StorageError`."""
    with stored(path) as place:
        place.write_text(text, encoding="utf-8", newline="\n")


def make_directory(path: Path) -> None:
    """Create a directory and its missing parents; raises `StorageError` if the system refuses."""
    with reported(path, "Choose another path.", verb="created"):
        path.mkdir(parents=True, exist_ok=True)


_WHOLE = 9.95  # percent: error bars from here on have no decimals


def error_bar(percent: float) -> str:
    """Return an error bar as text with two digits."""
    return f"{percent:.{0 if percent >= _WHOLE else 1}f}"


_AT_SPEED = " at\0rpm"  # stands for the speed in a note
_FEW = 4  # with more speeds, their number and range is said


def gathered(notes: Iterable[tuple[float, Iterable[Note]]]) -> list[Note]:
    """Return the notes of several speeds, rpm; those that differ only in the speed are merged."""
    speeds: dict[Note, list[str]] = {}
    for rpm, said in notes:
        for note in said:
            general = replace(note, text=note.text.replace(f" at {rpm:g} rpm", _AT_SPEED))
            speeds.setdefault(general, []).append(f"{rpm:g}")
    return [
        replace(note, text=note.text.replace(_AT_SPEED, f" at {some_speeds(rpm)}"))
        for note, rpm in speeds.items()
    ]


def some_speeds(rpm: Sequence[str]) -> str:
    """Return a few speeds, or how many there are and their range."""
    if len(rpm) <= _FEW:
        return f"{', '.join(rpm)} rpm"
    rising = sorted(rpm, key=float)
    return f"{len(rpm)} speeds from {rising[0]} to {rising[-1]} rpm"


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV; what is None stays blank."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def write_columns(path: Path, columns: Mapping[str, npt.ArrayLike]) -> None:
    """Write columns (n,), or numbers for all rows, by name. `ValueError`: lengths differ; `StorageError`."""
    every = np.broadcast_arrays(*(np.atleast_1d(np.asarray(column, float)) for column in columns.values()))
    values = np.stack(every, axis=1) + 0.0  # without negative zeros; what does not apply, NaN, is blank
    row = ",".join(["%.7g"] * values.shape[1]) + "\n"
    rows = (row * len(values) % tuple(values.ravel().tolist())).replace("nan", "")
    write_text(path, ",".join(columns) + "\n" + rows)


def read_columns(path: Path) -> dict[str, Floats]:
    """Read columns (n,) by their names, NaN for none. Raises `OSError`; `ValueError`: not such a table."""
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    values = [[float(cell) if cell else math.nan for cell in row.split(",")] for row in rows]
    return dict(zip(names, np.array(values).reshape(-1, len(names)).T, strict=True))
