"""Columns over the crank cycle as CSV, and back."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fea.output.text import write_text
from geometry.arrays import Floats


def write_columns(path: Path, columns: Mapping[str, npt.ArrayLike]) -> None:
    """Write columns over the cycle by name, (n,) or one number for all rows; units as the names say.

    Raises `ValueError`: the lengths differ; `StorageError`: the file could not be written.
    """
    values = np.broadcast_arrays(*(np.atleast_1d(np.asarray(column, float)) for column in columns.values()))
    write_text(path, ",".join(columns) + "\n" + _rows(np.stack(values, axis=1)))


def read_columns(path: Path) -> dict[str, Floats]:
    """Read columns (n,) by their names; what does not apply is NaN.

    Raises `OSError`, `ValueError`: there is no such file, or it is not such a table.
    """
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    values = [[float(cell) if cell else math.nan for cell in row.split(",")] for row in rows]
    return dict(zip(names, np.array(values).reshape(-1, len(names)).T, strict=True))


def _rows(values: Floats) -> str:
    """Rows with seven digits, without negative zeros; values that do not apply (NaN) are blank."""
    row = ",".join(["%.7g"] * values.shape[1]) + "\n"
    return (row * len(values) % tuple((values + 0.0).ravel().tolist())).replace("nan", "")
