"""What a reader must know about the fatigue strengths behind a factor."""

from collections.abc import Sequence

from fea.material import Material


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
