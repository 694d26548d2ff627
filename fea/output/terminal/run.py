"""What a run says at its end: a table a human can read, what was written, what to do next."""

from collections.abc import Collection, Mapping, Sequence
from itertools import compress
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.output.target import near
from fea.output.terminal.buckling import buckling_lines
from fea.output.terminal.figures import UNKNOWN, Summary, bar, factor, kilo, number, worst_case
from fea.output.terminal.sweep import print_sweep

_ENDLESS = 1000
WIDTH = 88  # of what is not a terminal: a file, a pipe
_CASE, _ANGLE, _PLACE, _MOVED = "case", "crank\n°", "at x, y, z\nmm", "displ.\nmm"
_PINS, _WALL = ("pin\nkN", "crank\nkN"), "wall\nkN"
_COLUMNS = (_CASE, _ANGLE, *_PINS, _WALL, "Mises\nMPa", "±\n%", _PLACE, "safety\nfactor", _MOVED)
# Gap between columns and those left out, from wide consoles to narrow ones.
_NARROWER: tuple[tuple[int, frozenset[str]], ...] = (
    (1, frozenset()),
    (0, frozenset()),
    (0, frozenset({_WALL, _MOVED})),
    (0, frozenset({*_PINS, _WALL, _MOVED})),
    (0, frozenset({_ANGLE, *_PINS, _WALL, _MOVED, _PLACE})),
)


def print_runs(runs: Sequence[tuple[Path, Summary]], console: Console | None = None) -> None:
    """Print finished runs.

    Parameters
    ----------
    runs
        The directory and the summary (as in ``summary.json``) of each speed.
    console
        Where to; standard output by default.
    """
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
    """What it takes where there is room without end."""
    return Console(width=_ENDLESS).measure(table).maximum


def _table(summary: Summary, gap: int, without: Collection[str]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, gap, 0, 0), pad_edge=False, show_edge=gap > 0)
    kept = [title not in without for title in _COLUMNS]
    for title in compress(_COLUMNS, kept):
        left = title in {_CASE, _PLACE}
        table.add_column(title, justify="left" if left else "right", no_wrap=True)
    worst = worst_case(summary)
    for case, result in summary["results"].items():
        cells = [case, *_cells(summary["loads"][case], result)]
        table.add_row(*compress(cells, kept), style="bold" if case == worst else "")
        if result.get("singular_max_von_mises_MPa"):
            table.add_row(*compress(_singular_cells(result), kept))
    return table


def _console() -> Console:
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDTH)


def _print_run(console: Console, folder: Path, summary: Summary) -> None:
    console.print(_headline(summary), markup=False, style="bold", soft_wrap=True)
    console.print(case_table(summary, console))
    for line in (*_doubts(summary), *_cycle(summary), *buckling_lines(summary), _model(summary)):
        # At words where a human reads; whole lines for a program.
        console.print(line, markup=False, soft_wrap=not console.is_terminal)
    for line in (*_files(folder), _next(folder, summary)):
        console.print(line, markup=False, soft_wrap=True)


def _cells(load: Summary, result: Summary) -> list[str]:
    at = result.get("at_mm")
    return [
        number(load.get("crank_deg"), ".0f"),
        *(kilo(load.get(name)) for name in ("pin_axial_N", "crank_axial_N", "wall_N")),
        number(result.get("max_von_mises_MPa"), ".1f"),
        bar(result.get("error_percent")),
        ", ".join(f"{coordinate + 0.0:.1f}" for coordinate in at) if at else UNKNOWN,
        factor(result.get("min_safety_factor")),
        number(result.get("max_displacement_mm"), ".3f"),
    ]


def _singular_cells(result: Summary) -> list[str]:
    """Return the row of what a case has near singular places: no element size bounds its error."""
    largest = number(result["singular_max_von_mises_MPa"], ".1f")
    return ["  diverging", "", "", "", "", largest, "∞", "singular place", UNKNOWN, ""]


def _headline(summary: Summary) -> str:
    case = worst_case(summary)
    safety = factor(summary["results"][case].get("min_safety_factor"))
    speed = f" at {summary['rpm']:g} rpm" if summary.get("rpm") is not None else ""
    return f"{summary['study']}{speed}: smallest safety factor against yield {safety} ({case})"


