"""The tables of the answer: each is described once, by its columns, for the terminal and the report."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from types import SimpleNamespace
from typing import Any, NamedTuple

from rich.table import Table as RichTable

from fea.analysis.summary_figures import HandFigures, Summary
from fea.base.checks import TITLES
from fea.base.units import KN, UM
from fea.judge.verdict import ConvergenceVerdict
from fea.output.terminal.prose import plain_table
from fea.output.units import bar, coordinates, factor, figure, heading, kilo, named, number, quantity

# The unit at the end of an attribute's name, and its factor, for columns in a larger or smaller unit.
_LARGER = {"kN": ("_N", KN), "µm": ("_mm", UM)}


class OnTerminal(NamedTuple):
    """How the terminal shows a column of the load cases."""

    title: str
    narrowest: int = 5  #: number of the last of the layouts, from wide to narrow, that has the column
    form: str = ""  #: the format, where it is another one


@dataclass(frozen=True)
class TableColumn:
    """A column: its title, its unit, the value that it reads of a row, and the format of that value.

    The value is an attribute's name or a function. The format is that of a number in the unit of the column,
    such as ``.1f``, or ``4g`` for `figure` with four digits, or a function that returns text. A value that is
    text stays as it is.
    """

    title: str
    unit: str
    value: str | Callable[[Any], Any]
    form: str | Callable[[Any], str] = ""
    words: bool = False  #: whether its cells are words, which stand on the left
    terminal: OnTerminal | None = None  #: of the load cases: how the terminal shows it, if it does

    @property
    def heading(self) -> str:
        """The title with the unit that is shown."""
        return heading(self.title, self.unit)

    def cell(self, row: Any) -> str:
        """Return the text of a row's cell."""
        value = getattr(row, self.value) if isinstance(self.value, str) else self.value(row)
        if isinstance(value, str):
            return value
        if callable(self.form):
            return self.form(value)
        suffix, per = _LARGER.get(self.unit, ("", 1.0))
        if value is not None and suffix and isinstance(self.value, str) and self.value.endswith(suffix):
            value = value / per
        if self.form.endswith("g") and self.form[0] != ".":
            return figure(value, int(self.form[:-1]), self.unit)
        return number(value, self.form, self.unit)

    def proper(self, row: Any) -> str:
        """Return the text of a row's cell with a proper minus."""
        return self.cell(row) if self.words else self.cell(row).replace("-", "−")


@dataclass(frozen=True)
class AnswerTable:
    """A table as text: the first cell of each row is its heading."""

    caption: str  #: what it shows
    head: tuple[str, ...]  #: headings of the columns
    rows: tuple[tuple[str, ...], ...]  #: cells
    marked: tuple[int, ...] = ()  #: numbers of rows that stand out
    words: tuple[int, ...] = (0,)  #: numbers of columns that hold words and not figures
    remark: str = ""  #: below the caption

    @classmethod
    def of(
        cls,
        caption: str,
        title: str,
        columns: Sequence[TableColumn],
        rows: Iterable[tuple[str, Any]],
        marked: Iterable[int] = (),
    ) -> "AnswerTable":
        """Return the table of some rows with their headings, whose column has a title."""
        cells = tuple((name, *(column.proper(row) for column in columns)) for name, row in rows)
        words = (0, *(k for k, column in enumerate(columns, start=1) if column.words))
        return cls(caption, (title, *(column.heading for column in columns)), cells, tuple(marked), words)

    @classmethod
    def of_quantities(cls, caption: str, quantities: Iterable[TableColumn], source: Any) -> "AnswerTable":
        """Return the table of the quantities of one thing, a row each."""
        rows = tuple((each.heading, each.proper(source)) for each in quantities)
        return cls(caption, ("quantity", "value"), rows)

    def printed(self, **options: Any) -> RichTable:
        """Return the table for the terminal, with units below their headings, and options of its own."""
        head = ["\n".join(title.rsplit(", ", 1)) for title in self.head]
        return plain_table(head, self.rows, left=[head[column] for column in self.words], **options)


