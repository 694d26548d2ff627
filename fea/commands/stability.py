"""`fea stability`."""

import sys
from pathlib import Path

CHECK_FAILED = 5
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

    require_report(report)
    with stages(silent=quiet) as listener:
        rows = compute(cases, listener)
    if report is not None:
        from fea.verify.stability.report import write_report

        target = report.name if report.is_absolute() else report.as_posix()
        write_report(report, rows, " ".join(["fea stability", *cases, f"--report {target}"]))
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text([row.as_dict() for row in rows], _DIGITS))
    elif not quiet:
        from fea.verify.stability.terminal import print_stability

        print_stability(rows)
        if report is not None:
            sys.stdout.write(f"Wrote {report}\n")
    return 0 if all(row.passed for row in rows) else CHECK_FAILED
