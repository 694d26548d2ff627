"""The printed tables: package data, read as text, because the number of printed digits matters."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Cell:
    """A printed figure.

    Attributes
    ----------
    key
        The first column of its row as printed, usually the crank angle in degrees.
    text
        The figure as printed.
    digit
        One unit of its last digit; a single 0 gets the finest digit of its column.
    """

    key: str
    text: str
    digit: float

    @property
    def value(self) -> float:
        """The figure as a number."""
        return float(self.text)


def records(name: str) -> list[dict[str, str]]:
    """Rows of a published table as printed, by the name of the file without its ending."""
    text = (files("fea") / "verify" / "published" / f"{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def column(name: str, title: str) -> list[Cell]:
    """Return the printed cells of one column, without the blank ones."""
    rows = records(name)
    key = next(iter(rows[0]))
    texts = [(row[key], row[title]) for row in rows if row[title]]
    finest = max(decimals(text) for _, text in texts)
    return [Cell(k, text, 10.0 ** -(decimals(text) if float(text) else finest)) for k, text in texts]


def degrees(cells: Sequence[Cell]) -> npt.NDArray[np.float64]:
    """Crank angles of printed cells, degrees."""
    return np.array([float(cell.key) for cell in cells])


def values(cells: Sequence[Cell]) -> npt.NDArray[np.float64]:
    """Printed figures as numbers."""
    return np.array([cell.value for cell in cells])


def decimals(text: str) -> int:
    """Count the printed decimal places."""
    return len(text.partition(".")[2])
