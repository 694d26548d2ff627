"""A cycle as a path through the space of unit loads, and how far it strays from chords.

Between two instants a and b of the path the weights are w = (1 − s) w_a + s w_b + δ. A convex function of
stress that is positively homogeneous, such as the von Mises or the largest principal stress, is then at
most max(f(σ_a), f(σ_b)) + Σ_k |δ_k| ‖σ_k‖, where ‖σ_k‖ bounds ±f of the unit stress σ_k: few instants say
where the others need not be looked at, and nothing is lost.
"""

from dataclasses import dataclass

import numpy as np

from fea.cycle.unit_solutions import Weights
from geometry.arrays import Floats, Ints

# Instants from one end of a chord to the other.
CHORD = 15


@dataclass(frozen=True)
class Path:
    """The instants of a cycle in order.

    Attributes
    ----------
    weights
        Of the even and the odd unit loads, (n_units, n_instants).
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
        even, odd = self.weights
        return even[:, self.ends], odd[:, self.ends]

    def inside(self, chord: int) -> tuple[slice, Weights]:
        """Instants within a chord, its ends left out, and their weights."""
        inside = slice(int(self.ends[chord]) + 1, int(self.ends[chord + 1]))
        even, odd = self.weights
        return inside, (even[:, inside], odd[:, inside])


def path(weights: Weights) -> Path:
    """Cut the instants, in the order given, into chords."""
    count = weights[0].shape[1]
    ends = np.unique(np.append(np.arange(0, count, CHORD), count - 1))
    even, odd = (_strays(w, ends) for w in weights)
    return Path(weights, ends, (even, odd))


def _strays(weights: Floats, ends: Ints) -> Floats:
    instants = np.arange(weights.shape[1])
    chord = np.clip(np.searchsorted(ends, instants, side="right") - 1, 0, max(len(ends) - 2, 0))
    after = np.minimum(chord + 1, len(ends) - 1)
    share = (instants - ends[chord]) / np.maximum(ends[after] - ends[chord], 1)
    straight = (1 - share) * weights[:, ends[chord]] + share * weights[:, ends[after]]
    away = np.abs(weights - straight)
    return np.maximum.reduceat(away, ends[:-1], axis=1) if len(ends) > 1 else away[:, :0]
