"""What a run at several speeds says at its end."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from fea.analysis.figures import Summary
from fea.analysis.speed_map import JOINT_OPENING, MODES, rounded, speed_map
from fea.analysis.survival import Answer
from fea.judge.verdict import Verdict
from fea.output.target import near
from fea.output.terminal.run_lines import bar, endurance_lines, factor, life_lines, number, plain_table
from fea.output.text import gathered


def print_sweep(console: Console, runs: Sequence[tuple[Path, Summary]]) -> None:
    """Print the worst case of each speed, and from which speed on the rod fails."""
    titles = ("rpm", "worst\ncase", "crank\n°", "von Mises\nMPa", "±\n%", "safety\nfactor", "")
    table = plain_table(titles, (_worst(summary) for _, summary in runs), left=("worst\ncase",))
    summaries = [summary for _, summary in runs]
    console.print(_headline(summaries), markup=False, style="bold", soft_wrap=True)
    console.print(table)
    for line in (*_sweep_doubts(summaries), *_critical(summaries), *life_lines(summaries[0].life)):
        console.print(line, markup=False, soft_wrap=not console.is_terminal)
    for line in (_written(runs), *_next(runs)):
        console.print(line, markup=False, soft_wrap=True)


def _worst(summary: Summary) -> tuple[str, ...]:
    case = summary.worst_case
    result = summary.results[case]
    return (
        number(summary.rpm, "g"),
        case,
        number(summary.loads[case].crank_deg, ".0f"),
        number(result.max_von_mises_MPa, ".1f"),
        bar(result.error_percent),
        factor(result.min_safety_factor),
        "" if summary.trusted else "check failed",
    )


def _headline(summaries: Sequence[Summary]) -> str:
    gravity = list(Answer)

    def rank(summary: Summary) -> tuple[int, float]:
        return -gravity.index(Answer(summary.survival.answer)), summary.survival.assured_safety_factor

    worst = min(summaries, key=rank)
    return f"{worst.title}, the worst of {len(summaries)} speeds: {worst.survival.text}"


def _written(runs: Sequence[tuple[Path, Summary]]) -> str:
    said = f"Written: {near(runs[0][0].parent)}/map.csv, and a directory for each speed."
    drawn = [f"{summary.rpm:g}" for _, summary in runs if _result(summary) is not None]
    if len(drawn) == len(runs):
        return said
    return f"{said} Fields are written at {', '.join(drawn)} rpm, the worst speeds; figures at the others."


def _result(summary: Summary) -> str | None:
    name = f"{summary.worst_case}.vtu"
    return name if name in (summary.files or ()) else None


def _next(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
    """Return what to look at: the map where there is one, and the worst case of all that is written."""
    folder, summary = runs[0]
    charts = [name for name in summary.shared_files or () if name.endswith(".png")]
    said = [f"look at {near(folder.parent / chart)}" for chart in charts]
    written = [(place, found, _result(found)) for place, found in runs if _result(found) is not None]
    if written:
        place, _, file = min(written, key=lambda run: run[1].min_safety_factor)
        said.append(f"fea view {near(place / str(file))}")
    return [f"Next: {', or '.join(said)}."] if said else []


def _sweep_doubts(summaries: Sequence[Summary]) -> list[str]:
    """Return what the reader must know before believing the figures, once for all speeds."""
    verdicts = [summary.results[summary.worst_case].verdict for summary in summaries]
    loose = verdicts.count(Verdict.NOT_CONVERGED)
    speeds = "1 speed" if loose == 1 else f"{loose} speeds"
    remedy = "a smaller --tolerance" if summaries[0].passes else "--tolerance 5 or less"
    remedy = "a finer mesh" if summaries[0].model.mesh_from_file else remedy
    doubts = [f"Not converged: the worst case of {speeds} (try {remedy})"] if loose else []
    return [*doubts, *gathered((summary.rpm or 0.0, [*map(str, summary.notes)]) for summary in summaries)]


def _critical(summaries: Sequence[Summary]) -> list[str]:
    """Return from which speed the joint opens and, with the whole cycle, from which the rod fails."""
    opening, found = _opening(summaries[0]), speed_map(summaries)
    if found is None:
        return opening
    said = [
        f"{mode} {'at no speed' if rpm is None else f'from {rounded(rpm)} rpm'}"
        for mode, rpm in found.critical.items()
        if mode in MODES and not np.isnan(found.columns[f"{mode}_safety_factor"]).all()
    ]
    line = f"Whole cycle, safety factor below 1: {', '.join(said)} (cycle_map.csv, cycle_map.png)."
    envelope = summaries[0].envelope
    return [*opening, line, *([] if envelope is None else endurance_lines(envelope))]


def _opening(summary: Summary) -> list[str]:
    critical = summary.critical_speeds_rpm or {}
    if JOINT_OPENING not in critical:
        return []
    rpm = critical[JOINT_OPENING]
    return [f"The joint opens at the bore {'at no speed' if rpm is None else f'from {rounded(rpm)} rpm'}."]
