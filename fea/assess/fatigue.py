"""Safety factor against fatigue from mean stress and stress amplitude: Goodman, Gerber, Soderberg.

n is the factor by which mean and amplitude may grow together until the line of the criterion is reached
(Budynas & Nisbett, Shigley's Mechanical Engineering Design, 9th ed., section 6-12). A compressive mean
stress gives no benefit: then n = S_e/σ_a.
"""

from collections.abc import Callable

import numpy as np

from fea.assess.safety import CAP
from fea.choices import Fatigue
from fea.material import Material
from geometry.arrays import Floats


def goodman(mean: Floats, amplitude: Floats, endurance: Floats | float, ultimate: float) -> Floats:
    """Return n of σ_a/S_e + σ_m/S_u = 1/n (modified Goodman)."""
    return _inverse(amplitude / endurance + np.maximum(mean, 0) / ultimate)


def soderberg(mean: Floats, amplitude: Floats, endurance: Floats | float, yield_strength: float) -> Floats:
    """Return n of σ_a/S_e + σ_m/S_y = 1/n."""
    return goodman(mean, amplitude, endurance, yield_strength)


def gerber(mean: Floats, amplitude: Floats, endurance: Floats | float, ultimate: float) -> Floats:
    """Return n of n σ_a/S_e + (n σ_m/S_u)² = 1."""
    a, m = amplitude / endurance, np.maximum(mean, 0) / ultimate
    # The positive root, in the form without cancellation at zero mean stress.
    return _inverse((a + np.sqrt(a**2 + 4 * m**2)) / 2)


_LINES: dict[Fatigue, tuple[Callable[[Floats, Floats, Floats | float, float], Floats], str]] = {
    Fatigue.GOODMAN: (goodman, "ultimate_strength"),
    Fatigue.GERBER: (gerber, "ultimate_strength"),
    Fatigue.SODERBERG: (soderberg, "yield_strength"),
}


def fatigue_factor(
    criterion: Fatigue, mean: Floats, amplitude: Floats, material: Material, surface: Floats | float = 1.0
) -> Floats | None:
    """Safety factor against fatigue, at most `CAP`; None if the material's strengths are not known.

    Parameters
    ----------
    criterion
        The mean-stress correction.
    mean, amplitude
        Of the signed equivalent stress, MPa, of one shape.
    material
        Gives S_e, S_u and S_y.
    surface
        Factor k_a of the surface on S_e, of the same shape or one for all.
    """
    line, strength_name = _LINES[criterion]
    strength, endurance = getattr(material, strength_name), material.endurance_limit
    if strength is None or endurance is None:
        return None
    # In the precision of the stresses.
    return line(mean, amplitude, np.asarray(surface, amplitude.dtype) * endurance, strength)


def _inverse(used: Floats) -> Floats:
    return np.asarray(1 / np.maximum(used, 1 / CAP))
