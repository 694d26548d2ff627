"""The map of limits: where each mode of failure begins on rays from rest through speed squared and gas."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from fea.apps.limits.engine import ScaledEngine
from fea.apps.limits.factors import ONSETS, FailureMode, ModeFactor
from geometry.arrays import Floats
from loads.gas import LARGEST_PEAK

# Just below the largest pressure of any engine, MPa: the highest that is evaluated.
MOST_PEAK = 0.999 * LARGEST_PEAK
# Loads over that at yield beyond which stress is not elastic, and nothing is drawn.
ELASTIC = 1.2
# Loads on a ray are at most so many times those of about its limit.
_FURTHEST = 3.0
# Gas load factor on the ray of inertia, relative to that of the limit by gas alone.
_LEAST_GAS = 0.02

T = TypeVar("T")
Point = tuple[float, float]  # speed, rpm, and gas load factor


@dataclass(frozen=True)
class LimitPoint:
    """A point at which a safety factor is the required one."""

    mode: FailureMode
    rpm: float
    scale: float  #: gas load factor
    peak: float  #: absolute peak pressure, MPa
    worst: ModeFactor
    slope: float  #: d ln x/d ln f of the coordinate x along which it was found
    interpolated: bool = False  #: between points that were solved
    spread: float = 0.0  #: relative uncertainty of the coordinate where it is estimated


@dataclass(frozen=True)
class RayAxes:
    """Scales of the rays: about the limit by inertia alone, rpm, and by gas alone, gas load factor."""

    rpm: float
    scale: float

    def point(self, angle: float, load: float) -> Point:
        """Return the point of a ray at a distance from rest."""
        return self.rpm * math.sqrt(load * math.cos(angle)), load * self.scale * math.sin(angle)

    def ray(self, rpm: Floats | float, scale: Floats | float) -> tuple[Floats, Floats]:
        """Angles, rad, and distances from rest of points."""
        along, up = (np.asarray(rpm) / self.rpm) ** 2, np.asarray(scale) / self.scale
        return np.arctan2(up, along), np.hypot(along, up)

    def angles(self, engine: ScaledEngine, count: int) -> Floats:
        """Angles (n,) of the rays, from inertia alone to gas at idling speed, rad."""
        if not engine.burns:
            return np.zeros(1)
        return np.linspace(math.atan(_LEAST_GAS), math.atan2(1.0, (engine.idle / self.rpm) ** 2), count)

    def furthest(self, engine: ScaledEngine, angle: float) -> float:
        """Return the load on a ray that no engine exceeds by its speed or its pressure."""
        most = min(_FURTHEST, (engine.fastest / self.rpm) ** 2 / max(math.cos(angle), 1e-9))
        if engine.burns:
            rpm, _ = self.point(angle, most)
            most = min(most, engine.scale(rpm, MOST_PEAK) / self.scale / math.sin(angle))
        return most


@dataclass(frozen=True)
class LimitMap:
    """The limits of a rod in an engine."""

    axes: RayAxes
    angles: Floats  #: (n,) of the rays, rad
    #: (n,) distances of the limit of each mode from rest; infinite without one
    loads: Mapping[FailureMode, Floats]
    rest: Mapping[FailureMode, float]  #: utilisation of the required factor at rest, where it is not 0
    #: on each ray; None where none was found. Empty in a survey
    limits: Mapping[FailureMode, tuple[LimitPoint | None, ...]] = field(default_factory=dict)

    @property
    def points(self) -> list[LimitPoint]:
        """Every limit."""
        return [limit for line in self.limits.values() for limit in line if limit is not None]

    def factors(self, rpm: Floats, scale: Floats) -> dict[FailureMode, Floats]:
        """Estimate the factors over that required at points (n,): utilisations are linear between rays."""
        angle, load = self.axes.ray(rpm, scale)
        angle = np.clip(angle, self.angles[0], self.angles[-1])
        after = np.clip(np.searchsorted(self.angles, angle), 1, max(len(self.angles) - 1, 1))
        ends = np.append(self.angles, self.angles[-1] + 1.0)[np.stack([after - 1, after])]
        # A point is the sum of vectors along the rays beside it.
        shares = np.sin([ends[1] - angle, angle - ends[0]]) / np.sin(ends[1] - ends[0])
        factors = {}
        for mode, loads in self.loads.items():
            inverse, still = np.append(1 / loads, 0.0), self.rest.get(mode, 0.0)
            usage = (shares[0] * inverse[after - 1] + shares[1] * inverse[after]) * load
            with np.errstate(divide="ignore"):
                factors[mode] = 1 / (still + max(1 - still, 0.0) * usage)
        return factors

    def ending_factors(self, rpm: Floats | float, scale: Floats | float) -> dict[FailureMode, Floats]:
        """Return those of the modes that end the rod."""
        return ending(self.factors(np.asarray(rpm), np.asarray(scale)))

    def least(self, rpm: Floats | float, scale: Floats | float) -> Floats:
        """Return the least of these; infinite where nothing limits the rod."""
        return least_of(self.ending_factors(rpm, scale), np.asarray(rpm))


def ending(by_mode: Mapping[FailureMode, T]) -> dict[FailureMode, T]:
    """Return the entries of the modes that end a rod."""
    return {mode: value for mode, value in by_mode.items() if mode not in ONSETS}


def least_of(factors: Mapping[FailureMode, Floats], points: Floats) -> Floats:
    """Return the least of the factors at points; infinite where nothing limits the rod."""
    return np.min(list(factors.values()), axis=0) if factors else np.full(np.shape(points), np.inf)