def case_rows(summary: Summary, most_edges: int | None = None) -> Iterator[Any]:
    """Yield every load case with what acts and its extremes, each followed by so many of its sharp edges.

    An edge, which has a letter, has only a peak and its factor, by the names that those of a load case have.
    """
    loads = summary.loads
    forces = [abs(force) for load in loads.values() for force in (load.pin_axial_N, load.crank_axial_N)]
    for name, result in summary.results.items():
        case = vars(loads[name]) | vars(result) | {"case": name, "edge": "", "largest_N": max(forces)}
        yield SimpleNamespace(**case)
        for edge in (result.sharp_edges or ())[:most_edges]:
            peak = {
                "case": name,
                "edge": edge.name,
                "max_von_mises_MPa": edge.structural_von_mises_MPa,
                "error_percent": edge.error_percent,
                "at_mm": edge.at_mm,
                "min_safety_factor": edge.safety_factor,
            }
            yield SimpleNamespace(**dict.fromkeys(case, "") | peak)


def _force(name: str) -> Callable[[Any], str]:
    def text(row: Any) -> str:
        force = getattr(row, name)
        return force if isinstance(force, str) else kilo(force, row.largest_N)

    return text


def _torque(newton_metres: float | None) -> str:
    if newton_metres is None or abs(newton_metres) >= 100:
        return number(newton_metres, ".0f", "N·m")
    return number(round(newton_metres, 9), ".3g", "N·m")  # rounding leaves less of a zero


# The columns of the load cases. The report has a table of each kind; the terminal one, of those that say so.
_ANGLE = TableColumn("crank angle", "°", "crank_deg", ".1f", terminal=OnTerminal("crank", 4, ".0f"))
FORCES = (
    _ANGLE,
    TableColumn("gas", "kN", _force("gas_N")),
    TableColumn("pin along", "kN", _force("pin_axial_N"), terminal=OnTerminal("pin", 3)),
    TableColumn("pin across", "kN", _force("pin_transverse_N")),
    TableColumn("crank along", "kN", _force("crank_axial_N"), terminal=OnTerminal("crank", 3)),
    TableColumn("crank across", "kN", _force("crank_transverse_N")),
    TableColumn("wall", "kN", _force("wall_N"), terminal=OnTerminal("wall", 2)),
    TableColumn("torque", "N·m", "torque_Nm", _torque),
)
PEAKS = (
    _ANGLE,
    TableColumn("von Mises", "MPa", "max_von_mises_MPa", ".1f", terminal=OnTerminal("Mises")),
    TableColumn("±", "%", "error_percent", bar, terminal=OnTerminal("±")),
    TableColumn("at x, y, z", "mm", "at_mm", coordinates, terminal=OnTerminal("at x, y, z", 4)),
    TableColumn("safety factor", "", "min_safety_factor", factor, terminal=OnTerminal("safety\nfactor")),
    TableColumn("largest principal", "MPa", "max_principal_MPa", ".0f"),
    TableColumn("least principal", "MPa", "min_principal_MPa", ".0f"),
    TableColumn("displacement", "mm", "max_displacement_mm", ".3f", terminal=OnTerminal("displ.", 2)),
)
# At the head of a report.
_FIRST = ("safety factor", "von Mises", "±", "crank angle", "at x, y, z")


def case_table(summary: Summary, columns: Sequence[TableColumn] = PEAKS) -> AnswerTable:
    """Return the load cases with what they do to the rod; the worst is marked."""
    cases = list(case_rows(summary))
    rows = [(f"{row.case}, sharp edge {row.edge}" if row.edge else row.case, row) for row in cases]
    marked = [k for k, row in enumerate(cases) if row.case == summary.worst_case and not row.edge]
    return AnswerTable.of("Peak stresses of the load cases", "load case", columns, rows, marked)


def head_table(summary: Summary) -> AnswerTable:
    """Return what a reader looks at first of the load cases."""
    titled = {column.title: column for column in PEAKS}
    return case_table(summary, [titled[title] for title in _FIRST])


def load_table(summary: Summary) -> AnswerTable:
    """Return the forces of the load cases."""
    caption = "Forces of the load cases; forces on the rod along it are positive in tension"
    rows = [(row.case, row) for row in case_rows(summary, most_edges=0)]
    return AnswerTable.of(caption, "load case", FORCES, rows)


