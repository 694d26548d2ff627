"""The reproduction on the terminal and as a Markdown report: tables, misprints, counts."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fea.base.units import DEG, RPM
from fea.output.plots.figure import new_figure
from fea.output.terminal.prose import print_lines, terminal
from fea.study.traces import shipped_trace
from fea.verify.layout import Line, explanation, markdown, print_table, write_document
from fea.verify.reproduce import columba, leon, molina
from fea.verify.reproduce.tables import (
    PrintedColumn,
    PrintedFigure,
    PrintedQuantity,
    PrintedTable,
    PublishedStudy,
    Status,
    misprinted,
    summarise,
)
from geometry.errors import require
from loads.crank_cycle import CrankCycle

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_PRINTED = {"marker": "o", "markersize": 3.5, "linestyle": "none", "color": "#c0392b"}


def _draw(study: PublishedStudy) -> "Figure":
    """Draw printed cells as dots over the exact curve and, where it is given, that of the printed formula."""
    drawing = study.data["drawing"]
    panels, columns = drawing["panel"], drawing["columns"]
    figure = new_figure(*drawing["inches"])
    grid = figure.subplots(-(-len(panels) // columns), columns).ravel()
    for axes, panel in zip(grid, panels, strict=True):
        quantity, last, scale = PrintedQuantity(**panel["quantity"]), panel["last"], panel.get("scale", 1.0)
        (rpm,) = quantity.rpm
        fine = PrintedColumn.at(np.linspace(0, last, 721))
        exact = scale * study.evaluate(quantity.corrected, fine, rpm)
        axes.plot(fine.degrees, exact, label="corrected", color="#1f4e79", linewidth=1.6)
        if quantity.cells:
            cells = study.printed(quantity, rpm)
            axes.plot(cells.degrees, scale * cells.values, label="published", **_PRINTED)
        if quantity.published:
            formula = study.evaluate(quantity.published, fine, rpm)
            axes.plot(fine.degrees, scale * formula, color="#c0392b", linewidth=0.8, label="as published")
        axes.set_title(study.text(quantity.name, rpm), fontsize=10)
        axes.set(xlabel="crank angle, °", ylabel=quantity.unit, xlim=(0, last))
        axes.set_xticks(range(0, last + 1, last // 4))
        axes.axhline(0, color="0.6", linewidth=0.7)
        axes.grid(alpha=0.3)
    grid[0].legend(frameon=False, fontsize=8)
    figure.suptitle(drawing["title"])
    return figure


SOURCES: dict[str, PublishedStudy] = {study.STUDY.source: study.STUDY for study in (leon, columba, molina)}


def reproduce(source: str) -> list[PrintedTable]:
    """Compare every printed figure of a study, or of all of them.

    Raises `InvalidValue`: there is no such study.
    """
    known = [*SOURCES, "all"]
    require(source in known, "SOURCE", source, f"must be one of {', '.join(known)}")
    return [table for name in SOURCES if source in ("all", name) for table in SOURCES[name].tables()]


_WORD = 13  # length of the longest word in a table's name
_FURTHEST = "largest error (published → corrected)"


def print_reproduction(tables: Sequence[PrintedTable]) -> None:
    """Print one line per printed table, the misprints and the counts."""
    header = ("table", "cells", "agree", "expl.", "wrong", _FURTHEST)
    for source, of_study in groupby(tables, key=lambda table: table.source):
        study, rows = list(of_study), list[Line]()
        for table in study:
            counts = summarise([table])
            numbers = (counts.compared, counts.agrees, counts.explained + counts.named, counts.wrong)
            rows.append(((f"{table.name}  {table.title}", *map(str, numbers), _furthest(table)), ""))
        misprints = [f"  {line}" for line in _misprint_lines(study)]
        heading = (
            ["Errors in single cells (rounded intermediate figures are not listed):"] if misprints else []
        )
        print_table(header, rows, words=("table", _FURTHEST), title=source, longest=_WORD, end=heading)
        print_lines(terminal(), [*misprints, ""])
    print_lines(terminal(), [str(summarise(tables))], "bold")
    print_lines(terminal(), ["All rows: use --json. Report with plots: use --report FILE.md"], "dim")


def _furthest(table: PrintedTable) -> str:
    worst = table.worst
    if worst is None or worst.published is None:
        return "–"
    at = f" at {worst.at}" if worst.at else ""
    return f"{worst.published:.4g} → {worst.corrected:.4g}{_unit(worst)}{at}"


def _unit(figure: PrintedFigure) -> str:
    return "" if figure.unit == "1" else f" {figure.unit}"


def _misprint_lines(tables: Sequence[PrintedTable]) -> Iterator[str]:
    """One line per error, with the places where it occurs."""
    figures = [f for f in misprinted(tables) if not (_is_rounding(f) and f.status is Status.EXPLAINED)]
    for (name, quantity, what), same in groupby(figures, key=lambda f: (f.table, f.quantity, _what(f))):
        places = " and ".join(figure.at for figure in same)
        yield ", ".join(filter(None, [name, quantity, places])) + f": {what}"


def _is_rounding(figure: PrintedFigure) -> bool:
    return figure.slip is not None and figure.slip.is_rounding


def _what(figure: PrintedFigure) -> str:
    if figure.slip is None or figure.status is Status.UNEXPLAINED:
        return f"UNEXPLAINED: {figure.published:.10g}, but the formula gives {figure.as_published:.10g}"
    return figure.slip.text


def write_report(path: Path, tables: Sequence[PrintedTable], command: str) -> None:
    """Write the report of the `tables`, which the `command` makes, with its plots next to it."""
    parts = [f"**{summarise(tables)}**", explanation("reproduce")]
    for source, of_study in groupby(tables, key=lambda table: table.source):
        study = list(of_study)
        plot = path.with_name(f"{path.stem}-{source}.png")
        _draw(SOURCES[source]).savefig(plot, dpi=110)
        described = SOURCES[source].data
        remarks = [f"- *{table.name}*: {remark}" for table in study for remark in table.remarks]
        parts += [f"## {described['title']}", _counts(study), f"![{described['caption']}]({plot.name})"]
        parts += ["### What is wrong with the tables", "\n".join(remarks)]
        parts += ["### Errors in single cells", *_misprints(study)]
        parts += ["### The largest error of each quantity", _largest(study)]
        if source == leon.SOURCE:
            parts += ["### Effect of the bore", explanation("reproduce-bore"), _sensitivity()]
    write_document(path, "Published figures against computed ones", command, parts)


def _counts(tables: Sequence[PrintedTable]) -> str:
    rows = []
    for table in tables:
        counts, worst = summarise([table]), table.worst
        far = "–"
        if worst is not None:
            where = ", ".join(filter(None, [worst.quantity, worst.at]))
            far = f"{where}: {_shown(worst.published)} → {_shown(worst.corrected)}{_unit(worst)}"
        rows.append((table.name, table.title, *map(str, counts), far))
    numbers = ("cells", "agree", "explained", "named", "unexplained", "wrong")
    return markdown(("table", "content", *numbers, _FURTHEST), rows)


def _misprints(tables: Sequence[PrintedTable]) -> Iterator[str]:
    figures = misprinted(tables)
    single = [figure for figure in figures if not _is_rounding(figure)]
    rounded = [figure for figure in figures if _is_rounding(figure)]
    header = ("table", "quantity", "at", "published", "as published", "explanation")
    rows = []
    for figure in single:
        unexplained = figure.status is Status.UNEXPLAINED or figure.slip is None
        what = "**unexplained**" if unexplained else _what(figure)
        both = _shown(figure.published), _shown(figure.as_published)
        rows.append((figure.table, figure.quantity, figure.at, *both, what))
    yield markdown(header, rows) if rows else "None."
    if rounded:
        largest = max(figure.difference for figure in rounded)
        yield (
            f"In addition, {len(rounded)} cells were computed with an intermediate figure rounded or "
            f"truncated by hand (largest effect {largest:.3g} {rounded[0].unit}); `--json` lists them."
        )


def _largest(tables: Sequence[PrintedTable]) -> str:
    header = ("table", "quantity", "at", "unit", "published", "as published", "corrected", "cause")
    rows = []
    for f in (figure for table in tables for figure in table.wrong_of_each_quantity):
        values = (_shown(value) for value in (f.published, f.as_published, f.corrected))
        rows.append((f.table, f.quantity, f.at, f.unit, *values, f.cause))
    return markdown(header, rows) if rows else "None differs."


# As printed, from the two litres of the engine, and from the piston area of table 7; mm.
_BORES = (76.0, 82.3, 87.0)


def _sensitivity() -> str:
    """The peak forces of León's rod with each of the bores."""
    peaks: dict[tuple[int, str], dict[float, str]] = {}
    for rpm in leon.SPEEDS:
        for bore in _BORES:
            cycle = CrankCycle(leon.engine(bore), leon.ROD, shipped_trace(leon.SOURCE), rpm * RPM)
            for case in cycle.peaks.cases:
                axial = max(float(case.pin_axial), float(case.crank_axial), key=abs)
                force = float(case.wall) if case.name == "side" else axial
                text = f"{_shown(round(force / 1e3, 2))} at {float(case.crank_angle) / DEG:.0f}°"
                if case.name in _PEAKS:
                    peaks.setdefault((rpm, _PEAKS[case.name]), {})[bore] = text
    none = "does not occur"
    rows = [(str(rpm), name, *(own.get(bore, none) for bore in _BORES)) for (rpm, name), own in peaks.items()]
    return markdown(("rpm", "peak", *(f"bore {bore:g} mm" for bore in _BORES)), rows)


_PEAKS = {"tension": "tension", "compression": "compression", "side": "wall force"}


def _shown(value: float | None) -> str:
    """Seven significant digits, without a negative zero."""
    return "–" if value is None else f"{value + 0.0:.7g}".replace("-", "−")
