"""The error bar of a peak stress, and the verdict on it.

The peak of a case is the largest von Mises stress over the nodes, each with its estimated error. The true
peak may therefore be as high as the largest sum of stress and error over *all* nodes: if the elements are too
large, a place that seems to be second may be the worst one. The error bar is the excess of that sum over the
computed peak, applied in both directions.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from fea.base.choices import CONVERGED_PERCENT
from geometry.arrays import Floats, Ints, Mask


class ConvergenceVerdict(StrEnum):
    """The verdict that follows from an error bar."""

    CONVERGED = "converged"
    SUFFICIENT = "sufficient"  # its bar is wide, but cannot lower the smallest safety factor
    NOT_CONVERGED = "not converged"
    DIVERGING = "diverging"  # of the stress near a singularity, which no figure includes


# The constants of the estimate come from rods drawn from dimensions, whose fillets have elements enough. Of a
# rod read from a file, errors beyond the bar of a converged peak are widened by this power of their excess:
# the first meshes of three of five CAD rods erred by up to 1.35 times their bar (results/cad-rods.md).
_WIDENED = 0.4


@dataclass(frozen=True)
class Peak:
    """The largest value of a field over the nodes that count, with its error bar."""

    node: int  #: node of the peak
    value: float  #: its value
    bar: float  #: the true peak lies within `value` ± `bar`
    bar_node: int  #: node that sets the bar: the largest sum of value and error
    unmasked: float  #: the largest over all nodes
    #: The largest near stress singularities, which grows without limit as the mesh is refined; 0 without such
    #: places
    singular: float = 0.0
    singular_node: int | None = None  #: where that is

    @property
    def highest(self) -> float:
        """The largest sum of value and error."""
        return self.value + self.bar

    @property
    def error_percent(self) -> float:
        """The bar relative to the value."""
        return 100 * self.bar / self.value if self.value > 0 else 0.0

    @property
    def diverges(self) -> bool:
        """Whether the stress near a singularity exceeds the peak: it grows with every refinement."""
        return self.unmasked > self.value

    def verdict(self, tolerance_percent: float | None = None) -> ConvergenceVerdict:
        """Return the verdict on the value for the tolerance; without one, or with 0, `CONVERGED_PERCENT`."""
        within = self.error_percent <= (tolerance_percent or CONVERGED_PERCENT)
        return ConvergenceVerdict.CONVERGED if within else ConvergenceVerdict.NOT_CONVERGED


def peak(value: Floats, error: Floats, masked: Mask | None = None) -> Peak:
    """Find the peak of a field (n_nodes,) with its errors; masked nodes count in `unmasked` only."""
    counts = np.ones(value.shape, dtype=bool) if masked is None or masked.all() else ~masked
    node = int(np.where(counts, value, -np.inf).argmax())
    highest, left_out = np.where(counts, value + error, -np.inf), np.where(counts, 0.0, value)
    bar_node = int(highest.argmax())
    return Peak(
        node=node,
        value=float(value[node]),
        bar=float(highest[bar_node] - value[node]),
        bar_node=bar_node,
        unmasked=float(value.max()),
        singular=float(left_out.max()),
        singular_node=None if counts.all() else int(left_out.argmax()),
    )


def widened(value: Floats, error: Floats, masked: Mask | None = None) -> Floats:
    """Widen errors (n_nodes,) on a mesh that may be too coarse for the constants of their estimate."""
    share = error / (CONVERGED_PERCENT / 100 * max(peak(value, error, masked).value, np.finfo(float).tiny))
    return np.asarray(error * np.maximum(1.0, share) ** _WIDENED)


# Upper limit of the factor, which would be infinite at zero stress; it keeps colour scales readable.
CAP = 100.0


def safety_factor(von_mises: Floats, yield_strength: float) -> Floats:
    """Yield strength over von Mises stress, at most `CAP`."""
    return np.asarray(yield_strength / np.maximum(von_mises, yield_strength / CAP))


def element_largest(nodal: Floats, tets: Ints) -> Floats:
    """Largest nodal value of each element, (n_elements,)."""
    return np.asarray(nodal[tets].max(axis=1))
