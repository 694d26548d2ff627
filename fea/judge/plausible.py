"""Notes on values that suggest a wrong unit; they are not errors, because the analysis still works."""

from collections.abc import Sequence

from fea.base.material import Material
from fea.base.note import Note, doubt
from fea.base.units import GPA, KG, KG_M3
from loads.engine import Engine

# The modulus of diamond, the density of osmium and the ideal strength of steel, rounded up; a tenth of the
# density of water.
STIFFEST, DENSEST, STRONGEST = 1300 * GPA, 23_000 * KG_M3, 20_000.0
LIGHTEST = 100 * KG_M3
_STEEL = 7850 * KG_M3


def unit_notes(materials: Sequence[Material], engine: Engine | None) -> tuple[Note, ...]:
    """Return notes on values that no solid or piston has, with the unit in which each is read."""
    said = [text for material in materials for text in _of_material(material)]
    if engine is not None and engine.piston_mass > _STEEL * engine.bore**3:
        said.append(
            f"engine.piston_mass_kg = {engine.piston_mass / KG:g} is more than the mass of a steel cube as "
            f"wide as the bore of {engine.bore:g} mm: check that they are in kg and mm"
        )
    return tuple(doubt(text) for text in dict.fromkeys(said))


def _of_material(material: Material) -> list[str]:
    said = []
    if material.youngs_modulus > STIFFEST:
        E = material.youngs_modulus / GPA
        said.append(f"material.E_GPa = {E:g} is stiffer than diamond: check that it is in GPa (steel: 207)")
    if not LIGHTEST <= material.density <= DENSEST:
        density = material.density / KG_M3
        what = f"material.density_kg_m3 = {density:g} is not the density of a metal"
        said.append(f"{what}: check that it is in kg/m³ (steel: 7850)")
    if material.yield_strength > STRONGEST:
        strength = f"material.yield_MPa = {material.yield_strength:g}"
        said.append(f"{strength} is higher than that of any metal: check that it is in MPa (steel: 600)")
    elif material.ultimate_strength is not None:
        said += _above_ultimate(material, material.ultimate_strength)
    return said


def _above_ultimate(material: Material, ultimate: float) -> list[str]:
    """Strengths above the ultimate strength, which no metal has."""
    others = {"yield_MPa": material.yield_strength, "endurance_MPa": material.endurance_limit}
    return [
        f"material.{key} = {value:g} is above ultimate_MPa = {ultimate:g}, which no metal has: check that "
        "the ultimate strength is not that of another material or preset"
        for key, value in others.items()
        if value is not None and value > ultimate
    ]
