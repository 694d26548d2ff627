"""Published tables: figures as printed, as recomputed, and why they differ.

*As published* is the printed formula, including the error made in evaluating it, applied to the printed
intermediate figures; *corrected* comes from the mechanics of this project. A printed figure must agree with
the former to one unit of its last digit, or have an explanation.

Package data describes each study: ``published/SOURCE.toml`` lists its tables, with an expression for every
figure, and CSV files hold the printed cells as text, because the number of printed digits matters.
"""

import ast
import csv
import math
from collections import ChainMap, Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from itertools import groupby
from string import Formatter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from fea.base import units
from fea.base.shipped import TomlTable, shipped_text, shipped_toml
from fea.output.json_file import JsonObject
from fea.study.traces import shipped_trace
from geometry.arrays import Floats
from loads.dynamics import center_acceleration, cycle
from loads.engine import kinematics


class Cell(NamedTuple):
    """A printed figure: the first column of its row (mostly the crank angle), its text, its last digit."""

    key: str
    text: str
    digit: float


class PrintedColumn(tuple[Cell, ...]):
    """The printed cells of one column, without the blank ones."""

    __slots__ = ()

    @classmethod
    def at(cls, degrees: Floats) -> "PrintedColumn":
        """Return cells with nothing in them at crank angles."""
        return cls(Cell(str(angle), "", 1.0) for angle in degrees.tolist())

    @property
    def degrees(self) -> Floats:
        """Crank angles."""
        return np.array([float(cell.key) for cell in self])

    @property
    def values(self) -> Floats:
        """The printed figures as numbers."""
        return np.array([float(cell.text) for cell in self])


def records(name: str) -> list[dict[str, str]]:
    """Rows of a published table as printed, by the name of the file without its ending."""
    return list(csv.DictReader(shipped_text(f"verify/published/{name}.csv").splitlines()))


def column(
    name: str, title: str, key: str | None = None, content: Mapping[str, str] = MappingProxyType({})
) -> PrintedColumn:
    """Return a column of a published table; a single 0 gets the finest digit of its column.

    `key`: the column that names the cells, by default the first; `content`: of other columns of the rows.
    """
    rows = [row for row in records(name) if all(row[of] == text for of, text in content.items())]
    key = next(iter(rows[0])) if key is None else key
    texts = [(row[key], row[title]) for row in rows if row[title]]
    finest = max(decimals(text) for _, text in texts)
    return PrintedColumn(
        Cell(k, text, 10.0 ** -(decimals(text) if float(text) else finest)) for k, text in texts
    )


def printed(name: str, title: str) -> Floats:
    """The figures of a column of a published table."""
    return column(name, title).values


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

    def as_dict(self) -> JsonObject:
        """Return the figure with the names that other programs rely on."""
        named = ("source", "table", "quantity", "at", "unit", "published", "as_published", "corrected")
        return {name: getattr(self, name) for name in (*named, "cause", "status")}

    def _within(self, value: float) -> bool:
        # One unit of the last digit, plus rounding, which matters for figures printed with ten digits.
        assert self.published is not None  # noqa: S101
        return abs(self.published - value) <= self.digit * (1 + 1e-6) + 4 * math.ulp(self.published)


@dataclass(frozen=True)
class PrintedTable:
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


class FigureCounts(NamedTuple):
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


def summarise(tables: Iterable[PrintedTable]) -> FigureCounts:
    """Count the printed figures of some tables."""
    figures = [f for table in tables for f in table.figures if f.status is not Status.NOT_PRINTED]
    counts = Counter(figure.status for figure in figures)
    by_status = {status.value: counts[status] for status in Status if status is not Status.NOT_PRINTED}
    return FigureCounts(compared=len(figures), wrong=sum(figure.is_wrong for figure in figures), **by_status)


def misprinted(tables: Sequence[PrintedTable]) -> list[PrintedFigure]:
    """Figures that are wrong on their own, rather than by the formula."""
    bad = (Status.EXPLAINED, Status.NAMED, Status.UNEXPLAINED)
    return [figure for table in tables for figure in table.figures if figure.status in bad]


@dataclass(frozen=True)
class PrintedQuantity:
    """A quantity of a table as the file describes it; its own keys precede those of the table's `common`.

    Formulas are expressions, see `PublishedStudy`, or numbers. In texts, ``{name}`` is the value of an
    expression without cells, or another text of the file.
    """

    name: str
    unit: str
    corrected: str  #: formula of correct mechanics
    published: str | float | None = None  #: formula as printed, if another than that
    #: cells, column, key: the file of the printed cells, their column and that of the crank angle, by default
    #: the first; without a file nothing is printed
    cells: str = ""
    column: str = ""
    key: str | None = None
    rows: Mapping[str, str] = field(default_factory=dict)  #: what other columns must contain
    #: speeds; successive quantities with the same ones alternate
    rpm: Sequence[int] = (0,)
    at: str | None = None  #: the place of a cell with its ``{key}``; by default crank angle and speed
    cause: str = ""  #: why the two formulas differ
    #: errors of cells by their keys, ``*`` for all others, or an expression that finds them
    slips: str | Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    misprints: Sequence[str] = ()  #: keys of cells with one wrong digit


