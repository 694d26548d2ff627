"""A study to begin with, for a CAD file that says nothing of engine and material."""

from collections.abc import Mapping
from typing import Any

from fea.study.tables import toml_text

_REST = """
[material]
preset = "c70-2005"    # or E_GPa, nu, density_kg_m3, yield_MPa, ultimate_MPa

[engine]
stroke_mm = 86.0
bore_mm = 86.0
piston_mass_kg = 0.55  # with rings and pin
gas = "otto"
compression_ratio = 10.0
peak_pressure_bar = 75.0

[speed]
rpm = 6000.0
"""


def ready_study(name: str, rod: Mapping[str, Any]) -> tuple[str, str]:
    """Return what to do about a study without an engine, and one to complete.

    Parameters
    ----------
    name
        Of the study.
    rod
        Its [rod] table.
    """
    remedy = (
        f"Name an engine with --engine, or save the lines below as {name}.toml, replace the figures by those "
        f"of your engine and material, and run fea run {name}.toml."
    )
    return remedy, toml_text({"rod": dict(rod)}) + _REST
