"""`fea converge`."""

from functools import partial
from pathlib import Path

from fea.commands.comparison import quoted, show
from fea.study.study import DEFAULT_STUDY

_DIGITS = 6


def converge(
    study: str = DEFAULT_STUDY,
    *,
    minutes: float = 10.0,
    json: bool = False,
    report: Path | None = None,
    quiet: bool = False,
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
    json
        Print every row as JSON and nothing else.
    report
        Write a Markdown report to this file (.md), with its plot next to it.
    quiet
        Print nothing.
    """
    from fea.machine.progress import stages
    from fea.output.target import require_report
    from fea.study.study import load_study
    from fea.verify.converge.advice import advice
    from fea.verify.converge.converge import converge as compute
    from fea.verify.converge.terminal import print_comparison
    from geometry.invalid import require_positive

    require_positive("--minutes", minutes)
    asked = load_study(study)
    require_report(report)
    with stages(silent=quiet or json) as listener:
        found = compute(asked, minutes, listener)
    if report is not None:
        from fea.verify.converge.report import write_report

        write_report(report, found, quoted(f"fea converge {study} --minutes {minutes:g}", report))
    rod = [row for row in found.rows if row.computation.problem == "rod"]
    advised = advice(rod, found.references["rod"].uncertainty_percent)
    table = partial(print_comparison, found.rows, advised)
    show(found.rows, _DIGITS, table, report=report, json=json, quiet=quiet)
    return 0
