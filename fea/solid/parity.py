"""Symmetric and antisymmetric parts about y = 0."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from geometry.arrays import Floats


class Parity(IntEnum):
    """How a vector field continues across y = 0: mirrored as it is, or mirrored and reversed."""

    SYMMETRIC = 1
    ANTISYMMETRIC = -1


@dataclass(frozen=True)
class Split:
    """A field split about y = 0; the second part is None for a model that is not cut there.

    Attributes
    ----------
    symmetric, antisymmetric
        Nodal values on the meshed cell, (n_nodes, 3).
    """

    symmetric: Floats
    antisymmetric: Floats | None

    def part(self, parity: Parity) -> Floats:
        """One of the two parts; zero where there is none."""
        if parity is Parity.SYMMETRIC:
            return self.symmetric
        return np.zeros_like(self.symmetric) if self.antisymmetric is None else self.antisymmetric
