"""The crank cycle of a study: columns, extremes with their crank angles, mean torque."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fea.analysis.figures import Figures, WhereKnown
from fea.base.note import TRACE, Note, doubt, warning
from fea.base.units import BAR, DEG, M_S, M_S2, N_M, RPM
from fea.rod.loading import EngineLoading
from fea.rod.reading import read_isolated
from fea.study.engine_table import engine_notes, layout_notes
from fea.study.rod_table import RodTable
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.mass import MassProperties, joined
from loads.dynamics import EngineInstants, cycle, whole_engine
from loads.engine import Engine
from loads.gas import GasModel, Scaled
from loads.trace import Trace, TraceReading, absorbed

if TYPE_CHECKING:
    from geometry.solid import Solid


def force_columns(engine: Engine, rod: MassProperties, gas: GasModel, rpm: float) -> dict[str, npt.ArrayLike]:
    """Kinematics and forces of one cylinder at a speed, rpm, at every degree."""
    return columns(cycle(engine, rod, gas, rpm * RPM, engine.cycle_angles), rpm)


def columns(c: EngineInstants, rpm: float) -> dict[str, npt.ArrayLike]:
    """Columns of a computed cycle."""
    motion = c.motion
    return {
        "rpm": rpm,
        "crank_deg": motion.crank_angle / DEG,
        "gas_N": c.gas,
        "piston_position_mm": motion.piston_position,
        "piston_velocity_m_s": motion.piston_velocity / M_S,
        "piston_acceleration_m_s2": motion.piston_acceleration / M_S2,
        "rod_deg": motion.rod_angle / DEG,
        "rod_angular_velocity_rad_s": motion.rod_rate,
        "rod_angular_acceleration_rad_s2": motion.rod_acceleration,
        "pin_axial_N": c.pin_axial,
        "pin_transverse_N": c.pin_transverse,
        "crank_axial_N": c.crank_axial,
        "crank_transverse_N": c.crank_transverse,
        "wall_N": c.wall,
        "torque_Nm": c.torque / N_M,
        "shaking_x_N": c.shaking_x,
        "shaking_y_N": c.shaking_y,
    }


# A peak between the angles of the table that is higher by this part of it is told.
_MISSED = 0.01
# What a reader looks for first, in words and with its unit; the other columns are in the CSV file.
EXTREMES = {
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
WHOLE_ENGINE = ("torque_Nm", "shaking_x_N", "shaking_y_N")


class Extreme(Figures):
    """Largest and least value of a column, and the crank angles (°) where they first occur."""

    max: float
    max_crank_deg: float
    min: float
    min_crank_deg: float


@dataclass(frozen=True)
class TraceSamples:
    """A pressure trace as it was read, at one speed."""

    source: str  #: name of its file
    #: degrees, bar: (n,) crank angles and gauge pressures of its samples
    degrees: Floats
    bar: Floats
    newtons_per_bar: float  #: gas force on the piston


@dataclass(frozen=True)
class ForceReport:
    """One speed of an engine."""

    rpm: float  #: speed
    #: Columns of ``loads.csv``: the first cylinder, or with all cylinders first the whole engine
    #: (``cylinder`` 0; columns that belong to one cylinder are NaN) and then each
    tables: tuple[dict[str, npt.ArrayLike], ...]
    notes: tuple[Note, ...]  #: what a reader must know about the gas pressure and the engine
    #: Of a user's pressure trace; None where the pressure comes from elsewhere
    samples: TraceSamples | None = None
    trace: TraceReading | None = None  #: how that was read

    @property
    def note(self) -> str:
        """All notes in a line."""
        return "; ".join(map(str, self.notes))

    @property
    def first(self) -> dict[str, npt.ArrayLike]:
        """Columns of the first cylinder."""
        return self.tables[0] if len(self.tables) == 1 else self.tables[1]

    @property
    def cycle_degrees(self) -> int:
        """Crank angle of the engine's cycle, degrees."""
        return round(float(np.asarray(self.first["crank_deg"])[-1]))

    @property
    def engine(self) -> dict[str, npt.ArrayLike] | None:
        """Columns of the whole engine, or None where one cylinder was asked."""
        return None if len(self.tables) == 1 else self.tables[0]

    def figures(self, study: str) -> "ForceFigures":
        """Return the figures for JSON."""
        whole = None if self.engine is None else self._figures(self.engine, WHOLE_ENGINE)
        first = vars(self._figures(self.first, EXTREMES))
        note = self.note or None
        return ForceFigures(study=study, rpm=self.rpm, note=note, engine=whole, trace=self.trace, **first)

    def _figures(self, table: dict[str, npt.ArrayLike], names: Iterable[str]) -> "EngineForceFigures":
        torque = mean_torque(table)
        power = torque * self.rpm * RPM / 1e3
        return EngineForceFigures(extremes=extremes(table, names), mean_torque_Nm=torque, mean_power_kW=power)


