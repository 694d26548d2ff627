"""`fea reproduce`."""

import sys
from pathlib import Path

CHECK_FAILED = 5
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

    require_report(report)
    tables = compare(source)
    if report is not None:
        from fea.verify.reproduce.report import write_report

        target = report.name if report.is_absolute() else report.as_posix()
        write_report(report, tables, f"fea reproduce {source} --report {target}")
    if json:
        from fea.output.json_file import json_text

        rows = [row.as_dict() for table in tables for row in table.rows]
        sys.stdout.write(json_text(rows, _DIGITS))
    elif not quiet:
        from fea.verify.reproduce.terminal import print_reproduction

        print_reproduction(tables)
        if report is not None:
            sys.stdout.write(f"Wrote {report}\n")
    return CHECK_FAILED if summarise(tables).unexplained else 0
