"""Pressure traces from files of measurements: what keys and headings leave open is decided and reported."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.base.shipped import TomlTable, shipped_text
from fea.base.units import BAR, DEG, RPM
from fea.study.trace_columns import TraceKeys, trace_columns
from fea.study.trace_cycles import (
    Recording,
    completed,
    firing_offset,
    from_firing,
    one_cycle,
    recorded,
    smoothed,
)
from fea.study.trace_table import DOCUMENTED, TraceTable, find_table, read_text, speed_of
from fea.study.two_stroke import EXHAUST_PORT_DEG
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.compression import CLOSING, ROD_RATIO, Compression, compression, is_motored, peak_angle
from loads.gas import ATMOSPHERE
from loads.trace import DOUBLE_ACTING, Trace, TraceReading

_TURN, _CYCLE = 360.0, 720.0
_FOUR_STROKES = 4
SHIPPED = ("leon-2001",)
# What a file of measurements may be called.
SUFFIXES = (".csv", ".txt", ".dat", ".tsv", ".asc", ".prn")


@dataclass(frozen=True)
class Surroundings:
    """The rest of the study that bears on a trace."""

    atmosphere: float = ATMOSPHERE  #: absolute pressure in the crankcase, MPa
    compression_ratio: float | None = None
    intake: float | None = None  #: absolute pressure in the intake, MPa
    rod_ratio: float = ROD_RATIO  #: crank radius over rod length
    strokes: int | None = None  #: of a cycle; None is not given: 4
    port: float = EXHAUST_PORT_DEG  #: degrees after TDC, of a two-stroke engine

    @property
    def cycle(self) -> float:
        """Crank angle of a cycle, degrees."""
        return _TURN if self.strokes == 2 else _CYCLE

    @property
    def shut(self) -> float:
        """Where the intake or the port shuts, about, degrees from firing TDC."""
        return -self.port if self.strokes == 2 else CLOSING


@dataclass(frozen=True)
class ImportedTrace:
    """A trace, and the keys by which it is read in the same way again."""

    trace: Trace
    keys: TraceKeys
    of_four: bool = False  #: whether the engine was taken for a four-stroke because nothing says so


_NONE, _STROKES = TraceKeys(), "strokes"
_NOWHERE = Surroundings()


def shipped_trace(name: str) -> Trace:
    """Load a trace that comes with the program. Raises `InvalidValue`: it is none of `SHIPPED`."""
    require(name in SHIPPED, "engine.gas", name, f"must be one of {', '.join(SHIPPED)} or a CSV file")
    table = find_table(shipped_text(f"studies/{name}-gas.csv"), "")
    return Trace(table.values[:, 0] * DEG, table.values[:, 1:].T * BAR, _speeds(table.names[1:]))


def _speeds(names: tuple[str, ...]) -> Floats:
    return np.array([speed_of(name) for name in names], dtype=np.float64) * RPM


def read_trace(path: Path, keys: TraceKeys = _NONE, around: Surroundings = _NOWHERE) -> ImportedTrace:
    """Read a user's trace by its keys, and decide the rest. Raises `InvalidValue` with file and line."""
    return parse_trace(read_text(path), path.name, keys, around)


def parse_trace(
    text: str, source: str, keys: TraceKeys = _NONE, around: Surroundings = _NOWHERE
) -> ImportedTrace:
    """Turn the text of a file into a trace; `source` is its name in messages.

    The documented format counts angles from gas-exchange TDC, 0 to 720°, or of a two-stroke engine from
    firing TDC, and is not smoothed, unless keys say otherwise; of a column per speed all are read.
    """
    table = find_table(text, source)
    angles = table.values[:, 0]
    documented = table.documented and keys.given.keys() <= {"pressure_offset_bar"}
    documented = documented and bool(angles.min() >= 0 and angles.max() <= around.cycle)
    by_speed = table.documented and table.names != DOCUMENTED and keys.pressure_column is None
    if not by_speed:
        return _imported(table, keys, around, documented=documented)
    columns, read = table.names[1:], list[ImportedTrace]()
    for column in columns:
        as_first = replace(read[0].keys if read else keys, pressure_column=column)
        read.append(_imported(table, as_first, around, documented=documented))
    traces = [each.trace for each in read]
    remarks, doubts = (
        tuple(dict.fromkeys(line for trace in traces for line in getattr(trace, kind)))
        for kind in ("remarks", "doubts")
    )
    highest = max(traces, key=lambda trace: float(trace.pressures.max()))
    pressures = np.concatenate([trace.pressures for trace in traces])
    trace = _checked(traces[0].crank_angles, pressures, _speeds(columns), source, around)
    trace = replace(trace, remarks=remarks, doubts=doubts, reading=highest.reading)
    return ImportedTrace(trace, replace(read[0].keys, pressure_column=None), read[0].of_four)


