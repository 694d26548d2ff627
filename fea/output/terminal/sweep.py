"""What a run at several speeds says at its end."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from fea.analysis.figures import Summary
from fea.analysis.speed_map import JOINT_OPENING, MODES, rounded, speed_map
from fea.analysis.survival import Answer
from fea.base.note import Note, NoteKind, by_consequence
from fea.judge.verdict import Verdict
from fea.output.target import near
from fea.output.terminal.answer import governs, levers, life, of_kind, singular
from fea.output.terminal.prose import counted, fitting, in_full, print_lines, print_paths, unusual
from fea.output.terminal.run_lines import bar, endurance_lines, factor, life_lines, number, plain_table
from fea.output.text import gathered, some_speeds


def print_sweep(console: Console, runs: Sequence[tuple[Path, Summary]], *, verbose: bool = False) -> None:
    """Print the worst case of each speed, and from which speed on the rod fails."""
    titles = ("rpm", "worst\ncase", "crank\n°", "von Mises\nMPa", "±\n%", "safety\nfactor", "")
    rising = sorted((summary for _, summary in runs), key=lambda summary: summary.rpm or 0.0)
    table = plain_table(titles, map(_row, rising), left=("worst\ncase",))
    summaries = [summary for _, summary in runs]
    gravity = list(Answer)

    def rank(summary: Summary) -> tuple[int, float]:
        return -gravity.index(Answer(summary.survival.answer)), summary.survival.assured_safety_factor

    worst = min(summaries, key=rank)
    headline = f"{worst.title}, the worst of {len(summaries)} speeds: {worst.survival.text}"
    noted = gathered((one.rpm or 0.0, (*one.notes, *one.left_out)) for one in summaries)
    notes, left_out = by_consequence(noted)
    print_lines(console, [headline], "bold")
    print_lines(console, unusual(notes))
    console.print(table)
    paths = [*_written(runs), *_next(runs)]
    if verbose:
        lines = [*_doubts(summaries), *singular(worst), governs(worst), *levers(worst)]
        lines += _critical(summaries)
        lines += [] if worst.envelope is None else endurance_lines(worst.envelope)
        lines += [*life_lines(worst.life), *in_full((*notes, *left_out))]
    else:
        more = counted(notes, left_out)
        said = _statements(summaries, worst, notes)
        lines = [*fitting(said, [more], paths, console.width), more]
    print_lines(console, lines)
    print_paths(console, paths)


def _statements(summaries: Sequence[Summary], worst: Summary, notes: Sequence[Note]) -> Iterator[str]:
    """Yield what a reader should know, by consequence, as `answer.statements` does for one speed."""
    yield from _doubts(summaries)
    yield from of_kind(notes, NoteKind.DOUBT)
    yield from singular(worst)
    yield from life(worst.life)
    yield from _critical(summaries)
    yield governs(worst)
    yield from levers(worst)
    yield from of_kind(notes, NoteKind.WARNING)


def _doubts(summaries: Sequence[Summary]) -> list[str]:
    failed = {
        f"{one.rpm:g}": name for one in summaries for name, check in one.checks.items() if not check.passed
    }
    checks, speeds = ", ".join(dict.fromkeys(failed.values())), some_speeds(list(failed))
    said = [f"NOT TO BE TRUSTED: failed checks at {speeds}: {checks}."] if failed else []
    verdicts = [summary.results[summary.worst_case].verdict for summary in summaries]
    loose = verdicts.count(Verdict.NOT_CONVERGED)
    number_of = "1 speed" if loose == 1 else f"{loose} speeds"
    remedy = "a smaller --tolerance" if summaries[0].passes else "--tolerance 5 or less"
    remedy = "a finer mesh" if summaries[0].model.mesh_from_file else remedy
    return [*said, f"Not converged: the worst case of {number_of} (try {remedy})"] if loose else said


def _row(summary: Summary) -> tuple[str, ...]:
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


def _written(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
    said = f"Written: {near(runs[0][0].parent)}/map.csv, and a directory for each speed."
    drawn = [f"{summary.rpm:g}" for _, summary in runs if _result(summary) is not None]
    if len(drawn) == len(runs):
        return [said]
    return [said, f"Fields are written at the worst speeds, {', '.join(drawn)} rpm."]


def _result(summary: Summary) -> str | None:
    name = f"{summary.worst_case}.vtu"
    return name if name in (summary.files or ()) else None


def _next(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
    """Return what to look at: the map where there is one, and the worst case of all that is written."""
    folder, summary = runs[0]
    charts = [name for name in summary.shared_files or () if name.endswith(".png")]
    looks = [f"Next: look at {near(folder.parent / chart)}" for chart in charts]
    written = [(place, found, _result(found)) for place, found in runs if _result(found) is not None]
    if not written:
        return looks
    place, _, file = min(written, key=lambda run: run[1].min_safety_factor)
    return [*looks, f"{'Then' if looks else 'Next'}: fea view {near(place / str(file))}"]


def _critical(summaries: Sequence[Summary]) -> list[str]:
    critical, found = summaries[0].critical_speeds_rpm or {}, speed_map(summaries)
    opening = []
    if JOINT_OPENING in critical:
        rpm = critical[JOINT_OPENING]
        opening = [
            f"The joint opens at the bore {'at no speed' if rpm is None else f'from {rounded(rpm)} rpm'}."
        ]
    if found is None:
        return opening
    said = [
        f"{mode} {'at no speed' if rpm is None else f'from {rounded(rpm)} rpm'}"
        for mode, rpm in found.critical.items()
        if mode in MODES and not np.isnan(found.columns[f"{mode}_safety_factor"]).all()
    ]
    line = f"Whole cycle, safety factor below 1: {', '.join(said)}."
    return [*opening, line]
