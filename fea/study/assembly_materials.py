"""Materials of the parts that an assembly adds to a rod, as given or as assumed."""

from collections.abc import Mapping

from fea.choices import BoltGrade
from fea.study.material_table import MaterialTable

# Names of the [material.…] tables, and of the parts that they are for.
BOLT, BUSHING, SHELL = "bolt", "bushing", "shell"
UPPER_SHELL, LOWER_SHELL = "upper shell", "lower shell"
_SHELLS = (UPPER_SHELL, LOWER_SHELL)
DEFAULT_GRADE = BoltGrade.G10_9
_ASSUMED = {
    BUSHING: "cusn8p",
    SHELL: "steel-backed-shell",
}


def table_name(part: str) -> str:
    """Return the name of the [material.…] table that a part's material stands in."""
    return SHELL if part in _SHELLS else part


def assembled(given: Mapping[str, MaterialTable], part: str, otherwise: MaterialTable) -> MaterialTable:
    """Return the material of a part of an assembly.

    Parameters
    ----------
    given
        The [material.…] tables by name.
    part
        Its name.
    otherwise
        [material], of rod and cap.
    """
    name = table_name(part)
    if part in given:
        return given[part]
    if name in given:
        return given[name]
    return MaterialTable(preset=_ASSUMED[name]) if name in _ASSUMED else otherwise


def bolt_material(given: Mapping[str, MaterialTable], grade: BoltGrade | None) -> MaterialTable:
    """Return the material of the bolts: that of [material.bolt], completed by a property class."""
    own = given.get(BOLT, MaterialTable())
    return own if own.preset else MaterialTable(**{**vars(own), "preset": f"bolt-{grade or DEFAULT_GRADE}"})


def assumed_materials(given: Mapping[str, MaterialTable], parts: tuple[str, ...]) -> tuple[str, ...]:
    """Say which materials of parts are assumed, with their figures."""
    names = dict.fromkeys(table_name(part) for part in parts if part not in given)
    said = []
    for name in names:
        if name in _ASSUMED and name not in given:
            table = MaterialTable(preset=_ASSUMED[name]).resolved()
            said.append(
                f"{name} of {_ASSUMED[name]}, {table.E_GPa:g} GPa, yield strength {table.yield_MPa:g} MPa "
                f"([material.{name}])"
            )
    return tuple(said)
