"""The exponent of compression, by which a pressure trace shows its unit, its reference and its TDC.

From the closing of the inlet valve to combustion the charge follows p Vⁿ = const with n between 1.2 and 1.4
(Heywood 1988, §9.2.2: 1.25 to 1.35 for hydrocarbon mixtures). A wrong zero of the pressure or a wrong dead
centre gives another slope of log p over log V.
"""

import math

import numpy as np

from geometry.arrays import Floats

# Crank angles after valve closing and before ignition in nearly every engine, degrees from firing TDC.
_FROM, _TO = -110.0, -60.0
# Slopes that belong to a compression, though the compression ratio may be any between 8 and 22 where the
# nominal one is taken: measured traces read rightly gave 1.33 to 1.53, read 1 bar too high 0.94 to 1.11.
LEAST, MOST = 1.18, 1.7
_NOMINAL_RATIO = 14.0
_ROD_RATIO = 0.29  # crank radius over rod length; 0.2 to 0.33 change n by less than 0.05


def compression_exponent(angles: Floats, pressures: Floats, ratio: float | None = None) -> float:
    """Slope n of p Vⁿ between 110° and 60° before firing TDC; NaN where a pressure is not positive.

    Parameters
    ----------
    angles
        (n,) degrees from firing TDC.
    pressures
        (n,) absolute, in any unit.
    ratio
        Compression ratio, if it is known.
    """
    inside = (angles >= _FROM) & (angles <= _TO)
    p = pressures[inside]
    if p.size < 3 or not (p > 0).all():
        return math.nan
    volume = 1 / ((ratio or _NOMINAL_RATIO) - 1) + _travel(np.radians(angles[inside]))
    return float(-np.polyfit(np.log(volume), np.log(p), 1)[0])


def is_compression(exponent: float) -> bool:
    """Whether an exponent can be that of a compression."""
    return LEAST <= exponent <= MOST


def _travel(theta: Floats) -> Floats:
    """Way of the piston from TDC over its stroke."""
    rod = (1 - np.sqrt(1 - (_ROD_RATIO * np.sin(theta)) ** 2)) / _ROD_RATIO
    return np.asarray((1 - np.cos(theta) + rod) / 2, dtype=np.float64)
