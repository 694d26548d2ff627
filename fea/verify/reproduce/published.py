"""Published tables as data: ``fea/verify/published/SOURCE.toml`` describes them, functions compute them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from string import Formatter
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.base.shipped import shipped_toml
from fea.verify.reproduce.printed import Cell, Column, PrintedFigure, Slip, Table, column, wrong_digit
from geometry.arrays import Floats

Formula = Callable[[Column, int], npt.ArrayLike]  #: figures of printed cells at a speed, rpm
Fact = Callable[[int], object]  #: something that a text states, at a speed, rpm


@dataclass(frozen=True)
class Quantity:
    """A quantity of a table as the file describes it; its own keys precede those of the table's `common`.

    Formulas are given by their names, ``|name|`` for the absolute value, or as a number. Texts may contain
    ``{rpm}`` and the names of facts.
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
    #: errors of cells by their keys, ``*`` for all others, or the name of what finds them
    slips: str | Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    misprints: Sequence[str] = ()  #: keys of cells with one wrong digit


@dataclass(frozen=True)
class PublishedStudy:
    """A study: its tables, read from package data, and what computes the figures in them."""

    source: str
    formulas: Mapping[str, Formula]
    facts: Mapping[str, Fact] = field(default_factory=dict)
    find_slips: Mapping[str, Callable[[Column, int], Mapping[str, Slip]]] = field(default_factory=dict)

    @cached_property
    def data(self) -> dict[str, Any]:
        """What the file of the study contains."""
        return shipped_toml(f"verify/published/{self.source}.toml")

    def tables(self) -> list[Table]:
        """Compare all tables, in the order of the study."""
        return [
            Table(
                *(self.source, table["name"], table["title"], tuple(self._figures(table))),
                remarks=tuple(self.text(remark, 0) for remark in table.get("remarks", ())),
            )
            for table in self.data["table"]
        ]

    def evaluate(self, formula: str | float, cells: Column, rpm: int) -> Floats:
        """Evaluate a formula for each of the cells."""
        if not isinstance(formula, str):
            return np.full(len(cells), formula)
        name = formula.strip("|")
        value = np.broadcast_to(self.formulas[name](cells, rpm), len(cells))
        return value if name == formula else np.abs(value)

    def printed(self, quantity: Quantity, rpm: int) -> Column:
        """Return the printed cells of a quantity; a blank one if nothing is printed."""
        if not quantity.cells:
            return Column([Cell("", "", 1.0)])
        rows = {name: self.text(content, rpm) for name, content in quantity.rows.items()}
        return column(quantity.cells, self.text(quantity.column, rpm), quantity.key, rows)

    def text(self, text: str, rpm: int, key: str = "") -> str:
        """Fill in what a text names: facts, other texts of the file, the speed, the crank angle."""
        named = {name for _, name, *_ in Formatter().parse(text)}
        facts = {name: fact(rpm) for name, fact in self.facts.items() if name in named}
        return text.format(rpm=rpm, key=key, **facts, **self.data.get("texts", {}))

    def _figures(self, table: dict[str, Any]) -> Iterator[PrintedFigure]:
        quantities = [Quantity(**table.get("common", {}) | given) for given in table["quantity"]]
        for speeds, alternating in groupby(quantities, key=lambda quantity: quantity.rpm):
            together = list(alternating)
            for rpm in speeds:
                for quantity in together:
                    yield from self._compared(table["name"], quantity, rpm)

    def _compared(self, table: str, quantity: Quantity, rpm: int) -> Iterator[PrintedFigure]:
        cells = self.printed(quantity, rpm)
        as_published = self.evaluate(quantity.published or quantity.corrected, cells, rpm)
        corrected = self.evaluate(quantity.corrected, cells, rpm)
        slips = self._slips(quantity, cells, rpm, as_published)
        at = ("{rpm} rpm, {key}°" if rpm else "{key}°") if quantity.at is None else quantity.at
        for number, printed in enumerate(cells):
            yield PrintedFigure(
                source=self.source,
                table=table,
                quantity=quantity.name,
                at=self.text(at, rpm, printed.key),
                unit=quantity.unit,
                published=float(printed.text) if printed.text else None,
                digit=printed.digit,
                as_published=float(as_published[number]),
                corrected=float(corrected[number]),
                formula_cause=self.text(quantity.cause, rpm),
                slip=slips.get(printed.key),
            )

    def _slips(self, quantity: Quantity, cells: Column, rpm: int, as_published: Floats) -> Mapping[str, Slip]:
        if isinstance(quantity.slips, str):
            return self.find_slips[quantity.slips](cells, rpm)
        slips = {}
        for number, printed in enumerate(cells):
            given = quantity.slips.get(printed.key, quantity.slips.get("*"))
            if printed.key in quantity.misprints:
                slips[printed.key] = wrong_digit(printed.text, float(as_published[number]))
            elif given is not None:
                value = given.get("value")
                if value is not None:
                    value = float(self.evaluate(value, cells, rpm)[number])
                text = self.text(given["text"], rpm, printed.key)
                slips[printed.key] = Slip(text, value, given.get("is_rounding", False))
        return slips
