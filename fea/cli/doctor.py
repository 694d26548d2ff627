"""`fea doctor`."""

from rich.console import Console
from rich.table import Table

from fea.cli.options import Json, print_json


def doctor(*, json: Json = False) -> int:
    """Check what this machine needs to run fea, and what is installed."""
    from fea.machine.doctor import examine

    findings = examine()
    ready = all(finding.good or not finding.needed for finding in findings)
    if json:
        print_json([vars(finding) for finding in findings])
    else:
        console = Console(highlight=False)
        table = Table(box=None, pad_edge=False)
        headings = ["", "what", "found"]
        if not all(finding.good for finding in findings):
            headings.append("remedy")
        for heading in headings:
            table.add_column(heading, overflow="fold")
        for finding in findings:
            mark = "ok" if finding.good else "missing" if finding.needed else "no"
            cells = (mark, finding.what, finding.found, "" if finding.good else finding.remedy)
            table.add_row(*cells[: len(table.columns)])
        console.print(table)
        missing = "Something that fea needs is missing: see the remedies above."
        console.print("Everything that fea needs is installed." if ready else missing)
    return 0 if ready else 7
