"""How the pressures of a trace are read: unit, reference and zero, by keys, headings and the compression."""

import math
from dataclasses import dataclass

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from geometry.arrays import Floats
from geometry.errors import InvalidValue
from loads.compression import ROD_RATIO, Compression, compression

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
# absolute, where no compression tells.
_NEAR_ZERO, _THROTTLED, _AMBIENT = 0.15, 0.4, 1.05
_LEAST = 1.0  # percentile: the least pressure, above the noise


@dataclass(frozen=True)
class Known:
    """What keys, headings and the rest of the study say; None where they say nothing."""

    unit: PressureUnit | None = None
    reference: PressureReference | None = None
    offset: float | None = None  #: bar, added to the pressures of the file
    #: atmosphere, intake: absolute pressures, bar
    atmosphere: float = 1.01325
    intake: float | None = None
    ratio: float | None = None  #: compression ratio
    rod_ratio: float = ROD_RATIO  #: crank radius over rod length


@dataclass(frozen=True)
class Reading:
    """Unit, reference and zero of the pressures of a file."""

    unit: PressureUnit
    reference: PressureReference
    offset: float = 0.0  #: bar, added to the pressures of the file before anything else

    def absolute(self, pressures: Floats, atmosphere: float) -> Floats:
        """Absolute pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        return pressures * self.unit.bar + self.offset + _base(self.reference, atmosphere)

    def gauge(self, pressures: Floats, atmosphere: float) -> Floats:
        """Gauge pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        return self.absolute(pressures, atmosphere) - atmosphere


@dataclass(frozen=True)
class Decision:
    """A reading, why it is that, and what is in doubt."""

    reading: Reading
    fit: Compression | None  #: None where the trace shows no compression
    zero_error: float | None = None  #: bar, standard deviation of an offset that was found
    #: why_reference, why_offset, doubt: in words; empty where nothing was decided, or is in doubt
    why_reference: str = ""
    why_offset: str = ""
    doubt: str = ""


def _base(reference: PressureReference, atmosphere: float) -> float:
    return atmosphere if reference is PressureReference.GAUGE else 0.0


def decide(angles: Floats, pressures: Floats, known: Known, source: str) -> Decision:
    """Decide how pressures (n,) over angles (n,), degrees from firing TDC, are read.

    A unit that nothing names is that which alone puts the absolute pressure at which the intake shuts within
    0.2 to 4 bar. The zero is that of the reference if the compression agrees, and else that of the
    compression, or of the intake where its pressure is given (Randolph, SAE 900170). Raises `InvalidValue`:
    the unit or the reference cannot be decided, or pressures are those of no engine.
    """
    fit = compression(angles, pressures, known.ratio, known.rod_ratio)
    unit = _unit(pressures, fit, source) if known.unit is None else known.unit
    references = [known.reference] if known.reference else list(PressureReference)
    doubt = _exponent_doubt(fit) or (_NOT_SHOWN if fit is None else "")
    if doubt and known.intake is None:
        reference, why = _by_level(references, pressures, unit, known, source)
        doubt = "" if fit is None and known.offset is not None else doubt
        return Decision(Reading(unit, reference, known.offset or 0.0), fit, why_reference=why, doubt=doubt)
    zero, error, why = _zero(angles, pressures, unit, fit, known)
    given = known.offset or 0.0
    away = {each: zero - given - _base(each, known.atmosphere) for each in references}
    nearest = min(away, key=lambda each: abs(away[each]))
    if len(away) > 1 and max(map(abs, away.values())) <= 3 * error:  # the compression tells no difference
        nearest, why = _by_level(references, pressures, unit, known, source)
    same = min(max(_SAME, 2 * error), _FARTHEST_SAME)
    if known.offset is not None or abs(away[nearest]) <= same:
        reading = Reading(unit, nearest, given)
        contradicted = known.offset is not None and abs(away[nearest]) > max(_CONTRADICTS, 3 * error)
        doubt = _contradiction(given, zero - _base(nearest, known.atmosphere), why) if contradicted else doubt
        decision = Decision(reading, fit, why_reference=why, doubt=doubt)
    else:
        reference = known.reference or PressureReference.ABSOLUTE
        other = {abs(away[reference] - swap): swap for swap in (known.atmosphere, -known.atmosphere)}
        near = min(other)  # as if the other reference were meant
        offset = other[near] if near <= same and known.reference else round(away[reference], 2)
        told = f"{why} shows a zero that is off by {-offset:+.2f} bar, ± {2 * error:.2g}".replace("-", "−")
        decision = Decision(Reading(unit, reference, offset), fit, error, why, told, doubt)
    _require_an_engine(decision.reading, pressures, fit, known, source)
    return decision


_NOT_SHOWN = "it shows no compression before firing TDC, by which zero and angles could be checked"


