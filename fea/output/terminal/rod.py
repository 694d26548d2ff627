"""The figures of a rod, its modes, and the extremes of the forces over the crank cycle."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rich.table import Table as RichTable

from fea.analysis.forces import EXTREMES, WHOLE_ENGINE, Extreme, ForceReport, extremes, mean_torque
from fea.base.note import HEADING, UNITS, by_consequence
from fea.base.units import RPM
from fea.output.tables import TableColumn
from fea.output.terminal.prose import gathered, in_full, plain_table, print_lines, terminal, unusual
from fea.output.units import in_unit, number, quantity, unit

if TYPE_CHECKING:
    from fea.analysis.modes import ModesFigures
    from fea.analysis.rod_report import RodReport, SectionFigures, SolidFigures

_MOST_LEFT_OUT = 3  # solids, by name


def print_rod(figures: "RodReport") -> None:
    """Print the figures of a rod."""
    console, slenderness = terminal(), figures.slenderness
    center = (number(at, ".2f", "mm", coarser=1) for at in figures.center_of_gravity_mm)
    inertia = (quantity(figures.inertia_kg_m2[k][k], ".4g", "kg·m²") for k in range(3))
    axes = ", ".join(f"{2 * axis} {value}" for axis, value in zip("xyz", inertia, strict=True))
    in_plane = f"slenderness K l / r {slenderness['in_plane']:.1f} in the plane of motion (K = 1)"
    mass, length = quantity(figures.mass_kg, ".4g", "kg"), quantity(figures.length_mm, ".6g", "mm")
    lines = [
        f"{figures.study}: {mass}, {length} between the bores",
        *unusual(figures.assumed),
        f"centre of gravity ({', '.join(center)}) {unit('mm')} from the crank pin",
        f"inertia about it: {axes}",
        *_bores_and_solids(figures),
        _least_section(figures.least_section),
        f"{in_plane}, {slenderness['sideways']:.1f} sideways (K = 0.5)",
    ]
    if len(figures.parts_mm3) > 1:
        parts = figures.parts_mm3.items()
        volumes = ", ".join(f"{name} {quantity(volume, '.0f', 'mm³')}" for name, volume in parts)
        lines.append(f"parts: {volumes}")
    print_lines(console, lines)
    rows = ([column.cell(section) for column in _SECTIONS] for section in figures.sections)
    console.print(plain_table([f"{column.title}\n{column.unit}" for column in _SECTIONS], rows))
    mesh = figures.mesh
    shapes = (
        f"mesh at {quantity(mesh.size_mm, '.4g', 'mm')}: {mesh.nodes} nodes, {mesh.elements} elements, "
        f"symmetry {figures.symmetry}; mass within {100 * mesh.mass_error:.2g} % of the solid's; "
        f"least shape {mesh.least_shape:.2f}, least scaled Jacobian {mesh.least_scaled_jacobian:.2f}"
    )
    print_lines(console, [shapes])


_SECTIONS = (
    TableColumn("x", "mm", "x_mm", ".1f"),
    TableColumn("area", "mm²", "area_mm2", ".1f"),
    TableColumn("I_y", "mm⁴", "inertia_y_mm4", ".0f"),
    TableColumn("I_z", "mm⁴", "inertia_z_mm4", ".0f"),
)


def _least_section(section: "SectionFigures") -> str:
    area, at = quantity(section.area_mm2, ".2f", "mm²"), quantity(section.x_mm, ".1f", "mm")
    y, z = (quantity(moment, ".0f", "mm⁴") for moment in (section.inertia_y_mm4, section.inertia_z_mm4))
    return f"least section {area} at x = {at}, I_y {y} and I_z {z}"


def _bores_and_solids(figures: "RodReport") -> Iterator[str]:
    for name, bore in zip(("big end", "small end"), figures.bores, strict=True):
        where = ""
        if bore.at_mm:  # the CAD kernel's 1e-14 is a zero
            at = ", ".join(number(round(coordinate, 3), ".4g", "mm", coarser=1) for coordinate in bore.at_mm)
            where = f" at ({at}) {unit('mm')} in the file"
        diameter, width = quantity(bore.diameter_mm, ".5g", "mm"), quantity(bore.width_mm, ".4g", "mm")
        yield f"{name}: bore {diameter}, {width} long{where}"
    if figures.solids is not None and len(figures.solids) > 1:
        yield f"solids of the file, which is in {figures.unit}:"
        yield from solid_lines(figures.solids)
    if figures.assembly:
        yield "as an assembly ([assembly] in a study):"
        yield from (f"  {text}" for text in figures.assembly)
    yield from (str(note) for note in figures.assumed if note.topic not in {UNITS, *HEADING})


def solid_lines(solids: "Sequence[SolidFigures]") -> Iterator[str]:
    """Yield a line for each solid of a file: those that are kept, and the largest of the others."""
    ordered = sorted(solids, key=lambda solid: (not solid.kept, -solid.mass_kg))
    left = sum(not solid.kept for solid in ordered)
    for solid in ordered[: len(ordered) - left + _MOST_LEFT_OUT]:
        size = " x ".join(number(length, ".4g", "mm") for length in solid.size_mm)
        kept = "" if solid.kept else ", left out"
        mass = quantity(solid.mass_kg, ".4g", "kg")
        yield f"  {solid.name}: {solid.role}{kept}; {size} {unit('mm')}, {mass}"
    if left > _MOST_LEFT_OUT:
        yield f"  and {left - _MOST_LEFT_OUT} smaller solids, left out (--json lists them)"


_MOST_SPEEDS = 4


def print_modes(figures: "ModesFigures") -> None:
    """Print the modes, a row each."""
    console = terminal()
    modes = figures.modes
    speeds = list(modes[0].orders)[:_MOST_SPEEDS]
    orders = (f"order at\n{speed.removesuffix('rpm')} rpm" for speed in speeds)
    rows = (
        (f"{n}", f"{mode.frequency_Hz:.0f}", *(f"{mode.orders[speed]:.1f}" for speed in speeds), mode.moves)
        for n, mode in enumerate(modes, start=1)
    )
    table = plain_table(("mode", "Hz", *orders, "moves mostly"), rows, left=("moves mostly",))
    print_lines(console, [f"{figures.study}: free–free vibration"], "bold")
    print_lines(console, unusual(figures.notes))
    console.print(table)
    if not figures.trusted:
        why = "there are not six rigid-body motions, or the modes do not satisfy their equation"
        print_lines(console, [f"NOT TO BE TRUSTED: {why}."])
    orders_of = "An order is the number of periods per crank revolution"
    print_lines(console, [f"{orders_of}; four-stroke engines excite half orders, too."])


# Rounding errors of quantities that cancel in the whole engine are smaller than this.
_NOISE = 1e-9
_MOST_TABLES = 4  # with more speeds, one line each


def print_forces(reports: Sequence[ForceReport], study: str) -> None:
    """Print a table a speed, or with many speeds a line each."""
    console = terminal()
    notes, _ = by_consequence(gathered((report.rpm, report.notes) for report in reports))
    print_lines(console, unusual(notes))
    if len(reports) > _MOST_TABLES:
        console.print(_overview(reports, study))
    else:
        for report in reports:
            console.print(_extremes(report, study))
    print_lines(console, in_full(note for note in notes if note.topic != UNITS))
    fires = 360 if reports[0].cycle_degrees > 360 else 0
    signs = f"Axial forces on the rod: tension positive. Crank angle: firing TDC at {fires}°."
    print_lines(console, [signs], "dim")


def _extremes(report: ForceReport, study: str) -> RichTable:
    titles, title = ("", "maximum", "at", "minimum", "at", "unit"), f"{study}, {report.rpm:g} rpm"
    table = plain_table(titles, (), left=("", "unit"), title=title, title_justify="left")
    for name, extreme in extremes(report.first, EXTREMES).items():
        table.add_row(*_extreme(*EXTREMES[name], extreme))
    table.add_row(*_mean("mean torque, one cylinder", mean_torque(report.first), report.rpm))
    if report.engine is not None:
        table.add_section()
        for name, extreme in extremes(report.engine, WHOLE_ENGINE).items():
            words, own = EXTREMES[name]
            table.add_row(*_extreme(f"whole engine: {words}", own, extreme))
        table.add_row(*_mean("whole engine: mean torque", mean_torque(report.engine), report.rpm))
    return table


def _extreme(words: str, own: str, e: Extreme) -> tuple[str, ...]:
    most, least = (_shown(in_unit(value, own)) for value in (e.max, e.min))
    return words, most, _at(e.max, e.max_crank_deg), least, _at(e.min, e.min_crank_deg), unit(own)


def _at(value: float, degrees: float) -> str:
    return "" if abs(value) < _NOISE else f"{degrees:g}°"


def _mean(words: str, torque: float, rpm: float) -> tuple[str, ...]:
    power = f"{in_unit(torque * rpm * RPM / 1e3, 'kW'):.1f} {unit('kW')}"
    return words, f"{in_unit(torque, 'N·m'):.1f}", "", "", "", f"{unit('N·m')} ({power})"


def _overview(reports: Sequence[ForceReport], study: str) -> RichTable:
    rows = []
    for report in reports:
        found = extremes(report.first, EXTREMES)
        pull = max((found["pin_axial_N"], found["crank_axial_N"]), key=lambda e: e.max)
        push = min((found["pin_axial_N"], found["crank_axial_N"]), key=lambda e: e.min)
        wall = found["wall_N"]
        side = max((wall.max, wall.max_crank_deg), (wall.min, wall.min_crank_deg), key=lambda v: abs(v[0]))
        torque = mean_torque(report.first if report.engine is None else report.engine)
        peaks = ((pull.max, pull.max_crank_deg), (push.min, push.min_crank_deg), side)
        cells = (text for value, angle in peaks for text in (_shown(in_unit(value, "N")), f"{angle:g}°"))
        rows.append((f"{report.rpm:g}", *cells, number(torque, ".1f", "N·m")))
    titles = ("rpm", "tension N", "at", "compression N", "at", "wall N", "at", "mean N·m")
    return plain_table(titles, rows, title=study, title_justify="left")


def _shown(value: float) -> str:
    if abs(value) < _NOISE:
        return "0"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
