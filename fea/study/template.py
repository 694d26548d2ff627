"""The commented study that `fea init` writes; its comments also describe the keys for editors."""

import re
from functools import cache
from importlib.resources import files

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
