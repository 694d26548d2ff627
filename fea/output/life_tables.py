"""Tables of endurance, life and strain gauges, for the terminal and the report."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from fea.analysis.life_figures import DutyFigures, LifeFigures, ReliabilityFigures
from fea.analysis.summary_figures import Summary
from fea.output.tables import AnswerTable, TableColumn
from fea.output.units import coordinates, factor, number, place, quantity

_ENDURANCE = (
    TableColumn("of specimens", "MPa", "specimen_MPa", "4g"),
    TableColumn("size", "", "size_factor", "3g"),
    TableColumn("load", "", "load_factor", "3g"),
    TableColumn("reliability", "", "reliability_factor", "3g"),
    TableColumn("finish", "", lambda row: f"{row.finish}{', assumed' if row.assumed else ''}", words=True),
    TableColumn("surface", "", "surface_factor", "3g"),
    TableColumn("limit", "MPa", "endurance_MPa", "4g"),
)


_DUTY = (
    TableColumn("time", "%", "time_percent", ".3g"),
    TableColumn("damage", "%", "damage_percent", ".3g"),
    TableColumn("reversed amplitude", "MPa", "reversed_amplitude_MPa", ".4g"),
)


def endurance_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the endurance limit of each region of every part, with its factors."""
    limits = {} if summary.envelope is None else summary.envelope.endurance or {}
    rows = [
        (f"{part}, {region}", SimpleNamespace(**vars(limit), **vars(surface)))
        for part, limit in limits.items()
        for region, surface in limit.regions.items()
    ]
    caption = "Endurance limit: that of polished specimens times its factors"
    if any(limit.estimated for limit in limits.values()):
        caption += "; the limit of the specimens is estimated from the ultimate strength"
    if rows:
        yield AnswerTable.of(caption, "part, region", _ENDURANCE, rows)


def _duty_entry(life: LifeFigures, entry: DutyFigures) -> str:
    unit = "bar" if life.log is not None and life.log.load == "boost" else "%"
    load = "" if life.log is None or entry.load is None else f", {life.log.load} {entry.load:.3g} {unit}"
    return f"{entry.rpm:g} rpm{f', {entry.gas}' if entry.gas else ''}{load}"


def life_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield what each entry of a duty does to the rod at the place that fails first."""
    if (life := summary.life) is None:
        return
    times = "" if life.duties is None else f"; {number(life.duties, '.3g')} times the duty"
    caption = (
        f"The duty at {place(life.at_mm)} in {life.part}, with an endurance limit of "
        f"{quantity(life.endurance_MPa, '.4g', 'MPa')} there{times}; hours with {life.band_of} "
        f"(±{life.band_percent:.3g} %); {number(life.largest_range_percent, '.4g')} % of the damage by "
        "the largest range of each cycle"
    )
    ordered = sorted(life.duty, key=lambda entry: -(entry.damage_percent or 0.0))
    rows = [(_duty_entry(life, entry), entry) for entry in ordered]
    yield AnswerTable.of(caption, "speed", _DUTY, rows)


_LIVES = tuple(TableColumn(f"B{share}", "h", f"b{share}_hours", ".3g") for share in (1, 10, 50))


def reliability_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the hours by which shares of the rods have failed, of places and of the whole."""
    cycle = None if summary.cycle is None else summary.cycle.life
    for when, life in ((f"at {summary.rpm:g} rpm", cycle), ("over the duty", summary.life)):
        if life is not None and life.reliability is not None:
            yield _reliability_table(when, life.reliability)


def _reliability_table(when: str, found: ReliabilityFigures) -> AnswerTable:
    rows: list[tuple[str, Any]] = [(f"{each.count} × {each.where}", each) for each in found.places]
    rows.append(("rod, places independent", found))
    if found.at_most is not None:
        rows.append(("rod, places dependent", found.at_most))
    if found.rods > 1:
        engine = {"b1_hours": "", "b10_hours": found.engine_b10_hours, "b50_hours": ""}
        rows.append((f"first of {found.rods} rods", SimpleNamespace(**engine)))
    causes = [f"{cause.replace('_', ' ')} {value:.3g} %" for cause, value in found.scatter_percent.items()]
    for each in found.responses or ():
        low, high = (number(change, "+.1f") for change in each.change_percent)
        ends = f"amplitude {low} % at −2, {high} % at +2 of these"
        causes.append(f"{each.cause} {each.deviation:.3g} {each.unit} ({ends})")
    caption = f"Hours {when} by which 1, 10 and 50 % have failed"
    if found.conditional:
        caption += ", if the assumed strength or peak pressure is right"
    if found.failed_percent is not None:
        least, most = (number(value, ".3g") for value in found.failed_percent)
        caption += f"; by {number(found.by_hours, 'g')} h {least} to {most} % of the rods have failed"
    error = number(found.sampling_error_percent, ".1g")
    caption += f"; standard deviations: {', '.join(causes)}; error of sampling {error} %"
    return AnswerTable.of(caption, "what fails", _LIVES, rows)


_GAUGES = (
    TableColumn("strain", "µm/m", "strain_um_m", ".0f"),
    TableColumn("± of the mesh", "µm/m", "error_um_m", ".0f"),
    TableColumn("measured", "µm/m", "measured_um_m", ".0f"),
    TableColumn("computed less measured", "%", "more_percent", ".1f"),
)


def gauge_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the strain of each gauge in each load case, beside what was measured, and over the cycle."""
    rows: list[tuple[str, Any]] = []
    for gauge in summary.gauges or ():
        for case, one in gauge.cases.items():
            measured = one.measured_um_m
            more = 100 * (one.strain_um_m / measured - 1) if measured else None
            rows.append((f"{gauge.name}, {case}", SimpleNamespace(**vars(one), more_percent=more)))
        every = gauge.history_um_m or ()
        for what, strain in (("highest", max(every)), ("lowest", min(every))) if every else ():
            row = SimpleNamespace(strain_um_m=strain, error_um_m=None, measured_um_m=None, more_percent=None)
            rows.append((f"{gauge.name}, {what} of the cycle", row))
    if rows:
        yield AnswerTable.of("Strain gauges: mean strain along the grid", "gauge", _GAUGES, rows)


_SPOTS = (
    TableColumn("at x, y, z", "mm", "at_mm", coordinates),
    TableColumn("von Mises", "MPa", "max_von_mises_MPa", ".1f"),
    TableColumn("at crank angle", "°", "crank_deg", ".0f"),
    TableColumn("mean", "MPa", "mean_MPa", ".0f"),
    TableColumn("amplitude", "MPa", "amplitude_MPa", ".0f"),
    TableColumn("R", "", "stress_ratio", ".2f"),
    TableColumn("yielding", "", "safety_factor", factor),
    TableColumn("fatigue", "", "fatigue_safety_factor", factor),
    TableColumn("Crossland", "", "crossland_safety_factor", factor),
)


def lettered(count: int) -> list[str]:
    """Return the names of the worst places of the cycle: those of the plot and of the buttons."""
    return [f"place {chr(ord('A') + k)}" for k in range(count)]


def fatigue_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the worst places of the cycle, the endurance limits, and the duty, as far as there are any."""
    if summary.cycle is not None:
        spots = summary.cycle.spots
        caption = "The worst places of the whole cycle: stress history and safety factors"
        yield AnswerTable.of(caption, "place", _SPOTS, zip(lettered(len(spots)), spots, strict=True))
    yield from endurance_tables(summary)
    yield from life_tables(summary)
    yield from reliability_tables(summary)
