"""Compare error against run time within a time limit, each computation in a separate process.

Series of computations have a Pareto front, times at equal error, and an advice.
"""

import math
import shutil
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import TypeVar

import numpy as np

from fea.machine.clock import Listener
from fea.machine.isolated import fresh
from fea.output.plots.figure import log_ticks, new_figure
from fea.study.study import Study
from fea.verify.cases.elasticity import EQUATOR, HOOP
from fea.verify.computations import (
    QUANTITY,
    Computation,
    ConvergenceRow,
    Reference,
    calculix_refuses,
    compute,
    rod_reference,
)
from fea.verify.layout import Line, explanation, markdown, print_table, write_document
from mesh.sizing import default_size

# Smaller errors, percent, come from the reference or are accidental; `floor` is what they count as.
FLOOR = 0.05
# The error of stress decreases with the size to the power of the element's order, at best to twice that
# power.
_BEST_RATE = 2


def pareto(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[ConvergenceRow]:
    """The rows of one problem that no other row beats in both time and error, the fastest first."""
    best: list[ConvergenceRow] = []
    for row in sorted(rows, key=lambda row: (row.seconds, abs(row.error_percent))):
        if not best or max(abs(row.error_percent), floor) < max(abs(best[-1].error_percent), floor):
            best.append(row)
    return best


def by_tool(rows: Iterable[ConvergenceRow]) -> dict[tuple[str, str], list[ConvergenceRow]]:
    """Rows of one problem by tool and element, each from coarse to fine."""
    series: dict[tuple[str, str], list[ConvergenceRow]] = {}
    for row in sorted(rows, key=lambda row: -row.computation.size):
        series.setdefault((row.computation.tool, row.computation.element), []).append(row)
    return series


def settled(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[float]:
    """Largest error, percent, of each mesh of a series and all finer ones.

    A mesh may be right by accident if the signed error crosses zero; the finer meshes show this. For the
    finest mesh there is none, so that its error counts as at least the error of the previous mesh reduced at
    twice the theoretical rate.
    """
    error = [abs(row.error_percent) for row in rows]
    if len(rows) > 1 and not rows[0].computation.adaptive:
        before, last = rows[-2].computation, rows[-1].computation
        error[-1] = max(error[-1], error[-2] * (last.size / before.size) ** (_BEST_RATE * last.order))
    running = np.maximum.accumulate(error[::-1])[::-1]
    return [max(float(value), floor) for value in running]


def fastest_within(rows: Sequence[ConvergenceRow], percent: float) -> dict[tuple[str, str], ConvergenceRow]:
    """Per tool and element, the fastest row for which it and all finer rows have errors within `percent`."""
    fastest = {}
    for tool, series in by_tool(rows).items():
        within = [row for row, error in zip(series, settled(series), strict=True) if error <= percent]
        if within:
            fastest[tool] = min(within, key=lambda row: row.seconds)
    return fastest


def seconds_to(rows: Sequence[ConvergenceRow], percent: float, floor: float = FLOOR) -> float:
    """Time after which a series stays below an error, interpolated logarithmically; infinite if never."""
    seconds = [row.seconds for row in rows]
    errors = settled(rows, floor)
    if not errors or errors[-1] > percent:
        return np.inf
    first = next(number for number, error in enumerate(errors) if error <= percent)
    if first == 0:
        return seconds[0]
    places = np.log([errors[first], errors[first - 1]])
    return float(np.exp(np.interp(np.log(percent), places, np.log([seconds[first], seconds[first - 1]]))))


PERCENTS = (5.0, 2.0, 1.0)
# Target: this many times as fast as CalculiX at equal error.
GOAL = 10.0
WHOLE, THEIRS = "fea, whole", "CalculiX"


@dataclass(frozen=True)
class EqualError:
    """Seconds to reach an error: infinite if a tool did not reach it."""

    percent: float
    #: ours, whole, theirs: s, of `fea` at its best and without mirror planes, and of CalculiX at its best
    ours: float
    whole: float
    theirs: float
    #: CalculiX's slowest row, s: if it did not reach the error, it would take longer than this
    longest: float

    @property
    def ratio(self) -> float:
        """CalculiX's time over ours, or a lower bound of it; NaN if we did not reach the error."""
        theirs = self.theirs if math.isfinite(self.theirs) else self.longest
        return theirs / self.ours if math.isfinite(self.ours) else math.nan

    @property
    def goal_met(self) -> bool:
        """Whether the ratio reaches `GOAL`."""
        return self.ratio >= GOAL


def same_mesh(rows: Sequence[ConvergenceRow]) -> list[tuple[ConvergenceRow, ConvergenceRow]]:
    """Rows of `fea` and of CalculiX on the same meshes, coarse to fine, where `fea` estimates its error."""
    series = by_tool(rows)
    return [
        (ours, theirs)
        for (tool, element), of_fea in series.items()
        if tool == "fea"
        for ours in of_fea
        for theirs in series.get((THEIRS, element), ())
        if theirs.computation.size == ours.computation.size and ours.error_bar is not None
    ]


def equal_error(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[EqualError]:
    """Compare at each of `PERCENTS`; empty without CalculiX."""
    longest = max((row.seconds for row in rows if row.computation.tool == THEIRS), default=0.0)
    compared = []
    for percent in PERCENTS if longest else ():
        best = dict.fromkeys(("ours", WHOLE, THEIRS), math.inf)
        for (tool, _), series in by_tool(rows).items():
            program = tool if tool in best else "ours"
            best[program] = min(best[program], seconds_to(series, percent, floor))
        compared.append(EqualError(percent, best["ours"], best[WHOLE], best[THEIRS], longest))
    return compared


def advice(rows: Sequence[ConvergenceRow], floor: float = FLOOR) -> list[str]:
    """A sentence for each accuracy, from the rows of the rod, whose errors are known to `floor` percent."""
    against = {compared.percent: compared for compared in equal_error(rows, floor)}
    return [_sentence(rows, percent, against.get(percent), floor) for percent in PERCENTS]


def _sentence(
    rows: Sequence[ConvergenceRow], percent: float, against: EqualError | None, floor: float
) -> str:
    if percent < floor:
        return f"Within {percent:g} %: the reference is not accurate enough (±{floor:.2g} %)."
    fastest = fastest_within(rows, percent)
    ours = {kind: row for kind, row in fastest.items() if kind[0] != THEIRS}
    if not ours:
        return f"Within {percent:g} %: no computation reached this within the time limit."
    (tool, element), best = min(ours.items(), key=lambda item: item[1].seconds)
    finest = min(by_tool(rows)[tool, element], key=lambda row: row.computation.size)
    meshes = "the finest mesh of the comparison" if best is finest else "confirmed by all finer meshes"
    text = (
        f"For a peak within {percent:g} %, {meshes}, use `{best.computation.name}` "
        f"with {element.upper()} elements: {best.seconds:.1f} s at {best.dofs} dofs"
    )
    if against is not None and math.isfinite(against.theirs):
        text += f"; CalculiX takes {against.ratio:.1f} times as long for the same error"
    elif against is not None:
        text += f"; CalculiX did not reach this in {against.longest:.0f} s"
    first = [name for name, kind in fastest if kind == "p1"]
    return text + ("." if first else ". No first-order mesh reached this.")


PROBLEMS = ("rod", "lame", "goodier")
# Shares of the time. The rod is the main problem; the others show that its result is not accidental.
SHARE = {"rod": 0.7, "lame": 0.15, "goodier": 0.15}
EXACT = {"lame": HOOP, "goodier": EQUATOR}
# Number of runs of a computation that takes less than LONG seconds; their median counts.
RUNS, LONG = 3, 5.0
# Largest cost of the next size relative to the previous one: 2.4 times the nodes, to the power 1.5.
_GROWTH = 3.5

# Ratio of successive sizes: each mesh has about 2.4 times the nodes of the previous one.
STEP = 0.75
LEVELS = 9
# Coarsest sizes: for the rod relative to its default size, for the others in mm.
COARSEST = {"rod": 2.4, "lame": 8.0, "goodier": 0.6}
TOLERANCES = (10.0, 5.0, 3.0, 2.0, 1.0)
TOOLS = ("fea", "fea, mean", "CalculiX")


def series(problem: str, default_size: float, *, calculix: bool = True) -> Iterator[list[Computation]]:
    """The computations of a problem, in series that differ only in the size, coarse to fine.

    `default_size` is that of the rod, mm; `calculix`: whether CalculiX can solve it.
    """
    unit = default_size if problem == "rod" else 1.0
    sizes = [COARSEST[problem] * unit * STEP**level for level in range(LEVELS)]
    tools = [tool for tool in TOOLS if tool != "CalculiX" or (calculix and shutil.which("ccx"))]
    for tool in (*tools, *(["fea, whole"] if problem == "rod" else [])):
        for element in ("p1", "p2") if tool != "fea, whole" else ("p2",):
            yield [Computation(tool, element, problem, size) for size in sizes]
    if problem == "rod":
        yield [Computation("fea --tolerance", "p2", problem, percent) for percent in TOLERANCES]
        first = round(COARSEST[problem] * unit, 1)
        tool = f"fea --size {first:g} --tolerance"
        yield [Computation(tool, "p2", problem, percent, first) for percent in TOLERANCES]


Result = TypeVar("Result")


def _in_process(work: Callable[..., Result], *arguments: object) -> Result | None:
    """Work in a fresh interpreter, to measure its peak memory and survive its crash; None if it fails."""
    try:
        with fresh(patient=True) as process:
            return process.run(work, *arguments)
    except Exception:  # noqa: BLE001 - a computation that fails is no point of the comparison
        return None


@dataclass(frozen=True)
class Comparison:
    """All rows, by problem, tool, element and size, and the references by problem."""

    rows: list[ConvergenceRow]
    references: dict[str, Reference]
    refused: str = ""  #: why CalculiX does not solve the rod; empty where it does, or is not installed

    @property
    def advice(self) -> list[str]:
        """Recommendations for the rod and omissions, a sentence each."""
        refused = [self.refused] if self.refused else []
        return [*advice(self.of("rod"), self.floor("rod")), *refused]

    def floor(self, problem: str) -> float:
        """Smallest error of a problem that can be determined, percent."""
        return max(FLOOR, self.references[problem].uncertainty_percent)

    def of(self, problem: str) -> list[ConvergenceRow]:
        """Return the rows of a problem."""
        return [row for row in self.rows if row.computation.problem == problem]


def converge(study: Study, minutes: float = 10.0, listener: Listener | None = None) -> Comparison:
    """Compare tools, elements and recoveries by error and total run time.

    Of the rod, the first load case at its first speed is used. The limit of `minutes` is that of everything
    except the rod's reference; `listener` is called with the name of each computation before it begins.
    """
    length = study.rod.length or 0.0
    rows: list[ConvergenceRow] = []
    references = {}
    for problem in PROBLEMS:
        if listener:
            listener(f"{problem}, reference")
        if problem in EXACT:
            references[problem] = Reference(EXACT[problem])
        else:
            references[problem] = _in_process(rod_reference, study) or Reference(math.nan, math.inf)
        outcomes = _computed(study, problem, default_size(length), 60 * minutes * SHARE[problem], listener)
        truth = references[problem].value
        outcomes.sort(key=lambda row: (row.computation.series, -row.computation.size))
        rows += [replace(row, error_percent=100 * (row.value / truth - 1)) for row in outcomes]
    return Comparison(rows, references, calculix_refuses(study))


def _computed(
    study: Study, problem: str, size: float, seconds: float, listener: Listener | None
) -> list[ConvergenceRow]:
    """Refine the series with the cheapest next step, until no step fits into the remaining time."""
    end = time.perf_counter() + seconds
    calculix = problem != "rod" or not calculix_refuses(study)
    waiting = [(0.0, computations) for computations in series(problem, size, calculix=calculix)]
    outcomes: list[ConvergenceRow] = []
    _in_process(compute, waiting[0][1][0], study)  # the first computation also pays for reading files
    while waiting:
        waiting.sort(key=lambda item: item[0])
        cost, (computation, *finer) = waiting.pop(0)
        if time.perf_counter() + cost > end:
            break
        if listener:
            listener(f"{problem}, {computation.tool}, {computation.element}, {computation.size:.3g}")
        start = time.perf_counter()
        row = _in_process(compute, computation, study)
        if row is None:
            if finer and not any(done.computation.series == computation.series for done in outcomes):
                waiting.append((cost, finer))  # this size was too coarse for the mesher
            continue
        spent = time.perf_counter() - start
        if spent < LONG:  # the median of the times counts
            again = [_in_process(compute, computation, study) for _ in range(RUNS - 1)]
            times = [each.seconds for each in (row, *again) if each is not None]
            row = replace(row, seconds=statistics.median(times))
        outcomes.append(row)
        if finer:
            waiting.append((_GROWTH * spent, finer))
    return outcomes


_TOOL = 12  # length of the longest word in a tool's name


def print_comparison(comparison: Comparison) -> None:
    """Print one line per computation, and the advice."""
    lines: list[Line] = []
    for row in comparison.rows:
        it = row.computation
        cells = (it.problem, f"{it.name}, {it.element}", *_costs(row), f"{row.value:.1f}")
        lines.append(((*cells, f"{row.error_percent:+.2f}"), ""))
    header = ("problem", "tool", "size mm", "dofs", "time s", "MiB", "MPa", "error %")
    print_table(header, lines, words=("tool",), end=comparison.advice, longest=_TOOL)


def _costs(row: ConvergenceRow) -> tuple[str, ...]:
    return f"{row.size:.3g}", str(row.dofs), f"{row.seconds:.2f}", f"{row.peak_memory:.0f}"


def write_report(path: Path, comparison: Comparison, command: str) -> None:
    """Write the report, which the `command` makes, with its plot next to it."""
    plot = path.with_suffix(".png")
    parts = [
        "\n".join(f"- {line}" for line in comparison.advice),
        explanation("converge").format(LONG=LONG, RUNS=RUNS),
        f"![error against total seconds]({plot.name})",
        *_same_mesh(comparison),
        *_against(comparison),
        *(part for problem in PROBLEMS for part in _section(problem, comparison)),
    ]
    write_document(path, "Error against run time", command, parts)
    _draw(comparison, plot)


def _same_mesh(comparison: Comparison) -> list[str]:
    """CalculiX beside `fea` on the same meshes of the rod; nothing where they share none."""
    rows = []
    for ours, theirs in same_mesh(comparison.of("rod")):
        difference, bar = 100 * (theirs.value / ours.value - 1), ours.bar_percent or 0.0
        values = (f"{ours.value:.2f}", f"{bar:.2g}", f"{theirs.value:.2f}", _minus(difference))
        within = "yes" if abs(difference) <= bar else "**no**"
        rows.append((ours.computation.element.upper(), f"{ours.size:.3g}", *values, within))
    if not rows:
        return []
    header = ("element", "size mm", "fea MPa", "± %", "CalculiX MPa", "difference %", "within the bar")
    return [
        "## The same mesh and forces",
        explanation("converge-same-mesh"),
        markdown(header, rows, "lrrrrrl"),
    ]


def _against(comparison: Comparison) -> list[str]:
    """The table of equal error; none without CalculiX."""
    lines = []
    for problem in PROBLEMS:
        for at in equal_error(comparison.of(problem), comparison.floor(problem)):
            least = "" if math.isfinite(at.theirs) else "> "  # it did not reach this error
            ratio = "–" if math.isnan(at.ratio) else f"{least}{at.ratio:.1f}"
            goal = "yes" if at.goal_met else "not known" if least else "no"
            theirs = f"{least}{min(at.theirs, at.longest):.2f}"
            ours = _seconds(at.ours), _seconds(at.whole)
            lines.append((problem, f"{at.percent:g}", *ours, theirs, ratio, goal))
    header = (
        "problem",
        "within %",
        "fea s",
        "fea, whole s",
        "CalculiX s",
        "CalculiX / fea",
        f"{GOAL:g} or more",
    )
    text = ["## Against CalculiX", explanation("converge-calculix"), markdown(header, lines, "lrrrrr")]
    return text if lines else []


def _seconds(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def _minus(value: float) -> str:
    return f"{value:.2f}".replace("-", "−")


def _section(problem: str, comparison: Comparison) -> tuple[str, str, str]:
    rows, reference = comparison.of(problem), comparison.references[problem]
    front = pareto(rows, comparison.floor(problem))
    known = f" ± {reference.uncertainty_percent:.2g} %" if reference.uncertainty_percent else ", exact"
    lines = []
    for row in rows:
        error = _minus(row.error_percent)
        if abs(row.error_percent) < reference.uncertainty_percent:
            error = f"({error})"
        name, element = row.computation.name, row.computation.element.upper()
        bar = "" if row.bar_percent is None else f"{row.bar_percent:.2g}"
        best = "**yes**" if row in front else ""
        lines.append((name, element, *_costs(row), f"{row.value:.2f}", bar, error, best))
    header = ("tool", "element", "size mm", "dofs", "seconds", "MiB", "MPa", "± %", "error %", "front")
    table = markdown(header, lines, "llrrrrrrr")
    return f"## {QUANTITY[problem]}", f"Reference: {reference.value:.2f} MPa{known}.", table


_COLOURS = {
    "fea": "tab:blue",
    "fea, mean": "tab:orange",
    "fea, whole": "tab:green",
    "fea --tolerance": "tab:red",
    "CalculiX": "0.45",
}
_COARSE = "tab:purple"  # a tolerance reached from a coarse mesh, whose name contains the size


def _draw(comparison: Comparison, path: Path) -> None:
    """Draw one panel per problem; the Pareto front is shaded."""
    figure = new_figure(13, 6)
    for axes, problem in zip(figure.subplots(1, len(PROBLEMS)), PROBLEMS, strict=True):
        rows, floor = comparison.of(problem), comparison.floor(problem)
        for (_, tool, element), same in groupby(rows, key=lambda row: row.computation.series):
            x, y = _points(list(same))
            style, label = "-o" if element == "p2" else "--^", f"{tool}, {element.upper()}"
            color = _COLOURS.get(tool, _COARSE)
            axes.loglog(x, y, style, color=color, markersize=4, linewidth=1, label=label)
        front = _points(pareto(rows, floor))
        axes.loglog(*front, color="gold", linewidth=7, alpha=0.4, zorder=0, label="fastest for its error")
        if floor > FLOOR and floor < 100:
            axes.axhspan(FLOOR / 2, floor, color="0.9", zorder=-1, label="below the reference's uncertainty")
        axes.set(title=QUANTITY[problem], xlabel="total seconds", ylabel="error, %")
        axes.grid(alpha=0.3, which="both")
        log_ticks(axes)
        axes.legend(fontsize=7, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.13))
    figure.savefig(path, dpi=100)


def _points(rows: Sequence[ConvergenceRow]) -> tuple[list[float], list[float]]:
    return [row.seconds for row in rows], [max(abs(row.error_percent), FLOOR / 2) for row in rows]
