"""Strengths of bolts by property class (ISO 898-1:2013, tables 3 and 5)."""

from dataclasses import dataclass

from fea.choices import BoltGrade

# Diameter up to which bolts of class 8.8 have the lower strengths, mm.
_THIN = 16.0


@dataclass(frozen=True)
class BoltStrength:
    """Strengths of a bolt, MPa.

    Attributes
    ----------
    proof
        S_p, under which a bolt keeps its length.
    yield_strength
        R_p0.2, least stress at 0.2 % non-proportional elongation.
    ultimate
        R_m, least tensile strength.
    """

    proof: float
    yield_strength: float
    ultimate: float


_STRENGTHS = {
    BoltGrade.G8_8: BoltStrength(580.0, 640.0, 800.0),
    BoltGrade.G9_8: BoltStrength(650.0, 720.0, 900.0),
    BoltGrade.G10_9: BoltStrength(830.0, 940.0, 1040.0),
    BoltGrade.G12_9: BoltStrength(970.0, 1100.0, 1220.0),
}
_THICK_8_8 = BoltStrength(600.0, 660.0, 830.0)
# S_p over R_p0.2 of classes 10.9 and 12.9, for bolts of other strengths.
PROOF_RATIO = 0.88


def bolt_strength(grade: BoltGrade, diameter: float) -> BoltStrength:
    """Return the strengths of a property class at a nominal diameter, mm."""
    thick = grade is BoltGrade.G8_8 and diameter > _THIN
    return _THICK_8_8 if thick else _STRENGTHS[grade]
