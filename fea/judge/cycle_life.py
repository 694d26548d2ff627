"""How many crank cycles a place lasts at one speed: on its S–N line, or on one assumed from its strengths.

*Assumed line.* Under axial load, 0.75 S_u at 10³ cycles (Juvinall 1967, as Shigley's Mechanical Engineering
Design quotes it: 0.9 S_u holds for bending), and the endurance limit at 10⁶ cycles, or at those that it is
known for. What such an estimate may err by is no scatter between rods: half the ultimate strength of a steel
is its endurance limit within a standard deviation of 13.8 % (Mischke 1987).

*Unlimited life* is stated of steels whose ultimate strength is below 1250 MPa, at constant amplitude.
Elsewhere the line goes on below the knee and falls by 5 % a decade (Sonsino, Int. J. Fatigue 29, 2007, 2246),
and what is stated is that no failure is expected by 10⁸ cycles.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from fea.base.choices import Fatigue
from fea.base.material import SCATTER, Basquin, Material
from fea.judge.fatigue import SHORT, LifeLine, criterion_strength, reversed_amplitude
from fea.judge.rainflow import rainflow
from geometry.arrays import Floats
from geometry.errors import InvalidValue

# Strength at 10³ cycles over the ultimate one, and cycles at the endurance limit of steels.
_AT_SHORT, _KNEE = 0.75, 1e6
# Standard deviation of an assumed endurance limit, and standard deviations of the band of a known line.
_ASSUMED, _BAND = 0.138, 2.0
# From which ultimate strength, MPa, a steel has no endurance limit, and how far its line falls in a decade.
HARD, DECADE = 1250.0, 0.05
LONGEST = 1e8  # cycles: beyond, only that no failure is expected by them is stated
LOW_CYCLE = 1e4  # cycles below which the stress of a notch is hardly elastic


@dataclass(frozen=True)
class CycleLife:
    """Crank cycles to failure of a place; infinite without damage."""

    cycles: float  #: at the assumed or median strength
    #: low, high: with all strengths lower and higher by the band
    low: float
    high: float
    band_percent: float
    assumed: bool  #: whether the S–N line is
    unlimited: bool  #: whether a life without damage may be called so


def assumed_line(material: Material) -> Basquin | None:
    """Return the S–N line of specimens that strengths imply; None where they are not known or do not fit."""
    if material.ultimate_strength is None or material.endurance_limit is None:
        return None
    marin, knee = material.marin, material.endurance_cycles or _KNEE
    polished = material.endurance_limit / (marin.load * marin.reliability * marin.size)
    short = _AT_SHORT * material.ultimate_strength / marin.load
    if polished >= short:
        return None
    exponent = math.log(polished / short) / math.log(knee / SHORT)
    return Basquin(short / (2 * SHORT) ** exponent, exponent)


def with_line(material: Material) -> Material:
    """Return a material with its S–N line, else with one that is assumed, which may be none."""
    return line_at(material, *(surface.factor for surface in material.marin.surfaces.values()))[0]


def line_at(material: Material, *surfaces: float) -> tuple[Material, LifeLine | None]:
    """Return a material as `with_line`, and the line of places of surface factors k_a.

    Raises `InvalidValue`: its own S–N line does not fit its endurance limit.
    """
    own = replace(material, basquin=material.basquin or assumed_line(material))
    try:
        return own, LifeLine.of(own, np.array(surfaces))
    except InvalidValue:
        if material.basquin is not None:
            raise
        return material, None


def band_of(*, assumed: bool) -> float:
    """Return by which share strengths may be lower and higher: of an assumed S–N line, or of a known one."""
    return _ASSUMED if assumed else _BAND * SCATTER


def cycle_life(
    history: Floats, material: Material, surface: float = 1.0, criterion: Fatigue = Fatigue.GOODMAN
) -> CycleLife | None:
    """Return the life of a place of surface factor k_a under a periodic signed stress (n,), MPa.

    None where neither its S–N line nor the strengths for one are known, or where these do not fit. Raises
    `InvalidValue`: its own S–N line does not fit its endurance limit.
    """
    assumed = material.basquin is None
    material, line = line_at(material, surface)
    if line is None or criterion_strength(criterion, material) is None:
        return None
    amplitude = reversed_amplitude(criterion, *rainflow(history), material)
    band = band_of(assumed=assumed)
    hard = line.endless and (material.ultimate_strength or 0.0) >= HARD
    low, cycles, high = (
        _cycles(line.stronger(strength), amplitude, hard=hard) for strength in (1 - band, 1.0, 1 + band)
    )
    return CycleLife(cycles, low, high, 100 * band, assumed, line.endless and not hard)


def _cycles(line: LifeLine, amplitude: Floats, *, hard: bool) -> float:
    """Periods until Palmgren and Miner's sum is 1; infinite without damage."""
    limit, largest = float(line.limit[0]), float(amplitude.max(initial=0.0))
    if line.endless and largest <= limit:
        if not hard or largest <= 0:
            return math.inf
        return line.knee * 10 ** (math.log(largest / limit) / math.log(1 - DECADE))
    damage = float((1 / line.cycles(amplitude[:, None])).sum())
    return 1 / damage if damage else math.inf
