"""Viscosity of oil under pressure and temperature, and asperities of rough surfaces that touch.

The pressure of asperities and the space between them depend on the gap between the mean planes of the
undeformed surfaces, which may be negative.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from scipy.special import ndtr, pbdv

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


# Gaps over the roughness beyond which nothing touches: the pressure is 1e-10 of that of planes that coincide.
_APART = 6.0
# Where the table of pressures begins, and its length.
_NEAR, _ENTRIES = -20.0, 20000


@dataclass(frozen=True)
class Asperities:
    """Asperities with Gaussian heights on both surfaces (Greenwood & Tripp 1970, Proc. IMechE 185, 625-633).

    p = 16 √2 π/15 (σβη)² √(σ/β) E* F_5/2(h/σ), with F_n(x) = ∫ₓ^∞ (s − x)ⁿ exp(−s²/2) ds/√2π.
    """

    roughness: float  #: σ of both surfaces together, mm
    modulus: float  #: the factor before F_5/2, MPa
    friction: float  #: coefficient of boundary friction

    @classmethod
    def of(
        cls, roughness: float, crowding: float, slope: float, stiffness: float, friction: float
    ) -> "Asperities":
        """By σβη and σ/β, radius β and number per area η of the summits, and E* of the surfaces, MPa."""
        modulus = 16 * math.sqrt(2) * math.pi / 15 * crowding**2 * math.sqrt(slope) * stiffness
        return cls(roughness, modulus, friction)

    def pressure(self, gap: Floats) -> tuple[Floats, Floats]:
        """Pressure, MPa, and its derivative, MPa/mm, at gaps, mm."""
        ratio, pressure, slope = gap / self.roughness, np.zeros_like(gap), np.zeros_like(gap)
        near = ratio < _APART
        if near.any():
            places, logs, slopes = _table()
            pressure[near] = self.modulus * np.exp(np.interp(ratio[near], places, logs))
            slope[near] = pressure[near] / self.roughness * np.interp(ratio[near], places, slopes)
        return pressure, slope

    def space(self, gap: Floats) -> tuple[Floats, Floats]:
        """Mean distance of the surfaces that oil can fill, mm, and its derivative.

        It is the mean of h + s where that is positive, with the Gaussian heights s (Wu & Zheng 1989, Journal
        of Tribology 111, 179-185).
        """
        ratio = gap / self.roughness
        share = ndtr(ratio)
        return gap * share + self.roughness * np.exp(-(ratio**2) / 2) / math.sqrt(2 * math.pi), share


def _integral(order: float, x: Floats) -> tuple[Floats, Floats]:
    """F_n(x) by the parabolic cylinder function D_−n−1 (Abramowitz & Stegun 1964, 19.5.3), and its slope."""
    values, slopes = pbdv(-order - 1, x)
    factor = math.gamma(order + 1) / math.sqrt(2 * math.pi) * np.exp(-(x**2) / 4)
    return np.asarray(factor * values), np.asarray(factor * (slopes - x / 2 * values))


@cache
def _table() -> Floats:
    """Places, the logarithm of F_5/2 there and its slope (3, n), between which all is linear.

    That changes no pressure by more than 1e-6; nearer than its beginning, planes are only on the way to a
    solution.
    """
    x = np.linspace(_NEAR, _APART, _ENTRIES)
    integral, slope = _integral(2.5, x)
    return np.stack([x, np.log(integral), slope / integral])
