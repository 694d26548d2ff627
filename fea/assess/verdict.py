"""The error bar of a peak stress, and the verdict on it.

The peak of a case is the largest von Mises stress over the nodes, each with its estimated error. The true
peak may therefore be as high as the largest sum of stress and error over *all* nodes: if the elements are too
large, a place that seems to be second may be the worst one. The error bar is the excess of that sum over the
computed peak, applied in both directions.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from geometry.arrays import Floats, Mask

# A peak counts as mesh-converged within this error bar, unless another tolerance is requested: it is less
# than the uncertainty of the assumed pressure distribution or of a material's strength.
CONVERGED_PERCENT = 5.0


class Verdict(StrEnum):
    """The verdict that follows from an error bar."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not converged"
    DIVERGING = "diverging"


@dataclass(frozen=True)
class Peak:
    """The largest value of a field over the nodes that count, with its error bar.

    Attributes
    ----------
    node
        Node of the peak.
    value
        Its value.
    bar
        The true peak lies within `value` ± `bar`.
    unmasked
        The largest over all nodes.
    singular
        The largest near stress singularities, which grows without limit as the mesh is refined; 0 without
        such places.
    """

    node: int
    value: float
    bar: float
    unmasked: float
    singular: float = 0.0

    @property
    def error_percent(self) -> float:
        """The bar relative to the value."""
        return 100 * self.bar / self.value if self.value > 0 else 0.0

    def verdict(self, tolerance_percent: float | None = None) -> Verdict:
        """Return the verdict for the tolerance, or for `CONVERGED_PERCENT` without one.

        It is diverging if the stress near a singularity exceeds the peak: it grows with every refinement.
        """
        if self.unmasked > self.value:
            return Verdict.DIVERGING
        within = self.error_percent <= (CONVERGED_PERCENT if tolerance_percent is None else tolerance_percent)
        return Verdict.CONVERGED if within else Verdict.NOT_CONVERGED


def peak(value: Floats, error: Floats, masked: Mask | None = None) -> Peak:
    """Find the peak of a field.

    Parameters
    ----------
    value, error
        (n_nodes,) the field and the estimated error of each value.
    masked
        (n_nodes,) nodes near stress singularities; they count in `Peak.unmasked` only.
    """
    counts = np.ones(value.shape, dtype=bool) if masked is None or masked.all() else ~masked
    node = int(np.where(counts, value, -np.inf).argmax())
    highest = float(np.where(counts, value + error, -np.inf).max())
    singular = float(value[~counts].max(initial=0.0))
    return Peak(node, float(value[node]), highest - float(value[node]), float(value.max()), singular)
