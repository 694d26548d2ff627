"""Tables of numbers in text files: separator, decimal sign and header are found from the lines themselves."""

import codecs
import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fea.study.paths import require_size
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require

# The separators in the order of preference where several fit; None stands for runs of blanks.
_SEPARATORS = (";", "\t", ",", None)
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_POINT = re.compile(_NUMBER, re.ASCII)
_COMMA = re.compile(_NUMBER.replace(r"\.", ","), re.ASCII)
_NOT_FINITE = {"nan", "inf", "-inf", "+inf", "infinity", "-infinity"}
_COMMENTS = ("#", "%")
_SAMPLE = 200  # lines from which the form of a table is found
_LONGEST_LINE = 2**16  # characters
_MOST_COLUMNS = 1000
_MOST_NAME_LINES = 3  # names, units and symbols stand in lines of their own


class Line(NamedTuple):
    """A line of a file that is not blank."""

    number: int
    text: str

    @property
    def is_comment(self) -> bool:
        """Whether it holds no data."""
        return self.text.lstrip().startswith(_COMMENTS)


class Form(NamedTuple):
    """How the lines of a table are written; `numbers` are the columns (from 0) that hold numbers."""

    separator: str | None
    comma: bool  #: decimal
    cells: int
    numbers: tuple[int, ...]
    exact: bool = False  #: whether lines with more cells are refused

    def fits(self, line: Line) -> bool:
        """Whether a line that is no comment is a row of the table."""
        cells = cells_of(line.text, self.separator)
        return len(cells) == self.cells and all(_is_number(cells[i], comma=self.comma) for i in self.numbers)


@dataclass(frozen=True)
class TraceTable:
    """Columns of numbers."""

    source: str  #: name of the file
    names: tuple[str, ...]  #: of the columns by the header, "" where there is none; columns of text included
    numbers: tuple[int, ...]  #: which columns (from 0) hold numbers
    values: Floats  #: (n, k), the columns of `numbers`
    lines: tuple[int, ...]  #: number of each row's line in the file

    def column(self, index: int) -> Floats:
        """Values of a column (from 0) that holds numbers, (n,)."""
        return np.asarray(self.values[:, self.numbers.index(index)], dtype=np.float64)


def find_table(lines: Sequence[Line], source: str, remedy: str) -> TraceTable:
    """Find the table in lines. Raises `InvalidValue`: none of two columns, or a line breaks its form."""
    require(bool(lines), "engine.gas", source, "contains no data", remedy)
    sample = lines[:_SAMPLE]
    form = _form([line for line in sample if not line.is_comment], source, remedy)
    start = next(i for i, line in enumerate(sample) if not line.is_comment and form.fits(line))
    return read_rows(lines[start:], form, _names(sample[:start], form, source), source)


def lines_of(text: str) -> list[Line]:
    """Return the lines that are not blank."""
    lines = re.split("\r\n|\r|\n", text)
    return [Line(number, line[:_LONGEST_LINE]) for number, line in enumerate(lines, 1) if line.strip()]


def cells_of(text: str, separator: str | None) -> list[str]:
    """Return the cells of a line without quotes; separators at its end make no columns."""
    cells = [cell.strip().strip('"').strip() for cell in text.split(separator, _MOST_COLUMNS)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str, *, comma: bool) -> bool:
    return bool((_COMMA if comma else _POINT).fullmatch(cell)) or cell.lower() in _NOT_FINITE


def _form(sample: Sequence[Line], source: str, remedy: str) -> Form:
    counts = [count for separator in _SEPARATORS if (count := _commonest(separator, sample)) is not None]
    rule = "contains no table with two columns of numbers"
    require(bool(counts), "engine.gas", source, rule, remedy)
    most = max(lines for _, lines in counts)
    forms = [form for form, lines in counts if 2 * lines > most]
    best = max(forms, key=lambda form: (len(form.numbers) / form.cells, len(form.numbers)))
    rule = f"has more than {_MOST_COLUMNS} columns"
    require(best.cells <= _MOST_COLUMNS, "engine.gas", source, rule, remedy)
    return best