class EngineForceFigures(Figures):
    """Extremes and means of a cylinder or of the whole engine."""

    extremes: Mapping[str, Extreme]
    mean_torque_Nm: float
    mean_power_kW: float


class ForceFigures(Figures):
    """The figures of ``fea loads`` at one speed: first cylinder, and the whole engine where asked for."""

    study: str
    rpm: float
    extremes: Mapping[str, Extreme]
    mean_torque_Nm: float
    mean_power_kW: float
    note: str | None
    engine: WhereKnown[EngineForceFigures] = None
    trace: WhereKnown[TraceReading] = None  #: how the pressures of a user's file were read


def force_reports(
    engine: Engine,
    rod: MassProperties,
    gas: GasModel,
    speeds: tuple[float, ...],
    *,
    every_cylinder: bool,
    brake: Callable[[float], float | None] = lambda _rpm: None,
) -> list[ForceReport]:
    """Compute the cycle, every degree, at each speed (rpm)."""
    angles = engine.cycle_angles
    reports = []
    for rpm in speeds:
        if every_cylinder:
            whole = whole_engine(engine, rod, gas, rpm * RPM, angles)
            each = [columns(c, rpm) | {"crank_deg": angles / DEG} for c in whole.cylinders]
            total: dict[str, npt.ArrayLike] = dict.fromkeys(each[0], np.nan)
            total |= {
                "rpm": rpm,
                "crank_deg": angles / DEG,
                "torque_Nm": whole.torque / N_M,
                "shaking_x_N": whole.shaking_x,
                "shaking_y_N": whole.shaking_y,
            }
            tables = tuple({"cylinder": k} | table for k, table in enumerate([total, *each]))
        else:
            tables = (columns(cycle(engine, rod, gas, rpm * RPM, angles), rpm),)
        torque = np.asarray(tables[-1]["torque_Nm"]) * N_M
        count = engine.cylinders if every_cylinder else 1
        absorbs = absorbed(gas, torque / count, brake(rpm))
        notes = (*gas.remarks, gas.note(rpm * RPM), _missed(gas, rpm * RPM, angles))
        samples = None
        if isinstance(gas, Trace) and gas.source:
            bar = gas.pressure(gas.samples, np.asarray(rpm * RPM)) / BAR
            samples = TraceSamples(gas.source, gas.samples / DEG, bar, engine.piston_area * BAR)
        doubts = (doubt(text, TRACE) for text in (*gas.doubts, absorbs) if text)
        said = (*doubts, *(warning(text) for text in notes if text))
        reports.append(ForceReport(rpm, tables, said, samples, trace_of(gas)))
    return reports


def trace_of(gas: GasModel) -> TraceReading | None:
    """Return how a user's trace was read, whatever multiplies it; None for other gases."""
    own = gas.gas if isinstance(gas, Scaled) else gas
    return own.reading if isinstance(own, Trace) else None


def _missed(gas: GasModel, speed: float, angles: Floats) -> str:
    if not gas.samples.size:
        return ""
    samples = gas.pressure(gas.samples, np.asarray(speed))
    peak = float(samples.max())
    if float(gas.pressure(angles, np.asarray(speed)).max()) >= (1 - _MISSED) * peak:
        return ""
    at = float(gas.samples[samples.argmax()]) / DEG
    missed = "between whole degrees: extremes miss that"
    return f"the gas pressure peaks at {at:g}°, {peak / BAR:.4g} bar, {missed}"


