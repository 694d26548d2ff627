"""Table reader for files of measurements: text with columns of numbers, in whatever form a program wrote it.

Recognised are UTF-8, UTF-16 and Latin-1; columns apart by semicolons, tabs, commas or blanks; decimal points
and commas; comments after ``#`` or ``%``; and, above the numbers, up to three lines of names and units. The
form is the one that most of the first lines have, and every further line must have it.
"""

import codecs
import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.study.files import require_size
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require

# Headings of the documented format, apart by commas: gauge pressures in bar over degrees, also one per speed.
DOCUMENTED = ("crank_deg", "pressure_bar")
_PER_SPEED = re.compile(r"pressure_bar_(\d+(?:\.\d+)?)rpm")
LARGEST_TRACE = 2**24  # bytes: a hundred cycles in steps of a tenth of a degree
_REMEDY = "A pressure trace needs a column of crank angles in degrees and one of pressures."
# The separators in the order of preference where several fit; None stands for runs of blanks.
_SEPARATORS = (";", "\t", ",", None)
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_POINT = re.compile(_NUMBER, re.ASCII)
_COMMA = re.compile(_NUMBER.replace(r"\.", ","), re.ASCII)
_NOT_FINITE = {"nan", "inf", "-inf", "+inf", "infinity", "-infinity"}
_COMMENTS = ("#", "%")
# Characters below a space, except tab, line feed, form feed and carriage return.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f]")
_SAMPLE = 200  # lines from which the form of a table is found
_LONGEST_LINE = 2**16  # characters
_MOST_COLUMNS = 1000
_MOST_NAME_LINES = 3  # names, units and symbols stand in lines of their own


class _TextLine(NamedTuple):
    """A line of a file that is not blank."""

    number: int
    text: str

    @property
    def is_comment(self) -> bool:
        """Whether it holds no data."""
        return self.text.lstrip().startswith(_COMMENTS)


class _Form(NamedTuple):
    """How the lines of a table are written; `numbers` are the columns (from 0) that hold numbers."""

    separator: str | None
    comma: bool  #: decimal
    cells: int
    numbers: tuple[int, ...]

    def fits(self, line: _TextLine) -> bool:
        """Whether a line that is no comment is a row of the table."""
        cells = _cells(line.text, self.separator)
        return len(cells) == self.cells and all(_is_number(cells[i], comma=self.comma) for i in self.numbers)


@dataclass(frozen=True)
class TraceTable:
    """Columns of numbers."""

    source: str  #: name of the file
    names: tuple[str, ...]  #: of the columns by the header, "" where there is none; columns of text included
    numbers: tuple[int, ...]  #: which columns (from 0) hold numbers
    values: Floats  #: (n, k), the columns of `numbers`
    lines: tuple[int, ...]  #: number of each row's line in the file
    documented: bool = False  #: whether it is in the documented format

    def column(self, index: int) -> Floats:
        """Values of a column (from 0) that holds numbers, (n,)."""
        return np.asarray(self.values[:, self.numbers.index(index)], dtype=np.float64)


def speed_of(name: str) -> float | None:
    """Speed, rpm, of a column in the documented format with one per speed."""
    match = _PER_SPEED.fullmatch(name)
    return None if match is None else float(match[1])


def read_text(path: Path, name: str = "engine.gas", largest: int = LARGEST_TRACE) -> str:
    """Read a text file, whose key is `name`. Raises `InvalidValue`: missing, of more bytes, or binary."""
    remedy = _REMEDY if name == "engine.gas" else ""
    try:
        require_size(name, path, largest)
        raw = path.read_bytes()
    except OSError as error:
        raise InvalidValue(name, str(path), f"cannot be read ({error.strerror})", remedy) from error
    # Latin-1 gives every byte a meaning: a degree sign of an older export is right, binary data is refused
    # for its control characters.
    wide = raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "latin-1"):
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if _CONTROL.search(text) is None:
            return text
        break
    raise InvalidValue(name, str(path), "cannot be read (it is not a text file)", remedy)


def find_table(text: str, source: str) -> TraceTable:
    """Find the table in a text; `source` is its name in messages.

    Raises `InvalidValue`, with the line: there is no table of two columns, or a line breaks its form.
    """
    numbered = enumerate(re.split("\r\n|\r|\n", text), 1)
    lines = [_TextLine(number, line[:_LONGEST_LINE]) for number, line in numbered if line.strip()]
    require(bool(lines), "engine.gas", source, "contains no data", _REMEDY)
    sample = lines[:_SAMPLE]
    form = _form([line for line in sample if not line.is_comment], source)
    start = next(i for i, line in enumerate(sample) if not line.is_comment and form.fits(line))
    return _rows(lines[start:], form, _names(sample[:start], sample[start], form, source), source)


def find_long_table(text: str, source: str) -> TraceTable:
    """As `find_table`, which looks at every line: of a million, only the first are looked at, if all fit."""
    lines = text.splitlines()
    head = find_table("\n".join(lines[:_SAMPLE]), source)
    sample = [_TextLine(0, line) for line in lines[:_SAMPLE] if line.strip()]
    form, start = _form([line for line in sample if not line.is_comment], source), head.lines[0] - 1
    rows = [line.replace(",", ".") for line in lines[start:]] if form.comma else lines[start:]
    try:
        values = np.loadtxt(
            rows, comments=None, delimiter=form.separator, usecols=form.numbers, quotechar='"', ndmin=2
        )
    except ValueError:
        return find_table(text, source)
    if len(values) != len(rows) or not np.isfinite(values).all():  # comments and blank lines among the rows
        return find_table(text, source)
    return TraceTable(source, head.names, form.numbers, values, tuple(range(start + 1, len(lines) + 1)))


