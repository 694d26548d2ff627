"""Unit and reference of a recorded pressure, where neither a key nor a heading gives them."""

from dataclasses import dataclass

import numpy as np

from fea.base.choices import PressureReference, PressureUnit
from fea.base.units import BAR
from geometry.arrays import Floats
from geometry.errors import InvalidValue
from loads.gas import LARGEST_PEAK
from loads.trace import Exponent, compression_exponent

_LOWEST_PEAK = 3.0  # bar gauge: a throttled engine that idles reaches no more
# Least absolute pressures, bar: those of any engine, of nearly all, and of most. A reading is preferred only
# where it is among the last and no other is among the second.
_ANY, _NEARLY_ALL, _MOST = (0.1, 6.5), (0.2, 4.5), (0.3, 3.5)
# Least pressures as they stand in the file, bar: below the first they are gauge, from the second to the third
# absolute, unless the compression says otherwise.
_NEAR_ZERO, _THROTTLED, _AMBIENT = 0.15, 0.4, 1.05
# Percentiles: the level at which the cylinder is filled, above the noise, and the least pressure of all.
_FILLING, _LEAST = 10.0, 1.0


@dataclass(frozen=True)
class Reading:
    """One way to read the pressures, by the values of the keys."""

    unit: PressureUnit
    reference: PressureReference

    def absolute(self, pressures: Floats, atmosphere: float) -> Floats:
        """Absolute pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        shift = atmosphere if self.reference is PressureReference.GAUGE else 0.0
        return pressures * self.unit.bar + shift

    def gauge(self, pressures: Floats, atmosphere: float) -> Floats:
        """Gauge pressures, bar, of pressures in the unit of the file; `atmosphere` in bar."""
        shift = atmosphere if self.reference is PressureReference.ABSOLUTE else 0.0
        return pressures * self.unit.bar - shift


def read_as(
    angles: Floats,
    pressures: Floats,
    unit: PressureUnit | None,
    reference: PressureReference | None,
    *,
    atmosphere: float,
    ratio: float | None,
    source: str,
) -> tuple[Reading, str, str]:
    """Decide unit and reference; say why, and where the result is in doubt.

    Angles (n,) are in degrees from firing TDC, pressures (n,) in the unit of the file, the atmosphere in bar;
    unit, reference and compression ratio are None where they are not known. Raises `InvalidValue`: no
    reading, or more than one, is possible.
    """
    readings = [
        Reading(u, r)
        for u in ([unit] if unit else PressureUnit)
        for r in ([reference] if reference else PressureReference)
    ]
    possible = [r for r in readings if _is_plausible(r, pressures, atmosphere, known_unit=unit is not None)]
    exponents = {
        r: compression_exponent(angles, r.absolute(pressures, atmosphere), ratio)
        for r in possible or readings
    }
    if len(readings) == 1:
        return readings[0], "", _doubt(exponents[readings[0]])
    fitting = [r for r in possible if exponents[r].is_compression]
    if len(fitting) == 1:
        return fitting[0], f"compression then follows p·V^{exponents[fitting[0]].middle:.3g}", ""
    left = _preferred(fitting or possible, pressures, atmosphere)
    if len(left) != 1:
        raise _no_reading(left, pressures, atmosphere, source)
    why = f"the least pressure is {_level(pressures, _LEAST):.3g} {left[0].unit}"
    return left[0], why, _doubt(exponents[left[0]])


def _doubt(exponent: Exponent) -> str:
    """A remark on a pressure that does not rise as compression makes it."""
    if exponent.is_compression or not exponent.known:
        return ""
    return (
        f"between 110° and 60° before firing TDC the pressure follows p·V^{exponent.middle:.3g}, which is "
        "not that of a compression (about 1.3): check pressure_reference and angle_offset_deg"
    )


def _level(pressures: Floats, percentile: float = _FILLING) -> float:
    return float(np.percentile(pressures, percentile))


def _is_plausible(reading: Reading, pressures: Floats, atmosphere: float, *, known_unit: bool) -> bool:
    absolute = reading.absolute(pressures, atmosphere)
    least, peak = _level(absolute), float(absolute.max()) - atmosphere
    if known_unit:
        return least > 0
    return _within(least, _ANY) and _LOWEST_PEAK <= peak <= LARGEST_PEAK / BAR


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _preferred(readings: list[Reading], pressures: Floats, atmosphere: float) -> list[Reading]:
    """Keep the readings that the least pressure indicates; all where it does not decide."""
    least = {r: _level(r.absolute(pressures, atmosphere)) for r in readings}
    near = [r for r in readings if _within(least[r], _NEARLY_ALL)]
    units = {r.unit for r in near}
    if len(units) == 1 and any(_within(least[r], _MOST) for r in near):
        readings = near
    return _by_level(readings, pressures) if len({r.unit for r in readings}) == 1 else readings


def _by_level(readings: list[Reading], pressures: Floats) -> list[Reading]:
    """Keep the reference, of readings in one unit, that the least pressure indicates."""
    if len(readings) == 1:
        return readings
    least = _level(pressures, _LEAST) * readings[0].unit.bar
    if least < _NEAR_ZERO:
        return [r for r in readings if r.reference is PressureReference.GAUGE]
    if _THROTTLED <= least <= _AMBIENT:
        return [r for r in readings if r.reference is PressureReference.ABSOLUTE]
    return readings


def _no_reading(readings: list[Reading], pressures: Floats, atmosphere: float, source: str) -> InvalidValue:
    name, value = f"{source}: pressures", f"{pressures.min():.4g}…{pressures.max():.4g}"
    if not readings:
        rule = "are those of a cylinder in none of bar, kPa, MPa, Pa and psi, neither absolute nor gauge"
        remedy = "Set engine.pressure_column, or engine.pressure_unit and engine.pressure_reference."
        return InvalidValue(name, value, rule, remedy)
    first, second = (
        f"{r.unit} {r.reference} (peak {float(r.gauge(pressures.max(), atmosphere)):.4g} bar gauge)"
        for r in readings[:2]
    )
    remedy = "Set engine.pressure_reference, or give engine.compression_ratio."
    if readings[0].unit is not readings[1].unit:
        remedy = "Set engine.pressure_unit and engine.pressure_reference."
    return InvalidValue(name, value, f"may be {first} or {second}", remedy)