_CONTACT = (
    TableColumn("pressure", "MPa", "max_pressure_MPa", ".1f"),
    TableColumn("at", "°", "at_deg", ".0f"),
    TableColumn("at z", "mm", "at_z_mm", ".1f"),
    TableColumn("arc", "°", "arc_deg", ".0f"),
    TableColumn("widest", "µm", "widest_mm", "+.0f"),
    TableColumn("at", "°", "widest_deg", ".0f"),
    TableColumn("narrowest", "µm", "narrowest_mm", "+.0f"),
    TableColumn("at", "°", "narrowest_deg", ".0f"),
)


def peak_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the peaks of the load cases, and the contact on the bores."""
    yield case_table(summary)
    yield from contact_tables(summary)


def contact_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the contact on the bores in every load case."""
    rows = [
        (f"{name}, {bore.replace('_bore', '').replace('_', ' ')}", contact)
        for name, case in summary.results.items()
        for bore, contact in (case.contact or {}).items()
    ]
    caption = "Contact with the pins: largest pressure, change of the bores' diameters; 0° is along the rod"
    if rows:
        yield AnswerTable.of(caption, "load case, bore", _CONTACT, rows)


_BOLTS = (
    TableColumn("preload, less embedding if that is given", "kN", "preload_N", ".1f"),
    TableColumn("largest force", "kN", "max_force_N", ".1f"),
    TableColumn("amplitude", "kN", "amplitude_N", ".2g"),
    TableColumn("load factor Φ of the bolt with the largest force", "", "largest_load_factor", ".2g"),
    TableColumn("load factor Φ of a central load", "", "vdi_load_factor", ".2g"),
    TableColumn("largest force over proof load", "", "proof_use", ".2f"),
    TableColumn("stress at tightening over yield strength", "", "tightening_use", ".2f"),
    TableColumn("safety factor against yielding", "", "yield_safety_factor", factor),
    TableColumn("alternating stress in the thread", "MPa", "alternating_stress_MPa", "3g"),
    TableColumn("endurance limit of the thread", "MPa", "endurance_MPa", "3g"),
    TableColumn("safety factor against fatigue", "", "fatigue_safety_factor", factor),
    TableColumn("largest bending stress", "MPa", "max_bending_MPa", "3g"),
    TableColumn(
        "safety factor against yielding of the outer fibre", "", "bending_yield_safety_factor", factor
    ),
    TableColumn("alternating stress with bending", "MPa", "bending_alternating_stress_MPa", "3g"),
    TableColumn("safety factor against fatigue with bending", "", "bending_fatigue_safety_factor", factor),
    TableColumn("largest pressure under head or nut", "MPa", "seat_pressure_MPa", "3g"),
    TableColumn("largest moment on a seat over that which lifts its edge", "", "seat_lift_ratio", ".2f"),
    TableColumn("shear stress where it bears on its hole", "MPa", "shear_MPa", "3g"),
)
_JOINT = (
    TableColumn("bolts", "kN", lambda row: _range([bolt.force_N for bolt in row.bolts])),
    TableColumn("clamped", "kN", "clamp_force_N", ".1f"),
    TableColumn("open", "%", "open_percent", ".0f"),
    TableColumn("gap", "µm", "opening_um", ".1f"),
    TableColumn("micro-slip", "%", "slipping_percent", ".0f"),
    TableColumn("by", "µm", "slip_um", ".1f"),
    TableColumn("slip safety", "", "slip_reserve", ".3g"),
)
_FIT = (
    TableColumn("mean", "MPa", "mean_pressure_MPa", ".1f"),
    TableColumn("least", "MPa", "min_pressure_MPa", ".1f"),
    TableColumn("largest", "MPa", "max_pressure_MPa", ".1f"),
    TableColumn("lifted", "%", "open_percent", ".0f"),
    TableColumn("micro-slip", "%", "slipping_percent", ".0f"),
)


