"""`fea reproduce`."""

from functools import partial
from pathlib import Path

from fea.commands.comparison import quoted, show
from fea.machine.exit_codes import CHECK_FAILED

# The studies print up to ten significant digits; every one is compared.
_DIGITS = 12


def reproduce(
    source: str = "all", *, json: bool = False, report: Path | None = None, quiet: bool = False
) -> int:
    """Compare published figures with computed ones: every printed cell, and why it differs.

    Parameters
    ----------
    source
        leon-2001, columba-2022, molina-2024 or all.
    json
        Print every row as JSON and nothing else.
    report
        Write a Markdown report to this file (.md), with its plots next to it.
    quiet
        Print nothing.
    """
    from fea.output.target import require_report
    from fea.verify.reproduce.sources import reproduce as compare
    from fea.verify.reproduce.summary import summarise
    from fea.verify.reproduce.terminal import print_reproduction

    require_report(report)
    tables = compare(source)
    if report is not None:
        from fea.verify.reproduce.report import write_report

        write_report(report, tables, quoted(f"fea reproduce {source}", report))
    rows = [row for table in tables for row in table.rows]
    show(rows, _DIGITS, partial(print_reproduction, tables), report=report, json=json, quiet=quiet)
    return CHECK_FAILED if summarise(tables).unexplained else 0