def _doubts(summary: Summary) -> list[str]:
    """Return what the reader must know before believing the figures."""
    failed = {name: check for name, check in summary["checks"].items() if not check["pass"]}
    doubts = [
        f"NOT TO BE TRUSTED: {name} = {number(check['value'], '.3g')}, beyond {check['limit']:.3g}"
        for name, check in failed.items()
    ]
    return [*doubts, *_unsettled(summary["results"]), *summary.get("notes", [])]


def _unsettled(results: Mapping[str, Summary]) -> list[str]:
    """Return the peaks that finer elements would change, and those that no element could settle."""
    by_verdict: dict[str, list[str]] = {}
    for case, result in results.items():
        by_verdict.setdefault(result.get("verdict", ""), []).append(case)
    lines = []
    if "not converged" in by_verdict:
        lines.append(f"Not converged: {', '.join(by_verdict['not converged'])} (try --tolerance 5 or less)")
    for case, result in results.items():
        if result.get("singular_max_von_mises_MPa"):
            lines.append(_diverging(case, result))
    return lines


def _diverging(case: str, result: Summary) -> str:
    """Return what is wrong at the singular places of a case, and what its figures stand for."""
    near = number(result["singular_max_von_mises_MPa"], ".1f")
    rest = number(result.get("max_von_mises_MPa"), ".1f")
    return (
        f"Diverging: {case} has {near} MPa near a sharp inner edge or a clamped border, where the exact "
        "stress is infinite and finer elements give ever more; "
        f"{rest} MPa and its ± are of the rest of the rod"
    )


def _cycle(summary: Summary) -> list[str]:
    """Return what the whole crank cycle adds, where it was worked out."""
    envelope = summary.get("envelope")
    if envelope is None:
        return []
    static = f"Whole cycle: smallest factor against yield {factor(envelope['min_safety_factor'])}"
    angle = number(envelope["crank_deg"], ".0f")
    static += f" at {angle}°"
    if angle != number(summary["loads"][worst_case(summary)].get("crank_deg"), ".0f"):
        static += " (stress peaks beside the case's force)"
    fatigue = envelope["fatigue"]
    if fatigue is None:
        return [f"{static}; fatigue is not judged (see notes)."]
    at = ", ".join(f"{coordinate + 0.0:.1f}" for coordinate in fatigue["at_mm"])
    judged = f"against fatigue {factor(fatigue['fatigue_safety_factor'])} at ({at}) mm"
    history = f"mean {fatigue['mean_MPa']:.0f}, amplitude {fatigue['amplitude_MPa']:.0f} MPa"
    ratio = f"R = {fatigue['stress_ratio']:.2f} ({envelope['fatigue_criterion']})"
    return [f"{static}; {judged}: {history}, {ratio}."]


def _model(summary: Summary) -> str:
    model, checks = summary["model"], summary["checks"]
    passed = sum(bool(check["pass"]) for check in checks.values())
    kind = f"{model['element']}, {model['size_mm']:.3g} mm"
    mesh = f"{model['nodes']} nodes, {model['elements']} elements ({kind})"
    return f"{mesh}; {passed} of {len(checks)} checks passed; {summary['total_s']:.1f} s"


def _files(folder: Path) -> list[str]:
    """Return the paths written, the files of a kind together."""
    names = sorted(entry.name for entry in folder.iterdir()) if folder.is_dir() else []
    kinds = [
        [name for name in names if name.endswith(kind)] for kind in (".json", ".toml", ".csv", ".vtu", ".png")
    ]
    return [f"Written to {near(folder)}/", *(f"  {'  '.join(names)}" for names in kinds if names)]


def _next(folder: Path, summary: Summary) -> str:
    file = near(folder) / f"{worst_case(summary)}.vtu"
    if not file.with_suffix(".png").exists():
        return f"Next: fea view {file}, or open it in ParaView."
    return f"Next: look at {file.with_suffix('.png')}, or open {file} in ParaView."
