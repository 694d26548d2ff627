"""`fea doctor`."""

import sys

from rich.console import Console
from rich.table import Table


def doctor(*, json: bool = False) -> int:
    """What this machine can and cannot do.

    Parameters
    ----------
    json
        Print the findings as JSON.
    """
    from fea.machine.doctor import examine

    findings = examine()
    if json:
        from fea.output.summary import json_text

        sys.stdout.write(json_text([vars(finding) for finding in findings]))
    else:
        console = Console(highlight=False)
        table = Table(box=None, pad_edge=False)
        for heading in ("", "what", "found", "remedy"):
            table.add_column(heading, overflow="fold")
        for finding in findings:
            mark = "ok" if finding.good else "missing" if finding.needed else "no"
            table.add_row(mark, finding.what, finding.found, "" if finding.good else finding.remedy)
        console.print(table)
    return 0 if all(finding.good or not finding.needed for finding in findings) else 7
