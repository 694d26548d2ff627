"""The comparison in tables, for the terminal and for its page: a row each quantity, a column each design."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from fea.analysis.summary_figures import OnsetFigures
from fea.apps.compare.run_compare import ComparedDesign, ComparisonFigures
from fea.apps.limits.figures import LargestValue
from fea.base.units import KN
from fea.judge.safety_factor import SafetyFactor, interval
from fea.output.folder import make_directory, write_text
from fea.output.html import html_page, page_file
from fea.output.life_statements import lasting
from fea.output.tables import AnswerTable, TableColumn
from fea.output.terminal.prose import print_lines, terminal
from fea.output.units import UNKNOWN, bar, factor, heading, named, study_value

Quantities = Sequence[TableColumn]


def _with_bar(value: SafetyFactor | None) -> str:
    return UNKNOWN if value is None else f"{factor(value)} {interval(value)}".strip()


def _governing(design: ComparedDesign) -> str:
    survival = design.summary.survival
    where = ", ".join(part for part in (survival.mode, survival.case, survival.place) if part)
    return f"{where}: {_with_bar(survival.safety_factor)}"


def _answer(design: ComparedDesign) -> str:
    return design.summary.survival.answer if design.summary.trusted else "NOT TO BE TRUSTED: a check failed"


def _lasts(design: ComparedDesign) -> str | None:
    cycle = design.summary.cycle
    return None if cycle is None or cycle.life is None else lasting(cycle.life)


_RODS = (
    TableColumn("answer", "", _answer, words=True),
    TableColumn("governed by", "", _governing, words=True),
    TableColumn("speed", "rpm", lambda one: one.summary.rpm, ".0f"),
    TableColumn("mass", "g", lambda one: 1000 * one.summary.rod.mass_kg, ".1f"),
    TableColumn(
        "centre of gravity from the crank pin",
        "mm",
        lambda one: one.summary.rod.center_of_gravity_mm[0],
        ".1f",
    ),
)
_FACTORS = (
    TableColumn("yielding", "", lambda one: one.summary.min_safety_factor, _with_bar),
    TableColumn(
        "fatigue",
        "",
        lambda one: one.summary.envelope and one.summary.envelope.min_fatigue_safety_factor,
        _with_bar,
    ),
    TableColumn("fatigue, at most", "", lambda one: one.summary.survival.fatigue_at_most, _with_bar),
    TableColumn("buckling", "", lambda one: one.summary.buckling.min_safety_factor, _with_bar),
    TableColumn(
        "largest von Mises stress",
        "MPa",
        lambda one: max(case.max_von_mises_MPa for case in one.summary.results.values()),
        ".0f",
    ),
    TableColumn("life over the duty", "h", lambda one: one.summary.life and one.summary.life.hours, ".3g"),
    TableColumn("life at this speed", "", _lasts, words=True),
)


def _of(part: Callable[[ComparedDesign], Any], value: Callable[[Any], Any], design: ComparedDesign) -> Any:
    """Return a figure of a part of what was found of a design; None without that part."""
    found = part(design)
    return None if found is None else value(found)


def _joint(design: ComparedDesign) -> OnsetFigures | None:
    assembly = design.summary.assembly
    return None if assembly is None else assembly.joint.opens


_bolts = partial(partial, _of, lambda design: design.summary.assembly and design.summary.assembly.bolts)
_BOLTS = (
    TableColumn("thread", "", _bolts(lambda bolts: bolts.thread), words=True),
    TableColumn("preload", "kN", _bolts(lambda bolts: bolts.preload_N / KN), ".1f"),
    TableColumn("largest force", "kN", _bolts(lambda bolts: bolts.max_force_N / KN), ".1f"),
    TableColumn("yielding", "", _bolts(lambda bolts: bolts.yield_safety_factor), _with_bar),
    TableColumn("fatigue", "", _bolts(lambda bolts: bolts.bending_fatigue_safety_factor), _with_bar),
    TableColumn("the joint opens at", "× load", partial(_of, _joint, lambda onset: onset.load_factor), ".2f"),
)


def _films(end: str) -> Quantities:
    of = partial(partial, _of, lambda design: (design.summary.film or {}).get(end))
    return (
        TableColumn("smallest film", "µm", of(lambda film: film.h_min_um), ".2f"),
        TableColumn("its error bar", "%", of(lambda film: film.h_min_error_percent), bar),
        TableColumn("highest pressure", "MPa", of(lambda film: film.p_max_MPa), ".0f"),
        TableColumn("friction power", "W", of(lambda film: film.power_W), ".0f"),
        TableColumn("verdict", "", of(lambda film: film.verdict), words=True),
    )


def _limits(key: str, words: str, unit: str) -> Quantities:
    of = partial(partial, _of, lambda design: design.limits and getattr(design.limits, key))
    return (
        TableColumn(words, unit, of(lambda found: found.value), ".0f"),
        TableColumn("its error bar", unit, of(lambda found: found.bar), ".0f"),
        TableColumn("at", "rpm", of(_speed_of_peak), ".0f"),
        TableColumn("ended by", "", of(lambda found: found.ending), words=True),
    )


def _speed_of_peak(found: LargestValue) -> float | None:
    return None if found.value == found.rpm else found.rpm


_LIMITS = (
    *_limits("largest_rpm", "largest speed", "rpm"),
    *_limits("largest_peak_pressure_bar", "largest peak pressure", "bar"),
)
_PARTS: Mapping[str, Quantities] = {
    "Rods": _RODS,
    "Safety factors, with error bars": _FACTORS,
    "Bolts and joint": _BOLTS,
    "Oil film of the big end": _films("big_end"),
    "Oil film of the small end": _films("small_end"),
    "Limits at full load": _LIMITS,
}


def comparison_tables(found: ComparisonFigures) -> Iterator[AnswerTable]:
    """Yield the tables; what no design has is left out, and of two the second is set against the first."""
    names = [design.name for design in found.designs]
    both = len(names) == 2
    for caption, quantities in _PARTS.items():
        rows = []
        for each in quantities:
            values = [each.value(design) for design in found.designs]  # type: ignore[operator]
            if any(value is not None for value in values):
                cells = [each.proper(design) for design in found.designs]
                rows.append((each.heading, *cells, *([_change(*values)] if both else [])))
        if rows:
            head = ("quantity", *names, *(["second to first"] if both else []))
            yield AnswerTable(caption, head, tuple(rows))
    for caption, keys in (
        ("Judged by different assumptions, so that more than the rods differs", found.assumptions),
        ("Dimensions, materials and bolts that differ", found.dimensions),
    ):
        if keys:
            rows = []
            for key, entries in keys.items():
                words, unit = _words(key)
                rows.append((heading(words, unit), *(study_value(value, unit) for value in entries)))
            yield AnswerTable(caption, ("key", *names), tuple(rows))


def _change(first: Any, second: Any) -> str:
    """Return how much larger the second value is, and whether error bars hide that."""
    if not isinstance(first, float) or not isinstance(second, float) or not first:
        return ""
    percent = round(100 * (second / first - 1))
    change = f"{percent:+} %".replace("-", "−") if percent else "the same"
    if isinstance(first, SafetyFactor) and isinstance(second, SafetyFactor) and percent:
        overlap = first.low <= second.high and second.low <= first.high
        return f"{change}, within the bars" if overlap and first.low < first.high else change
    return change


def _words(key: str) -> tuple[str, str]:
    """Return a key in words, with its table where that is not the rod, and its unit."""
    table, _, name = key.rpartition(".")
    words, unit = named(name)
    return (words if table in ("rod", words) else f"{table.replace('.', ', ')}: {words}"), unit


def sentences(found: ComparisonFigures) -> Iterator[str]:
    """Yield what is said of each design, and whether all are judged alike."""
    for design in found.designs:
        yield f"{design.name}: {design.summary.survival.text}."
        if design.limits is not None:
            yield f"{design.name}: {design.limits.text}"
        if design.lacks is not None:
            yield f"{design.name} was solved without {design.lacks}."
    if not found.assumptions:
        yield "All are judged by the same engine, speed, pins and mesh settings."
    else:
        keys = ", ".join(_words(key)[0] for key in found.assumptions)
        yield f"Judged differently ({keys}); --same judges all as the first."


def print_comparison(found: ComparisonFigures) -> None:
    """Print the sentences and the tables."""
    console = terminal()
    print_lines(console, sentences(found))
    for table in comparison_tables(found):
        console.print(table.printed(gap=1, title=table.caption, title_justify="left"))


def write_page(path: Path, found: ComparisonFigures) -> None:
    """Write the page, in one file that fetches nothing; raises `StorageError`."""
    text = html_page(
        "report",
        "compare.html.jinja",
        page_file("report", "report.css") + page_file("report", "compare.css"),
        script="",
        title=" and ".join([", ".join(one.name for one in found.designs[:-1]), found.designs[-1].name]),
        lines=list(sentences(found)),
        kind="untrusted" if not found.trusted else "undecided" if found.assumptions else "alike",
        tables=list(comparison_tables(found)),
    )
    make_directory(path.parent)
    write_text(path, text)