# The mechanics that every study has; and expressions: the crank angles of the cells and the speed, rad and
# rad/s.
_MECHANICS = {
    each.__name__: each for each in (kinematics, cycle, center_acceleration, shipped_trace, column, printed)
}
_SHARED = {"degrees": "cells.degrees", "theta": "degrees * DEG", "omega": "rpm * RPM"}


@dataclass(frozen=True)
class PublishedStudy:
    """A published study: its tables, read from package data, and the names that their formulas use.

    A formula is a Python expression whose value is broadcast to the printed cells. It may use the `names` of
    the study's module, `_MECHANICS`, units and functions of NumPy, the ``expressions`` of the file,
    ``degrees``, ``theta`` and ``omega``, the cells themselves and their speed, ``rpm``.
    """

    source: str
    names: dict[str, Any]

    @cached_property
    def data(self) -> TomlTable:
        """The content of the study's file."""
        return shipped_toml(f"verify/published/{self.source}.toml")

    @property
    def _shared(self) -> dict[str, str]:
        shared: dict[str, str] = self.data.get("expressions", {})
        return _SHARED | shared

    def tables(self) -> list[PrintedTable]:
        """Compare all tables, in the order of the study."""
        return [
            PrintedTable(
                *(self.source, table["name"], table["title"], tuple(self._figures(table))),
                remarks=tuple(self.text(remark, 0) for remark in table.get("remarks", ())),
            )
            for table in self.data["table"]
        ]

    def evaluate(self, formula: str | float, cells: PrintedColumn, rpm: int) -> Floats:
        """Evaluate a formula for each of the cells."""
        value = self._value(formula, cells=cells, rpm=rpm) if isinstance(formula, str) else formula
        return np.broadcast_to(value, len(cells))

    def _value(self, expression: str, **given: object) -> Any:
        tree = ast.parse(expression, mode="eval")
        named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        used = {name: self._value(self._shared[name], **given) for name in named & self._shared.keys()}
        names = ChainMap(used, given, self.names, _MECHANICS, vars(units), vars(np))
        return eval(expression, {}, names)  # noqa: S307 - the files of this package

    def printed(self, quantity: PrintedQuantity, rpm: int) -> PrintedColumn:
        """Return the printed cells of a quantity; a blank one if nothing is printed."""
        if not quantity.cells:
            return PrintedColumn([Cell("", "", 1.0)])
        rows = {name: self.text(content, rpm) for name, content in quantity.rows.items()}
        return column(quantity.cells, self.text(quantity.column, rpm), quantity.key, rows)

    def text(self, text: str, rpm: int, key: str = "") -> str:
        """Fill in what a text names: expressions, other texts of the file, the speed, the crank angle."""
        texts = {"key": key, **self.data.get("texts", {})}
        named = {name for _, name, *_ in Formatter().parse(text) if name and name not in texts}
        return text.format(**texts, **{name: self._value(name, rpm=rpm) for name in named})

    def _figures(self, table: TomlTable) -> Iterator[PrintedFigure]:
        quantities = [PrintedQuantity(**table.get("common", {}) | given) for given in table["quantity"]]
        for speeds, alternating in groupby(quantities, key=lambda quantity: quantity.rpm):
            together = list(alternating)
            for rpm in speeds:
                for quantity in together:
                    yield from self._compared(table["name"], quantity, rpm)

    def _compared(self, table: str, quantity: PrintedQuantity, rpm: int) -> Iterator[PrintedFigure]:
        cells = self.printed(quantity, rpm)
        as_published = self.evaluate(quantity.published or quantity.corrected, cells, rpm)
        corrected = self.evaluate(quantity.corrected, cells, rpm)
        slips = self._slips(quantity, cells, rpm, as_published)
        at = ("{rpm} rpm, {key}°" if rpm else "{key}°") if quantity.at is None else quantity.at
        for number, cell in enumerate(cells):
            yield PrintedFigure(
                source=self.source,
                table=table,
                quantity=quantity.name,
                at=self.text(at, rpm, cell.key),
                unit=quantity.unit,
                published=float(cell.text) if cell.text else None,
                digit=cell.digit,
                as_published=float(as_published[number]),
                corrected=float(corrected[number]),
                formula_cause=self.text(quantity.cause, rpm),
                slip=slips.get(cell.key),
            )

    def _slips(
        self, quantity: PrintedQuantity, cells: PrintedColumn, rpm: int, as_published: Floats
    ) -> Mapping[str, Slip]:
        if isinstance(quantity.slips, str):
            by_key: dict[str, Slip] = self._value(quantity.slips, cells=cells, rpm=rpm)
            return by_key
        slips = {}
        for number, cell in enumerate(cells):
            given = quantity.slips.get(cell.key, quantity.slips.get("*"))
            if cell.key in quantity.misprints:
                slips[cell.key] = wrong_digit(cell.text, float(as_published[number]))
            elif given is not None:
                value = given.get("value")
                if value is not None:
                    value = float(self.evaluate(value, cells, rpm)[number])
                text = self.text(given["text"], rpm, cell.key)
                slips[cell.key] = Slip(text, value, given.get("is_rounding", False))
        return slips
