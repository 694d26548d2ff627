"""Write small text files, and create directories for them."""

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import numpy.typing as npt

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
