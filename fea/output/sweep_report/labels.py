"""What keys and columns are called on the axes of a drawing."""

_UNITS = {
    "_kg_m3": "kg/m³", "_kg_m2": "kg m²", "_1_K": "1/K", "_mm": "mm", "_MPa": "MPa", "_GPa": "GPa",
    "_kN": "kN", "_N": "N", "_kg": "kg", "_deg": "°", "_percent": "%", "_bar": "bar", "_C": "°C",
    "_Hz": "Hz", "_hours": "h",
}  # fmt: skip


def label(name: str) -> str:
    """Return the name of a key or a column with its unit: ``web thickness (mm)``.

    The table of a key is left out where it is that of the rod.
    """
    plain = name.removeprefix("rod.")
    ending = next((end for end in _UNITS if plain.endswith(end)), "")
    words = plain.removesuffix(ending).replace(".", " ").replace("_", " ")
    return f"{words} ({_UNITS[ending]})" if ending else {"factor": "least factor"}.get(words, words)