def assembly_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the bolts, the joint by load case, and each fit by load case."""
    if (assembly := summary.assembly) is None:
        return
    bolts, joint = assembly.bolts, assembly.joint
    largest = max((bolt for case in bolts.by_case.values() for bolt in case), key=lambda bolt: bolt.force_N)
    quantities = SimpleNamespace(**vars(bolts), largest_load_factor=largest.load_factor)
    yield AnswerTable.of_quantities(f"Bolts, {bolts.thread}, by VDI 2230", _BOLTS, quantities)
    cases = joint.by_case.items()
    rows = [(case, SimpleNamespace(bolts=bolts.by_case[case], **vars(found))) for case, found in cases]
    yield AnswerTable.of(f"Joint between rod and cap, friction {joint.friction:g}", "joint", _JOINT, rows)
    for name, fit in assembly.fits.items():
        interference = f"{quantity(fit.interference_mm / UM, '.0f', 'µm')} of interference"
        caption = f"Fit of the {name}: pressures on the seat, {interference}"
        yield AnswerTable.of(caption, name, _FIT, fit.by_case.items())


def _range(newtons: Sequence[float]) -> str:
    low, high = (number(force / KN, ".1f", "kN") for force in (min(newtons), max(newtons)))
    return low if low == high else f"{low}…{high}"


SIDES = {"in_plane": "in the plane of motion", "sideways": "sideways"}
_FORMULAS = ("Euler", "Johnson", "Rankine")
_PLANES = (
    TableColumn("slenderness", "", "slenderness", ".1f"),
    *(TableColumn(name, "kN", f"{name.lower()}_N", ".1f") for name in _FORMULAS),
    *(TableColumn(f"factor, {name}", "", f"{name.lower()}_factor", factor) for name in _FORMULAS),
)
_MODES = (
    TableColumn("factor on the load", "", "factor", ".2f"),
    TableColumn("the rod moves", "", "moves", words=True),
)


def buckling_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the column formulas, and the buckling modes of the solid."""
    column = summary.buckling.column
    if column.case is not None:
        rows = []
        for name, plane in column.planes.items():
            critical = {formula.lower(): getattr(plane, f"{formula.lower()}_N") for formula in _FORMULAS}
            factors = {f"{formula}_factor": load / column.force_N for formula, load in critical.items()}
            rows.append((SIDES.get(name, name), SimpleNamespace(**vars(plane), **factors)))
        load = f"{quantity(column.force_N / KN, '.1f', 'kN')} ({column.case})"
        yield AnswerTable.of(f"The shank as a column under {load}", "bending", _PLANES, rows)
    modes = [
        (f"{case}, mode {k}", mode)
        for case, of_case in (summary.buckling.modes or {}).items()
        for k, mode in enumerate(of_case, start=1)
    ]
    if modes:
        yield AnswerTable.of("Buckling modes of the solid", "load case", _MODES, modes)


# Fields of an oil film whose names do not say enough.
_FILM = {
    "h_min_um": "smallest film", "p_max_MPa": "highest pressure", "power_W": "friction power, W",
    "friction_mep_bar": "friction mean effective pressure", "flow_l_min": "oil flow, l/min",
    "lambda_min": "smallest film over roughness", "asperity_percent": "largest share that asperities carry",
    "filled_percent": "share of the gap that is full of oil",
}  # fmt: skip


