"""`fea stability`."""

from functools import partial
from pathlib import Path

from fea.commands.comparison import quoted, show
from fea.machine.exit_codes import CHECK_FAILED

_DIGITS = 9


def stability(*cases: str, json: bool = False, report: Path | None = None, quiet: bool = False) -> int:
    """Solve ill-conditioned and extreme cases with known answers: no wrong result may pass unnoticed.

    Parameters
    ----------
    cases
        Cases to solve (contrast, slender, incompressible, …); default: all of them.
    json
        Print every row as JSON and nothing else.
    report
        Write a Markdown report to this file (.md), with its plot next to it.
    quiet
        Print nothing.
    """
    from fea.machine.progress import stages
    from fea.output.target import require_report
    from fea.verify.stability.stability import stability as compute
    from fea.verify.stability.terminal import print_stability

    require_report(report)
    with stages(silent=quiet) as listener:
        rows = compute(cases, listener)
    if report is not None:
        from fea.verify.stability.report import write_report

        write_report(report, rows, quoted(" ".join(["fea stability", *cases]), report))
    show(rows, _DIGITS, partial(print_stability, rows), report=report, json=json, quiet=quiet)
    return 0 if all(row.passed for row in rows) else CHECK_FAILED
