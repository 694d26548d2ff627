"""Published figures as printed, as recomputed, and why they differ.

*As published* is the printed formula, including the error made in evaluating it, applied to the printed
intermediate figures; *corrected* comes from the mechanics of this project. A printed figure must agree with
the former to one unit of its last digit, or have an explanation. The printed tables are package data, read as
text because the number of printed digits matters.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fea.base.shipped import shipped_text
from fea.base.units import DEG
from geometry.arrays import Floats


class Cell(NamedTuple):
    """A printed figure: the first column of its row (mostly the crank angle), its text, its last digit."""

    key: str
    text: str
    digit: float


class Column(tuple[Cell, ...]):
    """The printed cells of one column, without the blank ones."""

    __slots__ = ()

    @classmethod
    def at(cls, degrees: Floats) -> "Column":
        """Return cells with nothing in them at crank angles."""
        return cls(Cell(str(angle), "", 1.0) for angle in degrees.tolist())

    @property
    def degrees(self) -> Floats:
        """Crank angles."""
        return np.array([float(cell.key) for cell in self])

    @property
    def theta(self) -> Floats:
        """Crank angles, rad."""
        return self.degrees * DEG

    @property
    def values(self) -> Floats:
        """The printed figures as numbers."""
        return np.array([float(cell.text) for cell in self])


def records(name: str) -> list[dict[str, str]]:
    """Rows of a published table as printed, by the name of the file without its ending."""
    return list(csv.DictReader(shipped_text(f"verify/published/{name}.csv").splitlines()))


def column(
    name: str, title: str, key: str | None = None, content: Mapping[str, str] = MappingProxyType({})
) -> Column:
    """Return a column of a published table; a single 0 gets the finest digit of its column.

    `key`: the column that names the cells, by default the first; `content`: of other columns of the rows.
    """
    rows = [row for row in records(name) if all(row[of] == text for of, text in content.items())]
    key = next(iter(rows[0])) if key is None else key
    texts = [(row[key], row[title]) for row in rows if row[title]]
    finest = max(decimals(text) for _, text in texts)
    return Column(Cell(k, text, 10.0 ** -(decimals(text) if float(text) else finest)) for k, text in texts)


def decimals(text: str) -> int:
    """Count the printed decimal places."""
    return len(text.partition(".")[2])


class Status(StrEnum):
    """How a printed figure compares with the printed formula."""

    AGREES = "agrees"  # to one unit of the last printed digit
    EXPLAINED = "explained"  # it differs, and the given slip reproduces it
    NAMED = "named"  # it differs and is known to be wrong, but cannot be derived from the source
    UNEXPLAINED = "unexplained"
    NOT_PRINTED = "not printed"  # a computed figure without a printed one


@dataclass(frozen=True)
class Slip:
    """The error in one printed figure, in words, and the figure that results from it if that is known.

    With `is_rounding` an intermediate figure was only rounded.
    """

    text: str
    value: float | None = None
    is_rounding: bool = False


def wrong_digit(printed: str, true: float) -> Slip:
    """Explain a figure with one wrong digit where the formula gives `true`; more are not explained."""
    places = decimals(printed)
    # Some tables are truncated and some are rounded, so try both.
    for right in (f"{true:.{places}f}", f"{true:.{places + 4}f}"[:-4]):
        wrong = [i for i, (p, r) in enumerate(zip(printed, right, strict=False)) if p != r]
        if len(printed) == len(right) and len(wrong) == 1:
            i = wrong[0]
            text = f"misprint: {printed} instead of {right} ({printed[i]} instead of {right[i]})"
            return Slip(text, float(printed))
    return Slip(f"{printed} is not {true:.{places}f} with one wrong digit", true)


@dataclass(frozen=True)
class PrintedFigure:
    """A printed figure, the result of the printed formula, and the correct figure."""

    source: str
    table: str
    quantity: str
    at: str  #: crank angle and speed
    unit: str
    #: published, digit: the figure as printed, or None, and one unit of its last digit
    published: float | None
    digit: float
    as_published: float  #: from the printed formula and intermediate figures, including its systematic error
    corrected: float  #: from correct mechanics
    formula_cause: str = ""  #: why `as_published` and `corrected` differ
    slip: Slip | None = None  #: why `published` and `as_published` differ in this one cell

    @property
    def difference(self) -> float:
        """|published − as published|, zero if nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.as_published)

    @property
    def error(self) -> float:
        """|published − corrected|, zero if nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.corrected)

    @property
    def is_wrong(self) -> bool:
        """Whether the printed figure differs from the correct one."""
        return self.published is not None and not self._within(self.corrected)

    @property
    def status(self) -> Status:
        """How the printed figure compares."""
        if self.published is None:
            return Status.NOT_PRINTED
        if self._within(self.as_published):
            return Status.AGREES
        if self.slip is None:
            return Status.UNEXPLAINED
        if self.slip.value is None:
            return Status.NAMED
        return Status.EXPLAINED if self._within(self.slip.value) else Status.UNEXPLAINED

    @property
    def cause(self) -> str:
        """All reasons why the three figures differ; empty if they do not."""
        wrong = self.published is None or self.is_wrong
        slipped = [self.slip.text] if self.slip is not None and self.status is not Status.AGREES else []
        return "; ".join(slipped + [self.formula_cause] * (wrong and bool(self.formula_cause)))

    def as_dict(self) -> dict[str, object]:
        """Return the figure with the names that other programs rely on."""
        named = ("source", "table", "quantity", "at", "unit", "published", "as_published", "corrected")
        return {name: getattr(self, name) for name in (*named, "cause", "status")}

    def _within(self, value: float) -> bool:
        # One unit of the last digit, plus rounding, which matters for figures printed with ten digits.
        assert self.published is not None  # noqa: S101
        return abs(self.published - value) <= self.digit * (1 + 1e-6) + 4 * math.ulp(self.published)


@dataclass(frozen=True)
class Table:
    """A printed table compared cell by cell: its study, number and content, and in words what is wrong."""

    source: str
    name: str
    title: str
    figures: tuple[PrintedFigure, ...]
    remarks: tuple[str, ...] = ()

    @property
    def wrong_of_each_quantity(self) -> list[PrintedFigure]:
        """For each quantity (and speed), the figure with the largest error, if any."""
        worst: dict[tuple[str, str], PrintedFigure] = {}
        for figure in self.figures:
            key = figure.quantity, figure.at.partition(", ")[0] if "rpm" in figure.at else ""
            if figure.is_wrong and (key not in worst or figure.error > worst[key].error):
                worst[key] = figure
        return list(worst.values())

    @property
    def worst(self) -> PrintedFigure | None:
        """Figure with the largest error relative to the scale of its quantity; None if none differs."""

        def relative(figure: PrintedFigure) -> float:
            scale = max(abs(o.corrected) for o in self.figures if o.quantity == figure.quantity)
            return figure.error / scale if scale > 0 else figure.error

        return max(self.wrong_of_each_quantity, key=relative, default=None)


class Summary(NamedTuple):
    """Numbers of printed figures: all, by `Status`, and those that differ from the correct ones."""

    compared: int
    agrees: int
    explained: int
    named: int
    unexplained: int
    wrong: int

    def __str__(self) -> str:
        return (
            f"{self.compared} printed figures were compared: {self.agrees} agree with the printed formula, "
            f"{self.explained} are explained by an error in the cell, {self.named} are known to be wrong "
            f"without a traceable cause, {self.unexplained} are unexplained; {self.wrong} differ from the "
            "correct figures."
        )


def summarise(tables: Iterable[Table]) -> Summary:
    """Count the printed figures of some tables."""
    figures = [f for table in tables for f in table.figures if f.status is not Status.NOT_PRINTED]
    counts = Counter(figure.status for figure in figures)
    by_status = {status.value: counts[status] for status in Status if status is not Status.NOT_PRINTED}
    return Summary(compared=len(figures), wrong=sum(figure.is_wrong for figure in figures), **by_status)


def misprinted(tables: Sequence[Table]) -> list[PrintedFigure]:
    """Figures that are wrong on their own, rather than by the formula."""
    bad = (Status.EXPLAINED, Status.NAMED, Status.UNEXPLAINED)
    return [figure for table in tables for figure in table.figures if figure.status in bad]
