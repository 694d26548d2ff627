"""The pressure that a pin force exerts on one side of a bore.

A pressure is constant along the pin and spread over an arc centred on the force, φ being the angle
from it: p(φ) = p₀ s(φ) for |φ| ≤ arc/2. Its resultant on a bore of radius R and width b is
P = p₀ R b ∫ s(φ) cos φ dφ. Half cosine and uniform 120° follow Webster et al. (1983).
"""

import math
import re
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_positive


class Shape(StrEnum):
    """How the pressure varies over its arc."""

    COSINE = "cosine"
    UNIFORM = "uniform"


@dataclass(frozen=True)
class Arc:
    """A pressure shape over an arc."""

    shape: Shape  #: cosine, cos(π φ/arc), or uniform
    angle: float  #: the whole arc, rad, above zero and at most π: a pin presses on one side of its bore

    def __post_init__(self) -> None:
        degrees = math.degrees(require_positive("analysis.pressure arc", self.angle))
        rule = "must lie between 1 and 180, because a pin presses on one side of its bore only"
        require(1 <= degrees <= 180 * (1 + 1e-12), "analysis.pressure arc in degrees", degrees, rule)

    def __call__(self, phi: npt.ArrayLike) -> Floats:
        """Relative pressure s at angles φ (rad, any turn) from the force: 1 in the middle, 0 off the arc."""
        phi = np.asarray(phi, dtype=np.float64)
        phi = np.abs(np.mod(phi + math.pi, 2 * math.pi) - math.pi)
        return np.where(phi <= self.angle / 2, self.unbounded(np.minimum(phi, self.angle / 2)), 0.0)

    def unbounded(self, phi: npt.ArrayLike) -> Floats:
        """Relative pressure s, continued beyond the ends of the arc."""
        phi = np.asarray(phi, dtype=np.float64)
        return np.ones_like(phi) if self.shape is Shape.UNIFORM else np.cos(math.pi / self.angle * phi)

    @property
    def resultant(self) -> float:
        """∫ s(φ) cos φ dφ: force per p₀ R b. π/2 for the half cosine over 180°, √3 for uniform over 120°."""
        half = self.angle / 2
        if self.shape is Shape.UNIFORM:
            return 2 * math.sin(half)
        if math.isclose(self.angle, math.pi):
            return math.pi / 2
        k = math.pi / self.angle
        return 2 * k * math.cos(half) / (k**2 - 1)

    @property
    def second_resultant(self) -> float:
        """∫ s(φ) cos² φ dφ: force per p₀ R b on a bore whose width is b cos φ."""
        half = self.angle / 2
        if self.shape is Shape.UNIFORM:
            return half + math.sin(2 * half) / 2
        k = math.pi / self.angle
        beside = sum(half * float(np.sinc((k + step) * half / math.pi)) for step in (-2, 2))
        return 1 / k + beside / 2

    def peak(self, force: float, radius: float, width: float, taper: float = 0.0) -> float:
        """p₀ = P/(R ∫ b(φ) s cos φ dφ), MPa, for a force in N on a bore of radius and width in mm.

        The width is b(φ) = `width` + `taper` cos φ + c sin φ with any c.
        """
        return force / (radius * (width * self.resultant + taper * self.second_resultant))


@dataclass(frozen=True)
class BorePressure:
    """The arcs that a pin presses on when its end of the rod is pulled and when it is pushed."""

    #: As in the study file: ``cosine-180``, ``uniform-120``, ``cosine-<arc>``, ``uniform-<arc>`` or
    #: ``webster`` (half cosine in tension, uniform over 120° in compression)
    name: str
    #: tension, compression: the arc for an axial force of that sign
    tension: Arc
    compression: Arc

    @classmethod
    def parse(cls, name: str) -> "BorePressure":
        """Read a name of the study file. Raises `InvalidValue`: unknown, or an arc outside 1…180 degrees."""
        if name == "webster":
            return cls(name, Arc(Shape.COSINE, math.pi), Arc(Shape.UNIFORM, math.radians(120)))
        match = re.fullmatch(r"(cosine|uniform)-(\d+(?:\.\d+)?)", name)
        if match is None:
            rule = "must be cosine-180, uniform-120, cosine-<arc in degrees> or webster"
            raise InvalidValue("analysis.pressure", name, rule)
        degrees = float(match[2])
        require(1 <= degrees <= 180, "analysis.pressure", name, "the arc must lie between 1 and 180 degrees")
        arc = Arc(Shape(match[1]), math.radians(degrees))
        return cls(name, arc, arc)

    def arc(self, axial: float) -> Arc:
        """Choose the arc for an axial force of this sign (tension positive)."""
        return self.tension if axial > 0 else self.compression
