"""`fea report`."""

import sys
from pathlib import Path


def report(run: Path, *, threads: int | None = None, json: bool = False, quiet: bool = False) -> None:
    """Write the report of an earlier run: the whole analysis in one file, with the rod in 3-D.

    Parameters
    ----------
    run
        The folder of a run, such as results/leon-2001-6000rpm, or that of a run at several speeds. The
        report is report.html in the folder of each speed.
    threads
        Number of solver threads; default: all processors.
    json
        Print what was written as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.machine.threads import limit_threads

    limit_threads(threads)

    from fea.machine.progress import stages
    from fea.output.target import near
    from fea.runs.report_run import report_run

    with stages(silent=quiet or json) as listener:
        reports = report_run(run, listener)
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text({"files": [str(path) for path in reports]}))
    elif not quiet:
        for path in reports:
            sys.stdout.write(f"Wrote {near(path)}\n")
