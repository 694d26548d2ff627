"""What the commands have in common that hold answers against known ones: their rows, and their reports."""

import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol


class Row(Protocol):
    """One answer and what it is held against."""

    def as_dict(self) -> dict[str, object]:
        """By the names that JSON has."""


def quoted(command: str, report: Path) -> str:
    """Return a command with its report, as the report quotes it: an absolute path by its name alone."""
    return f"{command} --report {report.name if report.is_absolute() else report.as_posix()}"


def show(
    rows: Iterable[Row],
    digits: int,
    table: Callable[[], None],
    *,
    report: Path | None,
    json: bool,
    quiet: bool,
) -> None:
    """Print rows as JSON with so many significant digits, or as `table` does and where the report went."""
    if json:
        from fea.output.summary import json_text

        sys.stdout.write(json_text([row.as_dict() for row in rows], digits))
    elif not quiet:
        table()
        if report is not None:
            sys.stdout.write(f"Wrote {report}\n")
