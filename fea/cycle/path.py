"""A cycle as a path through the space of unit loads, and its deviation from chords.

Between two instants a and b of the path the weights are w = (1 − s) w_a + s w_b + δ. A convex function f of
stress that is positively homogeneous, such as the von Mises or the largest principal stress, is then at most
max(f(σ_a), f(σ_b)) + Σ_k |δ_k| ‖σ_k‖, where ‖σ_k‖ bounds ±f of the unit stress σ_k. A few instants therefore
show where the others need not be evaluated, without loss.
"""

from dataclasses import dataclass

import numpy as np

from fea.cycle.unit_loads import Weights
from geometry.arrays import Floats, Ints

# Instants from one end of a chord to the other.
CHORD = 15


@dataclass(frozen=True)
class Path:
    """The instants of a cycle in order.

    Attributes
    ----------
    weights
        At every instant.
    ends
        (n_chords + 1,) the instants at which chords begin and end.
    strays
        (n_units, n_chords) largest |δ_k| of the even and the odd weights.
    """

    weights: Weights
    ends: Ints
    strays: Weights

    def at_ends(self) -> Weights:
        """Weights at the ends of the chords."""
        return self.weights.at(self.ends)

    def inside(self, chord: int) -> tuple[slice, Weights]:
        """Instants within a chord, its ends left out, and their weights."""
        inside = slice(int(self.ends[chord]) + 1, int(self.ends[chord + 1]))
        return inside, self.weights.at(inside)


def path(weights: Weights) -> Path:
    """Divide the instants, in the given order, into chords."""
    count = weights.even.shape[1]
    ends = np.unique(np.append(np.arange(0, count, CHORD), count - 1))
    return Path(weights, ends, Weights(*(_strays(w, ends) for w in weights)))


def _strays(weights: Floats, ends: Ints) -> Floats:
    instants = np.arange(weights.shape[1])
    chord = np.clip(np.searchsorted(ends, instants, side="right") - 1, 0, max(len(ends) - 2, 0))
    after = np.minimum(chord + 1, len(ends) - 1)
    share = (instants - ends[chord]) / np.maximum(ends[after] - ends[chord], 1)
    straight = (1 - share) * weights[:, ends[chord]] + share * weights[:, ends[after]]
    away = np.abs(weights - straight)
    return np.maximum.reduceat(away, ends[:-1], axis=1) if len(ends) > 1 else away[:, :0]