def _cells(text: str, separator: str | None) -> list[str]:
    """Return the cells of a line without quotes; separators at its end make no columns."""
    cells = [cell.strip().strip('"').strip() for cell in text.split(separator, _MOST_COLUMNS)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str, *, comma: bool) -> bool:
    return bool((_COMMA if comma else _POINT).fullmatch(cell)) or cell.lower() in _NOT_FINITE


def _form(sample: Sequence[_TextLine], source: str) -> _Form:
    counts = [count for separator in _SEPARATORS if (count := _commonest(separator, sample)) is not None]
    require(bool(counts), "engine.gas", source, "contains no table with two columns of numbers", _REMEDY)
    most = max(lines for _, lines in counts)
    forms = [form for form, lines in counts if 2 * lines > most]
    best = max(forms, key=lambda form: (len(form.numbers) / form.cells, len(form.numbers)))
    rule = f"has more than {_MOST_COLUMNS} columns"
    require(best.cells <= _MOST_COLUMNS, "engine.gas", source, rule, _REMEDY)
    return best


def _commonest(separator: str | None, sample: Sequence[_TextLine]) -> tuple[_Form, int] | None:
    forms: Counter[_Form] = Counter()
    for line in sample:
        cells = _cells(line.text, separator)
        for comma in (False, True) if separator != "," else (False,):
            numbers = tuple(i for i, cell in enumerate(cells) if _is_number(cell, comma=comma))
            if len(numbers) >= 2:  # an angle and a pressure
                forms[_Form(separator, comma, len(cells), numbers)] += 1
    # Whole numbers fit either decimal sign, and the point goes first.
    best = max(forms, key=lambda form: (forms[form], len(form.numbers), not form.comma), default=None)
    return None if best is None else (best, forms[best])


def _names(above: Sequence[_TextLine], first: _TextLine, form: _Form, source: str) -> tuple[str, ...]:
    """Names of the columns: the lines above the first row with as many cells, joined column by column."""
    rows: list[list[str]] = []
    for line in reversed(above[-_MOST_NAME_LINES:]):
        cells = _headings(line.text.lstrip().lstrip("".join(_COMMENTS)), form)
        if cells is None:
            break
        rows.insert(0, cells)
    if not rows and above and not above[-1].is_comment:  # a line of names that does not fit
        cells, text = _cells(above[-1].text, form.separator), above[-1].text
        if len(cells) > 1 and all(_is_number(cell, comma=form.comma) for cell in cells):
            rule = f"must have {len(cells)} columns like the lines above it"
            raise InvalidValue(f"{source} line {first.number}", first.text, rule)
        is_preamble = len(cells) < 2 or (form.separator is None and not {"[", "("} & set(text))
        rule = f"names {len(cells)} columns, but the lines below it have {form.cells}"
        remedy = "Name every column, and use another separator than the decimal sign."
        require(is_preamble, f"{source} line {above[-1].number}", text, rule, remedy)
    return tuple(" ".join(parts).strip() for parts in zip(*rows, strict=True)) or ("",) * form.cells


def _headings(text: str, form: _Form) -> list[str] | None:
    """Return a name for every column, None where a line has another number of cells."""
    if form.separator is None:
        # Names of several words are farther apart than these, or their units in brackets end them.
        splits = [text.split(), *(re.split(apart, text.strip()) for apart in (r"\s{2,}|\t", r"\s+(?![\[(])"))]
        return next((cells for cells in splits if len(cells) == form.cells), None)
    cells = _cells(text, form.separator)
    unnamed = form.cells - len(cells)
    blanks = text.count(form.separator) + 1 - len(cells)  # empty cells at the end of the line
    return cells + [""] * unnamed if cells and 0 <= unnamed <= blanks else None


def _rows(lines: Iterable[_TextLine], form: _Form, names: tuple[str, ...], source: str) -> TraceTable:
    """Read the rows; in the documented format no line may have more cells than the header."""
    by_speed = all(speed_of(name) is not None for name in names[1:])
    documented = form.separator == "," and names[0] == DOCUMENTED[0] and (by_speed or names == DOCUMENTED)
    rows = [line for line in lines if not line.is_comment]
    pattern, sign = (_COMMA, "comma") if form.comma else (_POINT, "point")
    most = form.cells if documented else _MOST_COLUMNS + 1
    values = np.empty((len(rows), len(form.numbers)))
    for row, (number, text) in enumerate(rows):
        cells = _cells(text.partition("#")[0], form.separator)
        if not form.numbers[-1] < len(cells) <= most:
            rule = f"must have {form.cells} columns like the lines above it"
            raise InvalidValue(f"{source} line {number}", text, rule)
        for column, i in enumerate(form.numbers):
            value = float(cells[i].replace(",", ".")) if pattern.fullmatch(cells[i]) else math.nan
            if not math.isfinite(value):
                rule = f"must be a finite number, with a decimal {sign} as above"
                name = f"{source} line {number}, {names[i] or f'column {i + 1}'}"
                raise InvalidValue(name, cells[i], rule)
            values[row, column] = value
    numbers = tuple(line.number for line in rows)
    return TraceTable(source, names, form.numbers, values, numbers, documented)
