"""What the commands that compare results with known ones share: JSON rows, tables and reports."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Protocol

from fea.cli.options import Json, Markdown, Quiet, print_json, print_written
from fea.machine.exit_codes import CHECK_FAILED
from fea.study.study import DEFAULT_STUDY


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
        print_json([row.as_dict() for row in rows], digits)
    elif not quiet:
        table()
        print_written((report,))


_DIGITS = 9


def verify(*cases: str, json: Json = False, report: Path | None = None, quiet: Quiet = False) -> int:
    """Solve benchmark problems with known answers, with the elements, solver and recovery of a run.

    Parameters
    ----------
    cases
        Cases to solve (le1, le10, le11, lame, goodier, cook, …); default: all of them.
    report
        Write a Markdown report to this file (.md), with its plot next to it; it also solves every case on
        coarser meshes.
    """
    from fea.machine.clock import stages
    from fea.output.target import require_report
    from fea.verify.verify import print_verification, write_report
    from fea.verify.verify import verify as compute

    require_report(report)
    with stages(silent=quiet) as listener:
        rows = compute(cases, listener)
        if report is not None:
            write_report(report, rows, quoted(" ".join(["fea verify", *cases]), report), listener)
    show(rows, _DIGITS, partial(print_verification, rows), report=report, json=json, quiet=quiet)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED


_STABILITY_DIGITS = 9


def stability(*cases: str, json: Json = False, report: Markdown = None, quiet: Quiet = False) -> int:
    """Solve ill-conditioned and extreme cases with known answers: no wrong result may pass unnoticed.

    Parameters
    ----------
    cases
        Cases to solve (contrast, slender, incompressible, …); default: all of them.
    """
    from fea.machine.clock import stages
    from fea.output.target import require_report
    from fea.verify.stability.stability import print_stability, write_report
    from fea.verify.stability.stability import stability as compute

    require_report(report)
    with stages(silent=quiet) as listener:
        rows = compute(cases, listener)
    if report is not None:
        write_report(report, rows, quoted(" ".join(["fea stability", *cases]), report))
    show(rows, _STABILITY_DIGITS, partial(print_stability, rows), report=report, json=json, quiet=quiet)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED


_CONVERGE_DIGITS = 6


def converge(
    study: str = DEFAULT_STUDY,
    *,
    minutes: float = 10.0,
    json: Json = False,
    report: Markdown = None,
    quiet: Quiet = False,
) -> int:
    """Measure error against run time, for a rod and two problems with exact solutions.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file; its first load case at its
        first speed is solved.
    minutes
        Time for all compared computations, in minutes; the reference solution, on a very fine mesh of the
        rod, takes some minutes more.
    """
    from fea.machine.clock import stages
    from fea.output.target import require_report
    from fea.study.study import load_study
    from fea.verify.converge.converge import converge as compute
    from fea.verify.converge.report import print_comparison, write_report
    from fea.verify.converge.series import advice
    from geometry.errors import require_positive

    require_positive("--minutes", minutes)
    asked = load_study(study)
    require_report(report)
    with stages(silent=quiet or json) as listener:
        comparison = compute(asked, minutes, listener)
    if report is not None:
        write_report(report, comparison, quoted(f"fea converge {study} --minutes {minutes:g}", report))
    advised = advice(comparison.of("rod"), comparison.references["rod"].uncertainty_percent)
    table = partial(print_comparison, comparison.rows, advised)
    show(comparison.rows, _CONVERGE_DIGITS, table, report=report, json=json, quiet=quiet)
    return 0


# The studies print up to ten significant digits; every one is compared.
_REPRODUCE_DIGITS = 12


def reproduce(
    source: str = "all", *, json: Json = False, report: Markdown = None, quiet: Quiet = False
) -> int:
    """Compare published figures with computed ones: every printed cell, and why it differs.

    Parameters
    ----------
    source
        leon-2001, columba-2022, molina-2024 or all.
    """
    from fea.output.target import require_report
    from fea.verify.reproduce.printed import summarise
    from fea.verify.reproduce.report import print_reproduction, write_report
    from fea.verify.reproduce.report import reproduce as compare

    require_report(report)
    tables = compare(source)
    if report is not None:
        write_report(report, tables, quoted(f"fea reproduce {source}", report))
    figures = [figure for table in tables for figure in table.figures]
    show(
        figures, _REPRODUCE_DIGITS, partial(print_reproduction, tables), report=report, json=json, quiet=quiet
    )
    return CHECK_FAILED if summarise(tables).unexplained else 0
