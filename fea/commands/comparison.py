"""What the commands that compare results with known ones share: JSON rows, tables and reports."""

import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol


class Row(Protocol):
    """One result and what it is compared with."""

    def as_dict(self) -> dict[str, object]:
        """Return the figures by their JSON keys."""


def quoted(command: str, report: Path) -> str:
    """Return a command with its report, as the report quotes it: only the name of an absolute path."""
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
    """Print rows as JSON with so many significant digits, or as a table with the path of the report."""
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text([row.as_dict() for row in rows], digits))
    elif not quiet:
        table()
        if report is not None:
            sys.stdout.write(f"Wrote {report}\n")
