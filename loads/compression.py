"""The exponent of compression, by which a pressure trace shows its unit, its reference and its TDC.

From the closing of the inlet valve to combustion the charge follows p Vⁿ = const with n near 1.3 (Heywood
1988, §9.2.2); a compression ratio or a dead centre that is not exact gives a little more or less. A wrong
zero of the pressure gives another slope of log p over log V.
"""

import math
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats

# Crank angles after valve closing and before ignition in nearly every engine, degrees from firing TDC.
_FROM, _TO = -110.0, -60.0
# Exponents that measured compressions show.
_LEAST, _MOST = 1.22, 1.55
# Compression ratios of nearly all engines, and one in between.
_RATIOS, _NOMINAL = (7.5, 22.0), 14.0
_ROD_RATIO = 0.29  # crank radius over rod length; 0.2 to 0.33 change n by less than 0.05


class Exponent(NamedTuple):
    """Slope n of p Vⁿ, for the least, a middle and the largest compression ratio that may be meant."""

    least: float
    middle: float
    most: float

    @property
    def known(self) -> bool:
        """Whether there is a slope: enough samples, all pressures positive."""
        return not math.isnan(self.middle)

    @property
    def is_compression(self) -> bool:
        """Whether it can be that of a compression."""
        return self.known and self.most >= _LEAST and self.least <= _MOST


def compression_exponent(angles: Floats, pressures: Floats, ratio: float | None = None) -> Exponent:
    """Fit p Vⁿ between 110° and 60° before firing TDC.

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
        return Exponent(math.nan, math.nan, math.nan)
    ratios = (_RATIOS[1], _NOMINAL, _RATIOS[0]) if ratio is None else (ratio,) * 3
    travel = _travel(np.radians(angles[inside]))
    slopes = (-np.polyfit(np.log(1 / (r - 1) + travel), np.log(p), 1)[0] for r in ratios)
    return Exponent(*(float(slope) for slope in slopes))


def _travel(theta: Floats) -> Floats:
    """Way of the piston from TDC over its stroke."""
    rod = (1 - np.sqrt(1 - (_ROD_RATIO * np.sin(theta)) ** 2)) / _ROD_RATIO
    return np.asarray((1 - np.cos(theta) + rod) / 2, dtype=np.float64)