def _commonest(separator: str | None, sample: Sequence[Line]) -> tuple[Form, int] | None:
    forms: Counter[Form] = Counter()
    for line in sample:
        cells = cells_of(line.text, separator)
        for comma in (False, True) if separator != "," else (False,):
            numbers = tuple(i for i, cell in enumerate(cells) if _is_number(cell, comma=comma))
            if len(numbers) >= 2:  # an angle and a pressure
                forms[Form(separator, comma, len(cells), numbers)] += 1
    # Whole numbers fit either decimal sign, and the point goes first.
    best = max(forms, key=lambda form: (forms[form], len(form.numbers), not form.comma), default=None)
    return None if best is None else (best, forms[best])


def _names(above: Sequence[Line], form: Form, source: str) -> tuple[str, ...]:
    """Names of the columns: the lines above the first row with as many cells, joined column by column."""
    rows: list[list[str]] = []
    for line in reversed(above[-_MOST_NAME_LINES:]):
        cells = _headings(line.text.lstrip().lstrip("".join(_COMMENTS)), form)
        if cells is None:
            break
        rows.insert(0, cells)
    if not rows and above and not above[-1].is_comment:
        _require_preamble(above[-1], form, source)
    return tuple(" ".join(parts).strip() for parts in zip(*rows, strict=True)) or ("",) * form.cells


def _headings(text: str, form: Form) -> list[str] | None:
    """Return a name for every column, None where a line has another number of cells."""
    if form.separator is None:
        # Names of several words are farther apart than these, or their units in brackets end them.
        splits = [text.split(), *(re.split(apart, text.strip()) for apart in (r"\s{2,}|\t", r"\s+(?![\[(])"))]
        return next((cells for cells in splits if len(cells) == form.cells), None)
    cells = cells_of(text, form.separator)
    unnamed = form.cells - len(cells)
    blanks = text.count(form.separator) + 1 - len(cells)  # empty cells at the end of the line
    return cells + [""] * unnamed if cells and 0 <= unnamed <= blanks else None


def _require_preamble(line: Line, form: Form, source: str) -> None:
    cells = len(cells_of(line.text, form.separator))
    names = cells > 1 and (form.separator is not None or "[" in line.text or "(" in line.text)
    rule = f"names {cells} columns, but the lines below it have {form.cells}"
    remedy = "Name every column, and use another separator than the decimal sign."
    require(not names, f"{source} line {line.number}", line.text, rule, remedy)


def read_rows(lines: Iterable[Line], form: Form, names: tuple[str, ...], source: str) -> TraceTable:
    """Read the rows of a table. Raises `InvalidValue`: a line, which it names, does not have the form."""
    rows = [line for line in lines if not line.is_comment]
    pattern, sign = (_COMMA, "comma") if form.comma else (_POINT, "point")
    values = np.empty((len(rows), len(form.numbers)))
    for row, (number, text) in enumerate(rows):
        cells = cells_of(text.partition("#")[0], form.separator)
        if len(cells) <= form.numbers[-1] or (form.exact and len(cells) > form.cells):
            rule = f"must have {form.cells} columns like the lines above it"
            raise InvalidValue(f"{source} line {number}", text, rule)
        taken = [cells[i] for i in form.numbers]
        read = [float(each.replace(",", ".")) if pattern.fullmatch(each) else math.nan for each in taken]
        if not all(map(math.isfinite, read)):
            i = next(i for i, value in zip(form.numbers, read, strict=True) if not math.isfinite(value))
            rule = f"must be a finite number, with a decimal {sign} as above"
            raise InvalidValue(f"{source} line {number}, {names[i] or f'column {i + 1}'}", cells[i], rule)
        values[row] = read
    return TraceTable(source, names, form.numbers, values, tuple(line.number for line in rows))


LARGEST_TRACE = 2**24  # bytes: a hundred cycles in steps of a tenth of a degree
# Characters below a space, except tab, line feed, form feed and carriage return.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f]")


def read_text(path: Path, remedy: str) -> str:
    """Read UTF-8, UTF-16 with a mark, or Latin-1; `remedy`: what it should hold. Raises `InvalidValue`."""
    try:
        require_size("engine.gas", path, LARGEST_TRACE)
        raw = path.read_bytes()
    except OSError as error:
        raise InvalidValue("engine.gas", str(path), f"cannot be read ({error.strerror})", remedy) from error
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
    raise InvalidValue("engine.gas", str(path), "cannot be read (it is not a text file)", remedy)
