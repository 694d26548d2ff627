"""What suggests that a number was given in another unit: no error, for the mechanics is the same."""

from collections.abc import Sequence

from fea.material import Material
from fea.units import GPA, KG, KG_M3
from loads.engine import Engine

# Diamond's modulus, osmium's density and the ideal strength of steel, rounded up; a tenth of water's density.
STIFFEST, DENSEST, STRONGEST = 1300 * GPA, 23_000 * KG_M3, 20_000.0
LIGHTEST = 100 * KG_M3
_STEEL = 7850 * KG_M3


def unit_remarks(materials: Sequence[Material], engine: Engine | None) -> tuple[str, ...]:
    """Name values beyond what any solid or piston has, with the unit each is read in."""
    said = [remark for material in materials for remark in _of_material(material)]
    if engine is not None and engine.piston_mass > _STEEL * engine.bore**3:
        said.append(
            f"engine.piston_mass_kg = {engine.piston_mass / KG:g} is more than a steel cube as wide as the "
            f"bore of {engine.bore:g} mm weighs: are they in kg and mm?"
        )
    return tuple(dict.fromkeys(said))


def _of_material(material: Material) -> list[str]:
    said = []
    if material.youngs_modulus > STIFFEST:
        E = material.youngs_modulus / GPA
        said.append(f"material.E_GPa = {E:g} is stiffer than diamond: is it in GPa (steel 207)?")
    if not LIGHTEST <= material.density <= DENSEST:
        density = material.density / KG_M3
        said.append(f"material.density_kg_m3 = {density:g} is no metal's: is it in kg/m³ (steel 7850)?")
    if material.yield_strength > STRONGEST:
        strength = f"material.yield_MPa = {material.yield_strength:g}"
        said.append(f"{strength} is beyond any metal's: is it in MPa (steel 600)?")
    elif material.ultimate_strength is not None:
        said += _above_ultimate(material, material.ultimate_strength)
    return said


def _above_ultimate(material: Material, ultimate: float) -> list[str]:
    """Strengths that no metal has beside its ultimate strength."""
    others = {"yield_MPa": material.yield_strength, "endurance_MPa": material.endurance_limit}
    return [
        f"material.{key} = {value:g} lies above ultimate_MPa = {ultimate:g}, which no metal's does: "
        "is the ultimate strength that of another material, or of a preset?"
        for key, value in others.items()
        if value is not None and value > ultimate
    ]
