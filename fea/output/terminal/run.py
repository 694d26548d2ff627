"""The end of a run at one or several speeds: tables, statements, what was written and what to do next."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table as RichTable

from fea.analysis.many_speeds import JOINT_OPENING, MODES, rounded, speed_map
from fea.analysis.summary_figures import Summary
from fea.base.note import Note, NoteKind, by_consequence
from fea.judge.safety_factor import SurvivalAnswer
from fea.judge.verdict import ConvergenceVerdict
from fea.output import life_statements, life_tables, statements, tables
from fea.output.defect_answer import defect_tables
from fea.output.folder import near, picture_name
from fea.output.fretting import fretting_tables
from fea.output.tables import AnswerTable, TableColumn, hand_tables, head_clearance_tables
from fea.output.terminal import prose
from fea.output.terminal.prose import plain_table, print_lines, some_speeds
from fea.output.units import bar, factor, in_text, number, quantity, unit


def print_runs(
    runs: Sequence[tuple[Path, Summary]], console: Console | None = None, *, verbose: bool = False
) -> None:
    """Print runs and their folders: at most `prose.MOST_LINES` after the table, unless `verbose`."""
    console = console or prose.terminal()
    if len(runs) == 1:
        _print_run(console, *runs[0], verbose=verbose)
    elif runs:
        _print_speeds(console, runs, verbose=verbose)


def _print(
    console: Console, heading: list[str], printed: Iterable[RichTable], lines: list[str], paths: list[str]
) -> None:
    print_lines(console, heading[:1], "bold")
    print_lines(console, heading[1:])
    for table in printed:
        console.print(table)
    print_lines(console, lines)
    prose.print_paths(console, paths)


def _captioned(printed: Iterable[AnswerTable]) -> list[RichTable]:
    return [table.printed(gap=0, title=in_text(table.caption), title_justify="left") for table in printed]


def _print_run(console: Console, folder: Path, summary: Summary, *, verbose: bool) -> None:
    heading = [f"{summary.title}: {summary.survival.text}", *prose.unusual(summary.notes)]
    parts = list(tables.assembly_tables(summary))
    shown = [table for table in parts[1:] if verbose or table.head[0] == _governing_part(summary)]
    printed = [case_table(summary, console), *(part_table(table, console) for table in shown)]
    if verbose:
        printed += _captioned(
            [*parts[:1], *tables.contact_tables(summary), *life_tables.fatigue_tables(summary)]
        )
        more = [*tables.buckling_tables(summary), *hand_tables(summary), *head_clearance_tables(summary)]
        more += [*defect_tables(summary), *fretting_tables(summary), *life_tables.gauge_tables(summary)]
        printed += _captioned(more)
        lines = [*statements.full_statements(summary), *prose.in_full((*summary.notes, *summary.left_out))]
        lines.append(f"{summary.model.nodes} nodes, {_model(summary)}")
        paths = [f"Written to {near(folder)}/", *_files(summary), _next(folder, summary)]
    else:
        end = [_model(summary), prose.counted(summary.notes, summary.left_out)]
        paths = _written(folder, summary, console.width)
        lines = [*prose.fitting(statements.brief_statements(summary), end, paths, console.width), *end]
    _print(console, heading, printed, lines, paths)


# Gap between columns and whether there is a border, from wide consoles to narrow ones; a column of
# `fea.output.tables` names the last of these that has it.
_LAYOUTS = ((1, True), (0, True), (0, False), (0, False), (0, False), (0, False))
_ENDLESS = 1000


def case_table(summary: Summary, console: Console) -> RichTable:
    """Return the load cases of one speed, the worst bold; a narrow console shows fewer columns."""
    return _first_that_fits([_laid_out(summary, k) for k in range(len(_LAYOUTS))], console)


def part_table(table: AnswerTable, console: Console) -> RichTable:
    """Return the table of a part; a narrow console breaks its headings, and cuts no figure."""
    return _first_that_fits([table.printed(no_wrap=True), table.printed(gap=0)], console)


def _first_that_fits(choices: Sequence[RichTable], console: Console) -> RichTable:
    endless = Console(width=_ENDLESS)
    return next((one for one in choices if endless.measure(one).maximum <= console.width), choices[-1])


def _laid_out(summary: Summary, layout: int) -> RichTable:
    columns = [
        replace(column, title=shown.title, form=shown.form or column.form)
        for column in dict.fromkeys((*tables.FORCES, *tables.PEAKS))
        if (shown := column.terminal) and shown.narrowest >= layout
    ]
    head = ["case", *map(_head, columns)]
    left = ["case", *(title for title in head if title.startswith("at "))]
    gap, border = _LAYOUTS[layout]
    table = plain_table(head, (), left=left, no_wrap=True, gap=gap, show_edge=border)
    for row in tables.case_rows(summary, most_edges=1):
        name = f"  edge {row.edge}" if row.edge else row.case
        style = "bold" if name == summary.worst_case else ""
        table.add_row(name, *(column.cell(row) for column in columns), style=style)
    return table


def _governing_part(summary: Summary) -> str:
    if summary.survival.mode.endswith(("of the bolts", "of the joint")):
        return "joint"
    weakest = None if summary.governing is None else summary.governing.weakest
    part = "" if weakest is None else weakest.part
    return "shells" if part.endswith("shell") else part


def _model(summary: Summary) -> str:
    model, checks = summary.model, summary.checks
    passed = sum(check.passed for check in checks.values())
    refined = ", refined" if summary.passes is not None and len(summary.passes) > 1 else ""
    mesh = f"{model.elements} elements ({model.element}, {quantity(model.size_mm, '.3g', 'mm')}{refined})"
    return f"{mesh}; {passed} of {len(checks)} checks passed; {summary.total_s:.1f} s"


# Kinds of files that are named first.
_FIRST = (".json", ".toml", ".csv", ".vtu", ".png")
_FEW = 4  # files of the cycle that are all named


def _files(summary: Summary) -> Iterator[str]:
    """Yield a line for each kind of the files that were written."""
    kinds: dict[str, list[str]] = {}
    for name in summary.files or ():
        kinds.setdefault(Path(name).suffix, []).append(name)
    for kind in sorted(kinds, key=lambda kind: (_FIRST.index(kind) if kind in _FIRST else len(_FIRST), kind)):
        cycle = [name for name in kinds[kind] if name.startswith("cycle-")]
        names = kinds[kind]
        if len(cycle) >= _FEW:
            names = [name for name in names if name not in cycle]
            names.append(f"{cycle[0]} … {cycle[-1]} ({len(cycle)} files)")
        yield f"  {'  '.join(names)}"


def _written(folder: Path, summary: Summary, width: int) -> list[str]:
    written, after = f"Written to {near(folder)}/ ({len(summary.files or ())} files).", _next(folder, summary)
    both = f"{written} {after}"
    return [both] if len(both) <= width else [written, after]


def _next(folder: Path, summary: Summary) -> str:
    result = f"{summary.governing_result}.vtu"
    if result not in (summary.files or ()):
        result = f"{summary.worst_case}.vtu"
    picture = picture_name(result)
    if picture not in (summary.files or ()):
        return f"Next: fea view {near(folder) / result}"
    return f"Next: look at {near(folder) / picture}"


def _print_speeds(console: Console, runs: Sequence[tuple[Path, Summary]], *, verbose: bool) -> None:
    """Print the worst case of each speed, and from which speed on the rod fails."""
    summaries = [summary for _, summary in runs]
    gravity = list(SurvivalAnswer)

    def rank(summary: Summary) -> tuple[int, float]:
        return -gravity.index(SurvivalAnswer(summary.survival.answer)), summary.survival.assured_safety_factor

    worst = min(summaries, key=rank)
    headline = f"{worst.title}, the worst of {len(summaries)} speeds: {worst.survival.text}"
    noted = prose.gathered((one.rpm or 0.0, (*one.notes, *one.left_out)) for one in summaries)
    notes, left_out = by_consequence(noted)
    printed = [*_speed_tables(summaries)]
    paths = [*_speeds_written(runs), *_speeds_next(runs)]
    if verbose:
        printed += _captioned([*life_tables.endurance_tables(worst), *life_tables.life_tables(worst)])
        lines = [
            *_doubts(summaries),
            *statements.singular(worst),
            *statements.governs(worst),
            *statements.levers(worst),
        ]
        lines += [*_critical(summaries), *life_statements.life(worst), *prose.in_full((*notes, *left_out))]
    else:
        more = prose.counted(notes, left_out)
        brief = _brief_statements(summaries, worst, notes)
        lines = [*prose.fitting(brief, [more], paths, console.width), more]
    _print(console, [headline, *prose.unusual(notes)], printed, lines, paths)


def _brief_statements(summaries: Sequence[Summary], worst: Summary, notes: Sequence[Note]) -> Iterator[str]:
    """Yield what a reader should know, by consequence."""
    yield from _doubts(summaries)
    yield from statements.of_kind(notes, NoteKind.DOUBT)
    yield from _of_worst(summaries, worst)
    yield from statements.of_kind(notes, NoteKind.WARNING)


def _of_worst(summaries: Sequence[Summary], worst: Summary) -> Iterator[str]:
    yield from statements.singular(worst)
    yield from life_statements.life(worst)
    yield from _critical(summaries)
    yield from statements.governs(worst)
    yield from statements.levers(worst)


def _doubts(summaries: Sequence[Summary]) -> Iterator[str]:
    checks = ((one, name, check) for one in summaries for name, check in one.checks.items())
    failed = {f"{one.rpm:g}": name for one, name, check in checks if not check.passed}
    if failed:
        names, speeds = ", ".join(dict.fromkeys(failed.values())), some_speeds(list(failed))
        yield f"NOT TO BE TRUSTED: failed checks at {speeds}: {names}."
    verdicts = [summary.results[summary.worst_case].verdict for summary in summaries]
    loose = verdicts.count(ConvergenceVerdict.NOT_CONVERGED)
    remedy = "a smaller --tolerance" if summaries[0].passes else "--tolerance 5 or less"
    remedy = "a finer mesh" if summaries[0].model.mesh_from_file else remedy
    if loose:
        yield f"Not converged: the worst case of {loose} speed{'s' * (loose > 1)} (try {remedy})"


_WORST = (
    TableColumn("worst\ncase", "", "case", words=True),
    TableColumn("crank", "°", "crank_deg", ".0f"),
    TableColumn("von Mises", "MPa", "max_von_mises_MPa", ".1f"),
    TableColumn("±", "%", "error_percent", bar),
    TableColumn("safety\nfactor", "", "min_safety_factor", factor),
)
_FILMS = (
    TableColumn("min.\nfilm", "µm", "h_min_um", "3g"),
    TableColumn("±", "%", "h_min_error_percent", "3g"),
    TableColumn("λ", "", "lambda_min", "3g"),
    TableColumn("max.", "MPa", "p_max_MPa", "3g"),
    TableColumn("friction", "W", "power_W", "3g"),
    TableColumn("oil", "l/min", "flow_l_min", "3g"),
    TableColumn("oil", "°C", "temperature_C", "3g"),
    TableColumn("regime", "", "verdict", words=True),
)


def _speed_tables(summaries: Sequence[Summary]) -> Iterator[RichTable]:
    """Yield the worst load case of each speed, and the oil films."""
    rising = sorted(summaries, key=lambda summary: summary.rpm or 0.0)
    table = plain_table(("rpm", *map(_head, _WORST), ""), (), left=("worst\ncase",))
    for one in rising:
        row = next(row for row in tables.case_rows(one) if row.case == one.worst_case)
        failed = "" if one.trusted else "check failed"
        table.add_row(number(one.rpm, "g"), *(column.cell(row) for column in _WORST), failed)
    yield table
    if any(one.film for one in rising):
        table = plain_table(("rpm", "bearing", *map(_head, _FILMS)), (), left=("bearing", "regime"))
        for one in rising:
            for end, film in (one.film or {}).items():
                cells = (column.cell(film) for column in _FILMS)
                table.add_row(number(one.rpm, "g"), end.replace("_", " "), *cells)
        yield table


def _head(column: TableColumn) -> str:
    return "\n".join(filter(None, (column.title, unit(column.unit))))


def _speeds_written(runs: Sequence[tuple[Path, Summary]]) -> Iterator[str]:
    yield f"Written: {near(runs[0][0].parent)}/map.csv, and a directory for each speed."
    drawn = [f"{summary.rpm:g}" for _, summary in runs if _result(summary) is not None]
    if len(drawn) < len(runs):
        yield f"Fields are written at the worst speeds, {', '.join(drawn)} rpm."


def _result(summary: Summary) -> str | None:
    name = f"{summary.worst_case}.vtu"
    return name if name in (summary.files or ()) else None


def _speeds_next(runs: Sequence[tuple[Path, Summary]]) -> Iterator[str]:
    folder, summary = runs[0]
    charts = [name for name in summary.shared_files or () if name.endswith(".png")]
    yield from (f"Next: look at {near(folder.parent / chart)}" for chart in charts)
    written = [(place, found) for place, found in runs if _result(found) is not None]
    if written:
        place, found = min(written, key=lambda run: run[1].min_safety_factor)
        yield f"{'Then' if charts else 'Next'}: fea view {near(place / str(_result(found)))}"


def _critical(summaries: Sequence[Summary]) -> Iterator[str]:
    critical, cycles = summaries[0].critical_speeds_rpm or {}, speed_map(summaries)
    if JOINT_OPENING in critical:
        yield f"The joint opens at the bore {_from(critical[JOINT_OPENING])}."
    if cycles is not None:
        modes = [
            f"{mode} {_from(rpm)}"
            for mode, rpm in cycles.critical.items()
            if mode in MODES and not np.isnan(cycles.columns[f"{mode}_safety_factor"]).all()
        ]
        yield f"Whole cycle, safety factor below 1: {', '.join(modes)}."


def _from(rpm: float | None) -> str:
    return "at no speed" if rpm is None else f"from {rounded(rpm)} rpm"
