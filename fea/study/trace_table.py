"""Tables of numbers in text files: separator, decimal sign and header are found from the lines themselves."""

import codecs
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import islice
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
_ROW = re.compile(r"at row (\d+)")  # in numpy's messages, counted from 0 or 1
_LONGEST_LINE = 2**16  # characters
_MOST_COLUMNS = 1000
_MOST_NAME_LINES = 3  # names, units and symbols stand in lines of their own


@dataclass(frozen=True)
class Table:
    """Columns of numbers.

    Attributes
    ----------
    source
        Name of the file.
    names
        Of the columns by the header, "" where there is none; columns of text included.
    numbers
        Which columns (from 0) hold numbers.
    values
        (n, k), the columns of `numbers`.
    first_line
        Line of the first row in the file.
    """

    source: str
    names: tuple[str, ...]
    numbers: tuple[int, ...]
    values: Floats
    first_line: int

    def column(self, index: int) -> Floats:
        """Values of a column (from 0) that holds numbers, (n,)."""
        return np.asarray(self.values[:, self.numbers.index(index)], dtype=np.float64)


class _Line(NamedTuple):
    number: int
    text: str


class _Form(NamedTuple):
    """How the lines of a table are written."""

    separator: str | None
    comma: bool  # decimal
    cells: int
    numbers: tuple[int, ...]


