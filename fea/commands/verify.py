"""`fea verify`."""

from functools import partial
from pathlib import Path

from fea.commands.comparison import quoted, show
from fea.machine.exit_codes import CHECK_FAILED

_DIGITS = 9


def verify(*cases: str, json: bool = False, report: Path | None = None, quiet: bool = False) -> int:
    """Solve benchmark problems with known answers, with the elements, solver and recovery of a run.

    Parameters
    ----------
    cases
        Cases to solve (le1, le10, le11, lame, goodier, cook, …); default: all of them.
    json
        Print every row as JSON and nothing else.
    report
        Write a Markdown report to this file (.md), with its plot next to it; it also solves every case on
        coarser meshes.
    quiet
        Print nothing.
    """
    from fea.machine.progress import stages
    from fea.output.target import require_report
    from fea.verify.terminal import print_verification
    from fea.verify.verify import verify as compute

    require_report(report)
    with stages(silent=quiet) as listener:
        rows = compute(cases, listener)
        if report is not None:
            from fea.verify.verification_report import write_report

            write_report(report, rows, quoted(" ".join(["fea verify", *cases]), report), listener)
    show(rows, _DIGITS, partial(print_verification, rows), report=report, json=json, quiet=quiet)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED
