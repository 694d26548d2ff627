"""Keys and figures in words."""

import re

from fea.study.tables import unit_of

_SIGNS = {"degrees": "°", "percent": "%"}
_AS_THEY_ARE = {
    "E": "Young's modulus E",
    "nu": "Poisson's ratio ν",
    "rpm": "speed",
    "pin": "force of the pin",
}


def named(key: str) -> tuple[str, str]:
    """Return the name of a key in words, and its unit (empty where it has none)."""
    words, unit = unit_of(key)
    return _AS_THEY_ARE.get(words, words), "rpm" if key == "rpm" else _SIGNS.get(unit, unit)


def figure(value: float | None, digits: int = 4) -> str:
    """Return a figure with so many significant digits, and a proper minus."""
    if value is None:
        return "–"
    text = f"{value:.{digits}g}"
    found = re.fullmatch(r"(.*)e([+-])0*(\d+)", text)
    if found:
        power = (
            f"{'⁻' if found[2] == '-' else ''}{found[3].translate(str.maketrans('0123456789', '⁰¹²³⁴⁵⁶⁷⁸⁹'))}"
        )
        text = f"{found[1]}·10{power}"
    return text.replace("-", "−")


def shown(value: object) -> str:
    """Return a value of a study as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return figure(value, 10)
    if isinstance(value, list | tuple):
        return ", ".join(shown(item) for item in value)
    return str(value)


def listed(words: list[str]) -> str:
    """Return words as a list in a sentence."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