def _unit(pressures: Floats, fit: Compression | None, source: str) -> PressureUnit:
    name, value = f"{source}: pressures", f"{pressures.min():.4g}…{pressures.max():.4g}"
    remedy = 'Set pressure_unit, as in pressure_unit = "bar", and pressure_offset_bar if the zero is off.'
    if fit is None:
        rule = "have no unit in a heading, and show no compression that shows one"
        raise InvalidValue(name, value, rule, remedy)
    possible = []
    for unit in PressureUnit:
        peak = (pressures.max() + fit.zero) * unit.bar
        within = _CLOSING[0] <= fit.closing * unit.bar <= _CLOSING[1]
        if within and _LOWEST_PEAK <= peak <= _HIGHEST_PEAK:
            possible.append(unit)
    if len(possible) == 1:
        return possible[0]
    if not possible:
        rule = (
            "have no unit in a heading, and in none of bar, kPa, MPa, Pa and psi does the intake shut at 0.2 "
            "to 4 bar absolute"
        )
        raise InvalidValue(
            name, value, rule, f"Set engine.pressure_column, if it is another column. {remedy}"
        )
    listed = " or ".join(
        f"{unit} (peak {(pressures.max() + fit.zero) * unit.bar:.4g} bar absolute)" for unit in possible
    )
    raise InvalidValue(name, value, f"have no unit in a heading and may be {listed}", remedy)


def _zero(
    angles: Floats, pressures: Floats, unit: PressureUnit, fit: Compression | None, known: Known
) -> tuple[float, float, str]:
    """What makes the pressures of the file absolute, bar, its standard deviation, and what shows it."""
    bdc = (angles >= _AT_BDC[0]) & (angles <= _AT_BDC[1])
    if known.intake is not None and bdc.any():
        zero = known.intake - float(pressures[bdc].mean()) * unit.bar
        return zero, _PEG_ERROR, f"the pressure in the intake, {known.intake:.4g} bar,"
    if fit is None:
        return 0.0, math.inf, "nothing"
    why = f"the compression, p·V^{fit.exponent:.3g},"
    return fit.zero * unit.bar, fit.zero_error * unit.bar, why


def _exponent_doubt(fit: Compression | None) -> str:
    if fit is None or fit.is_usual:
        return ""
    return (
        f"before firing TDC the pressure follows p·V^{fit.exponent:.3g}, which is not that of a compression "
        "(about 1.3), and its zero is not checked: see compression_ratio and angle_offset_deg"
    )


def _contradiction(given: float, found: float, why: str) -> str:
    return (
        f"pressure_offset_bar = {given:g} is taken, but {why} shows {found:.2f}: check it, the unit and "
        "pressure_reference, or leave it out"
    )


def _by_level(
    references: list[PressureReference], pressures: Floats, unit: PressureUnit, known: Known, source: str
) -> tuple[PressureReference, str]:
    """Decide the reference of a trace without a compression by the least pressure, where that tells."""
    if len(references) == 1:
        return references[0], ""
    least = float(np.percentile(pressures, _LEAST)) * unit.bar + (known.offset or 0.0)
    why = f"the least pressure is {least:.3g} bar"
    if least < _NEAR_ZERO:
        return PressureReference.GAUGE, why
    if _THROTTLED <= least <= _AMBIENT:
        return PressureReference.ABSOLUTE, why
    first, second = (
        f"{unit} {each} (peak {Reading(unit, each).gauge(pressures.max(), known.atmosphere):.4g} bar gauge)"
        for each in references
    )
    name, value = f"{source}: pressures", f"{pressures.min():.4g}…{pressures.max():.4g}"
    remedy = "Set engine.pressure_reference, or give engine.compression_ratio."
    raise InvalidValue(name, value, f"may be {first} or {second}", remedy)


def _require_an_engine(
    reading: Reading, pressures: Floats, fit: Compression | None, known: Known, source: str
) -> None:
    """Refuse a unit that is given and with which the intake shuts at a pressure of no engine."""
    if fit is None or known.unit is None:
        return
    closing = fit.closing * reading.unit.bar
    if _DOUBTFUL[0] <= closing <= _DOUBTFUL[1]:
        return
    others = [str(unit) for unit in PressureUnit if _CLOSING[0] <= fit.closing * unit.bar <= _CLOSING[1]]
    likely = f"In {' or '.join(others)} it would be usual: s" if others else "S"
    rule = (
        f"are in {reading.unit} by key or heading, in which the intake shuts at {closing:.3g} bar absolute, "
        "as in no engine"
    )
    value = f"{pressures.min():.4g}…{pressures.max():.4g}"
    raise InvalidValue(f"{source}: pressures", value, rule, f"{likely}et engine.pressure_unit.")
