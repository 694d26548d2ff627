"""[engine]: the engine and its gas."""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass
from pathlib import Path

import numpy as np

from fea.base.note import Note, assumptions, warning
from fea.base.shipped import TomlTable
from fea.base.units import BAR, DEG, KG, N_M
from fea.study.engine_library import EnginePreset, engine_preset
from fea.study.files import located
from fea.study.tables import Positive, checked, full_key, key, keys_of, one_of, within
from fea.study.trace_columns import TraceKeys
from fea.study.traces import SHIPPED, SUFFIXES, ImportedTrace, Surroundings, read_trace, shipped_trace
from fea.study.two_stroke import CycleKeys, cycle_notes
from geometry.errors import InvalidValue, require, require_positive
from loads.combustion import FUELS, cut_off, peak_interval
from loads.compression import ROD_RATIO
from loads.engine import Engine
from loads.gas import (
    ATMOSPHERE,
    HEAT_RATIO_AIR,
    Boyle,
    Compressor,
    GasModel,
    NoGas,
    Otto,
    TwoStrokeOtto,
    scaled,
)


def with_preset(raw: object) -> object:
    """Return what a study says of its engine, with the figures of the preset that it names filled in.

    `raw` comes from the TOML parser: a table, or the name of an engine of the library. An alias becomes the
    name that it stands for. Raises `InvalidValue`: there is no engine of that name.
    """
    if isinstance(raw, str):
        preset = engine_preset(raw, "engine")
        return {**preset.entries(), "preset": preset.name}
    if not isinstance(raw, Mapping) or "preset" not in raw:
        return raw
    preset = engine_preset(checked("engine.preset", raw["preset"], str))
    return {**_charged(preset, raw), **raw, "preset": preset.name}


_BOOST = {"boost_bar", "intake_pressure_bar"}  # keys that set the charge of an engine


def _charged(preset: EnginePreset, raw: Mapping[str, object]) -> TomlTable:
    """Return the figures of a preset; its peak pressure does not stand for that of another boost or fuel."""
    given = {full_key(name, keys_of(EngineTable)) for name in raw}
    figures, boosted = preset.entries(), bool(given & _BOOST)
    if boosted:
        figures = {name: value for name, value in figures.items() if name not in _BOOST}
    computed = raw.get("gas", figures.get("gas")) == "otto" and "peak_pressure_bar" not in given
    if computed and (boosted or "fuel" in given):
        figures.pop("peak_pressure_bar", None)
        figures["fuel"] = "diesel" if "diesel" in preset.title else "petrol"
    return figures


_BURNING = {"fuel", "peak_pressure_bar"}  # keys of a gas that burns
# Keys of a gas that do not say which.
_OF_GAS = "compression_ratio", "intake_pressure_bar", "delivery_pressure_bar", "heat_ratio", "gas_scale"


def with_implied_gas(raw: object) -> object:
    """Return what a study says of its engine; with a fuel or a peak pressure and no gas, the gas burns.

    Raises `InvalidValue`: a key has no effect, because no gas is given or implied.
    """
    if not isinstance(raw, Mapping) or "gas" in raw:
        return raw
    given = [name for name, value in raw.items() if value is not None]
    if _BURNING.intersection(given):
        return {"gas": "otto", **raw}
    for name in _OF_GAS:
        rule = "has no effect without gas: nothing would press on the piston"
        remedy = 'Give peak_pressure_bar or fuel, with which the gas burns, or gas = "motored" or another.'
        require(name not in given, f"engine.{name}", raw.get(name), rule, remedy)
    return raw


_CYCLES = ("boyle", "otto", "motored", "compressor", "none")
_LOADS = ("peak_pressure_bar", "torque_Nm")  # one of which a point of full load gives


