"""What other strengths make of a rod's fatigue factor, by the stress that was found: nothing is solved again.

The stress of a linear elastic rod does not depend on its strength, so that these factors are those of a
further run.
"""

from dataclasses import dataclass

import numpy as np

from fea.base.choices import Fatigue
from fea.judge.fatigue import gerber, goodman
from geometry.arrays import Floats


@dataclass(frozen=True)
class FatigueField:
    """Stress and strength at the places (n,) of a rod, MPa."""

    criterion: Fatigue
    mean: Floats
    amplitude: Floats
    endurance: Floats  #: of the part, with the factor of the surface
    strength: float  #: with which a mean stress is compared

    def factors(self, share: Floats | float = 1.0) -> Floats:
        """Safety factors (n,) with the endurance limit multiplied by a share, (n,) or one for all."""
        line = gerber if self.criterion is Fatigue.GERBER else goodman
        return line(self.mean, self.amplitude, np.asarray(share) * self.endurance, self.strength)

    def least(self, share: Floats | float = 1.0) -> float:
        """The smallest of them."""
        return float(self.factors(share).min())

    def needed(self, factor: float) -> float:
        """Multiple of the endurance limit with which every place has a safety factor; infinite: none has."""
        used = factor * np.maximum(self.mean, 0) / self.strength
        left = 1 - (used**2 if self.criterion is Fatigue.GERBER else used)
        with np.errstate(divide="ignore"):
            shares = np.where(left > 0, factor * self.amplitude / self.endurance / left, np.inf)
        return float(shares.max())
