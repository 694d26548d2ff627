"""What a run says at its end: a table a human can read, what was written, what to do next."""

from collections.abc import Collection, Mapping, Sequence
from itertools import compress
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.analysis.figures import BoreFigures, CaseFigures, LoadFigures, Summary
from fea.base.choices import Support
from fea.judge.verdict import Verdict
from fea.output.target import near, picture_name
from fea.output.terminal.assembly import assembly_lines, assembly_tables
from fea.output.terminal.run_lines import (
    UNBOUNDED,
    UNKNOWN,
    bar,
    buckling_lines,
    endurance_lines,
    factor,
    kilo,
    life_lines,
    number,
    place,
    sharp_cells,
    sharp_edge_lines,
)
from fea.output.terminal.sweep import print_sweep

_ENDLESS = 1000
WIDTH = 88  # of what is not a terminal: a file, a pipe
_CASE, _ANGLE, _PLACE, _MOVED = "case", "crank\n°", "at x, y, z\nmm", "displ.\nmm"
_PINS, _WALL = ("pin\nkN", "crank\nkN"), "wall\nkN"
_COLUMNS = (_CASE, _ANGLE, *_PINS, _WALL, "Mises\nMPa", "±\n%", _PLACE, "safety\nfactor", _MOVED)
# Kinds of files that are named first.
_FIRST = (".json", ".toml", ".csv", ".vtu", ".png")
# Gap between columns and those left out, from wide consoles to narrow ones.
_NARROWER: tuple[tuple[int, frozenset[str]], ...] = (
    (1, frozenset()),
    (0, frozenset()),
    (0, frozenset({_WALL, _MOVED})),
    (0, frozenset({*_PINS, _WALL, _MOVED})),
    (0, frozenset({_ANGLE, *_PINS, _WALL, _MOVED, _PLACE})),
)


def print_runs(runs: Sequence[tuple[Path, Summary]], console: Console | None = None) -> None:
    """Print finished runs, each with its directory, on standard output or another console."""
    console = console or _console()
    if len(runs) == 1:
        _print_run(console, *runs[0])
    elif runs:
        print_sweep(console, runs)


def case_table(summary: Summary, console: Console) -> Table:
    """Return the load cases of one speed with what they do to the rod; the worst one is bold.

    Where the console is narrow columns stand closer, then some are left out: no figure is cut.
    """
    tables = [_table(summary, gap, without) for gap, without in _NARROWER]
    return next((table for table in tables if _width(table) <= console.width), tables[-1])


def _width(table: Table) -> int:
    return Console(width=_ENDLESS).measure(table).maximum


def _table(summary: Summary, gap: int, without: Collection[str]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=gap > 0)
    kept = [title not in without for title in _COLUMNS]
    for title in compress(_COLUMNS, kept):
        left = title in {_CASE, _PLACE}
        table.add_column(title, justify="left" if left else "right", no_wrap=True)
    for case, result in summary.results.items():
        cells = [case, *_cells(summary.loads[case], result)]
        table.add_row(*compress(cells, kept), style="bold" if case == summary.worst_case else "")
        if result.sharp_edges:
            table.add_row(*compress(sharp_cells(result.sharp_edges[0]), kept))
        if result.singular_max_von_mises_MPa and _unjudged(summary, result):
            table.add_row(*compress(_singular_cells(result.singular_max_von_mises_MPa), kept))
    return table


def _console() -> Console:
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDTH)


def _print_run(console: Console, folder: Path, summary: Summary) -> None:
    console.print(_headline(summary), markup=False, style="bold", soft_wrap=True)
    console.print(case_table(summary, console))
    if summary.assembly is not None:
        for table in assembly_tables(summary.assembly):
            console.print(table)
    buckling = buckling_lines(summary.buckling)
    for line in (
        *_doubts(summary),
        *sharp_edge_lines(summary),
        *_contact(summary),
        *assembly_lines(summary.assembly),
        *_cycle(summary),
        *life_lines(summary.life),
        *buckling,
        _model(summary),
    ):
        # At words where a human reads; whole lines for a program.
        console.print(line, markup=False, soft_wrap=not console.is_terminal)
    for line in (*_files(folder, summary), _next(folder, summary)):
        console.print(line, markup=False, soft_wrap=True)


def _cells(load: LoadFigures, result: CaseFigures) -> list[str]:
    return [
        number(load.crank_deg, ".0f"),
        *(kilo(force) for force in (load.pin_axial_N, load.crank_axial_N, load.wall_N)),
        number(result.max_von_mises_MPa, ".1f"),
        bar(result.error_percent),
        place(result.at_mm),
        factor(result.min_safety_factor),
        number(result.max_displacement_mm, ".3f"),
    ]


def _singular_cells(largest: float) -> list[str]:
    """Return the row of what a case has near singular places: no element size bounds its error."""
    return ["  diverging", "", "", "", "", number(largest, ".1f"), "∞", "singular place", UNKNOWN, ""]


def _headline(summary: Summary) -> str:
    away = " (away from the singular places below)" if _singular(summary) else ""
    away = f"; {UNBOUNDED}" if _judged(summary) else away
    return f"{summary.title}: {summary.survival.text}{away}"


def _judged(summary: Summary) -> bool:
    return any(result.sharp_edges for result in summary.results.values())


def _unjudged(summary: Summary, result: CaseFigures) -> bool:
    """Whether there may be singular places other than the sharp edges that are judged."""
    return not result.sharp_edges or summary.model.support == Support.CLAMPED or result.contact is not None


def _singular(summary: Summary) -> bool:
    return any(result.singular_max_von_mises_MPa for result in summary.results.values())


