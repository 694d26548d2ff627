"""Safety factor against fatigue from mean stress and stress amplitude: Goodman, Gerber, Soderberg.

n is the factor by which mean and amplitude may grow together until the line of the criterion is reached
(Budynas & Nisbett, Shigley's Mechanical Engineering Design, 9th ed., section 6-12). A compressive mean
stress gives no benefit: then n = S_e/σ_a.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from fea.base.checks import Check
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.judge.verdict import CAP
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


_LINES: dict[Fatigue, Callable[[Floats, Floats, Floats | float, float], Floats]] = {
    Fatigue.GOODMAN: goodman,
    Fatigue.GERBER: gerber,
    Fatigue.SODERBERG: soderberg,
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
    line = _LINES[criterion]
    strength, endurance = criterion_strength(criterion, material), material.endurance_limit
    if strength is None or endurance is None:
        return None
    # In the precision of the stresses.
    return line(mean, amplitude, np.asarray(surface, amplitude.dtype) * endurance, strength)


def criterion_strength(criterion: Fatigue, material: Material) -> float | None:
    """Return the strength, MPa, that a mean stress is compared with; None if it is not known."""
    return {
        Fatigue.GOODMAN: material.ultimate_strength,
        Fatigue.GERBER: material.ultimate_strength,
        Fatigue.SODERBERG: material.yield_strength,
    }[criterion]


def reversed_amplitude(criterion: Fatigue, mean: Floats, amplitude: Floats, material: Material) -> Floats:
    """Amplitude, MPa, of the fully reversed stress that does the same damage.

    σ_ar of σ_a/σ_ar + σ_m/S = 1 (Goodman, Soderberg) or σ_a/σ_ar + (σ_m/S)² = 1 (Gerber). It exceeds S_e
    where the factor of `fatigue_factor` is below 1, and is infinite where σ_m ≥ S. A compressive mean stress
    gives no benefit.

    Parameters
    ----------
    criterion, mean, amplitude, material
        As `fatigue_factor` takes them; the material's strengths are known.
    """
    used = np.maximum(mean, 0) / (criterion_strength(criterion, material) or np.nan)
    left = 1 - (used**2 if criterion is Fatigue.GERBER else used)
    return np.asarray(np.where(left > 0, amplitude / np.where(left > 0, left, 1), np.inf))


def _inverse(used: Floats) -> Floats:
    return np.asarray(1 / np.maximum(used, 1 / CAP))


_WHY = {
    "tilt": (
        "the pin forces do not act in one plane (the bores are off the mid-plane of the rod): in reality a "
        "pressure that varies along the pins balances them, in this model the inertia of the rod does"
    ),
    "small_strain": (
        "strains are too large for linear elasticity: real stresses and displacements differ (check that "
        "E_GPa is in GPa)"
    ),
    "small_displacement": (
        "displacements are too large for linear elasticity, in which loads act on the undeformed shape "
        "(check that E_GPa is in GPa)"
    ),
}


def fatigue_remarks(materials: Sequence[Material], criterion: Fatigue) -> tuple[str, ...]:
    """Name the strengths needed by a criterion that were estimated or are missing."""
    needed = {"endurance_MPa": [material.endurance_limit for material in materials]}
    if criterion is not Fatigue.SODERBERG:  # which uses the yield strength
        needed["ultimate_MPa"] = [material.ultimate_strength for material in materials]
    said = []
    if any(None in strengths for strengths in needed.values()):
        said.append(f"fatigue is not assessed for materials without {' or '.join(needed)}")
    if any(material.endurance_estimated for material in materials):
        said.append(
            "endurance_MPa is not given: half the ultimate strength is used, as for polished steel, times "
            "the factors of surface, size and reliability"
        )
    return tuple(said)


def check_remarks(checks: Mapping[str, Check]) -> tuple[str, ...]:
    """Explain what failed checks of the model's assumptions mean."""
    return tuple(why for name, why in _WHY.items() if name in checks and not checks[name].passed)