def film_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the figures of the oil film of each end."""
    for end, film in (summary.film or {}).items():
        quantities = []
        for name in (field.name for field in fields(film) if getattr(film, field.name) is not None):
            words, own = ("temperature error", "K") if name == "temperature_error_K" else named(name)
            title = "at crank angle" if own == "°" else _FILM.get(name, words)
            title = "its error bar" if words.endswith(" error") else title
            quantities.append(TableColumn(title, own, name, "4g"))
        caption = f"The film of the {end.replace('_', ' ')} over the crank cycle"
        yield AnswerTable.of_quantities(caption, quantities, film)


_BARS = (
    TableColumn("error bar of the peak", "%", "error_percent", bar),
    TableColumn("error in the energy norm", "%", "energy_error_percent", ".1f"),
    TableColumn("verdict", "", "verdict", words=True),
)
_PASSES = (
    TableColumn("elements", "", "elements", ".0f"),
    TableColumn("nodes", "", "nodes", ".0f"),
    TableColumn("largest error bar", "%", "error_percent", bar),
    TableColumn("time", "s", "seconds", ".1f"),
)


def convergence_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the error bars and verdicts of the load cases, and the passes of the refinement."""
    cases = summary.results.items()
    loose = [
        k for k, (_, case) in enumerate(cases) if case.verdict not in {ConvergenceVerdict.CONVERGED, None}
    ]
    yield AnswerTable.of("Error bars", "load case", _BARS, cases, loose)
    if summary.passes:
        rows = ((str(k), each) for k, each in enumerate(summary.passes, start=1))
        yield AnswerTable.of("Refinement of the mesh", "pass", _PASSES, rows)


_CHECKS = (
    TableColumn("value", "", "value", "3g"),
    TableColumn("limit", "", "limit", "3g"),
    TableColumn("verdict", "", lambda check: "passed" if check.passed else "FAILED", words=True),
)


def check_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield every check with its limit."""
    checks = summary.checks.items()
    rows = [(TITLES.get(name, name.replace("_", " ")), check) for name, check in checks]
    failed = [k for k, (_, check) in enumerate(rows) if not check.passed]
    caption = "Checks: each value must not exceed its limit; relative, unless it is a count or a ratio"
    yield AnswerTable.of(caption, "check", _CHECKS, rows, failed)


def _of(name: str) -> Callable[[HandFigures], str]:
    def text(row: HandFigures) -> str:
        value = getattr(row, name)
        return quantity(value, ".1f", row.unit) if row.unit else factor(value)

    return text


_HAND = (
    TableColumn("formula", "", "formula", words=True),
    TableColumn("by hand", "", _of("value")),
    TableColumn("finite elements", "", _of("result")),
    TableColumn("ratio", "", "ratio", ".2f"),
)


def hand_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield what was worked out by hand, if anything was."""
    rows = [(each.title, each) for each in (summary.hand or {}).values()]
    if rows:
        yield AnswerTable.of(
            "By hand and by finite elements; the ratio is the latter over the former", "figure", _HAND, rows
        )


_CAPTION = (
    "What the gap between piston and head must leave at {}, beside a margin; "
    "builders are used to leave about 1 mm with steel rods and 1.5 mm with aluminium rods"
)
_PARTS = (
    TableColumn("stretch of the rod between its pins, with ovality and joint", "mm", "rod_stretch_mm", ".3f"),
    TableColumn("radial clearances of both pins", "mm", "clearances_mm", ".3f"),
    TableColumn("bending of the piston pin", "mm", "pin_bending_mm", ".3f"),
    TableColumn("main bearing and crank (assumed)", "mm", "crank_mm", ".3f"),
    TableColumn("sum of the cold engine", "mm", "cold_mm", ".2f"),
    TableColumn("growth of the warm piston (assumed)", "mm", "piston_growth_mm", ".3f"),
    TableColumn("growth of the warm rod (assumed)", "mm", "rod_growth_mm", ".3f"),
    TableColumn(
        "growth of a block of aluminium, which carries the head away (assumed)",
        "mm",
        lambda row: -row.aluminium_block_growth_mm,
        ".3f",
    ),
    TableColumn("the same of cast iron", "mm", lambda row: -row.iron_block_growth_mm, ".3f"),
    TableColumn("sum of the warm engine, aluminium block", "mm", "hot_aluminium_block_mm", ".2f"),
    TableColumn("sum of the warm engine, iron block", "mm", "hot_iron_block_mm", ".2f"),
)


def head_clearance_tables(summary: Summary) -> Iterator[AnswerTable]:
    """Yield the parts of the gap with their signs and their sums, where they are known."""
    if summary.head_clearance is not None:
        centre = "top dead centre, were the gas not to push there"
        centre = "the dead centre of gas exchange" if summary.cycle_degrees > 360 else centre
        yield AnswerTable.of_quantities(_CAPTION.format(centre), _PARTS, summary.head_clearance)
