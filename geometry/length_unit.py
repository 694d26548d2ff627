"""Units of length in files, and which of them gives a rod a usual length."""

from collections.abc import Iterator

# Millimetres per unit of length: those that can be asked for, and those that a file may declare.
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
DECLARED = {**UNITS, "µm": 1e-3, "dm": 100.0, "km": 1e6, "ft": 304.8}
# Distances of the bores, mm, that the unit of a file is believed with, and that another unit must lead to:
# rods are 50 mm to 2 m long.
_BELIEVED, _USUAL = (20.0, 4000.0), (50.0, 2000.0)


def is_usual(length: float) -> bool:
    """Whether a distance of the bores, mm, is that of most rods."""
    return _USUAL[0] <= length <= _USUAL[1]


def usual_units(number: float) -> Iterator[str]:
    """The units in which a distance of bores is that of a rod, the most frequent first."""
    return (unit for unit in ("mm", "m", "in", "cm") if is_usual(number * UNITS[unit]))


def plausible_unit(length: float, unit: str) -> str:
    """Return the unit with which a distance of bores is that of a rod; the one it was read with if none is.

    Parameters
    ----------
    length
        Distance of the bores, mm, if `unit` is right.
    unit
        Of `DECLARED`.
    """
    if _BELIEVED[0] <= length <= _BELIEVED[1]:
        return unit
    return next(usual_units(length / DECLARED[unit]), unit)