def _doubts(summary: Summary) -> list[str]:
    doubts = [
        f"NOT TO BE TRUSTED: check {name} failed: {number(check.value, '.3g')}, limit {check.limit:.3g}"
        for name, check in summary.checks.items()
        if not check.passed
    ]
    return [*doubts, *_unsettled(summary), *map(str, summary.notes)]


def _unsettled(summary: Summary) -> list[str]:
    """Return the peaks that finer elements would change, and those that no element size could settle."""
    results = summary.results
    loose = [case for case, result in results.items() if result.verdict == Verdict.NOT_CONVERGED]
    fixed = summary.passes or summary.model.mesh_from_file
    remedy = "" if fixed else " (try --tolerance 5 or less)"
    lines = [f"Not converged: {', '.join(loose)}{remedy}"] if loose else []
    singular = {
        case: number(result.singular_max_von_mises_MPa, ".1f")
        for case, result in results.items()
        if result.singular_max_von_mises_MPa and _unjudged(summary, result)
    }
    return [*lines, _diverging(singular, parts=summary.assembly is not None)] if singular else lines


def _diverging(singular: Mapping[str, str], *, parts: bool) -> str:
    """Return what is wrong at the singular places, by the largest stress there of each case."""
    found = ", ".join(f"{case} {stress}" for case, stress in singular.items())
    rim = ", or the rim of a place where parts touch" if parts else ""
    return (
        f"Diverging: {found} MPa near a sharp re-entrant edge, the border of a clamped surface or the end of "
        f"a bore that a bending pin presses on{rim}, where the exact stress is infinite (singular) and finer "
        "elements give ever higher values; the figures above and their ± are of the rest of the rod"
    )


def _contact(summary: Summary) -> list[str]:
    found: dict[str, list[tuple[str, BoreFigures]]] = {}
    for case, result in summary.results.items():
        for bore, figures in (result.contact or {}).items():
            found.setdefault(bore, []).append((case, figures))
    lines = []
    for bore, cases in found.items():
        hardest, most = max(cases, key=lambda item: item[1].max_pressure_MPa)
        where = f"{most.at_deg:.0f}°, z = {number(most.at_z_mm, '.1f')} mm, on an arc of {most.arc_deg:.0f}°"
        oval, shape = max(cases, key=lambda item: item[1].ovality_mm)
        change = f"{1e3 * shape.widest_mm:+.0f} µm at {shape.widest_deg:.0f}°"
        change += f", {1e3 * shape.narrowest_mm:+.0f} µm at {shape.narrowest_deg:.0f}°"
        lines.append(
            f"Contact, {bore.replace('_', ' ')}: at most {most.max_pressure_MPa:.0f} MPa ({hardest}) at "
            f"{where}; diameter {change} ({oval})."
        )
    return lines


def _cycle(summary: Summary) -> list[str]:
    envelope = summary.envelope
    if envelope is None:
        return []
    static = f"Whole cycle: smallest factor against yielding {factor(envelope.min_safety_factor)}"
    angle = number(envelope.crank_deg, ".0f")
    static += f" at {angle}°"
    if angle != number(summary.loads[summary.worst_case].crank_deg, ".0f"):
        static += " (the stress peaks at another angle than the force)"
    fatigue = envelope.fatigue
    endurance = endurance_lines(envelope)
    if fatigue is None:
        return [f"{static}; fatigue is not judged (see the notes).", *endurance]
    judged = f"against fatigue {factor(fatigue.fatigue_safety_factor)} at ({place(fatigue.at_mm)}) mm"
    history = f"mean {fatigue.mean_MPa:.0f}, amplitude {fatigue.amplitude_MPa:.0f} MPa"
    ratio = f"R = {fatigue.stress_ratio:.2f} ({envelope.fatigue_criterion})"
    return [f"{static}; {judged}: {history}, {ratio}.", *endurance]


def _model(summary: Summary) -> str:
    model, checks = summary.model, summary.checks
    passed = sum(check.passed for check in checks.values())
    refined = ", refined" if summary.passes is not None and len(summary.passes) > 1 else ""
    kind = f"{model.element}, {model.size_mm:.3g} mm{refined}"
    mesh = f"{model.nodes} nodes, {model.elements} elements ({kind})"
    return f"{mesh}; {passed} of {len(checks)} checks passed; {summary.total_s:.1f} s"


def _files(folder: Path, summary: Summary) -> list[str]:
    """Return the paths written, the files of a kind together."""
    kinds: dict[str, list[str]] = {}
    for name in summary.files or ():
        kinds.setdefault(Path(name).suffix, []).append(name)
    order = sorted(kinds, key=lambda kind: (_FIRST.index(kind) if kind in _FIRST else len(_FIRST), kind))
    return [f"Written to {near(folder)}/", *(f"  {'  '.join(_shortened(kinds[kind]))}" for kind in order)]


def _shortened(names: list[str]) -> list[str]:
    """Name the first and the last of the files that follow the crank angle."""
    numbered = [name for name in names if name.startswith("cycle-")]
    if len(numbered) < 4:
        return names
    rest = [name for name in names if name not in numbered]
    return [*rest, f"{numbered[0]} … {numbered[-1]} ({len(numbered)} files)"]


def _next(folder: Path, summary: Summary) -> str:
    result = f"{summary.worst_case}.vtu"
    file, picture = near(folder) / result, picture_name(result)
    if picture not in (summary.files or ()):
        return f"Next: fea view {file}, or open it in ParaView."
    return f"Next: look at {near(folder) / picture}, or open {file} in ParaView."
