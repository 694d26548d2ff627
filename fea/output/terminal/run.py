"""What a run at one or several speeds says at its end: a table, what was written, what to do next."""

from collections.abc import Collection, Iterator, Sequence
from itertools import compress
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from fea.analysis.figures import CaseFigures, LoadFigures, Summary
from fea.analysis.many_speeds import JOINT_OPENING, MODES, rounded, speed_map
from fea.base.note import Note, NoteKind, by_consequence
from fea.judge.safety_factor import Answer
from fea.judge.verdict import Verdict
from fea.output.report import tables as tabular
from fea.output.report.tables import figure
from fea.output.target import near, picture_name
from fea.output.terminal import answer, prose, run_lines
from fea.output.terminal.answer import assembly_lines, governs, levers, life, of_kind, singular
from fea.output.terminal.prose import counted, fitting, in_full, print_lines, print_paths, unusual
from fea.output.terminal.run_lines import bar, factor, kilo, largest_force, number, place, plain_table
from fea.output.text import gathered, some_speeds
from fea.output.units import in_rows, in_text


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
    heading, tables = [headline, *unusual(notes)], [table]
    if any(summary.film for summary in rising):
        tables.append(_film_table(rising))
    paths = [*_sweep_written(runs), *_sweep_next(runs)]
    if verbose:
        tables += _captioned(tabular.endurance_table(worst), tabular.life_table(worst.life))
        lines = [*_doubts(summaries), *singular(worst), governs(worst), *levers(worst)]
        lines += [*_critical(summaries), *life(worst.life), *in_full((*notes, *left_out))]
    else:
        more = counted(notes, left_out)
        said = _statements(summaries, worst, notes)
        lines = [*fitting(said, [more], paths, console.width), more]
    _print(console, heading, tables, lines, paths)


def _print(
    console: Console, heading: list[str], tables: list[Table], lines: list[str], paths: list[str]
) -> None:
    print_lines(console, heading[:1], "bold")
    print_lines(console, heading[1:])
    for table in tables:
        console.print(table)
    print_lines(console, lines)
    print_paths(console, paths)


def _captioned(*tables: tabular.Table | None) -> list[Table]:
    known = filter(None, tables)
    return [one.printed(gap=0, title=in_text(one.caption), title_justify="left") for one in known]


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
    checked = ((one, name, check) for one in summaries for name, check in one.checks.items())
    failed = {f"{one.rpm:g}": name for one, name, check in checked if not check.passed}
    checks, speeds = ", ".join(dict.fromkeys(failed.values())), some_speeds(list(failed))
    said = [f"NOT TO BE TRUSTED: failed checks at {speeds}: {checks}."] if failed else []
    verdicts = [summary.results[summary.worst_case].verdict for summary in summaries]
    loose = verdicts.count(Verdict.NOT_CONVERGED)
    number_of = "1 speed" if loose == 1 else f"{loose} speeds"
    remedy = "a smaller --tolerance" if summaries[0].passes else "--tolerance 5 or less"
    remedy = "a finer mesh" if summaries[0].model.mesh_from_file else remedy
    return [*said, f"Not converged: the worst case of {number_of} (try {remedy})"] if loose else said


def _row(summary: Summary) -> tuple[str, ...]:
    case, failed = summary.worst_case, "" if summary.trusted else "check failed"
    result, angle = summary.results[case], number(summary.loads[case].crank_deg, ".0f")
    stress = number(result.max_von_mises_MPa, ".1f"), bar(result.error_percent)
    return number(summary.rpm, "g"), case, angle, *stress, factor(result.min_safety_factor), failed


_FILM = {
    "min.\nfilm\nµm": "h_min_um", "±\n%": "h_min_error_percent", "λ": "lambda_min", "max.\nMPa": "p_max_MPa",
    "friction\nW": "power_W", "oil\nl/min": "flow_l_min", "oil\n°C": "temperature_C",
}  # fmt: skip


