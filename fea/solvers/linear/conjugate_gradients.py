"""Preconditioned conjugate gradients for many right-hand sides at once."""

from collections.abc import Callable

import numpy as np

from fea.solid.errors import StagnationError
from geometry.arrays import Floats

Operator = Callable[[Floats], Floats]

# For stiffness matrices: far below any discretisation error.
TOLERANCE = 1e-8
MOST_ITERATIONS = 300


def conjugate_gradients(
    operator: Operator, precondition: Operator, right_hand_sides: Floats, *, tolerance: float, remedy: str
) -> Floats:
    """Solve A x = b for (n, k) right-hand sides (Hestenes & Stiefel 1952), iterated independently.

    The operator is applied to all vectors that have not converged together, so that a matrix is read from
    memory once per iteration.

    Parameters
    ----------
    operator, precondition
        A and its approximate inverse, both symmetric and positive definite, on (n, …) vectors.
    right_hand_sides
        b.
    tolerance
        Of the residual in the preconditioner's norm, relative to that of b: roughly the error in energy.
    remedy
        The remedy in the error message.

    Raises
    ------
    StagnationError
        A residual did not reach the tolerance.
    """
    x = np.zeros_like(right_hand_sides)
    active = np.flatnonzero(right_hand_sides.any(axis=0))
    residual = right_hand_sides[:, active].copy()
    direction = np.zeros_like(residual)
    energy, goal = np.ones(len(active)), np.zeros(len(active))
    for iteration in range(MOST_ITERATIONS + 1):
        preconditioned = precondition(residual) if active.size else residual
        last, energy = energy, (residual * preconditioned).sum(axis=0)
        if iteration == 0:
            goal = tolerance**2 * energy
        going = ~(energy <= goal)
        if not going.any():
            return x
        if iteration == MOST_ITERATIONS:
            break
        active, goal, last, energy = active[going], goal[going], last[going], energy[going]
        residual, direction, preconditioned = (
            residual[:, going],
            direction[:, going],
            preconditioned[:, going],
        )
        direction = preconditioned + direction * (energy / last)
        image = operator(direction)
        step = energy / (direction * image).sum(axis=0)
        x[:, active] += step * direction
        residual -= step * image
    reached = tolerance * float(np.sqrt((energy / goal).max()))
    message = (
        f"conjugate gradients stagnated at a relative residual of {reached:.1e} after {iteration} steps. "
    )
    raise StagnationError(message + remedy)
