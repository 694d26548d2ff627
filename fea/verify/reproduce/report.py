"""The reproduction as a Markdown report."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from fea.output.text import make_directory, write_text
from fea.verify.reproduce import leon_engine
from fea.verify.reproduce.plots import draw
from fea.verify.reproduce.row import Row, Status
from fea.verify.reproduce.sensitivity import BORES, PeakLoad, bore_sensitivity
from fea.verify.reproduce.summary import misprinted, summarise, verdict, worst, worst_of_each_quantity
from fea.verify.reproduce.table import Table

_STUDIES = {
    "leon-2001": "León 2001: finite-element analysis of a connecting rod (UNAM)",
    "columba-2022": "Columba 2022: dynamic forces, Suzuki Forsa 1 (ESPE Latacunga)",
    "molina-2024": "Molina et al. 2024: kinematics of a 2000 cc engine",
}

_READING = """\
**Published** is the figure as printed. **As published** is the printed formula, including the error made in
evaluating it, applied to the printed intermediate figures: it shows where the figure comes from.
**Corrected** is the correct figure: exact kinematics and Newton–Euler dynamics in closed form.

A printed cell *agrees* if it is within one unit of its last digit of *as published* (some tables are
truncated, not rounded). It is *explained* if a known error or rounding of that single cell reproduces it, and
*named* if it is known to be wrong but cannot be derived from the source. *Wrong* counts the printed cells
that differ from the corrected figure by more than one unit of their last digit.
"""


def write_report(path: Path, tables: Sequence[Table], command: str) -> None:
    """Write the report, with its plots next to it.

    Parameters
    ----------
    path
        The .md file.
    tables
        The compared tables.
    command
        The command that makes the report.
    """
    make_directory(path.parent)
    plots = draw(tables, path.parent, path.stem)
    parts = [_head(tables, command)]
    for source in dict.fromkeys(table.source for table in tables):
        own = [table for table in tables if table.source == source]
        drawn, caption = plots[source]
        parts += [_study(source, own), f"![{caption}]({os.path.relpath(drawn, path.parent)})\n"]
        parts += [_remarks(own), _misprints(own), _important(own)]
        if source == leon_engine.SOURCE:
            parts += [_sensitivity()]
    write_text(path, "\n".join(parts))


def _head(tables: Sequence[Table], command: str) -> str:
    return "\n\n".join(
        [
            "# Published figures against computed ones",
            f"Made by `{command}`.",
            f"**{verdict(tables)}**",
            _READING,
        ]
    )


def _study(source: str, tables: Sequence[Table]) -> str:
    counts = ("cells", "agree", "explained", "named", "unexplained", "wrong")
    header = ("table", "content", *counts, "largest error (published → corrected)")
    return f"## {_STUDIES[source]}\n\n" + _markdown(header, [_summary_line(table) for table in tables])


def _summary_line(table: Table) -> tuple[str, ...]:
    counts, row = summarise([table]), worst(table)
    far = "–"
    if row is not None:
        where = ", ".join(filter(None, [row.quantity, row.at]))
        unit = "" if row.unit == "1" else f" {row.unit}"
        far = f"{where}: {shown(row.published)} → {shown(row.corrected)}{unit}"
    agreement = (counts.compared, counts.agrees, counts.explained, counts.named, counts.unexplained)
    return (table.name, table.title, *(str(number) for number in (*agreement, counts.wrong)), far)


def _remarks(tables: Sequence[Table]) -> str:
    lines = [f"- *{table.name}*: {remark}" for table in tables for remark in table.remarks]
    return "### What is wrong with the tables\n\n" + "\n".join(lines) + "\n"


def _misprints(tables: Sequence[Table]) -> str:
    rows = misprinted(tables)
    single = [row for row in rows if row.slip is None or not row.slip.is_rounding]
    rounded = [row for row in rows if row.slip is not None and row.slip.is_rounding]
    text = "### Errors in single cells\n\n"
    if single:
        header = ("table", "quantity", "at", "published", "as published", "explanation")
        text += _markdown(header, [_misprint_line(row) for row in single])
    else:
        text += "None.\n"
    if rounded:
        largest = max(row.difference for row in rounded)
        text += (
            f"\nIn addition, {len(rounded)} cells were computed with an intermediate figure rounded or "
            f"truncated by hand (largest effect {largest:.3g} {rounded[0].unit}); `--json` lists them.\n"
        )
    return text


def _misprint_line(row: Row) -> tuple[str, ...]:
    what = "**unexplained**" if row.status is Status.UNEXPLAINED or row.slip is None else row.slip.text
    return (row.table, row.quantity, row.at, shown(row.published), shown(row.as_published), what)


def _important(tables: Sequence[Table]) -> str:
    header = ("table", "quantity", "at", "unit", "published", "as published", "corrected", "cause")
    rows = [row for table in tables for row in worst_of_each_quantity(table)]
    lines = [
        (
            row.table,
            row.quantity,
            row.at,
            row.unit,
            shown(row.published),
            shown(row.as_published),
            shown(row.corrected),
            row.cause,
        )
        for row in rows
    ]
    title = "### The largest error of each quantity\n\n"
    return title + (_markdown(header, lines) if lines else "None differs.\n")


def _sensitivity() -> str:
    found = bore_sensitivity()
    cases = dict.fromkeys((load.rpm, load.case) for load in found)
    lines = []
    for rpm, case in cases:
        by_bore = {load.bore: load for load in found if (load.rpm, load.case) == (rpm, case)}
        cells = [_peak(by_bore[bore]) if bore in by_bore else "does not occur" for bore in BORES]
        lines.append((str(rpm), "wall force" if case == "side" else case, *cells))
    header = ("rpm", "peak", *(f"bore {bore:g} mm" for bore in BORES))
    return (
        "### Effect of the bore\n\n"
        "The bore is printed as 76 mm; two litres need 82.3 mm, and table 7 was computed with 87 mm.\n"
        "Corrected peak axial force at the worse end (tension positive) and peak wall force, in kN:\n\n"
        + _markdown(header, lines)
    )


def _peak(load: PeakLoad) -> str:
    force = load.wall if load.case == "side" else load.axial
    return f"{shown(round(force / 1e3, 2))} at {load.crank_deg:.0f}°"


def shown(value: float | None) -> str:
    """Seven significant digits, without a negative zero."""
    return "–" if value is None else f"{value + 0.0:.7g}".replace("-", "−")


def _markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    escaped = ([cell.replace("|", r"\|") for cell in line] for line in lines)
    return "\n".join("| " + " | ".join(line) + " |" for line in escaped) + "\n"