def _film_table(summaries: Sequence[Summary]) -> Table:
    films = [(number(one.rpm, "g"), *each) for one in summaries for each in (one.film or {}).items()]
    rows = (
        (rpm, end.replace("_", " "), *(figure(getattr(film, key), 3) for key in _FILM.values()), film.verdict)
        for rpm, end, film in films
    )
    return plain_table(("rpm", "bearing", *_FILM, "regime"), rows, left=("bearing", "regime"))


def _sweep_written(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
    said = f"Written: {near(runs[0][0].parent)}/map.csv, and a directory for each speed."
    drawn = [f"{summary.rpm:g}" for _, summary in runs if _result(summary) is not None]
    if len(drawn) == len(runs):
        return [said]
    return [said, f"Fields are written at the worst speeds, {', '.join(drawn)} rpm."]


def _result(summary: Summary) -> str | None:
    name = f"{summary.worst_case}.vtu"
    return name if name in (summary.files or ()) else None


def _sweep_next(runs: Sequence[tuple[Path, Summary]]) -> list[str]:
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


_ENDLESS = 1000
_CASE, _ANGLE, _PLACE, _MOVED = "case", "crank\n°", "at x, y, z\nmm", "displ.\nmm"
_PINS, _WALL = ("pin\nkN", "crank\nkN"), "wall\nkN"
_COLUMNS = (_CASE, _ANGLE, *_PINS, _WALL, "Mises\nMPa", "±\n%", _PLACE, "safety\nfactor", _MOVED)
# Kinds of files that are named first.
_FIRST = (".json", ".toml", ".csv", ".vtu", ".png")
# Gap between columns, whether there is a border, and columns left out, from wide consoles to narrow ones.
_NARROWER: tuple[tuple[int, bool, frozenset[str]], ...] = (
    (1, True, frozenset()),
    (0, True, frozenset()),
    (0, False, frozenset()),
    (0, False, frozenset({_WALL, _MOVED})),
    (0, False, frozenset({*_PINS, _WALL, _MOVED})),
    (0, False, frozenset({_ANGLE, *_PINS, _WALL, _MOVED, _PLACE})),
)


def print_runs(
    runs: Sequence[tuple[Path, Summary]], console: Console | None = None, *, verbose: bool = False
) -> None:
    """Print runs and their folders: at most `prose.MOST_LINES` after the table, unless `verbose`."""
    console = console or prose.terminal()
    if len(runs) == 1:
        _print_run(console, *runs[0], verbose=verbose)
    elif runs:
        print_sweep(console, runs, verbose=verbose)


def case_table(summary: Summary, console: Console) -> Table:
    """Return the load cases of one speed, the worst bold; a narrow console shows fewer columns."""
    tables, endless = [_table(summary, *layout) for layout in _NARROWER], Console(width=_ENDLESS)
    return next((one for one in tables if endless.measure(one).maximum <= console.width), tables[-1])


def _table(summary: Summary, gap: int, border: bool, without: Collection[str]) -> Table:  # noqa: FBT001
    kept = [title not in without for title in _COLUMNS]
    titles = compress(_COLUMNS, kept)
    table = plain_table(titles, (), left={_CASE, _PLACE}, no_wrap=True, gap=gap, show_edge=border)
    largest = largest_force(summary.loads.values())
    for case, result in summary.results.items():
        (cells,) = in_rows(_COLUMNS, [[case, *_cells(summary.loads[case], result, largest)]])
        table.add_row(*compress(cells, kept), style="bold" if case == summary.worst_case else "")
        if result.sharp_edges:
            edge = result.sharp_edges[0]
            stress = number(edge.structural_von_mises_MPa, ".1f"), bar(edge.error_percent)
            judged = *stress, place(edge.at_mm), factor(edge.safety_factor)
            (cells,) = in_rows(_COLUMNS, [[f"  edge {edge.name}", *[""] * 4, *judged, ""]])
            table.add_row(*compress(cells, kept))
    return table


def _print_run(console: Console, folder: Path, summary: Summary, *, verbose: bool) -> None:
    heading = [f"{summary.title}: {summary.survival.text}", *unusual(summary.notes)]
    parts = [] if summary.assembly is None else tabular.assembly_tables(summary.assembly)
    shown = [one for one in parts[1:] if verbose or one.head[0] == _governing(summary)]
    tables = [case_table(summary, console), *(one.printed(no_wrap=True) for one in shown)]
    if verbose:
        tables += _captioned(
            *parts[:1],
            tabular.contact_table(summary),
            None if summary.cycle is None else tabular.cycle_table(summary.cycle),
            tabular.endurance_table(summary),
            tabular.life_table(summary.life),
            *tabular.buckling_tables(summary),
        )
        lines = [
            *answer.failed_checks(summary),
            *answer.not_converged(summary),
            *answer.singular(summary),
            *answer.basis(summary),
            answer.governs(summary),
            *answer.levers(summary),
            *run_lines.sharp_edge_lines(summary),
            *([] if summary.assembly is None else assembly_lines(summary.assembly)),
            *answer.linings(summary),
            *answer.cycle(summary),
            *run_lines.film_lines(summary),
            *life(summary.life),
            *answer.buckling(summary.buckling),
            *in_full((*summary.notes, *summary.left_out)),
            f"{summary.model.nodes} nodes, {_model(summary)}",
        ]
        kinds: dict[str, list[str]] = {}
        for name in summary.files or ():
            kinds.setdefault(Path(name).suffix, []).append(name)
        order = sorted(kinds, key=lambda kind: (_FIRST.index(kind) if kind in _FIRST else len(_FIRST), kind))
        files = (f"  {'  '.join(_shortened(kinds[kind]))}" for kind in order)
        paths = [f"Written to {near(folder)}/", *files, _next(folder, summary)]
    else:
        figures = [_model(summary), counted(summary.notes, summary.left_out)]
        paths = _written(folder, summary, console.width)
        lines = [*fitting(answer.statements(summary), figures, paths, console.width), *figures]
    _print(console, heading, tables, lines, paths)


def _governing(summary: Summary) -> str:
    if summary.survival.mode.endswith(("of the bolts", "of the joint")):
        return "joint"
    weakest = None if summary.governing is None else summary.governing.weakest
    part = "" if weakest is None else weakest.part
    return "shells" if part.endswith("shell") else part


def _cells(load: LoadFigures, result: CaseFigures, largest: float) -> list[str]:
    return [
        number(load.crank_deg, ".0f"),
        *(kilo(force, largest) for force in (load.pin_axial_N, load.crank_axial_N, load.wall_N)),
        number(result.max_von_mises_MPa, ".1f"),
        bar(result.error_percent),
        place(result.at_mm),
        factor(result.min_safety_factor),
        number(result.max_displacement_mm, ".3f"),
    ]


def _model(summary: Summary) -> str:
    model, checks = summary.model, summary.checks
    passed = sum(check.passed for check in checks.values())
    refined = ", refined" if summary.passes is not None and len(summary.passes) > 1 else ""
    kind = f"{model.element}, {model.size_mm:.3g} mm{refined}"
    mesh = f"{model.elements} elements ({kind})"
    return f"{mesh}; {passed} of {len(checks)} checks passed; {summary.total_s:.1f} s"


def _shortened(names: list[str]) -> list[str]:
    numbered = [name for name in names if name.startswith("cycle-")]
    if len(numbered) < 4:
        return names
    rest = [name for name in names if name not in numbered]
    return [*rest, f"{numbered[0]} … {numbered[-1]} ({len(numbered)} files)"]


def _written(folder: Path, summary: Summary, width: int) -> list[str]:
    said = f"Written to {near(folder)}/ ({len(summary.files or ())} files)."
    both = f"{said} {_next(folder, summary)}"
    return [both] if len(both) <= width else [said, _next(folder, summary)]


def _next(folder: Path, summary: Summary) -> str:
    result = f"{summary.governing_result}.vtu"
    if result not in (summary.files or ()):
        result = f"{summary.worst_case}.vtu"
    picture = picture_name(result)
    if picture not in (summary.files or ()):
        return f"Next: fea view {near(folder) / result}"
    return f"Next: look at {near(folder) / picture}"
