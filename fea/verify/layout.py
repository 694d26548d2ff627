"""What the reports of the verification commands share: Markdown, tables on the terminal."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from rich import box
from rich.table import Table

from fea.output.text import make_directory, write_text


def write_document(path: Path, parts: Iterable[str]) -> None:
    """Write the parts of a Markdown document, separated by empty lines; raises `StorageError`."""
    make_directory(path.parent)
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]], align: str = "") -> str:
    """Return a Markdown table; `align` has an ``r`` for each column that is aligned to the right."""
    rules = ["---:" if side == "r" else "---" for side in align.ljust(len(header))]
    escaped = ([cell.replace("|", r"\|") for cell in row] for row in rows)
    return "\n".join("| " + " | ".join(line) + " |" for line in (header, rules, *escaped))


def narrow_table() -> Table:
    """Start a table without frame and padding, for many columns."""
    return Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0)
