"""The sections of a report in their order, each with a template; empty ones are left out."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.analysis.life_figures import EnvelopeFigures
from fea.analysis.summary_figures import Summary
from fea.output import life_tables, tables
from fea.output.defect_answer import defect_tables
from fea.output.fretting import FRETTING, RANKED, fretting_tables
from fea.output.json_file import JsonObject
from fea.output.plots.chart import Chart, chart, log_chart
from fea.output.report.assumptions import assumptions, limits, note_groups
from fea.output.statements import full_statements
from fea.output.stored_run import Run
from fea.output.tables import AnswerTable, hand_tables, head_clearance_tables
from fea.output.units import factor, figure, named, study_value, unit
from fea.study.changes import TABLES
from fea.study.material_table import LIBRARY
from fea.study.study import ASSUMED_MATERIAL, Study
from geometry.arrays import Floats
from geometry.presets import ORIGINS, PRESETS


def force_charts(forces: Mapping[str, Any], marks: Mapping[str, float]) -> list[Chart]:
    """Return the charts of the forces over the cycle, from the columns of ``loads.csv``."""
    degrees = np.asarray(forces["crank_deg"], float)
    kilo = {name: 1e-3 * np.asarray(forces[name], float) for name in forces if name.endswith("_N")}
    drawn: Sequence[tuple[tuple[str, str, str], dict[str, Floats]]] = (
        (("chart-axial", "Force along the rod (tension positive)", "kN"),
         {"piston pin": kilo["pin_axial_N"], "crank pin": kilo["crank_axial_N"]}),
        (("chart-transverse", "Force across the rod", "kN"),
         {"piston pin": kilo["pin_transverse_N"], "crank pin": kilo["crank_transverse_N"]}),
        (("chart-gas", "Gas force and side force on the piston", "kN"),
         {"gas": kilo["gas_N"], "cylinder wall": kilo["wall_N"]}),
        (("chart-torque", "Torque on the crank", "N·m"), {"": np.asarray(forces["torque_Nm"], float)}),
    )  # fmt: skip
    return [chart(heading, degrees, curves, marks) for heading, curves in drawn]


_TITLES = {
    "rod": "Rod", "material": "Material", "engine": "Engine and gas", "speed": "Speed",
    "forces": "Given forces", "mesh": "Mesh", "analysis": "Analysis", "contact": "Pins in contact",
}  # fmt: skip
_GIVEN, _DEFAULT = "the study", "the program's default"


def input_tables(study: Study) -> Iterator[AnswerTable]:
    """Yield all inputs of a study, but those that say where results are written, and where they come from."""
    for name, values in replace(study, gauge=()).as_dict().items():  # gauges have a table of their own
        nested = {key: value for key, value in values.items() if isinstance(value, Mapping)}
        plain = {key: value for key, value in values.items() if key not in nested}
        title = _TITLES.get(name, name.replace("_", " ").capitalize())
        if name != "output":
            yield from _input_table(study, name, title, plain)
        for part, own in nested.items():
            yield from _input_table(study, "material", f"Material of {part.replace('_', ' ')}", own)


def _input_table(study: Study, table: str, title: str, values: Mapping[str, Any]) -> Iterator[AnswerTable]:
    head: tuple[str, ...] = ("input", "value", "unit", "source")
    rows: list[tuple[str, ...]] = []
    usual: JsonObject = {}
    if table in TABLES and table not in {"rod", "material", "engine", "speed"}:
        usual = {field.name: field.default for field in fields(TABLES[table])}
    for key, value in values.items():
        words, own = named(key)
        origin = _engine_origin(study, key, value) if table == "engine" else ""
        if not origin:
            origin = _DEFAULT if key in usual and usual[key] == value else _GIVEN
        rows.append((words, study_value(value, own), unit(own), origin))
    remark = _remark(study, table, values)
    if len(origins := {row[-1] for row in rows}) == 1:
        remark, head, rows = f"{remark} From {origins.pop()}.".strip(), head[:-1], [row[:-1] for row in rows]
    if rows:
        yield AnswerTable(title, head, tuple(rows), words=(0, 2, 3), remark=remark)


def _engine_origin(study: Study, key: str, value: object) -> str:
    """Return the source of a figure of an engine of the library; empty where the study gives it itself."""
    preset = None if study.engine is None else study.engine.library()
    known = None if preset is None else preset.engine.get(key)
    if preset is None or known is None or known.value != value:
        return ""
    return f"assumed: {known.origin}" if known.assumed else preset.sources.get(known.origin, known.origin)


def _remark(study: Study, table: str, values: Mapping[str, Any]) -> str:
    if table == "rod":
        same = [name for name, rod in PRESETS.items() if rod == study.rod.dimensions]
        return f"The rod {same[0]} of the library: {ORIGINS[same[0]]}" if same else ""
    if table == "material":
        known = ("E_GPa", "nu", "density_kg_m3", "yield_MPa", "ultimate_MPa", "endurance_MPa")
        given = {key: values[key] for key in known if values.get(key) is not None}
        alike = [m for m in LIBRARY.values() if given == {k: v for k, v in m.figures.items() if k in known}]
        assumed = "Assumed, as the study says nothing. " if study.material is ASSUMED_MATERIAL else ""
        return assumed + (f"The material {alike[0].name} of the library: {alike[0].source}" if alike else "")
    if table == "engine" and study.engine is not None and study.engine.library() is not None:
        preset = study.engine.library()
        return f"The engine {preset.name} of the library: {preset.title}." if preset else ""
    return ""


_SIGN = (
    "The sign of the von Mises stress is that of the mean stress where the curve is largest; elsewhere it is "
    "the same where the deviatoric stress points the same way."
)
_BARS = (
    "In 95 of 100 cases the true peak lies within the error bar of the computed one; the bar holds for the "
    "peak stress, and so for the safety factor."
)
_PROCESSORS = ("x86_64", "AMD64", "aarch64", "arm64")


@dataclass(frozen=True)
class ReportSection:
    """A section: its id and title, its template, what that needs, and a shorter title for the contents."""

    id: str
    title: str
    template: str
    content: Mapping[str, Any]
    short: str = ""


def sections(run: Run) -> Iterator[ReportSection]:
    """Yield the sections that a run has, in the order of the page."""
    summary = run.summary
    groups = note_groups(summary.notes, summary.survival.mode)
    assumed = {"statements": assumptions(run), "groups": groups}
    yield ReportSection("assumptions", "Assumptions", "statements.html.jinja", assumed)
    left_out = {"limits": list(limits(run)), "omissions": summary.left_out}
    yield ReportSection("limits", "What the model leaves out", "limits.html.jinja", left_out, "Left out")
    yield ReportSection("inputs", "Inputs", "inputs.html.jinja", {"tables": list(input_tables(run.study))})
    charts = [] if run.forces is None else force_charts(run.forces, marks(summary))
    fires = 360 if summary.cycle_degrees > 360 else 0
    angles = [f"Crank angles count from top dead centre; at {fires}° the engine fires."] if charts else []
    loads, open_tables = [tables.load_table(summary)], 0 if charts else 1
    yield from _answer(summary, "loads", "Loads", loads, text=angles, charts=charts, open_tables=open_tables)
    yield from _answer(summary, "results", "Results", tables.peak_tables(summary))
    yield from _answer(summary, "assembly", "Bolts, joint and fits", tables.assembly_tables(summary))
    yield from _answer(summary, "gauges", "Strain gauges", life_tables.gauge_tables(summary))
    if (cycle := summary.cycle) is not None:
        at = "" if cycle.crank_deg is None else f" at {figure(cycle.crank_deg, 3)}°"
        least = f"The least factor against yielding over the cycle is {factor(cycle.min_safety_factor)}{at}."
        histories, text = [_history_chart(summary, cycle)], [least, _SIGN]
        histories += [] if run.log is None else _log_charts(run.log)
        fatigue = life_tables.fatigue_tables(summary)
        yield from _answer(
            summary, "fatigue", "Cycle and fatigue", fatigue, text=text, charts=histories, open_tables=0
        )
    yield from _answer(summary, "defects", "Defects", defect_tables(summary))
    if run.film is not None and summary.film:
        charts = list(_film_charts(summary, run.film))
        title, found = "Oil films of the bearings", tables.film_tables(summary)
        films = _answer(summary, "film", title, found, charts=charts, open_tables=0)
        yield from (replace(section, template="film.html.jinja") for section in films)
    rubbed = list(fretting_tables(summary))
    yield from _answer(summary, FRETTING, "Fretting", rubbed, text=[RANKED] if rubbed else [])
    yield from _answer(summary, "buckling", "Buckling", tables.buckling_tables(summary))
    fixed = ["The mesh comes from a file and was not refined."] if summary.model.mesh_from_file else []
    gap = head_clearance_tables(summary)
    yield from _answer(summary, "head-clearance", "Piston to head", gap)
    for table in hand_tables(summary):
        content = {"table": table, "hand": list((summary.hand or {}).values())}
        yield ReportSection("hand", "Hand calculation", "hand.html.jinja", content)
    bars = tables.convergence_tables(summary)
    yield from _answer(summary, "convergence", "Convergence", bars, text=[_BARS, *fixed], open_tables=0)
    checks = tables.check_tables(summary)
    yield from _answer(
        summary, "checks", "Checks", checks, text=_passed(summary), open_tables=not summary.trusted
    )
    yield _repeat(run)


def _answer(
    summary: Summary,
    name: str,
    title: str,
    found: Iterable[AnswerTable],
    *,
    text: Sequence[str] = (),
    charts: Sequence[Chart] = (),
    open_tables: int = 1,
) -> Iterator[ReportSection]:
    """Yield a section with the statements on its topic, after some text of its own, if it has tables.

    After so many open tables the rest is folded behind a line that names it.
    """
    every, lines = list(found), [*text, *full_statements(summary, name)]
    content = {
        "tables": every[:open_tables],
        "folded": every[open_tables:],
        "named": "; ".join(table.caption.partition(":")[0] for table in every[open_tables:]),
        "text": lines,
        "charts": charts,
    }
    if every:
        yield ReportSection(name, title, "tables.html.jinja", content)


def _passed(summary: Summary) -> list[str]:
    passed = sum(check.passed for check in summary.checks.values())
    return [f"{passed} of {len(summary.checks)} checks of mesh, loads and solution passed."]


def _history_chart(summary: Summary, cycle: EnvelopeFigures) -> Chart:
    histories = [np.array(spot.history_MPa, float) for spot in cycle.spots]
    curves = dict(zip(life_tables.lettered(len(histories)), histories, strict=True))
    heading = ("chart-history", "Signed von Mises stress at the worst places", "MPa")
    return chart(heading, np.linspace(0.0, summary.cycle_degrees, cycle.instants), curves, marks(summary))


def _film_charts(summary: Summary, film: Mapping[str, npt.ArrayLike]) -> Iterator[Chart]:
    columns = {name: np.asarray(values, float) for name, values in film.items()}
    degrees, ends = np.arange(summary.cycle_degrees + 1.0), {"big end": "", "small end": "small_end_"}
    for name, title, given in _FILM_CHARTS:
        courses = {end: columns[first + name] for end, first in ends.items() if first + name in columns}
        curves = {end: np.interp(degrees, columns["crank_deg"], own) for end, own in courses.items()}
        yield chart((f"chart-{name}", title, given), degrees, curves, marks(summary))


def _log_charts(log: Mapping[str, npt.ArrayLike]) -> Iterator[Chart]:
    times, speed, damage = (np.asarray(log[name], float) for name in ("time_s", "rpm", "damage_percent"))
    yield log_chart(("chart-log-rpm", "Highest speed of the log", "rpm"), times, speed)
    yield log_chart(("chart-log-damage", "What eats the rod: share of the damage", "%"), times, damage)


_FILM_CHARTS = (
    ("h_min_um", "Smallest film", "µm"),
    ("p_max_MPa", "Highest pressure", "MPa"),
    ("power_W", "Friction power", "W"),
    ("filled_percent", "Share of the gap that is full of oil", "%"),
)


def _repeat(run: Run) -> ReportSection:
    summary = run.summary
    platform = summary.environment.platform
    processor = next((name for name in _PROCESSORS if name.lower() in platform.lower()), "")
    content = {
        "study": study_text(run),
        "environment": summary.environment,
        "system": " on ".join(part for part in (platform.partition("-")[0], processor) if part),
        "model": summary.model,
        "total_s": summary.total_s,
        "memory": summary.peak_memory_MiB,
    }
    return ReportSection(
        "repeat", "Versions, and how to repeat this run", "repeat.html.jinja", content, "Repeat"
    )


def marks(summary: Summary) -> dict[str, float]:
    """Return the crank angle, degrees, of each load case that is an instant of the cycle."""
    loads = summary.loads.items()
    return {name: load.crank_deg for name, load in loads if name != "gas" and load.crank_deg is not None}


def study_text(run: Run) -> str:
    """Return the study as a file; files are named without the folders of this machine."""
    text, study = run.study.text(), run.study
    named = [study.engine.gas] if study.engine is not None else []
    named += [str(file.path) for file in (study.rod.cad, study.rod.mesh) if file is not None]
    named += [study.duty.log] if study.duty is not None and study.duty.log is not None else []
    for path in named:
        text = text.replace(path, path.replace("\\", "/").rpartition("/")[2])
    return text
