"""The commented study that `fea init` writes; its comments also describe the keys for editors."""

import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from fea.study.tables import toml_text

_HEADING = re.compile(r"(?m)^(?:# )?\[([\w.]+)\](?: .*)?$\n")
_KEY = re.compile(r"(?:# )?(\w+) = [^#]*(?:# (.*))?")
_MORE = re.compile(r"\s{8,}# (.*)")
_UNITS = {
    "kg_m2": "kg·m²",
    "kg_m3": "kg/m³",
    "mm": "mm",
    "kg": "kg",
    "deg": "degrees",
    "bar": "bar",
    "GPa": "GPa",
    "MPa": "MPa",
    "1_K": "1/K",
    "kN": "kN",
    "Nm": "N·m",
    "um": "µm",
    "C": "°C",
    "N": "N",
    "percent": "percent",
}


@cache
def template() -> str:
    """Return the text of the study."""
    return (files("fea") / "studies" / "template.toml.txt").read_text(encoding="utf-8")


@cache
def comments() -> dict[str, dict[str, str]]:
    """Return what the template says of each key, by its table and its name; empty where it says nothing."""
    pieces = _HEADING.split(template())
    found: dict[str, dict[str, str]] = {}
    for table, text in zip(pieces[1::2], pieces[2::2], strict=True):
        found.setdefault(table, {}).update(_comments(text))
    return found


def _comments(text: str) -> dict[str, str]:
    """Comments of the keys in a part of the template; a line that is only a comment continues one."""
    said: dict[str, str] = {}
    for line in text.splitlines():
        if key := _KEY.fullmatch(line):
            said[key[1]] = key[2] or ""
        elif (more := _MORE.fullmatch(line)) and said:
            last = next(reversed(said))
            said[last] = f"{said[last]} {more[1]}"
    return said


def description(table: str, key: str) -> str:
    """Describe a key of a table: its name in words, its unit, and what the template says of it."""
    unit = next((unit for unit in _UNITS if key.endswith(f"_{unit}")), None)
    words = (key if unit is None else key.removesuffix(f"_{unit}")).replace("_", " ")
    said = comments().get(table, {}).get(key, "")
    return words + (f", {_UNITS[unit]}" if unit else "") + (f": {said}" if said else "")


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
