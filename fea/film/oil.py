"""Oil under pressure, by Roelands' viscosity, and how it thins as it warms up."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geometry.arrays import Floats

# Roelands 1966, Correlational Aspects of the Viscosity–Temperature–Pressure Relationship of Lubricating Oils:
# all oils have the viscosity e^−9.67 Pa·s at the pressure −1/5.1e-9 Pa.
_LOG_POLE, _PER_MPA, _PA_S = 9.67, 5.1e-3, 1e6
# Largest relative viscosity, a choice: beyond, oil is a solid that shears at its limiting stress (Bair &
# Winer 1979, A rheological model for elastohydrodynamic contacts, J. Lubr. Technol. 101, 258).
_MOST = 1e3
# Powers of e beyond which there is no number.
_FAR = 700.0
# Places and weights of Gauss's rule between 0 and 1, and the end of that range.
_GAUSS, _SHARES = np.polynomial.legendre.leggauss(8)
_PLACES, _WEIGHTS = np.append((1 + _GAUSS) / 2, 1.0), np.append(_SHARES / 2, 0.0)


@dataclass(frozen=True)
class Oil:
    """An oil at the temperature of the film."""

    viscosity: float  #: μ₀ without pressure, MPa·s (1e-9 of it is 1 mPa·s)
    piezoviscosity: float = 0.0  #: α = d ln μ/dp without pressure, 1/MPa

    @cached_property
    def _roelands(self) -> tuple[float, float]:
        """Logarithm of the viscosity over that of the pole, and the exponent of the pressure."""
        log = math.log(self.viscosity * _PA_S) + _LOG_POLE
        return log, self.piezoviscosity / (_PER_MPA * log)

    @cached_property
    def solid(self) -> float:
        """Pressure at which the viscosity is the largest, MPa."""
        log, exponent = self._roelands
        power = math.log1p(math.log(_MOST) / log) / exponent if exponent else math.inf
        return math.expm1(power) / _PER_MPA if power < _FAR else math.inf

    def relative_viscosity(self, pressure: Floats) -> Floats:
        """Return μ(p)/μ₀ at pressures p ≥ 0, MPa (Roelands 1966)."""
        if not self.piezoviscosity:
            return np.ones_like(pressure)
        log, exponent = self._roelands
        grown = log * ((1 + _PER_MPA * pressure) ** exponent - 1)
        return np.asarray(np.exp(np.minimum(grown, math.log(_MOST))))

    def generalised(self, pressure: Floats) -> tuple[Floats, Floats]:
        """Return q = ∫₀ᵖ μ₀/μ dp, MPa, and its derivative, at pressures p ≥ 0.

        The flow is in proportion to the gradient of q. A viscosity at the mean pressure of two cells has no
        such potential, and has two solutions where oil is trapped.
        """
        if not self.piezoviscosity:
            return pressure, np.ones_like(pressure)
        liquid = np.minimum(pressure, self.solid)
        inner = 1 / self.relative_viscosity(liquid[..., None] * _PLACES)
        return liquid * (inner @ _WEIGHTS) + (pressure - liquid) / _MOST, inner[..., -1]


# Of ASTM D341 in the form of Walther: lg lg(ν + 0.7) is linear in lg T, with ν in mm²/s and T in K.
_ADDED, _KELVIN = 0.7, 273.15
# Thermal expansion of engine oils from 15 °C, 1/K, and their specific heat times the root of the specific
# gravity, kJ/(kg K), and its rise by °C (Cragoe 1929, Thermal Properties of Petroleum Products, NBS M 97).
_EXPANSION, _HEAT, _HEAT_RISE = 6.5e-4, 1.685, 3.39e-3
_KG_M3, _MPAS = 1e-12, 1e-9
_KJ_KG_K = 1e9  # mm²/(s² K)


@dataclass(frozen=True)
class WarmOil:
    """An oil by its kinematic viscosity at two temperatures, °C; between and beyond them by ASTM D341."""

    temperatures: tuple[float, ...]
    kinematic: tuple[float, ...]  #: at them, mm²/s
    density: float  #: at 15 °C, kg/m³
    piezoviscosity: float  #: as of `Oil`

    @classmethod
    def of(cls, dynamic: Sequence[tuple[float, float]], density: float, piezoviscosity: float) -> "WarmOil":
        """By temperatures, °C, and dynamic viscosities, mPa·s."""
        oil = cls((), (), density, piezoviscosity)
        kinematic = [value * _MPAS / oil.density_at(t) for t, value in dynamic]
        return replace(oil, temperatures=tuple(t for t, _ in dynamic), kinematic=tuple(kinematic))

    def density_at(self, temperature: float) -> float:
        """Density, t/mm³."""
        return self.density * (1 - _EXPANSION * (temperature - 15)) * _KG_M3

    def at(self, temperature: float) -> Oil:
        """The oil at a temperature, °C."""
        lgs = [math.log10(math.log10(nu + _ADDED)) for nu in self.kinematic]
        first, second, here = (math.log10(_KELVIN + t) for t in (*self.temperatures, temperature))
        lg = lgs[0] + (lgs[1] - lgs[0]) * (here - first) / (second - first)
        return Oil((10 ** (10**lg) - _ADDED) * self.density_at(temperature), self.piezoviscosity)

    def carried(self, temperature: float) -> float:
        """Heat that a volume of oil takes up when it warms up by 1 K, MPa/K."""
        heat = (_HEAT + _HEAT_RISE * temperature) / math.sqrt(self.density / 999) * _KJ_KG_K
        return heat * self.density_at(temperature)
