"""Thermal expansion of a study's materials: as given, or typical of the metal that its figures tell."""

from fea.study.material_table import MaterialTable
from geometry.invalid import InvalidValue, require

REFERENCE_TEMPERATURE = 20.0  # °C, at which dimensions and fits are given

# Mean linear expansion from 20 to 100…200 °C, 1/K, by ranges of Young's modulus, GPa, and density, kg/m³:
# steel, VDI 2230-1:2015, table A4 (11.1…11.9e-6); Ti-6Al-4V, ASM data sheet (8.6e-6); 7075, Aluminum
# Association (23.6e-6); C52100, copper with 8 % of tin (17.2…18.5e-6 in suppliers' tables); grey and nodular
# iron (11…12.5e-6).
_METALS = (
    ("steel", (170, 225), (6500, 8300), 11.5e-6),
    ("iron", (140, 170), (6800, 7600), 11.5e-6),
    ("titanium", (100, 125), (4200, 4900), 8.6e-6),
    ("aluminium", (60, 90), (2500, 3000), 23.5e-6),
    ("copper alloy", (80, 140), (8000, 9200), 18.0e-6),
)
_LARGEST = 1e-4


def thermal_expansion(name: str, table: MaterialTable) -> tuple[float, str | None]:
    """Return α, 1/K, of a material and, where it is assumed, the metal that it is taken for.

    Parameters
    ----------
    name
        Of its table in a study, for messages: ``material.bushing``.
    table
        The material.

    Raises
    ------
    InvalidValue
        It is out of range, or not given and the metal is not recognised.
    """
    own, key = table.resolved(), f"{name}.thermal_expansion_1_K"
    given = own.thermal_expansion_1_K
    if given is not None:
        rule = f"must not be negative and be at most {_LARGEST:g}"
        require(0 <= given <= _LARGEST, key, given, rule, "That of steel is 11.5e-6.")
        return given, None
    for metal, (soft, stiff), (light, heavy), expansion in _METALS:
        if own.E_GPa is None or own.density_kg_m3 is None:
            break
        if soft <= own.E_GPa <= stiff and light <= own.density_kg_m3 <= heavy:
            return expansion, metal
    raise InvalidValue(
        key, None, "is missing, and E_GPa and density_kg_m3 are of no common metal", "Give it."
    )
