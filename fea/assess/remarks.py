"""What a reader must know about the strengths behind a factor, and about a failed check of the model."""

from collections.abc import Mapping, Sequence

from fea.checks import Check
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


def fatigue_remarks(materials: Sequence[Material]) -> tuple[str, ...]:
    """Say which strengths were estimated or are missing."""
    said = []
    if any(material.endurance_limit is None or material.ultimate_strength is None for material in materials):
        said.append("fatigue is not judged where [material] lacks endurance_MPa or ultimate_MPa")
    if any(material.endurance_estimated for material in materials):
        said.append(
            "endurance_MPa is not given: half the ultimate strength is taken, as for polished steel, "
            "times the factors of surface, size and reliability"
        )
    return tuple(said)


def check_remarks(checks: Mapping[str, Check]) -> tuple[str, ...]:
    """Say in words what a failed check of the model's assumptions means."""
    return tuple(why for name, why in _WHY.items() if name in checks and not checks[name].passed)
