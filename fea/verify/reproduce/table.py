"""Rows of one printed table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fea.verify.reproduce.printed import Cell
from fea.verify.reproduce.row import Row, Slip


@dataclass(frozen=True)
class Table:
    """A printed table compared cell by cell.

    Attributes
    ----------
    source, name, title
        The study, the number of the table in the study, and its content.
    rows
        Its figures.
    remarks
        What is wrong with it, in sentences; may be empty.
    """

    source: str
    name: str
    title: str
    rows: tuple[Row, ...]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Column:
    """Printed cells of one quantity and what they should be.

    Attributes
    ----------
    quantity, unit
        The quantity in the cells.
    cells
        The cells as printed.
    as_published, corrected
        (n_cells,) figures.
    cause
        Why these two differ.
    speed
        Text before the crank angle, such as ``6000 rpm``; may be empty.
    slips
        By the key of the cell: the error in that cell.
    """

    quantity: str
    unit: str
    cells: Sequence[Cell]
    as_published: npt.ArrayLike
    corrected: npt.ArrayLike
    cause: str = ""
    speed: str = ""
    slips: Mapping[str, Slip] = field(default_factory=dict)


def table(
    source: str, name: str, title: str, columns: Sequence[Column], remarks: Sequence[str] = ()
) -> Table:
    """Compare columns cell by cell."""
    rows = tuple(row for column in columns for row in _rows(source, name, column))
    return Table(source, name, title, rows, tuple(remarks))


def _rows(source: str, name: str, column: Column) -> list[Row]:
    as_published = np.broadcast_to(np.asarray(column.as_published, dtype=np.float64), len(column.cells))
    corrected = np.broadcast_to(np.asarray(column.corrected, dtype=np.float64), len(column.cells))
    return [
        Row(
            source=source,
            table=name,
            quantity=column.quantity,
            at=", ".join(filter(None, [column.speed, f"{cell.key}°"])),
            unit=column.unit,
            published=cell.value,
            digit=cell.digit,
            as_published=float(a),
            corrected=float(c),
            formula_cause=column.cause,
            slip=column.slips.get(cell.key),
        )
        for cell, a, c in zip(column.cells, as_published, corrected, strict=True)
    ]
