"""A cycle as a path through the space of unit loads, and its deviation from chords.

Between two instants a and b of the path the weights are w = (1 − s) w_a + s w_b + δ. A convex function f of
stress that is positively homogeneous, such as the von Mises or the largest principal stress, is then at most
max(f(σ_a), f(σ_b)) + Σ_k |δ_k| ‖σ_k‖, where ‖σ_k‖ bounds ±f of the unit stress σ_k. Where there are many
unit loads, the root of Σ_k δ_k² over some of them, times the most that unit weights of them can cause, takes
the place of their part of the sum. A few instants therefore show where the others need not be evaluated,
without loss.
"""

from dataclasses import dataclass

import numpy as np

from fea.judge.history import deviator_norm
from fea.pins.model import NOT_JOINT, JointBounds, Weights
from geometry.arrays import Floats, Ints, Reals

# Instants from one end of a chord to the other, also where many unit loads make the bounds wide.
CHORD, SHORT, MANY = 15, 11, 150
# Allowance for rounding in the bounds on what many unit loads can do together, in single precision.
_ROUNDING = 1e-3


@dataclass(frozen=True)
class Path:
    """The instants of a cycle in order."""

    weights: Weights  #: at every instant
    ends: Ints  #: (n_chords + 1,) the instants at which chords begin and end
    strays: Weights  #: (m, n_chords) largest sizes of δ, as of `sizes`, of the even and the odd weights
    joint: JointBounds  #: unit loads whose deviations are bounded jointly

    def at_ends(self) -> Weights:
        """Weights at the ends of the chords."""
        return self.weights.at(self.ends)

    def inside(self, chord: int) -> tuple[slice, Weights]:
        """Instants within a chord, its ends left out, and their weights."""
        inside = slice(int(self.ends[chord]) + 1, int(self.ends[chord + 1]))
        return inside, self.weights.at(inside)


def path(weights: Weights, joint: JointBounds = NOT_JOINT) -> Path:
    """Divide the instants, in the given order, into chords."""
    count = weights.even.shape[1]
    chord = CHORD if sum(map(len, weights)) < MANY else SHORT
    ends = np.unique(np.append(np.arange(0, count, chord), count - 1))
    strays = Weights(*(_strays(w, ends, own) for w, own in zip(weights, joint, strict=True)))
    return Path(weights, ends, strays, joint)


def sizes(away: Floats, joint: slice) -> Floats:
    """Sizes (m, n) of deviations (n_units, n): of each by itself, then of those bounded jointly."""
    alone = np.abs(np.delete(away, joint, axis=0))
    bounded = np.linalg.norm(away[joint], axis=0, keepdims=True)
    return np.concatenate([alone, bounded]) if away[joint].size else alone


def norms(units: Reals, joint: slice) -> tuple[Reals, Reals]:
    """Largest von Mises stress, and largest mean stress, each (n, m), that deviations of unit size can cause.

    `units` (n, 6, n_units) unit stresses, components of `fea.judge.history`; `joint`: as for `sizes`.
    """
    alone, others = np.delete(units, joint, axis=2), units[..., joint]
    equivalent, mean = deviator_norm(alone), np.abs(alone[:, 5])
    if not others.shape[2]:
        return equivalent, mean
    q = others[:, :5]
    largest = np.linalg.eigvalsh(q @ q.swapaxes(1, 2))[:, -1:]
    furthest = (1 + _ROUNDING) * np.sqrt(np.maximum(largest, 0.0))
    pressed = (1 + _ROUNDING) * np.linalg.norm(others[:, 5], axis=1, keepdims=True)
    return np.concatenate([equivalent, furthest], axis=1), np.concatenate([mean, pressed], axis=1)


def _strays(weights: Floats, ends: Ints, joint: slice) -> Floats:
    instants = np.arange(weights.shape[1])
    chord = np.clip(np.searchsorted(ends, instants, side="right") - 1, 0, max(len(ends) - 2, 0))
    after = np.minimum(chord + 1, len(ends) - 1)
    share = (instants - ends[chord]) / np.maximum(ends[after] - ends[chord], 1)
    straight = (1 - share) * weights[:, ends[chord]] + share * weights[:, ends[after]]
    away = sizes(weights - straight, joint)
    return np.maximum.reduceat(away, ends[:-1], axis=1) if len(ends) > 1 else away[:, :0]
