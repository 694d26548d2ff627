"""Peak pressure of a burning charge, from the intake, the compression ratio, and when the charge burns.

The closed cycle of one zone of gas, with heat by a Wiebe function (Heywood 1988, section 9.2):

    dp = −γ p dV/V + (γ − 1) dQ/V,    γ = γ₀ − γ₁ T

What decides the peak is when the charge burns. With the best timing of ignition half of it has burned about
10° after TDC, and the pressure is largest at about 16° (Heywood 1988, section 9.1), as in this closed cycle.
Later ignition, as where an engine would knock, lowers the peak by up to a half. A peak is therefore an
interval, from late and slow combustion to early and fast combustion in a cylinder that is filled well.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InvalidValue
from loads.compression import ROD_RATIO, volume

_GAS_CONSTANT = 287.0  # J/(kg K)
_HEAT_RATIO, _PER_KELVIN = 1.40, 7.5e-5  # γ₀ and γ₁, between those of air and of burned gas
_LOST = 0.15  # share of the heat that the walls take before the peak
_WIEBE, _COMPLETE = 3.0, 6.908  # exponent m + 1, and a = −ln(0.001)
# Angles from TDC, degrees, between which the cycle is closed.
_CLOSED = np.arange(-180.0, 120.0, 0.25)


class Timing(NamedTuple):
    """When a charge burns."""

    half_burned: float  #: half of it, degrees after TDC
    duration: float  #: how long, degrees
    filling: float  #: pressure at the beginning of compression over that in the intake


@dataclass(frozen=True)
class Fuel:
    """A fuel and how it burns at full load."""

    heat: float  #: that a kilogram of charge sets free, J
    temperature: float  #: of the charge at the beginning of compression, K
    #: late, early: combustion with the lowest and the highest peak pressure
    late: Timing
    early: Timing


# Heat of combustion over the air that it takes (petrol 44.0 MJ/kg over 14.6, diesel 42.5 over 14.5; Heywood
# 1988, table D.4); petrol burns all the air, a diesel engine at full load 70 % of it. 4 % of the charge are
# residual gas, and the fuel of petrol engines is part of it.
FUELS = {
    "petrol": Fuel(0.96 * 44.0e6 / 14.6 / (1 + 1 / 13.0), 350.0, Timing(25, 60, 0.9), Timing(8, 40, 1.1)),
    "diesel": Fuel(0.96 * 0.7 * 42.5e6 / 14.5, 360.0, Timing(18, 80, 0.95), Timing(8, 50, 1.05)),
}


def closed_cycle(
    ratio: float, pressure: float, fuel: Fuel, timing: Timing, rod_ratio: float, *, since: float = -180.0
) -> tuple[Floats, Floats]:
    """Integrate the pressure of a closed cycle from `pressure`, MPa, at BDC.

    Returned are crank angles (n,), degrees from TDC, and absolute pressures (n,), MPa. `ratio`: of
    compression; `rod_ratio`: crank radius over rod length; `since`: degrees from TDC at which a port closes,
    if not at BDC.
    """
    angles = _CLOSED[since <= _CLOSED]
    sizes = volume(angles, ratio, rod_ratio)
    half = (math.log(2) / _COMPLETE) ** (1 / _WIEBE)  # of the duration, until half has burned
    passed = np.clip((angles - timing.half_burned) / timing.duration + half, 0.0, 1.0)
    burned = -np.expm1(-_COMPLETE * passed**_WIEBE)
    # Heat, MPa times the unit of the volume: mass = p V/(R T).
    mass = pressure * sizes[0] / (_GAS_CONSTANT * fuel.temperature)
    heat = mass * fuel.heat * (1 - _LOST) * np.diff(burned)
    compressed, middle = sizes[:-1] / sizes[1:], (sizes[1:] + sizes[:-1]) / 2
    pressures = [pressure]
    for number in range(len(heat)):
        now = pressures[-1]
        gamma = _HEAT_RATIO - _PER_KELVIN * now * sizes[number] / (mass * _GAS_CONSTANT)
        heated = (gamma - 1) * float(heat[number] / middle[number])
        pressures.append(now * float(compressed[number] ** gamma) + heated)
    return angles, np.array(pressures)


def peak_interval(
    name: str, ratio: float, intake: float, rod_ratio: float = ROD_RATIO, since: float = -180.0
) -> tuple[float, float]:
    """Return the lowest and the highest absolute peak pressure of an engine at full load, MPa.

    `name`: of the fuel; `intake`: absolute pressure, MPa; `since`: as of `closed_cycle`. Raises
    `InvalidValue`: an unknown fuel.
    """
    if name not in FUELS:
        raise InvalidValue("engine.fuel", name, f"must be one of {', '.join(FUELS)}")
    fuel = FUELS[name]
    low, high = (
        float(closed_cycle(ratio, timing.filling * intake, fuel, timing, rod_ratio, since=since)[1].max())
        for timing in (fuel.late, fuel.early)
    )
    return low, high


def cut_off(fuel: Fuel, squeezed: float, rise: float, heat_ratio: float) -> float:
    """Return the volume over that at TDC until which fuel burns at the peak pressure; at least 1.

    Limited-pressure cycle of a perfect gas (Heywood 1988, table 5.1): heat that does not raise the pressure
    is set free at constant pressure, q = c_v (T₃ − T₂) + c_p T₃ (ρ − 1) with c_v = R/(γ − 1). `squeezed`:
    pressure after compression over that before it; `rise`: that of combustion; `heat_ratio`: γ.
    """
    heated = fuel.temperature * squeezed ** (1 - 1 / heat_ratio)  # T₂, K
    heat = (1 - _LOST) * fuel.heat * (heat_ratio - 1) / (_GAS_CONSTANT * heated)  # over c_v T₂
    return max(1.0, float(1 + (heat - (rise - 1)) / (heat_ratio * rise)))
