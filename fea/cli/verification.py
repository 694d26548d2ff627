"""The commands that compare results with known ones: JSON rows, tables and reports."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from fea.cli.options import Markdown, Printed
from fea.machine.clock import stages
from fea.machine.exit_codes import CHECK_FAILED
from fea.output.folder import require_target
from fea.study.study import DEFAULT_STUDY, load_study
from geometry.errors import require_positive


@dataclass(frozen=True)
class Shown(Printed):
    """How rows are shown."""

    report: Markdown = None

    def __post_init__(self) -> None:
        require_target("--report", self.report, (".md",), parents=True)

    def write(self, command: str, write: Callable[[Path, str], object]) -> None:
        """Write the report, which quotes the command with the name of an absolute path only."""
        if self.report is not None:
            name = self.report.name if self.report.is_absolute() else self.report.as_posix()
            write(self.report, f"{command} --report {name}")


Options = Annotated[Shown, Parameter(name="*")]
_NOTHING = Shown()


def verify(*cases: str, shown: Options = _NOTHING) -> int:
    """Solve benchmark problems with known answers, with the elements, solver and recovery of a run.

    Parameters
    ----------
    cases
        Cases to solve (le1, le10, le11, lame, goodier, cook, …); default: all of them.
    """
    from fea.verify import verify as benchmarks

    with stages(silent=shown.quiet) as listener:
        rows = benchmarks.verify(cases, listener)
        command = " ".join(["fea verify", *cases])
        shown.write(command, lambda file, text: benchmarks.write_report(file, rows, text, listener))
    figures = [row.as_dict() for row in rows]
    shown.show(figures, lambda: benchmarks.print_verification(rows), written=(shown.report,), digits=9)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED


def stability(*cases: str, shown: Options = _NOTHING) -> int:
    """Solve ill-conditioned and extreme cases with known answers: no wrong result may pass unnoticed.

    Parameters
    ----------
    cases
        Cases to solve (contrast, slender, incompressible, …); default: all of them.
    """
    from fea.verify.stability import stability as extremes

    with stages(silent=shown.quiet) as listener:
        rows = extremes.stability(cases, listener)
    command = " ".join(["fea stability", *cases])
    shown.write(command, lambda file, text: extremes.write_report(file, rows, text))
    figures = [row.as_dict() for row in rows]
    shown.show(figures, lambda: extremes.print_stability(rows), written=(shown.report,), digits=9)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED


def converge(study: str = DEFAULT_STUDY, *, minutes: float = 10.0, shown: Options = _NOTHING) -> int:
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
    from fea.verify import converge as comparison

    require_positive("--minutes", minutes)
    loaded = load_study(study)
    loaded.require_plausible()
    with stages(silent=shown.quiet or shown.json) as listener:
        result = comparison.converge(loaded, minutes, listener)
    command = f"fea converge {study} --minutes {minutes:g}"
    shown.write(command, lambda file, text: comparison.write_report(file, result, text))
    figures = [row.as_dict() for row in result.rows]
    shown.show(figures, lambda: comparison.print_comparison(result), written=(shown.report,))
    return 0


def reproduce(source: str = "all", *, shown: Options = _NOTHING) -> int:
    """Compare published figures with computed ones: every printed cell, and why it differs.

    Parameters
    ----------
    source
        leon-2001, columba-2022, molina-2024 or all.
    """
    from fea.verify.reproduce import report as comparison
    from fea.verify.reproduce.tables import summarise

    tables = comparison.reproduce(source)
    shown.write(f"fea reproduce {source}", lambda file, text: comparison.write_report(file, tables, text))
    figures = [figure.as_dict() for table in tables for figure in table.figures]
    # The studies print up to ten significant digits; every one is compared.
    shown.show(figures, lambda: comparison.print_reproduction(tables), written=(shown.report,), digits=12)
    return CHECK_FAILED if summarise(tables).unexplained else 0