def read_table(text: str, source: str, remedy: str) -> Table:
    """Find the table in a text.

    Raises
    ------
    InvalidValue
        There is no table with two columns of numbers, or one of its lines breaks its form.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    sample = [] if not text or text.isspace() else list(islice(_lines(text), _SAMPLE))
    require(bool(sample), "engine.gas", source, "contains no data", remedy)
    form = _form([line for line in sample if not _is_comment(line)], source, remedy)
    start = next(line for line in sample if _fits(line, form))
    names = _names([line for line in sample if line.number < start.number], form, source)
    values = _values(text, form, start.number, source)
    return Table(source, names, form.numbers, values, start.number)


def _lines(text: str, start: int = 0, first: int = 1) -> Iterator[_Line]:
    """Lines that are not blank, from an index of the text on; `first` is the number of the first."""
    number = first
    while start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        line = text[start : min(end, start + _LONGEST_LINE)]
        if line.strip():
            yield _Line(number, line)
        start, number = end + 1, number + 1


def _is_comment(line: _Line) -> bool:
    return line.text.lstrip().startswith(_COMMENTS)


def _cells(text: str, separator: str | None) -> list[str]:
    """Cells of a line without quotes; separators at its end make no columns."""
    cells = [cell.strip().strip('"').strip() for cell in text.split(separator, _MOST_COLUMNS)]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str, *, comma: bool) -> bool:
    return bool((_COMMA if comma else _POINT).fullmatch(cell)) or cell.lower() in _NOT_FINITE


def _form(sample: Sequence[_Line], source: str, remedy: str) -> _Form:
    """The form that most lines have; of several, the one with the largest part of numbers, then the most."""
    counts = [count for separator in _SEPARATORS if (count := _commonest(separator, sample)) is not None]
    rule = "contains no table with two columns of numbers"
    require(bool(counts), "engine.gas", source, rule, remedy)
    most = max(lines for _, lines in counts)
    forms = [form for form, lines in counts if 2 * lines > most]
    best = max(forms, key=lambda form: (len(form.numbers) / form.cells, len(form.numbers)))
    rule = f"has more than {_MOST_COLUMNS} columns"
    require(best.cells <= _MOST_COLUMNS, "engine.gas", source, rule, remedy)
    return best


def _commonest(separator: str | None, sample: Sequence[_Line]) -> tuple[_Form, int] | None:
    """Return the commonest form of the lines with a separator, and how many have it; None without numbers."""
    found: Counter[_Form] = Counter()
    for line in sample:
        cells = _cells(line.text, separator)
        for comma in (False, True) if separator != "," else (False,):
            numbers = tuple(i for i, cell in enumerate(cells) if _is_number(cell, comma=comma))
            if len(numbers) >= 2:  # an angle and a pressure
                found[_Form(separator, comma, len(cells), numbers)] += 1
    # Whole numbers fit either decimal sign, and the point goes first.
    best = max(found, key=lambda form: (found[form], len(form.numbers), not form.comma), default=None)
    return None if best is None else (best, found[best])


def _fits(line: _Line, form: _Form) -> bool:
    cells = _cells(line.text, form.separator)
    return (
        not _is_comment(line)
        and len(cells) == form.cells
        and all(_is_number(cells[i], comma=form.comma) for i in form.numbers)
    )


def _names(above: Sequence[_Line], form: _Form, source: str) -> tuple[str, ...]:
    """Names of the columns: the lines above the first row with as many cells, joined column by column."""
    rows: list[list[str]] = []
    for line in reversed(above[-_MOST_NAME_LINES:]):
        cells = _headings(line.text.lstrip().lstrip("".join(_COMMENTS)), form)
        if cells is None:
            break
        rows.insert(0, cells)
    if not rows and above and not _is_comment(above[-1]):
        _require_preamble(above[-1], form, source)
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


def _require_preamble(line: _Line, form: _Form, source: str) -> None:
    """Refuse a line above the first row that names columns, but not as many as there are."""
    cells = len(_cells(line.text, form.separator))
    names = cells > 1 and (form.separator is not None or "[" in line.text or "(" in line.text)
    rule = f"names {cells} columns, but the lines below it have {form.cells}"
    remedy = "Name every column, and use another separator than the decimal sign."
    require(not names, f"{source} line {line.number}", line.text, rule, remedy)


def _values(text: str, form: _Form, first_line: int, source: str) -> Floats:
    """Parse the rows from a line on, with the line named that breaks the form."""
    body = text.split("\n", first_line - 1)[-1]
    try:
        values = np.loadtxt(
            StringIO(body.replace(",", ".") if form.comma else body),
            delimiter=form.separator,
            usecols=form.numbers,
            comments="#",
            quotechar='"',
            ndmin=2,
        )
    except ValueError as error:
        row = _ROW.search(str(error))
        broken = _broken(body, form, first_line, source, after=int(row[1]) - 2 if row else 0)
        unread = InvalidValue("engine.gas", source, f"contains a number that cannot be read ({error})")
        raise broken or unread from error
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    # A point beside decimal commas may separate thousands.
    doubtful = form.comma and "." in body
    if bad.size or doubtful:
        broken = _broken(body, form, first_line, source, after=0 if doubtful else int(bad[0]))
        if broken is not None:
            raise broken
    return np.asarray(values, dtype=np.float64)


def _broken(body: str, form: _Form, first_line: int, source: str, *, after: int) -> InvalidValue | None:
    """Name the first line that does not have the form of the others, None where all have it.

    The first `after` rows are known to have it.
    """
    rows = (line for line in _lines(body, first=first_line) if not _is_comment(line))
    for line in islice(rows, max(after, 0), None):
        cells = _cells(line.text, form.separator)
        where = f"{source} line {line.number}"
        if len(cells) <= form.numbers[-1]:
            return InvalidValue(where, line.text, f"must have {form.cells} columns like the lines above it")
        for i in form.numbers:
            finite = _is_number(cells[i], comma=form.comma) and cells[i].lower() not in _NOT_FINITE
            if not finite:
                sign = "comma" if form.comma else "point"
                rule = f"must be a finite number, with a decimal {sign} as above"
                return InvalidValue(f"{where}, column {i + 1}", cells[i], rule)
    return None


LARGEST_TRACE = 2**24  # bytes: a hundred cycles in steps of a tenth of a degree
_WIDE = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
# Characters below a space, except tab, line feed, form feed and carriage return.
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f]")


def read_text(path: Path, remedy: str) -> str:
    """Read a text file in UTF-8, UTF-16 with a byte-order mark, or Latin-1.

    Parameters
    ----------
    path
        The file.
    remedy
        What the file should contain, for messages.

    Raises
    ------
    InvalidValue
        The file cannot be read, is too large, or is not text.
    """
    try:
        require_size("engine.gas", path, LARGEST_TRACE)
        raw = path.read_bytes()
    except OSError as error:
        raise InvalidValue("engine.gas", str(path), f"cannot be read ({error.strerror})", remedy) from error
    text = _decoded(raw)
    is_text = text is not None and _CONTROL.search(text) is None
    require(is_text, "engine.gas", str(path), "cannot be read (it is not a text file)", remedy)
    return text or ""


def _decoded(raw: bytes) -> str | None:
    """Return the text, None where no encoding fits."""
    wide = _WIDE.get(raw[:2])
    try:
        if wide is not None:
            return raw.decode(wide)
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Latin-1 gives every byte a meaning: a degree sign of an older export is right, binary data is
        # refused for its control characters.
        return None if wide is not None else raw.decode("latin-1")
