"""What the names of columns say: crank angle or cylinder pressure, its unit and its reference."""

import re
from itertools import pairwise

from fea.choices import PressureReference, PressureUnit

_ANGLES = {
    *(
        "crank",
        "crankangle",
        "crankshaft",
        "ca",
        "cad",
        "deg",
        "degca",
        "cadeg",
        "degree",
        "degrees",
        "theta",
    ),
    *("phi", "φ", "θ", "angle", "angolo", "angulo", "vilebrequin", "winkel", "kurbelwinkel", "kw", "°ca"),
    *("°kw", "°", "曲轴转角", "转角"),
}
_PRESSURES = {
    *("p", "press", "pressure", "druck", "zylinderdruck", "pression", "presion", "pressione", "pressao"),
    *("cylp", "pcyl", "pzyl", "pz", "cylpress", "cylpres", "cylinderpressure", "缸压", "压力", "气缸压力"),
}
# Pressures elsewhere than in the cylinder, and quantities derived from its pressure.
_OTHERS = {
    *("intake", "inlet", "manifold", "boost", "exhaust", "oil", "fuel", "rail", "injection", "ambient"),
    *("atmosphere", "atmospheric", "rate", "dp", "derivative", "filter", "spark", "ignition", "rod"),
}
# Headings of our own format: gauge pressures.
DOCUMENTED = ("crank_deg", "pressure_bar")
_PER_SPEED = re.compile(r"pressure_bar_(\d+(?:\.\d+)?)rpm")
_UNITS = {unit.lower(): unit for unit in PressureUnit}
_REFERENCES = {
    **dict.fromkeys(("a", "abs", "absolute", "absolut", "absolu"), PressureReference.ABSOLUTE),
    **dict.fromkeys(("g", "ga", "gauge", "gage", "rel", "relative", "relativ"), PressureReference.GAUGE),
}
_BRACKETS = re.compile(r"[\[({<]([^\])}>]*)[\])}>]")


def speed_of(name: str) -> float | None:
    """Return the speed, rpm, of a column in our own format with one per speed."""
    match = _PER_SPEED.fullmatch(name)
    return None if match is None else float(match[1])


def is_documented(angle: str, pressure: str) -> bool:
    """Whether the headings are those of our own format."""
    return angle == DOCUMENTED[0] and (pressure == DOCUMENTED[1] or speed_of(pressure) is not None)


def is_angle(name: str) -> bool:
    """Whether a column's name is one of those that crank angles have."""
    words = _words(name)
    return bool(words & _ANGLES) and not words & _OTHERS and not is_pressure(name)


def is_pressure(name: str) -> bool:
    """Whether a column's name is one of those that cylinder pressures have."""
    words = _words(name)
    known = bool(words & _PRESSURES) or any(re.fullmatch(r"p_?(?:cyl|zyl)\w*", word) for word in words)
    return known and not words & _OTHERS


def unit_of(name: str) -> PressureUnit | None:
    """Return the unit of pressure in a column's name: in brackets, or a word or suffix of its own."""
    units = [unit for word in _ordered_words(name) if (unit := _split_unit(word)[0]) is not None]
    return units[-1] if units else None


def reference_of(name: str) -> PressureReference | None:
    """Return what a column's name says of the reference: ``bara``, ``[bar abs]``, ``psig`` or ``gauge``."""
    words = _ordered_words(name)
    units = [i for i, word in enumerate(words) if _split_unit(word)[0] is not None]
    for i in units:
        suffix = _split_unit(words[i])[1]
        if suffix in _REFERENCES:
            return _REFERENCES[suffix]
    # A single letter says something only after a unit: "bar (a)".
    for i, word in enumerate(words):
        if word in _REFERENCES and (len(word) > 2 or i - 1 in units):
            return _REFERENCES[word]
    return None


def unknown_unit(name: str) -> str:
    """Return what stands in brackets where that is not a unit of pressure, as in ``[V]``; else nothing."""
    inside = [match[1].strip() for match in _BRACKETS.finditer(name)]
    strange = [
        text for text in inside if text and unit_of(text) is None and reference_of(f"bar {text}") is None
    ]
    return strange[-1] if strange and unit_of(name) is None else ""


def _ordered_words(name: str) -> list[str]:
    """Words of a name in small letters; a capital after two small letters begins a word."""
    apart = re.sub(r"(?<=[a-z][a-z])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[^\w°]+|_", apart.lower()) if word]


def _words(name: str) -> set[str]:
    words = _ordered_words(_BRACKETS.sub(" ", name))
    return set(words) | {"".join(pair) for pair in pairwise(words)} | _bracketed(name)


def _bracketed(name: str) -> set[str]:
    """Words in brackets, where they are all that the name has: ``[deg]``."""
    return set() if _ordered_words(_BRACKETS.sub(" ", name)) else set(_ordered_words(name))


def _split_unit(word: str) -> tuple[PressureUnit | None, str]:
    """Split a word into a unit and the letters after it: ``bara``, ``psig``."""
    for unit, value in _UNITS.items():
        if word == unit or (word.startswith(unit) and word[len(unit) :] in _REFERENCES):
            return value, word[len(unit) :]
    return None, ""
