"""The tables of a report and of the terminal: cells are text, so that both only lay them out."""

import re
from dataclasses import dataclass, fields
from typing import Any

from rich.table import Table as RichTable

from fea.analysis.figures import AssemblyFigures, EnvelopeFigures, FilmFigures, LifeFigures, Summary
from fea.base.checks import TITLES
from fea.base.units import KN
from fea.judge.verdict import Verdict
from fea.output.terminal.run_lines import (
    SIDES,
    UNKNOWN,
    bar,
    factor,
    kilo,
    largest_force,
    number,
    place,
    plain_table,
)
from fea.output.units import in_cells, in_heading, in_rows
from fea.study.tables import unit_of

_SIGNS = {"degrees": "°", "percent": "%"}
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_AS_THEY_ARE = {
    "E": "Young's modulus E",
    "nu": "Poisson's ratio ν",
    "rpm": "speed",
    "pin": "force of the pin",
}


def named(key: str) -> tuple[str, str]:
    """Return the name of a key in words, and its unit (empty where it has none)."""
    words, unit = unit_of(key)
    return _AS_THEY_ARE.get(words, words), "rpm" if key == "rpm" else _SIGNS.get(unit, unit)


def figure(value: float | None, digits: int = 4) -> str:
    """Return a figure with so many significant digits, and a proper minus."""
    if value is None:
        return "–"
    text = f"{value:.{digits}g}"
    found = re.fullmatch(r"(.*)e([+-])0*(\d+)", text)
    if found:
        sign, power = "⁻" if found[2] == "-" else "", found[3].translate(_RAISED)
        text = f"{found[1]}·10{sign}{power}"
    return text.replace("-", "−")