def _checked(angles: Floats, pressures: Floats, speeds: Floats, source: str, around: Surroundings) -> Trace:
    try:
        return Trace(angles, pressures, speeds, source, cycle=around.cycle * DEG)
    except InvalidValue as error:
        raise InvalidValue(f"{source}: {error.name}", error.value, error.rule, error.remedy) from error


# Values of keys that neither the study nor the file gives, and why they were chosen.
_Assumed = dict[str, tuple[str | float, str]]


def _imported(table: TraceTable, keys: TraceKeys, around: Surroundings, *, documented: bool) -> ImportedTrace:
    """Read one column of pressures, or one set of cycles."""
    source, atmosphere = table.source, around.atmosphere / BAR
    columns = trace_columns(table, keys)
    samples = columns.angles, columns.pressures, source, table.lines
    offset, width, held = keys.angle_offset_deg, 0.0, np.nan
    if documented:
        recording = one_cycle(*samples, around.cycle)
        angles, turned, unsmoothed = from_firing(recording, around.cycle)
        pressures = unsmoothed
    else:
        recording = recorded(*samples, around.cycle)
        offset = firing_offset(recording, source) if offset is None else offset
        angles, unsmoothed, held = completed(recording, _TURN - offset, source, around.cycle)
        pressures, width = smoothed(angles, unsmoothed, recording.step, keys.smoothing_deg, around.cycle)
        turned = np.mod(angles + _TURN, around.cycle)
    fit = compression(angles, pressures, around.compression_ratio, around.rod_ratio, around.shut)
    by_heading = replace(keys, pressure_unit=columns.unit, pressure_reference=columns.reference)
    scale = _pressure_scale(angles, pressures, fit, by_heading, around=around, source=source)
    unit, absolute = scale.unit, scale.absolute(pressures, atmosphere)
    gauge = absolute - atmosphere

    assumed: _Assumed = {key: (at, f"of {len(table.names)} columns") for key, at in columns.chosen.items()}
    if columns.unit is None:
        assumed["pressure_unit"] = unit, f"which makes the largest {absolute.max():.4g} bar absolute"
    if columns.reference is None:
        assumed["pressure_reference"] = scale.reference, f"as {scale.shown_by.rstrip(',')} shows"
    if offset is not None and keys.angle_offset_deg is None:
        from_tdc = recording.peak - _TURN + offset
        tdc = _TURN - offset + around.cycle * round(from_tdc / around.cycle)
        why = f"firing TDC at {tdc:g}° in the file, where the peak is at {recording.peak:.4g}°"
        assumed["angle_offset_deg"] = offset, why
    if not np.isnan(held) and around.strokes is None:
        why = f"the gas exchange is held at {held:.4g} {unit}, where compression begins"
        assumed[_STROKES] = _FOUR_STROKES, f"one revolution is recorded; {why}"
    if width and keys.smoothing_deg is None:
        change = float(np.abs(pressures - unsmoothed).max())
        peaks = f"the peak from {unsmoothed.max():.4g} to {pressures.max():.4g} {unit}"
        assumed["smoothing_deg"] = width, f"changes no pressure by more than {change:.2g} {unit}, {peaks}"

    order = np.argsort(turned, kind="stable")
    trace = _checked(turned[order] * DEG, gauge[order] * BAR, np.zeros(0), source, around)
    name, flanks, doubts = f"pressure trace {source}", "", [*scale.doubts]
    if fit is not None and is_motored(angles, absolute):
        doubts.append(_motored_phase(peak_angle(angles, absolute), source))
    elif fit is not None and keys.angle_offset_deg is None:
        flanks = _phase_error(angles, absolute, around)
    remarks = [_summary(trace, recording, scale, atmosphere, assumed), flanks]
    trace = replace(
        trace,
        remarks=tuple(f"{name}: {remark}" for remark in remarks if remark),
        doubts=tuple(f"{name}: {doubt}" for doubt in doubts if doubt),
        reading=TraceReading(
            unit=unit.value,
            reference=scale.reference.value,
            offset_bar=scale.offset,
            offset_error_bar=scale.offset_error,
            compression_exponent=None if fit is None else fit.exponent,
            peak_bar=float(gauge.max()),
        ),
    )
    decided: TomlTable = {key: value for key, (value, _) in assumed.items() if key != _STROKES}
    return ImportedTrace(trace, replace(keys, **decided), _STROKES in assumed)


