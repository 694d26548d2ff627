"""What a run at several speeds says at its end."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.analysis.speed_map import rounded, speed_map
from fea.output.notes import gathered
from fea.output.target import near
from fea.output.terminal.figures import Summary, bar, factor, least_factor, number, worst_case


def print_sweep(console: Console, runs: Sequence[tuple[Path, Summary]]) -> None:
    """Print the worst case of each speed, and from which speed on the rod fails."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for title in ("rpm", "worst\ncase", "crank\n°", "von Mises\nMPa", "±\n%", "safety\nfactor", ""):
        table.add_column(title, justify="left" if title.startswith("worst") else "right")
    for _, summary in runs:
        case = worst_case(summary)
        result = summary["results"][case]
        table.add_row(
            number(summary["rpm"], "g"),
            case,
            number(summary["loads"][case].get("crank_deg"), ".0f"),
            number(result.get("max_von_mises_MPa"), ".1f"),
            bar(result.get("error_percent")),
            factor(result.get("min_safety_factor")),
            "" if summary["trusted"] else "check failed",
        )
    console.print(f"{runs[0][1]['study']}: {len(runs)} speeds", markup=False, style="bold")
    console.print(table)
    summaries = [summary for _, summary in runs]
    for line in (*_sweep_doubts(summaries), *_critical(summaries)):
        console.print(line, markup=False, soft_wrap=not console.is_terminal)
    folder = runs[0][0].parent
    said = f"Written: {near(folder)}/map.csv, and a directory for each speed."
    drawn = [f"{summary['rpm']:g}" for place, summary in runs if any(place.glob("*.vtu"))]
    if len(drawn) < len(runs):
        said += f" Fields are written at {', '.join(drawn)} rpm, the worst; figures at the others."
    for line in (said, *_next(runs)):
        console.print(line, markup=False, soft_wrap=True)


def _next(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
    """Return what to look at: the map where there is one, and the worst case of all that is written."""
    charts = [near(runs[0][0].parent / "cycle_map.png")]
    said = [f"look at {chart}" for chart in charts if chart.is_file()]
    files = {place / f"{worst_case(summary)}.vtu": least_factor(summary) for place, summary in runs}
    written = {file: least for file, least in files.items() if file.is_file()}
    if written:
        said.append(f"fea view {near(min(written, key=lambda file: written[file]))}")
    return [f"Next: {', or '.join(said)}."] if said else []


def _sweep_doubts(summaries: Sequence[Summary]) -> list[str]:
    """Return what the reader must know before believing the figures, once for all speeds."""
    verdicts = [summary["results"][worst_case(summary)].get("verdict") for summary in summaries]
    loose = verdicts.count("not converged")
    speeds = "1 speed" if loose == 1 else f"{loose} speeds"
    doubts = [f"Not converged: the worst case of {speeds} (try --tolerance 5 or less)"] if loose else []
    return [*doubts, *gathered((summary["rpm"], summary.get("notes", [])) for summary in summaries)]


def _critical(summaries: Sequence[Summary]) -> list[str]:
    """Return from which speed the rod fails, where the whole cycle was worked out."""
    found = speed_map(summaries)
    if found is None:
        return []
    said = [
        f"{mode} {'within no speed' if rpm is None else f'from {rounded(rpm)} rpm'}"
        for mode, rpm in found.critical.items()
        if not np.isnan(found.columns[f"{mode}_safety_factor"]).all()
    ]
    return [f"Whole cycle, safety factor below 1: {', '.join(said)} (cycle_map.csv, cycle_map.png)."]
