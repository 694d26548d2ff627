"""Small defects as small cracks: the stress at which one does not grow, and the largest that a stress bears.

Up to √area = 1000 µm this is Murakami's model, σ_w = C (HV + 120) / (√area)^(1/6) · ((1 − R)/2)^α with
α = 0.226 + HV·10⁻⁴ (Murakami & Endo 1994; C as Chapetti et al., Procedia Structural Integrity 76, 2026,
equation 6, print it for the range of stress), which holds within 10 % up to 400 HV. Neither what a steel
without a defect bears, 1.6 HV, nor the threshold of long cracks is exceeded, and R below −1 gives no benefit.
Larger defects are cracks whose threshold is that of El Haddad, Topper & Smith (1979).
"""

from enum import StrEnum
from typing import NamedTuple

import numpy as np

from fea.base.material import CrackMetal, Material
from fea.judge.crack import inside_intensity, surface_intensity
from geometry.arrays import Floats, Ints, Mask

LARGEST, ACCURATE = 1000.0, 400.0  # √area, µm, and HV up to which the model holds
LONG = 10**0.5  # a long shallow defect counts as this multiple of its depth (Murakami, Metal Fatigue, 2002)
_SMOOTH = 1.6  # fatigue limit of a steel without a defect over its hardness, MPa/HV
_METRE, _LARGE = 1e-3, 1e6  # wall over depth of a body that is large beside a flaw


class Position(StrEnum):
    """Where a defect lies; touching: below the surface, which its edge just reaches."""

    SURFACE = "surface"
    TOUCHING = "touching"
    INSIDE = "inside"


_CONSTANT = {Position.SURFACE: 1.43, Position.TOUCHING: 1.41, Position.INSIDE: 1.56}
# Largest K along the edge over σ √(π √area) (Murakami, as above).
_GEOMETRY = {Position.SURFACE: 0.65, Position.TOUCHING: 0.65, Position.INSIDE: 0.5}


class StressCycle(NamedTuple):
    """Stress across the plane of a defect, MPa, each (n,): the highest and the lowest of a cycle."""

    highest: Floats
    lowest: Floats

    @property
    def amplitude(self) -> Floats:
        """Half of the range, not 0."""
        return np.maximum((self.highest - self.lowest) / 2, 1e-9)

    @property
    def ratio(self) -> Floats:
        """R; NaN where the plane never opens."""
        never = np.full_like(self.highest, np.nan)
        return np.divide(self.lowest, self.highest, out=never, where=self.highest > 0)

    @property
    def opening(self) -> Floats:
        """Share (n,) of the range that opens a crack, which is the tensile part."""
        return (np.maximum(self.highest, 0) - np.maximum(self.lowest, 0)) / (2 * self.amplitude)

    def some(self, rows: Mask | Ints, factor: Floats | float = 1.0) -> "StressCycle":
        """Return some of the cycles, with stresses multiplied by factors (n,)."""
        return StressCycle(*((factor * end)[rows] for end in self))


def area_root(depth: float, half: float) -> float:
    """√area, µm, of half an ellipse of half a length at the surface, or a whole one inside, mm."""
    return float(min((np.pi / 2 * depth * half) ** 0.5, LONG * depth) / _METRE)


def mean_stress_factor(ratio: Floats, hardness: float) -> Floats:
    """((1 − R)/2)^α at stress ratios R (n,), at most 1."""
    return np.asarray(((1 - np.clip(ratio, -1, 1)) / 2) ** (0.226 + hardness * 1e-4))


def murakami_limit(size: float, ratio: Floats, hardness: float, position: Position) -> Floats:
    """Stress amplitude (n,), MPa, at which defects of √area, µm, do not grow at ratios R (n,)."""
    strength = _CONSTANT[position] * (hardness + 120) / size ** (1 / 6)
    return np.asarray(strength * mean_stress_factor(ratio, hardness))


def smooth_limit(material: Material, cycle: StressCycle) -> Floats:
    """Amplitude (n,), MPa, borne without a defect at R: 1.6 HV, else by Goodman; ∞ if not known."""
    if material.hardness is not None:
        return _SMOOTH * material.hardness * mean_stress_factor(cycle.ratio, material.hardness)
    strengths = material.endurance_limit or np.inf, material.ultimate_strength or np.inf
    used = cycle.amplitude / strengths[0] + np.maximum(cycle.highest + cycle.lowest, 0) / 2 / strengths[1]
    return np.asarray(cycle.amplitude / np.maximum(used, 1e-12))


def el_haddad_limit(
    depth: float, geometry: float, metal: CrackMetal, cycle: StressCycle, smooth: Floats | float = np.inf
) -> Floats:
    """Stress amplitude (n,), MPa, at which cracks of a depth, mm, with K = Y σ √(π a) do not grow.

    Δσ = ΔK_th/(Y √(π (a + a₀))) with a₀ = (ΔK_th/(Y Δσ_w))²/π, both ranges those that open the crack;
    `geometry` is Y, and `smooth` the amplitude (n,) without a crack; with ∞ every crack counts as long.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        amplitude = metal.threshold_at(cycle.ratio) / (2 * geometry * cycle.opening)
        return np.asarray(amplitude / np.sqrt(np.pi * depth * _METRE + (amplitude / smooth) ** 2))


def flaw_limit(
    size: tuple[float, float], cycle: StressCycle, material: Material, metal: CrackMetal, position: Position
) -> tuple[str, Floats]:
    """Return the criterion of a flaw of a depth and half length, mm, and the limit of amplitudes (n,), MPa.

    Beyond Murakami's model it is a crack of its shape in a body that is large beside it, and bears no more
    than the largest flaw within the model.
    """
    (depth, half), root, smooth = size, area_root(*size), smooth_limit(material, cycle)
    most = smooth
    if material.hardness is not None:
        within = min(root, LARGEST)
        long = el_haddad_limit(within * _METRE, _GEOMETRY[position], metal, cycle)
        small = murakami_limit(within, cycle.ratio, material.hardness, position)
        most = np.minimum.reduce([small, long, smooth])
        if root <= LARGEST:
            return "Murakami", most
    if position is Position.INSIDE:
        depth /= 2  # half of its height
        largest = inside_intensity(np.array([depth, depth, half]), np.ones_like, _LARGE * depth)
    else:
        largest = surface_intensity(np.array([depth, half]), np.ones_like, _LARGE * depth)
    geometry = float(largest.max() / np.sqrt(np.pi * depth * _METRE))
    return "El Haddad", np.minimum(el_haddad_limit(depth, geometry, metal, cycle, smooth), most)


def largest_defect(cycle: StressCycle, material: Material, metal: CrackMetal, position: Position) -> Floats:
    """√area (n,), µm, of the largest defects that do not grow in a steel, at most `LARGEST`.

    It is 0 where the steel breaks without a defect. A plane that never opens bears any defect.
    """
    small = (murakami_limit(1.0, cycle.ratio, material.hardness or 0.0, position) / cycle.amplitude) ** 6
    unit = el_haddad_limit(1.0, _GEOMETRY[position], metal, cycle)  # of 1 mm
    size = np.minimum(np.minimum(small, (unit / cycle.amplitude) ** 2 / _METRE), LARGEST)
    size = np.where(cycle.amplitude > smooth_limit(material, cycle), 0.0, size)
    return np.where(cycle.highest > 0, size, LARGEST)
