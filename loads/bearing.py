"""The pressure that a pin force exerts on one side of a bore.

A pressure is constant along the pin and spread over an arc centred on the force, φ being the angle
from it: p(φ) = p₀ s(φ) for |φ| ≤ arc/2. Its resultant on a bore of radius R and width b is
P = p₀ R b ∫ s(φ) cos φ dφ. Half cosine and uniform 120° follow Webster et al. (1983).
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_positive

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class PressureProfile:
    """Variation of a pressure over an arc."""

    words: str  #: what a report calls it
    #: Relative pressure at t = φ/(arc/2): 1 at t = 0, even, and smooth slightly beyond |t| = 1, too
    relative: Callable[[Floats], Floats]

    @property
    def jumps(self) -> bool:
        """Whether the pressure jumps at the ends of its arc."""
        return float(self.relative(np.array(1.0))) > 1e-9


# By their names in a study, which an arc in degrees follows (``cosine-180``). A further profile is a line.
PROFILES = {
    "cosine": PressureProfile("half a cosine of pressure", lambda t: np.cos(math.pi / 2 * t)),
    "uniform": PressureProfile("a uniform pressure", np.ones_like),
}
# The names that a study may give, in a sentence.
NAMES = f"cosine-180, uniform-120, {', '.join(f'{name}-<arc in degrees>' for name in PROFILES)}, webster"


@dataclass(frozen=True)
class PressureArc:
    """A pressure profile over an arc."""

    profile: PressureProfile
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
        return self.profile.relative(np.asarray(phi, dtype=np.float64) / (self.angle / 2))

    def moment(self, power: int) -> float:
        """∫ s(φ) cosⁿ φ dφ for n = `power`: of n = 1, force per p₀ R b; of n = 2, on a width of b cos φ.

        π/2 and 4/3 for the half cosine over 180°; the first is √3 for a uniform pressure over 120°.
        """
        phi = self.angle / 2 * _PLACES
        return self.angle / 2 * float(_WEIGHTS @ (self.unbounded(phi) * np.cos(phi) ** power))

    def peak(self, force: float, radius: float, width: float, taper: float = 0.0) -> float:
        """p₀ = P/(R ∫ b(φ) s cos φ dφ), MPa, for a force in N on a bore of radius and width in mm.

        The width is b(φ) = `width` + `taper` cos φ + c sin φ with any c.
        """
        return force / (radius * (width * self.moment(1) + taper * self.moment(2)))

    @property
    def words(self) -> str:
        """Description in a sentence."""
        return f"{self.profile.words} over {math.degrees(self.angle):.0f}°"


@dataclass(frozen=True)
class BorePressure:
    """The arcs that a pin presses on when its end of the rod is pulled and when it is pushed."""

    tension: PressureArc
    compression: PressureArc

    @classmethod
    def parse(cls, name: str) -> "BorePressure":
        """Read a name of the study file: ``<profile>-<arc in degrees>``, or ``webster``.

        The latter is half a cosine in tension, uniform over 120° in compression. Raises `InvalidValue`.
        """
        if name == "webster":
            return cls(cls.parse("cosine-180").tension, cls.parse("uniform-120").tension)
        match = re.fullmatch(rf"({'|'.join(PROFILES)})-(\d+(?:\.\d+)?)", name)
        if match is None:
            raise InvalidValue("analysis.pressure", name, f"must be one of {NAMES}")
        degrees = float(match[2])
        require(1 <= degrees <= 180, "analysis.pressure", name, "the arc must lie between 1 and 180 degrees")
        arc = PressureArc(PROFILES[match[1]], math.radians(degrees))
        return cls(arc, arc)

    def arc(self, axial: float) -> PressureArc:
        """Choose the arc for an axial force of this sign (tension positive)."""
        return self.tension if axial > 0 else self.compression

    @property
    def words(self) -> str:
        """Description of the pins for a report."""
        pushing = f" where it pulls the rod, and with {self.compression.words} where it pushes"
        return (
            f"Each pin presses on its bore with {self.tension.words}"
            f"{'' if self.tension == self.compression else pushing}. It is constant along the pin and "
            "centred on the force; the pins' stiffness, clearance and oil film do not enter."
        )
