"""How far a reported peak can be trusted: an error bar, and a word for it.

The peak of a case is the largest von Mises stress over the nodes, each of which may be off by its estimated
error. So the true peak may lie as high as the largest sum of stress and error over *all* nodes: where the
elements are too large, a place that seems to come second may be the worst one. The bar is that sum's excess
over the computed peak, and is meant to either side.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from geometry.arrays import Floats, Mask

# A peak is called converged within this, unless another tolerance is asked for: less than a pressure's
# assumed distribution or a material's strength is known to.
CONVERGED_PERCENT = 5.0


class Verdict(StrEnum):
    """What an error bar means."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not converged"
    DIVERGING = "diverging"


@dataclass(frozen=True)
class Peak:
    """The largest value of a field over the nodes that count, with its error bar.

    Attributes
    ----------
    node
        Where.
    value
        What.
    bar
        The true peak lies within `value` ± `bar`.
    unmasked
        The largest over all nodes.
    singular
        The largest near singular places, which finer elements raise without end; 0 without such places.
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
        """Judge by the tolerance, `CONVERGED_PERCENT` without one.

        A peak exceeded at a singular place is diverging: finer elements will give more and more there.
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
        (n_nodes,) nodes near singular places; they count in `Peak.unmasked` only.
    """
    counts = np.ones(value.shape, dtype=bool) if masked is None or masked.all() else ~masked
    node = int(np.where(counts, value, -np.inf).argmax())
    highest = float(np.where(counts, value + error, -np.inf).max())
    singular = float(value[~counts].max(initial=0.0))
    return Peak(node, float(value[node]), highest - float(value[node]), float(value.max()), singular)