def _shown(value: str | float) -> str:
    return f"{value:g}" if isinstance(value, int | float) else f'"{value}"'


def _summary(
    trace: Trace, recording: Recording, scale: "_Scale", atmosphere: float, assumed: _Assumed
) -> str:
    """Say how many cycles were averaged and what was assumed; "" where there is nothing to say."""
    cycles, pressures = "", trace.pressures[0]
    if recording.cycles > 1:
        highest = float(scale.absolute(np.array(recording.highest), atmosphere)) - atmosphere
        cycles = f"the mean of {recording.cycles} cycles, the highest of which reaches {highest:.4g} bar, "
    if not cycles and not assumed:
        return ""
    peak, angle = pressures.max() / BAR, trace.crank_angles[int(pressures.argmax())] / DEG
    texts = (f"{key} = {_shown(value)} ({why})" for key, (value, why) in assumed.items())
    assuming = f", assuming {', '.join(texts)}" if assumed else ""
    return f"{cycles}peak {peak:.4g} bar gauge at {angle:.4g}°{assuming}"


# Degrees from TDC of a motored peak, which heat and leaks bring before it: the latest, as near to TDC as a
# peak can be located, those between which it is not doubted, and where it usually is.
_MOTORED_LATEST, _MOTORED_UNDOUBTED, _MOTORED_USUAL = -0.02, (-2.0, -0.2), -0.6


def _motored_phase(peak: float, source: str) -> str:
    """Return a doubt of the angles of a motored trace. Raises `InvalidValue`: it peaks at or after TDC."""
    rule = "of a motored engine lies at or after TDC: heat and leaks bring it 0.3 to 1° before it"
    remedy = f"Add {_MOTORED_USUAL - peak:.2g}° to the angles (engine.angle_offset_deg)."
    require(peak < _MOTORED_LATEST, f"{source}: the peak", f"{peak:+.2f}° from TDC", rule, remedy)
    if _MOTORED_UNDOUBTED[0] <= peak <= _MOTORED_UNDOUBTED[1]:
        return ""
    return f"the motored peak is {-peak:.2g}° before TDC, where 0.3 to 1° is usual: check angle_offset_deg"


_FLANKS = 60.0  # degrees about firing TDC in which the pressure rises and falls fastest
# Bar, by which the shock of the flame's heat moves the exhaust stroke of a pegged sensor.
_SHOCK = "±0.3 to 0.5"


def _phase_error(angles: Floats, absolute: Floats, around: Surroundings) -> str:
    """Say what an uncertain TDC of a degree costs, where neither file nor key gives it."""
    # The last sample of a two-stroke cycle may stand at firing TDC, as the first.
    near = (np.abs(angles) <= _FLANKS) & (np.diff(angles, prepend=-np.inf) > 0)
    flank = float(np.abs(np.gradient(absolute[near], angles[near])).max())
    said = f"each degree by which its TDC is off changes the flanks of the peak by up to {flank:.2g} bar"
    if around.strokes == 2:
        return said
    return (
        f"{said}, and the heat of the flame moves the sensor's exhaust stroke, which counts at gas-exchange "
        f"TDC, by {_SHOCK} bar"
    )


_LOWEST_PEAK, _HIGHEST_PEAK = 3.0, 400.0  # bar absolute: an engine that idles, and more than any reaches
# Absolute pressures at which the intake shuts, bar: of engines, and by which a unit that is given is doubted.
_CLOSING, _DOUBTFUL = (0.2, 4.0), (0.1, 6.0)
# Zeros nearer than this to that of the reference, bar, are taken for the same; with a wide error the second.
_SAME, _FARTHEST_SAME = 0.12, 0.45
# A zero that is given is doubted where the compression shows another by more than this, bar.
_CONTRADICTS = 0.3
_PEG_ERROR = 0.05  # bar, of the pressure in the cylinder at BDC against that in the intake
_AT_BDC = (-190.0, -170.0)  # degrees from firing TDC, about the dead centre at which the cylinder is filled
# Least pressures as they stand in the file, bar: below the first they are gauge, from the second to the third
# absolute, where no compression decides.
_NEAR_ZERO, _THROTTLED, _AMBIENT = 0.15, 0.4, 1.05
_LEAST = 1.0  # percentile: the least pressure, above the noise


