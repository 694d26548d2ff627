"""The uniform material law: cyclic constants of a metal from its ultimate strength.

Bäumel & Seeger, Materials Data for Cyclic Loading, Supplement 1 (1990); the constants were read in programs
that implement it, not in the book. Steel: σ_f′ = 1.5 S_u, b = −0.087, ε_f′ = 0.59 ψ, c = −0.58 with
ψ = 1.375 − 125 S_u/E, at most 1; K′ = 1.65 S_u, n′ = 0.15. Aluminium and titanium: σ_f′ = 1.67 S_u,
b = −0.095, ε_f′ = 0.35, c = −0.69; K′ = 1.61 S_u, n′ = 0.11.
"""

from fea.base.material import Basquin, CoffinManson, Material, is_steel

YIELD_STRAIN = 0.002  # plastic strain at the cyclic yield strength
_LIGHT = 5e-9  # t/mm³: aluminium and titanium are below, bronze is above
_BRITTLE = 0.1  # ψ below which the law of steels is not valid


def estimated_lines(material: Material) -> tuple[Basquin, CoffinManson] | None:
    """Estimate the lines of elastic and plastic strain over life; None where the law is not valid."""
    ultimate = material.ultimate_strength
    if ultimate is None:
        return None
    if is_steel(material.youngs_modulus):
        ductile = min(1.375 - 125 * ultimate / material.youngs_modulus, 1.0)
        if ductile < _BRITTLE:
            return None
        return Basquin(1.5 * ultimate, -0.087), CoffinManson(0.59 * ductile, -0.58)
    if material.density < _LIGHT:
        return Basquin(1.67 * ultimate, -0.095), CoffinManson(0.35, -0.69)
    return None


def estimated_cyclic_yield(ultimate: float, youngs_modulus: float) -> float:
    """0.2 % yield strength K′ 0.002^n′, MPa, in repeated loading; of a metal of S_u and E in MPa."""
    ratio, exponent = (1.65, 0.15) if is_steel(youngs_modulus) else (1.61, 0.11)
    return float(ratio * ultimate * YIELD_STRAIN**exponent)
