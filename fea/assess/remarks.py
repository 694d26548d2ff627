"""Remarks for the user about the strengths behind a factor, and about failed checks of the model."""

from collections.abc import Mapping, Sequence

from fea.checks import Check
from fea.choices import Fatigue
from fea.material import Material

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
