"""What the report of a sweep shows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from geometry.arrays import Floats, Ints


@dataclass(frozen=True, kw_only=True)
class Influenced:
    """What a figure depends on: a row for each key, as the table shows it.

    Attributes
    ----------
    figure
        Its name.
    columns
        Titles of the columns beside the key.
    rows
        Key and values, as text.
    bars
        Length of the bar of each key, 0 to 1.
    note
        What must be known beside it.
    """

    figure: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[str, ...]], ...]
    bars: tuple[float, ...]
    note: str


@dataclass(frozen=True, kw_only=True)
class Swept:
    """A sweep, a design each.

    Attributes
    ----------
    title
        Its name.
    counts
        What became of the rows, in words.
    keys
        (n,) values of the varied keys that are numbers, by key.
    figures
        (n,) values of mass and factors by name, NaN where there is none.
    rows
        (n,) number of the row of the table that a design is shown by.
    studies
        (n,) study files.
    front
        Numbers of the designs of which none is both lighter and stronger.
    probabilities
        Rows of a table: factor, share below 1, interval, rods, rods without a result.
    influences
        What matters, by figure.
    failures
        Rows, reasons and how many there are.
    """

    title: str
    counts: str
    keys: Mapping[str, Floats]
    figures: Mapping[str, Floats]
    rows: Sequence[int]
    studies: Sequence[str]
    front: Ints
    probabilities: Sequence[tuple[str, ...]] = ()
    influences: Sequence[Influenced] = ()
    failures: Sequence[tuple[int, str, Any]] = field(default_factory=tuple)