@dataclass(frozen=True)
class _Scale:
    """Unit, reference and zero of the pressures of a file, and what shows them."""

    unit: PressureUnit
    reference: PressureReference
    offset: float = 0.0  #: bar, added to the pressures of the file before anything else
    offset_error: float | None = None  #: bar, standard deviation of an offset that was found
    shown_by: str = ""  #: what shows the reference, in words
    doubts: tuple[str, ...] = ()  #: in words; empty ones do not count

    def absolute(self, pressures: Floats, atmosphere: float) -> Floats:
        """Absolute pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        return pressures * self.unit.bar + self.offset + _base(self.reference, atmosphere)


def _base(reference: PressureReference, atmosphere: float) -> float:
    return atmosphere if reference is PressureReference.GAUGE else 0.0


def _pressure_scale(
    angles: Floats,
    pressures: Floats,
    fit: Compression | None,
    keys: TraceKeys,
    *,
    around: Surroundings,
    source: str,
) -> _Scale:
    """Decide how pressures (n,) over angles (n,), degrees from firing TDC, are read.

    An unknown unit is the only one in which the intake shuts at 0.2 to 4 bar. The zero is that of the
    reference if the compression agrees, else that of the compression, or of a given intake pressure
    (Randolph, SAE 900170). Raises `InvalidValue`: neither unit nor reference, or no engine.
    """
    offset, atmosphere = keys.pressure_offset_bar, around.atmosphere / BAR
    unit = keys.pressure_unit or _unit(pressures, fit, source)
    doubt = _compression_doubt(fit)
    if doubt and around.intake is None:
        reference, why = _by_level(pressures, unit, keys, atmosphere, source)
        doubts = () if fit is None and offset is not None else (doubt,)
        return _Scale(unit, reference, offset or 0.0, shown_by=why, doubts=doubts)
    zero, error, why = _zero(angles, pressures, unit, fit, around)
    references = [keys.pressure_reference] if keys.pressure_reference else list(PressureReference)
    away = {each: zero - (offset or 0.0) - _base(each, atmosphere) for each in references}
    nearest = min(away, key=lambda each: abs(away[each]))
    if len(away) > 1 and max(map(abs, away.values())) <= 3 * error:  # the compression shows no difference
        nearest, why = _by_level(pressures, unit, keys, atmosphere, source)
    same = min(max(_SAME, 2 * error), _FARTHEST_SAME)
    if offset is not None or abs(away[nearest]) <= same:
        if offset is not None and abs(away[nearest]) > max(_CONTRADICTS, 3 * error):
            doubt = (
                f"pressure_offset_bar = {offset:g} is taken, but {why} shows "
                f"{zero - _base(nearest, atmosphere):.2f}: check it, the unit and pressure_reference, or "
                "leave it out"
            )
        scale = _Scale(unit, nearest, offset or 0.0, shown_by=why, doubts=(doubt,))
    else:
        reference = keys.pressure_reference or PressureReference.ABSOLUTE
        # Off by an atmosphere is exactly that, as if the other reference were meant.
        other = min((atmosphere, -atmosphere), key=lambda swap: abs(away[reference] - swap))
        swapped = abs(away[reference] - other) <= same and keys.pressure_reference
        offset = other if swapped else round(away[reference], 2)
        shift = f"{-offset:+.2f} bar, ± {2 * error:.2g}".replace("-", "−")
        shifted = (
            f"{why} shows a zero that is off by {shift}; the pressures are shifted by that "
            "(pressure_offset_bar sets it)"
        )
        scale = _Scale(unit, reference, offset, error, why, (doubt, shifted))
    if fit is not None and keys.pressure_unit is not None:
        _require_an_engine(fit, unit, pressures, source)
    return scale


def _compression_doubt(fit: Compression | None) -> str:
    if fit is None:
        return "it shows no compression before firing TDC, by which zero and angles could be checked"
    if fit.is_usual:
        return ""
    return (
        f"before firing TDC the pressure follows p·V^{fit.exponent:.3g}, which is not that of a compression "
        "(about 1.3), and its zero is not checked: see compression_ratio and angle_offset_deg"
    )


def _closes_within(fit: Compression, unit: PressureUnit, bounds: tuple[float, float]) -> bool:
    return bounds[0] <= fit.closing * unit.bar <= bounds[1]


# Of the largest pressure: how far below zero pressures fall that no lost zero of a sensor explains.
_BOTH_SIDES = 0.3


def _unit(pressures: Floats, fit: Compression | None, source: str) -> PressureUnit:
    name, value = _named(pressures, source)
    usual = fit is not None and fit.is_usual
    rule = "fall far below zero, as those of a cylinder with pressure on both sides of its piston"
    both = pressures.min() < -_BOTH_SIDES * pressures.max()
    require(usual or not both, name, value, rule, DOUBLE_ACTING)
    remedy = 'Set pressure_unit, as in pressure_unit = "bar", and pressure_offset_bar if the zero is off.'
    if fit is None:
        rule = "have no unit in a heading, and show no compression that shows one"
        raise InvalidValue(name, value, rule, remedy)
    peaks = {unit: (pressures.max() + fit.zero) * unit.bar for unit in PressureUnit}
    possible = [
        unit
        for unit, peak in peaks.items()
        if _closes_within(fit, unit, _CLOSING) and _LOWEST_PEAK <= peak <= _HIGHEST_PEAK
    ]
    if len(possible) == 1:
        return possible[0]
    listed = " or ".join(f"{unit} (peak {peaks[unit]:.4g} bar absolute)" for unit in possible)
    rule = f"have no unit in a heading and may be {listed}"
    if not possible:
        rule = (
            "have no unit in a heading, and in none of bar, kPa, MPa, Pa and psi does the intake shut at 0.2 "
            "to 4 bar absolute"
        )
        remedy = f"Set engine.pressure_column, if it is another column. {remedy}"
    raise InvalidValue(name, value, rule, remedy)


def _zero(
    angles: Floats, pressures: Floats, unit: PressureUnit, fit: Compression | None, around: Surroundings
) -> tuple[float, float, str]:
    """Return the offset to absolute pressure, bar, its standard deviation, and what shows it."""
    bdc = (angles >= _AT_BDC[0]) & (angles <= _AT_BDC[1])
    if around.intake is not None and bdc.any():
        intake = around.intake / BAR
        zero = intake - float(pressures[bdc].mean()) * unit.bar
        return zero, _PEG_ERROR, f"the pressure in the intake, {intake:.4g} bar,"
    if fit is None:
        return 0.0, math.inf, "nothing"
    why = f"the compression, p·V^{fit.exponent:.3g},"
    return fit.zero * unit.bar, fit.zero_error * unit.bar, why


def _by_level(
    pressures: Floats, unit: PressureUnit, keys: TraceKeys, atmosphere: float, source: str
) -> tuple[PressureReference, str]:
    """Decide the reference of a trace without a compression by the least pressure, where that suffices."""
    if keys.pressure_reference is not None:
        return keys.pressure_reference, ""
    least = float(np.percentile(pressures, _LEAST)) * unit.bar + (keys.pressure_offset_bar or 0.0)
    why = f"the least pressure is {least:.3g} bar"
    if least < _NEAR_ZERO:
        return PressureReference.GAUGE, why
    if _THROTTLED <= least <= _AMBIENT:
        return PressureReference.ABSOLUTE, why
    peaks = {
        each: _Scale(unit, each).absolute(pressures.max(), atmosphere) - atmosphere
        for each in PressureReference
    }
    listed = " or ".join(f"{unit} {each} (peak {peak:.4g} bar gauge)" for each, peak in peaks.items())
    remedy = "Set engine.pressure_reference, or give engine.compression_ratio."
    raise InvalidValue(*_named(pressures, source), f"may be {listed}", remedy)


def _require_an_engine(fit: Compression, unit: PressureUnit, pressures: Floats, source: str) -> None:
    """Refuse a unit that is given and with which the intake shuts at a pressure of no engine."""
    others = [str(other) for other in PressureUnit if _closes_within(fit, other, _CLOSING)]
    likely = f"In {' or '.join(others)} it would be usual: s" if others else "S"
    rule = (
        f"are in {unit} by key or heading, in which the intake shuts at {fit.closing * unit.bar:.3g} bar "
        "absolute, as in no engine"
    )
    valid, remedy = _closes_within(fit, unit, _DOUBTFUL), f"{likely}et engine.pressure_unit."
    require(valid, *_named(pressures, source), rule, remedy)


def _named(pressures: Floats, source: str) -> tuple[str, str]:
    return f"{source}: pressures", f"{pressures.min():.4g}…{pressures.max():.4g}"
