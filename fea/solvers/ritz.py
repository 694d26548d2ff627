"""Largest eigenvalues of A φ = θ K φ with a factorised K: block Krylov spaces, thick restarts.

Rayleigh-Ritz values on a space that grows by K⁻¹ times the residuals of a whole block (Saad 2011, chapters 6
and 8; Wu & Simon 2000 on the restarts). K itself is never multiplied, because the forces K Z of the vectors Z
are stored.

SciPy's eigsh (of A and K, with K⁻¹ given) and lobpcg (with K⁻¹ as preconditioner) find the same factors. For
the buckling of the shipped rods at 18 000 to 49 000 unknowns they take 1.6 to 2.0 and 2.1 to 2.6 times the
CPU time: eigsh solves for one vector at a time, lobpcg keeps no more than three blocks, and neither starts
from the space that an earlier load case left.
"""

from dataclasses import dataclass

import numpy as np

from fea.solvers.linear.solver import Operator
from geometry.arrays import Floats

# Number of additional pairs that are improved too, so that none is overlooked, and their accuracy.
_GUARDS = 2
_GUARDED = 0.1
_ROUNDS = 40
_PATIENCE = 5
# Size of the space, in blocks of vectors, at which it is reduced to two blocks.
_BLOCKS = 5
# A vector shorter than this fraction of its original length after orthogonalisation is only rounding.
_DEPENDENT = 1e-10


@dataclass(frozen=True)
class Space:
    """Vectors and the forces that cause them."""

    vectors: Floats  #: Z (n, m), ZᵀKZ = 1
    forces: Floats  #: F (n, m) with K⁻¹F = Z

    def __matmul__(self, weights: Floats) -> "Space":
        return Space(self.vectors @ weights, self.forces @ weights)

    def without(self, other: "Space") -> "Space":
        """Return a K-orthonormal basis of the part of this space that is not in another."""
        vectors, forces = self.vectors, self.forces
        for _ in range(2):  # twice is enough (Parlett 1980)
            share = other.forces.T @ vectors
            vectors, forces = vectors - other.vectors @ share, forces - other.forces @ share
        return orthonormal(vectors, forces)

    def joined(self, other: "Space") -> "Space":
        """Return the sum of two spaces that are orthogonal to each other."""
        return Space(np.hstack([self.vectors, other.vectors]), np.hstack([self.forces, other.forces]))


@dataclass(frozen=True)
class Pairs:
    """Eigenvalues and vectors."""

    values: Floats  #: θ (k,), in decreasing order
    vectors: Floats  #: φ (n, k)
    residuals: Floats  #: ‖φ − K⁻¹A φ/θ‖ / ‖φ‖ (k,), maximum norms
    space: Space  #: the space to start from for a similar A


def largest(
    solve: Operator,
    push: Operator,
    start: Space,
    count: int,
    *,
    least: float,
    accuracy: float,
    enough: float = 0.0,
) -> Pairs:
    """Find the `count` largest positive eigenvalues, from a space with a component of every wanted vector.

    `solve` and `push` multiply blocks (n, k) by K⁻¹ and A. Eigenvalues below the fraction `least` of the
    largest magnitude are ignored, those below `enough` are not needed. `accuracy` is the largest accepted
    residual; the error of θ is of the order of its square.
    """
    space, pushed, block = start, push(start.vectors), count + _GUARDS
    for turn in range(_ROUNDS):
        values, weights = np.linalg.eigh(_symmetric(space.vectors.T @ pushed))
        values, weights = values[::-1], weights[:, ::-1]
        theta, best = values[:block], weights[:, :block]
        ritz, images = space @ best, pushed @ best
        change = Space(solve(images) - theta * ritz.vectors, images - theta * ritz.forces)
        residuals = _lengths(change.vectors) / (np.abs(theta) * _lengths(ritz.vectors))
        counted = theta > least * np.abs(values).max()
        useful = theta * (1 + residuals) > enough  # the residual bounds the error of the eigenvalue
        limits = np.where((np.arange(len(theta)) < count) & useful, accuracy, _GUARDED)
        late = ~counted | (residuals > limits)
        # If too few eigenvalues count yet, more may still appear.
        patient = turn >= _PATIENCE or counted[:count].all()
        if turn == _ROUNDS - 1 or (patient and not (late & counted).any()):
            break
        if len(values) >= _BLOCKS * block:
            space, pushed = space @ weights[:, : 2 * block], pushed @ weights[:, : 2 * block]
        new = (change @ np.eye(len(theta))[:, late]).without(space)
        space, pushed = space.joined(new), np.hstack([pushed, push(new.vectors)])
    chosen = np.flatnonzero((counted & (theta > enough))[:count])
    kept = space @ weights[:, : 2 * block]
    return Pairs(theta[chosen], ritz.vectors[:, chosen], residuals[chosen], kept)


def orthonormal(vectors: Floats, forces: Floats) -> Space:
    """Return a basis with ZᵀKZ = 1 of the span of vectors, given with the forces that cause them."""
    space = Space(vectors, forces)
    for _ in range(2):
        values, weights = np.linalg.eigh(_symmetric(space.vectors.T @ space.forces))
        kept = values > _DEPENDENT * values.max(initial=0.0)
        space = space @ (weights[:, kept] / np.sqrt(values[kept]))
    return space


def ritz_values(space: Space, pushed: Floats) -> Floats:
    """Return the Ritz values, in increasing order, of a space and A times its vectors."""
    return np.asarray(np.linalg.eigvalsh(_symmetric(space.vectors.T @ pushed)))


def _symmetric(matrix: Floats) -> Floats:
    return (matrix + matrix.T) / 2


def _lengths(vectors: Floats) -> Floats:
    return np.asarray(np.abs(vectors).max(axis=0))
