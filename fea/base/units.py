"""The one converter between engineering units and the coherent system mm, N, MPa, t, s, rad.

Multiply by a constant to convert input, divide by it to convert output: ``mass = 0.785 * KG``.
"""

import math

from fea.base.shipped import shipped_toml

M = 1e3
GPA = 1e3
BAR = 0.1
KG = 1e-3
KG_M2 = 1e3  # t·mm²
KG_M3 = 1e-12  # t/mm³
N_M = 1e3  # N·mm
KN = 1e3
UM = 1e-3
M_S = 1e3
M_S2 = 1e3
DEG = math.pi / 180
RPM = 2 * math.pi / 60

SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

_DATA = shipped_toml("base/units.toml")
# How the units at the ends of keys are written, where that is otherwise.
WRITTEN: dict[str, str] = _DATA["written"]
# What else a quantity is given in, by the unit at the end of its key: how much of that unit it is.
OTHER_UNITS: dict[str, dict[str, float]] = _DATA["other"]
# What is shown in place of a unit (US customary): its name, how much of the other it is, and what it reads
# where the other is 0, if not 0.
US_CUSTOMARY: dict[str, tuple[str, float] | tuple[str, float, float]] = _DATA["us"]
INCH = OTHER_UNITS["mm"]["inches"]


def with_power(text: str) -> str:
    """Return the text of a number with a power of ten in place of its exponent: 5e+08 as 5·10⁸."""
    mantissa, _, power = text.partition("e")
    times = "" if mantissa == "1" else f"{mantissa}·"
    return f"{times}10{str(int(power)).translate(SUPERSCRIPTS)}" if power else text