def shown(value: object) -> str:
    """Return a value of a study as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return figure(value, 10)
    if isinstance(value, list | tuple):
        return ", ".join(shown(item) for item in value)
    return str(value)


_FILM = {
    "h min": "smallest film",
    "p max": "highest pressure",
    "power W": "friction power, W",
    "friction mep": "friction mean effective pressure",
    "flow l min": "oil flow, l/min",
    "temperature error K": "its error bar, K",
    "lambda min": "smallest film over roughness",
    "asperity": "largest share that asperities carry",
    "filled": "share of the gap that is full of oil",
}
_QUANTITY = ("quantity", "value")


@dataclass(frozen=True)
class Table:
    """A table: the first cell of each row is its heading."""

    caption: str  #: what it shows
    head: tuple[str, ...]  #: headings of the columns
    rows: tuple[tuple[str, ...], ...]  #: cells as text
    marked: tuple[int, ...] = ()  #: numbers of rows that stand out
    text: tuple[int, ...] = (0,)  #: numbers of columns that hold words and not figures

    @property
    def shown_head(self) -> list[str]:
        """The headings with the units that are shown."""
        return [in_heading(title) for title in self.head]

    @property
    def shown_rows(self) -> list[list[str]]:
        """The cells in these units; where a row holds a single quantity, its heading names the unit."""
        if self.head == _QUANTITY:
            return [[in_heading(row[0]), *in_cells(row[0], row[1:])] for row in self.rows]
        return list(in_rows(self.head, self.rows))

    def printed(self, **options: Any) -> RichTable:
        """Return the table for the terminal, with units below their headings, and options of its own."""
        head = ["\n".join(title.rsplit(", ", 1)) for title in self.shown_head]
        return plain_table(head, self.shown_rows, left=[head[column] for column in self.text], **options)


def case_table(summary: Summary) -> Table:
    """Return the load cases with what they do to the rod; the worst is marked."""
    rows: list[tuple[str, ...]] = []
    marked: list[int] = []
    for name, result in summary.results.items():
        if name == summary.worst_case:
            marked.append(len(rows))
        load = summary.loads[name]
        rows.append(
            (
                name, number(load.crank_deg, ".1f"), number(result.max_von_mises_MPa, ".1f"),
                bar(result.error_percent), place(result.at_mm), factor(result.min_safety_factor),
                number(result.max_principal_MPa, ".0f"), number(result.min_principal_MPa, ".0f"),
                number(result.max_displacement_mm, ".3f"),
            )
        )  # fmt: skip
        rows += [
            (f"{name}, sharp edge {edge.name}", "", number(edge.structural_von_mises_MPa, ".1f"),
             bar(edge.error_percent),
             place(edge.at_mm), factor(edge.safety_factor), "", "", "")
            for edge in result.sharp_edges or ()
        ]  # fmt: skip
    head = ("load case", "crank angle, °", "von Mises, MPa", "±, %", "at x, y, z, mm", "safety factor",
            "largest principal, MPa", "least principal, MPa", "displacement, mm")  # fmt: skip
    return _signed(Table("Peak stresses of the load cases", head, tuple(rows), tuple(marked)))


def head_table(summary: Summary) -> Table:
    """Return what a reader looks at first of the load cases."""
    full, order = case_table(summary), (0, 5, 2, 3, 1, 4)
    rows = tuple(tuple(row[k] for k in order) for row in full.rows)
    return Table(full.caption, tuple(full.head[k] for k in order), rows, full.marked)


def _torque(newton_metres: float | None) -> str:
    small = newton_metres is not None and abs(newton_metres) < _WHOLE
    return number(newton_metres, ".3g" if small else ".0f")


_WHOLE = 100.0  # N·m: torques from here on have no decimals


def load_table(summary: Summary) -> Table:
    """Return the forces of the load cases."""
    largest = largest_force(summary.loads.values())
    rows = [
        (
            name, number(load.crank_deg, ".1f"), *(kilo(force, largest) for force in (
                load.gas_N, load.pin_axial_N, load.pin_transverse_N, load.crank_axial_N,
                load.crank_transverse_N, load.wall_N)), _torque(load.torque_Nm),
        )
        for name, load in summary.loads.items()
    ]  # fmt: skip
    head = ("load case", "crank angle, °", "gas, kN", "pin along, kN", "pin across, kN", "crank along, kN",
            "crank across, kN", "wall, kN", "torque, N·m")  # fmt: skip
    caption = "Forces of the load cases; forces on the rod along it are positive in tension"
    return _signed(Table(caption, head, tuple(rows)))


def check_table(summary: Summary) -> Table:
    """Return every check with its limit."""
    rows, checks = list[tuple[str, ...]](), summary.checks
    marked = tuple(number for number, check in enumerate(checks.values()) if not check.passed)
    for name, check in checks.items():
        words = TITLES.get(name, name.replace("_", " "))
        verdict = "passed" if check.passed else "FAILED"
        rows.append((words, figure(check.value, 3), figure(check.limit, 3), verdict))
    caption = "Checks: each value must not exceed its limit; relative, unless it is a count or a ratio"
    return Table(caption, ("check", "value", "limit", "verdict"), tuple(rows), marked, (0, 3))


def film_table(end: str, film: FilmFigures) -> Table:
    """Return the figures of the oil film of an end, ``big_end`` or ``small_end``."""
    rows = []
    for field in fields(film):
        value, (words, unit) = getattr(film, field.name), named(field.name)
        heading = "at crank angle" if unit == "°" else _FILM.get(words, words)
        heading = "its error bar" if words.endswith(" error") else heading
        if value is not None:
            text = value if isinstance(value, str) else figure(value)
            rows.append((f"{heading}, {unit}" if unit else heading, text))
    caption = f"The film of the {end.replace('_', ' ')} over the crank cycle"
    return Table(caption, _QUANTITY, tuple(rows))


def convergence_tables(summary: Summary) -> list[Table]:
    """Return the error bars and verdicts of the load cases, and the passes of the refinement."""
    cases = tuple(
        (name, bar(case.error_percent), number(case.energy_error_percent, ".1f"), case.verdict or UNKNOWN)
        for name, case in summary.results.items()
    )
    loose = tuple(k for k, row in enumerate(cases) if row[3] not in {Verdict.CONVERGED, UNKNOWN})
    bars = ("load case", "error bar of the peak, %", "error in the energy norm, %", "verdict")
    tables = [Table("Error bars", bars, cases, loose, (0, 3))]
    if summary.passes:
        passes = tuple(
            (str(k), str(one.elements), str(one.nodes), bar(one.error_percent), f"{one.seconds:.1f}")
            for k, one in enumerate(summary.passes, start=1)
        )
        head = ("pass", "elements", "nodes", "largest error bar, %", "time, s")
        tables.append(Table("Refinement of the mesh", head, passes))
    return tables


def cycle_table(found: EnvelopeFigures) -> Table:
    """Return the worst places of the cycle; the letters are those of the plot and of the buttons."""
    rows = [
        (
            f"place {chr(ord('A') + k)}", place(spot.at_mm), number(spot.max_von_mises_MPa, ".1f"),
            number(spot.crank_deg, ".0f"), number(spot.mean_MPa, ".0f"), number(spot.amplitude_MPa, ".0f"),
            number(spot.stress_ratio, ".2f"), factor(spot.safety_factor), factor(spot.fatigue_safety_factor),
            factor(spot.crossland_safety_factor),
        )
        for k, spot in enumerate(found.spots)
    ]  # fmt: skip
    head = ("place", "at x, y, z, mm", "von Mises, MPa", "at crank angle, °", "mean, MPa", "amplitude, MPa",
            "R", "yielding", "fatigue", "Crossland")  # fmt: skip
    caption = "The worst places of the whole cycle: stress history and safety factors"
    return _signed(Table(caption, head, tuple(rows)))


def endurance_table(summary: Summary) -> Table | None:
    """Return the endurance limit of each region of every part, with its factors."""
    limits = {} if summary.envelope is None else summary.envelope.endurance or {}
    rows = []
    for part, limit in limits.items():
        for region, skin in limit.regions.items():
            finish = f"{skin.finish}{', assumed' if skin.assumed else ''}"
            rows.append(
                (
                    f"{part}, {region}", figure(limit.specimen_MPa), figure(limit.size_factor, 3),
                    figure(limit.load_factor, 3), figure(limit.reliability_factor, 3), finish,
                    figure(skin.surface_factor, 3), figure(skin.endurance_MPa),
                )
            )  # fmt: skip
    if not rows:
        return None
    estimated = any(limit.estimated for limit in limits.values())
    factors = ("size", "load", "reliability", "finish", "surface")
    head = ("part, region", "of specimens, MPa", *factors, "limit, MPa")
    said = "Endurance limit: that of polished specimens times its factors"
    said += "; the limit of the specimens is estimated from the ultimate strength" if estimated else ""
    return Table(said, head, tuple(rows), text=(0, 5))


def life_table(found: LifeFigures | None) -> Table | None:
    """Return what each entry of a duty does to the rod at the place that fails first."""
    if found is None:
        return None
    rows = tuple(
        (
            f"{entry.rpm:g} rpm{f', {entry.gas}' if entry.gas else ''}", number(entry.time_percent, ".3g"),
            number(entry.damage_percent, ".3g"), number(entry.reversed_amplitude_MPa, ".4g"),
        )
        for entry in sorted(found.duty, key=lambda entry: -(entry.damage_percent or 0.0))
    )  # fmt: skip
    times = "" if found.duties is None else f"; {number(found.duties, '.3g')} times the duty"
    caption = (
        f"The duty at ({place(found.at_mm)}) mm in {found.part}, with an endurance limit of "
        f"{number(found.endurance_MPa, '.4g')} MPa there{times}; hours with {found.band_of} "
        f"(±{found.band_percent:.3g} %); {number(found.largest_range_percent, '.4g')} % of the damage by "
        "the largest range of each cycle"
    )
    return Table(caption, ("speed", "time, %", "damage, %", "reversed amplitude, MPa"), rows)


def buckling_tables(summary: Summary) -> list[Table]:
    """Return the column formulas, and the buckling modes of the solid."""
    column, tables = summary.buckling.column, []
    if column.case is not None:
        rows = tuple(
            (
                SIDES.get(name, name), number(plane.slenderness, ".1f"),
                *(number(load / 1000, ".1f") for load in critical),
                *(factor(load / column.force_N) for load in critical),
            )
            for name, plane in column.planes.items()
            for critical in [(plane.euler_N, plane.johnson_N, plane.rankine_N)]
        )  # fmt: skip
        head = ("bending", "slenderness", "Euler, kN", "Johnson, kN", "Rankine, kN", "factor, Euler",
                "factor, Johnson", "factor, Rankine")  # fmt: skip
        caption = f"The shank as a column under {column.force_N / 1000:.1f} kN ({column.case})"
        tables.append(Table(caption, head, rows))
    modes = tuple(
        (f"{case}, mode {k}", f"{mode.factor:.2f}", mode.moves)
        for case, of_case in (summary.buckling.modes or {}).items()
        for k, mode in enumerate(of_case, start=1)
    )
    if modes:
        kinds = ("load case", "factor on the load", "the rod moves")
        tables.append(Table("Buckling modes of the solid", kinds, modes, text=(0, 2)))
    return tables


def contact_table(summary: Summary) -> Table | None:
    """Return the contact on the bores in every load case."""
    rows = [
        (
            f"{name}, {bore.replace('_bore', '').replace('_', ' ')}", number(touch.max_pressure_MPa, ".1f"),
            number(touch.at_deg, ".0f"), number(touch.at_z_mm, ".1f"), number(touch.arc_deg, ".0f"),
            number(1e3 * touch.widest_mm, "+.0f"), number(touch.widest_deg, ".0f"),
            number(1e3 * touch.narrowest_mm, "+.0f"), number(touch.narrowest_deg, ".0f"),
        )
        for name, case in summary.results.items()
        for bore, touch in (case.contact or {}).items()
    ]  # fmt: skip
    head = ("load case, bore", "pressure, MPa", "at, °", "at z, mm", "arc, °", "widest, µm", "at, °",
            "narrowest, µm", "at, °")  # fmt: skip
    caption = "Contact with the pins: largest pressure, change of the bores' diameters; 0° is along the rod"
    return _signed(Table(caption, head, tuple(rows))) if rows else None


def _signed(table: Table) -> Table:
    rows = tuple((row[0], *(cell.replace("-", "−") for cell in row[1:])) for row in table.rows)
    return Table(table.caption, table.head, rows, table.marked, table.text)


def assembly_tables(found: AssemblyFigures) -> list[Table]:
    """Return the bolts, the joint by load case, and each fit by load case."""
    bolts = found.bolts
    hardest = max((one for case in bolts.by_case.values() for one in case), key=lambda one: one.force_N)
    rows = (
        ("preload after tightening and embedding, kN", number(bolts.preload_N / KN, ".1f")),
        ("largest force, kN", number(bolts.max_force_N / KN, ".1f")),
        ("amplitude, kN", number(bolts.amplitude_N / KN, ".2g")),
        ("load factor Φ of the bolt with the largest force", number(hardest.load_factor, ".2g")),
        ("load factor Φ of a central load", number(bolts.vdi_load_factor, ".2g")),
        ("largest force over proof load", number(bolts.proof_use, ".2f")),
        ("stress at tightening over yield strength", number(bolts.tightening_use, ".2f")),
        ("safety factor against yielding", factor(bolts.yield_safety_factor)),
        ("alternating stress in the thread, MPa", figure(bolts.alternating_stress_MPa, 3)),
        ("endurance limit of the thread, MPa", figure(bolts.endurance_MPa, 3)),
        ("safety factor against fatigue", factor(bolts.fatigue_safety_factor)),
        ("largest bending stress, MPa", figure(bolts.max_bending_MPa, 3)),
        ("safety factor against yielding of the outer fibre", factor(bolts.bending_yield_safety_factor)),
        ("alternating stress with bending, MPa", figure(bolts.bending_alternating_stress_MPa, 3)),
        ("safety factor against fatigue with bending", factor(bolts.bending_fatigue_safety_factor)),
        ("largest pressure under head or nut, MPa", figure(bolts.seat_pressure_MPa, 3)),
        ("largest moment on a seat over that which lifts its edge", number(bolts.seat_lift_ratio, ".2f")),
        ("shear stress where it bears on its hole, MPa", figure(bolts.shear_MPa, 3)),
    )
    joint_rows = tuple(
        (
            case,
            _ends([bolt.force_N / KN for bolt in bolts.by_case[case]]),
            number(joint.clamp_force_N / KN, ".1f"), number(joint.open_percent, ".0f"),
            number(joint.opening_um, ".1f"), number(joint.slipping_percent, ".0f"),
            number(joint.slip_um, ".1f"), number(joint.slip_reserve, ".3g"),
        )
        for case, joint in found.joint.by_case.items()
    )  # fmt: skip
    opening = ("open, %", "gap, µm", "micro-slip, %", "by, µm")
    head = ("joint", "bolts, kN", "clamped, kN", *opening, "slip safety")
    tables = [
        Table(f"Bolts, {bolts.thread}, by VDI 2230", _QUANTITY, rows),
        Table(f"Joint between rod and cap, friction {found.joint.friction:g}", head, joint_rows),
    ]
    for name, fit in found.fits.items():
        interference = f"{1e3 * fit.interference_mm:.0f} µm of interference"
        fit_rows = tuple(
            (
                case,
                number(face.mean_pressure_MPa, ".1f"), number(face.min_pressure_MPa, ".1f"),
                number(face.max_pressure_MPa, ".1f"), number(face.open_percent, ".0f"),
                number(face.slipping_percent, ".0f"),
            )
            for case, face in fit.by_case.items()
        )  # fmt: skip
        columns = (name, "mean, MPa", "least, MPa", "largest, MPa", "lifted, %", "micro-slip, %")
        tables.append(Table(f"Fit of the {name}: pressures on the seat, {interference}", columns, fit_rows))
    return tables


def _ends(forces: list[float]) -> str:
    said = sorted({number(force, ".1f") for force in forces}, key=float)
    return said[0] if len(said) == 1 else f"{said[0]}…{said[-1]}"
