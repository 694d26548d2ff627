"""Markdown and terminal tables of the verification commands."""

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.base.shipped import shipped_text
from fea.output.folder import make_directory, write_text


def write_document(path: Path, title: str, command: str, parts: Iterable[str]) -> None:
    """Write a Markdown document, which the `command` makes, part by part; raises `StorageError`."""
    make_directory(path.parent)
    every = (f"# {title}", f"Made by `{command}`.", *parts)
    write_text(path, "\n\n".join(part.strip() for part in every) + "\n")


def explanation(name: str) -> str:
    """Return the text of the package that explains a report."""
    return shipped_text(f"verify/reading/{name}.md")


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]], align: str = "") -> str:
    """Return a Markdown table; `align` has an ``r`` for each column that is aligned to the right."""
    rules = ["---:" if side == "r" else "---" for side in align.ljust(len(header))]
    escaped = ([cell.replace("|", r"\|") for cell in row] for row in rows)
    return "\n".join("| " + " | ".join(line) + " |" for line in (header, rules, *escaped))


Line = tuple[Sequence[str], str]  # the cells of a row of a table, and its style; "" for none


def print_table(
    header: Sequence[str],
    rows: Iterable[Line],
    *,
    words: Collection[str],
    end: Iterable[str] = (),
    title: str | None = None,
    longest: int = 0,
) -> None:
    """Print a table of many columns, and bold lines behind it; cells of figures are never broken.

    `words` are the headings of columns of words, whose `longest` word has so many letters.
    """
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0, title=title)
    table.title_justify = "left"
    for name in header:
        if name in words:
            table.add_column(name, min_width=longest)
        else:
            table.add_column(name.replace(" ", "\n"), justify="right", no_wrap=True)
    for cells, style in rows:
        table.add_row(*cells, style=style or None)
    console = Console(highlight=False)
    console.print(table)
    for line in end:
        console.print(line, style="bold", markup=False)