@dataclass(frozen=True, kw_only=True)
class EngineTable(
    CycleKeys,
    TraceKeys,
    table="engine",
    intro="With a preset, an engine of the library, its figures stand for keys that are not given. Alone it "
    'can also be given as `engine = "toyota-2jz"` above all tables. `fea init --engine NAME` writes a study '
    "with its sources.",
):
    """[engine]: dimensions, masses and gas; the keys of `TraceKeys` say how a file of pressures is read."""

    preset: str | None = key(
        '"toyota-2jz"',
        "or an alias, such as 2jz; a name that does not exist lists all",
        flag="engine",
        help="Engine of the library in place of the study's, by name or alias: toyota-2jz, k20, …; any other "
        "name lists all.",
    )
    stroke_mm: float = key("94.0", default=MISSING, stated=True)
    bore_mm: float = key("76.0", default=MISSING, stated=True)
    piston_mass_kg: float = key("0.5", "with pin and rings", default=MISSING, stated=True)
    cylinders: int = key("4", default=1, stated=True)
    phase_deg: float | None = key("180.0", "crank angle between the firing of successive cylinders")
    bank_angle_deg: float | None = key(
        "90.0",
        "between the banks of a V engine, in the sense of rotation from the bank of the first cylinder; 180: "
        "flat. Default: in line",
        within(0.0, 360.0, " degrees"),
    )
    banks: str | None = key(
        '"ABAB"',
        "bank of each cylinder in the order of firing, with bank_angle_deg; default: alternately",
        needs="bank_angle_deg, the angle between the banks",
    )
    crank_pins_deg: tuple[float, ...] | None = key(
        "[0, 0, 240, 240]",
        "how far the crank pin of each cylinder, in the order of firing, is behind that of the first; the "
        "same where they share one. Each fires at its dead centre nearest to even firing. Default: the pins "
        "that let them fire at intervals of phase_deg",
        within(-720.0, 720.0, " degrees"),
    )
    pin_offset_mm: float = key(
        "0.0",
        "distance of the cylinder axis from the crank axis, positive towards the side of the crank pin after "
        "TDC: less wall force in the expansion stroke. A pin offset towards the thrust side, against piston "
        "slap, is negative. Angles count from the crank pin parallel to the cylinder axis: TDC is "
        "asin(offset/(crank radius + rod)) later",
        default=0.0,
    )
    friction: float = key("0.0", "coefficient of friction between piston and wall", default=0.0)
    gas: str = key(
        '"otto"',
        'or "leon-2001" (a measured trace), "boyle", "motored", "compressor", "none", or a file of pressures '
        'over crank angle, such as "trace.csv"',
        default="none",
        stated=True,
    )
    compression_ratio: float | None = key("10.0", stated=True)
    peak_pressure_bar: float | None = key("60.0", stated=True)
    fuel: str | None = key(
        '"petrol"',
        'or "diesel": for "otto" without peak_pressure_bar, which is then computed for full load from the '
        "intake and the compression ratio: the upper end of the interval from late to early combustion",
        one_of(FUELS),
    )
    intake_pressure_bar: Positive | None = key(
        "1.01325", 'for "otto" and "motored", absolute; of a trace, that to which its zero is pegged'
    )
    boost_bar: float | None = key(
        "1.0",
        "gauge pressure in the intake, in place of intake_pressure_bar: of computed cycles; or with a "
        "trace the boost with which it was measured, from which fea limits counts",
    )
    atmosphere_bar: Positive | None = key("1.01325", "pressure in the crankcase")
    delivery_pressure_bar: Positive | None = key(
        "8.0",
        'absolute pressure at which a "compressor" delivers; its clearance follows from compression_ratio',
    )
    heat_ratio: float | None = key("1.4", 'of the gas, for "otto", "motored" and "compressor"')
    gas_scale: Positive | None = key(
        "1.5",
        'multiple of the charge: of intake and peak pressure (absolute) for "otto" and "motored", of the '
        "gauge pressure of any other gas; default: 1",
    )
    full_load: tuple[dict[str, float], ...] | None = key(
        "[{ rpm = 3000, peak_pressure_bar = 70 }, { rpm = 6000, torque_Nm = 210 }]",
        "what the engine reaches at full load, for fea limits: peak pressure (absolute) or torque of the "
        "whole engine; also as tables [[engine.full_load]]",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for number, point in enumerate(self.full_load or (), 1):
            name, rule = f"engine.full_load {number}", f"must have rpm and one of {', '.join(_LOADS)}"
            valid = len(point) == 2 and "rpm" in point and any(load in point for load in _LOADS)
            require(valid, name, ", ".join(point), f"{rule}, and nothing else")
            for load, value in point.items():
                require_positive(f"{name}.{load}", value)
        for name, value in self.given.items():
            rule, remedy = "says how a file is to be read, but gas names none", "Remove it, or give a file."
            require(_is_file(self.gas), f"engine.{name}", value, rule, remedy)

        self._require_one_charge()
        rule = f'does not suit gas = "{self.gas}", the trace of a four-stroke engine'
        require(self.strokes != 2 or self.gas not in SHIPPED, "engine.strokes", 2, rule, "Give another gas.")

    def _require_one_charge(self) -> None:
        """Refuse two keys that both set the charge, and boost for a gas that it does not change."""
        if self.boost_bar is None:
            return
        name, value = "engine.boost_bar", self.boost_bar
        lowest, least = "must be above vacuum, the atmosphere below zero", -self.atmosphere / BAR
        require(value > least, name, value, lowest)
        rule = "stands beside intake_pressure_bar, which is the same pressure, absolute"
        require(self.intake_pressure_bar is None, name, value, rule, "Remove one of them.")
        rule = "stands beside gas_scale, which multiplies the charge, too"
        require(self.gas_scale is None, name, value, rule, "Remove one of them.")
        rule = f'does nothing for gas = "{self.gas}"'
        require(self.gas not in _NOT_BOOSTED, name, value, rule, 'Use gas = "otto", "motored" or a trace.')

    def located(self, folder: Path) -> "EngineTable":
        """Return the table with the path of a file made absolute."""
        return dataclasses.replace(self, gas=located_gas("engine.gas", self.gas, folder))

    def with_gas(self, gas: str) -> "EngineTable":
        """Return the table with another gas; keys that say how a file is to be read stay for files only."""
        unused: TomlTable = {} if _is_file(gas) else dict.fromkeys(self.given)
        return dataclasses.replace(self, gas=gas, **unused)

    def engine(self, rod_length: float) -> Engine:
        """Return the engine with a rod of `rod_length` (mm), in coherent units."""
        require_positive("engine.stroke_mm", self.stroke_mm)
        strokes = self.strokes or 4
        even = 180.0 * strokes / max(self.cylinders, 1)  # interval of firing
        phase, axes = even if self.phase_deg is None else self.phase_deg, self._axes()
        return Engine(
            crank_radius=self.stroke_mm / 2,
            rod_length=rod_length,
            bore=self.bore_mm,
            piston_mass=self.piston_mass_kg * KG,
            pin_offset=self.pin_offset_mm,
            friction=self.friction,
            cylinders=self.cylinders,
            phase=phase * DEG,
            axes=axes,
            firing=self._firing(phase, axes),
            strokes=strokes,
        )

    def _firing(self, phase: float, axes: Sequence[float]) -> tuple[float, ...]:
        """Crank angle at which each cylinder fires, rad, where the crank pins are given; else empty."""
        if self.crank_pins_deg is None:
            return ()
        name, pins = "engine.crank_pins_deg", self.crank_pins_deg
        rule = f"must give the pin of each of {self.cylinders} cylinders, beginning with 0 for the first"
        require(len(pins) == self.cylinders and pins[:1] == (0.0,), name, pins, rule)
        fires = []
        for number, (pin, axis) in enumerate(zip(pins, axes or (0.0,) * len(pins), strict=True)):
            top, even = pin + axis / DEG, number * phase
            fires.append(top + 360.0 * round((even - top) / 360.0))
        listed = ", ".join(f"{angle:g}" for angle in fires)
        ordered = all(first <= second for first, second in itertools.pairwise(fires))
        rule = f"puts the cylinders out of their order: they would fire at {listed} degrees"
        require(ordered, name, pins, rule, "List pins and banks in the order of firing.")
        return tuple(angle * DEG for angle in fires)

    def _axes(self) -> tuple[float, ...]:
        """Axis of each cylinder from that of the first, rad; empty for an in-line engine."""
        if self.bank_angle_deg is None:
            return ()
        banks = self.banks or ("AB" * self.cylinders)[: self.cylinders]
        rule = f"must name the bank of each of {self.cylinders} cylinders, A or B, beginning with A"
        valid = len(banks) == self.cylinders and set(banks) <= {"A", "B"} and banks[:1] == "A"
        require(valid, "engine.banks", banks, rule)
        return tuple(self.bank_angle_deg * DEG * (bank == "B") for bank in banks)

    def gas_model(self, engine: Engine) -> GasModel:
        """Return the cylinder pressure. Raises `InvalidValue`: a missing key, or a trace of not one cycle."""
        gas: GasModel = NoGas()
        missing = f'is missing: gas = "{self.gas}" needs it', "Give it in [engine]."
        if self.gas in SHIPPED:
            gas = shipped_trace(self.gas)
        elif _is_file(self.gas):
            gas = self._imported(engine.crank_radius / engine.rod_length).trace
        elif self.gas == "boyle":
            gas = Boyle(engine, self.needed("compression_ratio", *missing), self.atmosphere)
        elif self.gas == "compressor":
            ratio = self.needed("compression_ratio", *missing)
            delivery = self.needed("delivery_pressure_bar", *missing) * BAR
            heat_ratio = HEAT_RATIO_AIR if self.heat_ratio is None else self.heat_ratio
            gas = Compressor(engine, ratio, delivery, self.intake, self.atmosphere, heat_ratio)
        elif self.gas != "none":
            ratio = self.needed("compression_ratio", *missing)
            peak, remark = self._peak(ratio, engine) if self.gas == "otto" else (None, "")
            heat_ratio = HEAT_RATIO_AIR if self.heat_ratio is None else self.heat_ratio
            ideal = self.ideal_cycle(engine, ratio, peak, self.intake, heat_ratio)
            gas = dataclasses.replace(ideal, remark=remark)
            if peak is not None and self.fuel == "diesel":  # which burns on while the piston goes down
                rises = ideal.compressed / ideal.intake, peak / ideal.compressed
                until = cut_off(FUELS["diesel"], *rises, heat_ratio)
                burns = f"diesel burns at the peak pressure up to {until:.3g} times the volume at TDC"
                gas = dataclasses.replace(ideal, remark=f"{remark}; {burns}".lstrip("; "), cut_off=until)
        return scaled(gas, self.gas_scale or 1.0)

    def _peak(self, ratio: float, engine: Engine) -> tuple[float, str]:
        """Return the absolute peak pressure, MPa, and where it comes from if it is computed."""
        if self.peak_pressure_bar is not None or self.fuel is None:
            rule, remedy = 'is missing: gas = "otto" needs it', 'Give it, or fuel = "petrol" or "diesel".'
            return self.needed("peak_pressure_bar", rule, remedy) * BAR, ""
        rod_ratio = engine.crank_radius / engine.rod_length
        since = -self.port if self.strokes == 2 else -180.0
        low, high = peak_interval(self.fuel, ratio, self.intake, rod_ratio, since)
        return high, (
            f"peak_pressure_bar = {high / BAR:.3g}, computed for {self.fuel} at full load with "
            f"{self.intake / BAR:.3g} bar in the intake: from late to early combustion it is "
            f"{low / BAR:.0f} to {high / BAR:.0f} bar, of which the largest is used"
        )

    def ideal_cycle(
        self, engine: Engine, ratio: float, peak: float | None, intake: float, heat_ratio: float
    ) -> Otto:
        """Return the ideal cycle of an engine by its strokes; arguments as of `Otto`."""
        of_engine = ratio, peak, intake, self.atmosphere, heat_ratio
        if engine.strokes == 2:
            return TwoStrokeOtto(engine, *of_engine, port=self.port * DEG)
        return Otto(engine, *of_engine)

    def library(self) -> EnginePreset | None:
        """Return the engine of the library that `preset` names."""
        return None if self.preset is None else engine_preset(self.preset)

    def resolved(self) -> "EngineTable":
        """Return the table with what was found out about a trace; as it is if that cannot be read."""
        if not _is_file(self.gas):
            return self
        try:
            read = self._imported()
            strokes = 4 if read.of_four else self.strokes
            return dataclasses.replace(self, **read.keys.given, strokes=strokes)
        except InvalidValue:  # the file is gone: the study still says what was asked for
            return self

    def _imported(self, rod_ratio: float = ROD_RATIO) -> ImportedTrace:
        given = self.intake_pressure_bar is not None or self.boost_bar is not None
        intake = self.intake if given else None
        engine = self.compression_ratio, intake, rod_ratio, self.strokes, self.port
        around = Surroundings(self.atmosphere, *engine)
        return read_trace(Path(self.gas), self, around)

    @property
    def atmosphere(self) -> float:
        """Absolute pressure in the crankcase, MPa."""
        return ATMOSPHERE if self.atmosphere_bar is None else self.atmosphere_bar * BAR

    def brake_torque(self, rpm: float) -> float | None:
        """Return the torque of a cylinder at a speed, rpm, by `full_load`, N·mm; None where that has none."""
        points = sorted((at["rpm"], at["torque_Nm"]) for at in self.full_load or () if "torque_Nm" in at)
        if not points or not points[0][0] <= rpm <= points[-1][0]:
            return None
        return float(np.interp(rpm, *np.transpose(points))) * N_M / self.cylinders

    @property
    def intake(self) -> float:
        """Absolute pressure in the intake, before `gas_scale` multiplies it, MPa."""
        if self.boost_bar is not None:
            return self.atmosphere + self.boost_bar * BAR
        return self.atmosphere if self.intake_pressure_bar is None else self.intake_pressure_bar * BAR


def located_gas(name: str, gas: str, folder: Path) -> str:
    """Return `name` of the gas, a file's path made absolute. Raises `InvalidValue`: no model or such file."""
    if not _is_file(gas):
        return gas
    if not gas.lower().endswith(SUFFIXES):
        choices = ", ".join((*SHIPPED, *_CYCLES))
        remedy = f"Choose {choices} or a text file ({', '.join(SUFFIXES)}); save a spreadsheet as CSV."
        raise InvalidValue(name, gas, "is not a gas model", remedy)
    return str(located(name, gas, folder))


def _is_file(gas: str) -> bool:
    return gas not in SHIPPED and gas not in _CYCLES


_NOT_BOOSTED = {"none", "boyle"}  # gas models that know no pressure in the intake
_SAME_LENGTH = 2e-3  # relative difference up to which two rods count as equally long
# The gas models that need a key; the others do without.
_NEEDED_BY = {
    "compression_ratio": {"boyle", "otto", "motored", "compressor"},
    "peak_pressure_bar": {"otto"},
}


def engine_notes(table: EngineTable, rod_length: float, rpm: float) -> list[Note]:
    """Return notes on an engine of the library; none on other engines. `rod_length` is in mm."""
    preset = table.library()
    notes = cycle_notes(table, table.gas, table.bore_mm, table.intake, table.atmosphere)
    if preset is None:
        return notes
    estimates = [
        f"{key} = {value if isinstance(value, str) else f'{value:g}'} ({origin})"
        for key, (value, origin, assumed) in preset.engine.items()
        if assumed and getattr(table, key) == value and table.gas in _NEEDED_BY.get(key, {table.gas})
    ]
    notes += assumptions(f"engine {preset.name}", estimates)
    if not math.isclose(rod_length, preset.rod_length, rel_tol=_SAME_LENGTH):
        length = f"the rod of the {preset.name} engine is {preset.rod_length:g} mm long"
        notes.append(warning(f"{length}, the one of this study {rod_length:.4g} mm"))
    if rpm > preset.redline_rpm:
        limit = f"the redline of the {preset.name} engine, {preset.redline_rpm:g} rpm"
        notes.append(warning(f"{rpm:g} rpm is above {limit}"))
    return notes


def layout_notes(table: EngineTable) -> list[Note]:
    """Return what the sums over all cylinders leave out if the engine is not an in-line one."""
    preset = table.library()
    in_line = preset is None or preset.layout == "in-line" or table.cylinders == 1
    if preset is None or in_line or table.bank_angle_deg is not None:
        return []
    summed = f"the shaking forces of the whole engine are those of {table.cylinders} cylinders in line"
    real = f"the {preset.name} engine is of {preset.layout} layout"
    remedy = "set engine.bank_angle_deg, and engine.crank_pins_deg if it fires unevenly"
    return [warning(f"{summed}, but {real} ({remedy}); with even firing, the torque is the same")]
