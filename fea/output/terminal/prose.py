"""Lines and tables that fit a terminal, and no more lines than are read."""

import re
from collections.abc import Collection, Iterable, Sequence, Sized
from dataclasses import replace
from itertools import groupby
from textwrap import wrap
from typing import Any, Literal

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table as RichTable

from fea.base.note import HEADING, UNITS, Note, NoteKind
from fea.output.units import Verbatim, in_heading, in_text

MOST_LINES = 10  # after the table of a run
_MOST_UNUSUAL = 2
WIDTH = 80  # of what is not a terminal: a file, a pipe
_INDENT = "  "
# Blanks within a figure, at which no line is broken.
_TOGETHER = re.compile(r"(?<=±) | (?=±)|(?<=\d) (?=(?:MPa|mm|µm|kN|ksi|in|lbf|rpm|h|W|°C|°F|%)\b)")
# Headings of the notes that are printed in full.
_HEADINGS = {
    NoteKind.DOUBT: "Doubts",
    NoteKind.WARNING: "Limits of the figures",
    NoteKind.ASSUMPTION: "Assumptions",
    NoteKind.REMARK: "Remarks",
    NoteKind.OMISSION: "Left out",
}


def terminal() -> Console:
    """Return standard output, `WIDTH` columns wide where it is not a terminal."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDTH)


def plain_table(
    columns: Iterable[str],
    rows: Iterable[Iterable[str]],
    *,
    left: Collection[str] = (),
    no_wrap: bool = False,
    gap: int = 1,
    **options: Any,
) -> RichTable:
    """Return a table without vertical rules, figures to the right but for the columns on the left.

    The cells are in the units that are shown; those at the ends of the headings are converted.
    """
    table = RichTable(box=SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, **options)
    for title in columns:
        justify: Literal["left", "right"] = "left" if title in left else "right"
        cut: Literal["ellipsis", "fold"] = "ellipsis" if no_wrap else "fold"
        table.add_column(in_heading(title), justify=justify, no_wrap=no_wrap, overflow=cut)
    for row in rows:
        table.add_row(*row)
    return table


def wrapped(text: str, width: int) -> list[str]:
    """Break a text at words, with a hanging indent; a word that is longer than a line stays whole."""
    joined = _TOGETHER.sub("\0", text)
    lines = wrap(joined, width, subsequent_indent=_INDENT, break_long_words=False, break_on_hyphens=False)
    return [line.replace("\0", " ") for line in lines]


def print_lines(console: Console, lines: Iterable[str], style: str = "") -> None:
    """Print texts, each broken at words to the width of the console."""
    for text in lines:
        for line in wrapped(in_text(text), console.width):
            console.print(line, markup=False, soft_wrap=True, style=style)


def print_paths(console: Console, lines: Iterable[str]) -> None:
    """Print lines that name files whole, to be copied."""
    for line in lines:
        console.print(line, markup=False, soft_wrap=True)


def fitting(statements: Iterable[str], end: Iterable[str], paths: Sized, width: int) -> list[str]:
    """Return the statements for which `MOST_LINES` leaves room above the lines of the `end` and the paths.

    They are taken in their order; one that is too long for what is left is passed over. A path is a line,
    however long it is.
    """
    ending = len(paths) + sum(len(wrapped(in_text(text), width)) for text in end)
    chosen, left = list[str](), MOST_LINES - ending
    for text in statements:
        needed = len(wrapped(in_text(text), width))
        if needed <= left:
            chosen.append(text)
            left -= needed
    return chosen


def unusual(notes: Iterable[Note]) -> list[str]:
    """Return what stands below the headline: doubts of what was read, and values that engines do not have."""
    notes = tuple(notes)
    read = dict.fromkeys(note.text for note in notes if note.topic in HEADING)
    return [*(Verbatim(f"{text[0].upper()}{text[1:]}.") for text in read), *_units(notes)]


def _units(notes: Iterable[Note]) -> list[str]:
    texts = list(dict.fromkeys(note.text for note in notes if note.topic == UNITS))
    left = len(texts) - _MOST_UNUSUAL
    more = f" Unusual, too: {left} more value{'s' * (left > 1)} (--verbose)." if left > 0 else ""
    return [Verbatim(f"Check the units: {'; '.join(texts[:_MOST_UNUSUAL])}.{more}")] if texts else []


def counted(notes: Sequence[Note], left_out: Sequence[Note]) -> str:
    """Return how much there is to read beside the figures, and where."""
    assumed = sum(note.kind is NoteKind.ASSUMPTION for note in notes)
    counts = {"assumption": assumed, "note": len(notes) - assumed, "omission": len(left_out)}
    parts = [f"{count} {name}{'' if count == 1 else 's'}" for name, count in counts.items() if count]
    where = "--verbose, `fea report`, summary.json"
    return f"{', '.join(parts)}: {where}." if parts else f"More: {where}."


def in_full(notes: Iterable[Note]) -> list[str]:
    """Return notes in their order, under a heading for each kind."""
    return [
        line
        for kind, own in groupby(notes, key=lambda note: note.kind)
        for line in (f"{_HEADINGS[kind]}:", *(f"- {note}" for note in own))
    ]


_AT_SPEED = " at\0rpm"  # stands for the speed in a note
_FEW = 4  # with more speeds, their number and range are printed


def gathered(notes: Iterable[tuple[float, Iterable[Note]]]) -> list[Note]:
    """Return the notes of several speeds, rpm; those that differ only in the speed are merged."""
    speeds: dict[Note, list[str]] = {}
    for rpm, own in notes:
        for note in own:
            general = replace(note, text=note.text.replace(f" at {rpm:g} rpm", _AT_SPEED))
            speeds.setdefault(general, []).append(f"{rpm:g}")
    return [
        replace(note, text=note.text.replace(_AT_SPEED, f" at {some_speeds(rpm)}"))
        for note, rpm in speeds.items()
    ]


def some_speeds(rpm: Sequence[str]) -> str:
    """Return a few speeds, or how many there are and their range."""
    if len(rpm) <= _FEW:
        return f"{', '.join(rpm)} rpm"
    rising = sorted(rpm, key=float)
    return f"{len(rpm)} speeds from {rising[0]} to {rising[-1]} rpm"
