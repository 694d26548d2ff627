"""What a reader must know about the strengths behind a factor, and about a failed check of the model."""

from collections.abc import Mapping, Sequence

from fea.checks import Check
from fea.choices import Fatigue
from fea.material import Material

_WHY = {
    "tilt": (
        "the forces of the pins are off one line along the pins (bores off the rod's mid-plane), and the "
        "pressure that would balance them varies along the pin: here the rod's inertia does"
    ),
    "small_strain": (
        "strains are beyond linear elasticity, which holds for small ones: real stresses and displacements "
        "differ (is E_GPa in GPa?)"
    ),
    "small_displacement": (
        "displacements are beyond linear elasticity, in which loads keep to the undeformed shape "
        "(is E_GPa in GPa?)"
    ),
}


def fatigue_remarks(materials: Sequence[Material], criterion: Fatigue) -> tuple[str, ...]:
    """Say which strengths that a criterion needs were estimated or are missing."""
    needed = {"endurance_MPa": [material.endurance_limit for material in materials]}
    if criterion is not Fatigue.SODERBERG:  # which goes by the yield strength
        needed["ultimate_MPa"] = [material.ultimate_strength for material in materials]
    said = []
    if any(None in strengths for strengths in needed.values()):
        said.append(f"fatigue is not judged where [material] lacks {' or '.join(needed)}")
    if any(material.endurance_estimated for material in materials):
        said.append(
            "endurance_MPa is not given: half the ultimate strength is taken, as for polished steel, "
            "times the factors of surface, size and reliability"
        )
    return tuple(said)


def check_remarks(checks: Mapping[str, Check]) -> tuple[str, ...]:
    """Say in words what a failed check of the model's assumptions means."""
    return tuple(why for name, why in _WHY.items() if name in checks and not checks[name].passed)