def extremes(table: dict[str, npt.ArrayLike], names: Iterable[str]) -> dict[str, Extreme]:
    """Find largest and least values of some columns: the first of those that rounding alone tells apart."""
    degrees, largest = np.asarray(table["crank_deg"]), {}
    for name in names:
        values = np.asarray(table[name])
        rounding = 1e-9 * np.abs(values).max()
        top, bottom = (int(np.argmax(of >= of.max() - rounding)) for of in (values, -values))
        largest[name] = Extreme(
            max=float(values[top]),
            max_crank_deg=float(degrees[top]),
            min=float(values[bottom]),
            min_crank_deg=float(degrees[bottom]),
        )
    return largest


def mean_torque(table: dict[str, npt.ArrayLike]) -> float:
    """Mean over the cycle, N·m; its end repeats its start."""
    return float(np.mean(np.asarray(table["torque_Nm"])[:-1]))


def stacked(reports: Sequence[ForceReport]) -> dict[str, npt.ArrayLike]:
    """Return the columns of all speeds and cylinders one below the other."""
    tables = [table for report in reports for table in report.tables]
    length = np.asarray(tables[0]["crank_deg"]).size
    return {
        name: np.concatenate([np.broadcast_to(np.asarray(own[name], np.float64), length) for own in tables])
        for name in tables[0]
    }


def study_forces(study: Study, *, every_cylinder: bool) -> list[ForceReport]:
    """Compute the crank forces at each speed of a study.

    Raises `InvalidValue`: it has no engine, or a value breaks a rule; `GeometryError`: no solid came out to
    take the rod's mass from.
    """
    table = study.require_engine()
    if study.rod.length is not None:  # refused before anything is drawn
        EngineLoading.of(table, study.rod.length)
    length, mass = rod_mass(study)
    lengths = {"rod.length_mm": length}
    study.require_plausible(lengths)
    loading = EngineLoading.of(table, length)
    speeds = study.engine_speeds(table)
    reports = force_reports(
        loading.engine, mass, loading.gas, speeds, every_cylinder=every_cylinder, brake=table.brake_torque
    )
    of_all = (*study.unusual_notes(lengths), *(layout_notes(table) if every_cylinder else ()))
    return [
        replace(report, notes=(*report.notes, *engine_notes(table, length, report.rpm), *of_all))
        for report in reports
    ]


def rod_mass(study: Study) -> tuple[float, MassProperties]:
    """Return the rod's length, mm, and the given mass properties or the CAD kernel's of its solid.

    Raises `InvalidValue`: it has neither masses nor dimensions; `GeometryError`: no solid came out.
    """
    rod = study.rod
    if rod.mass is not None and rod.length is not None:
        return rod.length, rod.mass
    if rod.mesh is not None:
        from fea.analysis.meshing import mesh_study  # noqa: PLC0415 - other rods need no mesh for their forces
        from fea.solid.inertia import inertia  # noqa: PLC0415

        meshed = mesh_study(study)
        (material,) = study.materials(meshed.parts)
        return meshed.bores.rod_length, rod.mass or inertia(meshed.cell, material.density).properties
    solid = drawn_solid(rod)
    materials = study.materials(part.name for part in solid.parts)
    both = zip(solid.parts, materials, strict=True)
    drawn = joined([part.mass.times(material.density) for part, material in both])
    return solid.bores[1].x, rod.mass or drawn


def drawn_solid(rod: RodTable) -> "Solid":
    """Draw a rod, or read it from its CAD file, in a session of its own; errors as of `RodTable.draw`."""
    return _drawn(rod) if rod.cad is None else read_isolated(partial(_drawn, rod), f"read {rod.cad.path}")


def _drawn(rod: RodTable) -> "Solid":
    from geometry.session import session  # noqa: PLC0415 - gmsh is loaded only where a solid is drawn

    with session():
        return rod.draw()
