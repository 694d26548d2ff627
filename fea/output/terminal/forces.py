"""The extremes of the crank cycle on the terminal."""

from collections.abc import Sequence

from rich.table import Table

from fea.analysis.forces import EXTREMES, WHOLE_ENGINE, Extreme, ForceReport, extremes, mean_torque
from fea.base.note import UNITS, by_consequence
from fea.base.units import RPM
from fea.output import units
from fea.output.terminal.prose import in_full, print_lines, terminal, unusual
from fea.output.terminal.run_lines import plain_table
from fea.output.text import gathered
from fea.output.units import in_unit

_NAMES = {
    "gas_N": ("gas force", "N"),
    "piston_velocity_m_s": ("piston velocity", "m/s"),
    "piston_acceleration_m_s2": ("piston acceleration", "m/s²"),
    "rod_angular_acceleration_rad_s2": ("rod angular acceleration", "rad/s²"),
    "pin_axial_N": ("axial force, piston pin", "N"),
    "crank_axial_N": ("axial force, crank pin", "N"),
    "crank_transverse_N": ("transverse force, crank pin", "N"),
    "wall_N": ("wall force on the piston", "N"),
    "torque_Nm": ("torque", "N·m"),
    "shaking_x_N": ("shaking force along cylinder", "N"),
    "shaking_y_N": ("shaking force across cylinder", "N"),
}
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
            titles = ("", "maximum", "at", "minimum", "at", "unit")
            title = f"{study}, {report.rpm:g} rpm"
            table = plain_table(titles, (), left=("", "unit"), title=title, title_justify="left")
            for name, extreme in extremes(report.first, EXTREMES).items():
                _add(table, *_NAMES[name], extreme)
            table.add_row(*_mean("mean torque, one cylinder", mean_torque(report.first), report.rpm))
            if report.engine is not None:
                table.add_section()
                for name, extreme in extremes(report.engine, WHOLE_ENGINE).items():
                    quantity, unit = _NAMES[name]
                    _add(table, f"whole engine: {quantity}", unit, extreme)
                table.add_row(*_mean("whole engine: mean torque", mean_torque(report.engine), report.rpm))
            console.print(table)
    print_lines(console, in_full(note for note in notes if note.topic != UNITS))
    signs = "Axial forces on the rod: tension positive. Crank angle: firing TDC at 360°."
    print_lines(console, [signs], "dim")


def _add(table: Table, name: str, unit: str, e: Extreme) -> None:
    most, least = (_shown(in_unit(value, unit)) for value in (e.max, e.min))
    ends = _at(e.max, e.max_crank_deg), _at(e.min, e.min_crank_deg)
    table.add_row(name, most, ends[0], least, ends[1], units.unit(unit))


def _at(value: float, degrees: float) -> str:
    return "" if abs(value) < _NOISE else f"{degrees:g}°"


def _mean(name: str, torque: float, rpm: float) -> tuple[str, ...]:
    power = f"{in_unit(torque * rpm * RPM / 1e3, 'kW'):.1f} {units.unit('kW')}"
    return name, f"{in_unit(torque, 'N·m'):.1f}", "", "", "", f"{units.unit('N·m')} ({power})"


def _overview(reports: Sequence[ForceReport], study: str) -> Table:
    rows = []
    for report in reports:
        found = extremes(report.first, EXTREMES)
        pull = max((found["pin_axial_N"], found["crank_axial_N"]), key=lambda e: e.max)
        push = min((found["pin_axial_N"], found["crank_axial_N"]), key=lambda e: e.min)
        wall = found["wall_N"]
        side, at = max(
            (wall.max, wall.max_crank_deg), (wall.min, wall.min_crank_deg), key=lambda v: abs(v[0])
        )
        torque = mean_torque(report.first if report.engine is None else report.engine)
        row = (
            f"{report.rpm:g}",
            _shown(pull.max),
            f"{pull.max_crank_deg:g}°",
            _shown(push.min),
            f"{push.min_crank_deg:g}°",
            _shown(side),
            f"{at:g}°",
            f"{torque:.1f}",
        )
        rows.append(row)
    titles = ("rpm", "tension N", "at", "compression N", "at", "wall N", "at", "mean N·m")
    return plain_table(titles, rows, title=study, title_justify="left")


def _shown(value: float) -> str:
    if abs(value) < _NOISE:
        return "0"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
