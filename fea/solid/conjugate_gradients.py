"""Preconditioned conjugate gradients for many right-hand sides at once."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fea.solid.assembly import SymmetricMatrix
from fea.solid.errors import StagnationError

Floats = npt.NDArray[np.float64]

# Relative residual. Its error in energy is this squared times the condition number of the preconditioned
# matrix (about ten): far below any discretisation error.
TOLERANCE = 1e-8
MOST_ITERATIONS = 300


def conjugate_gradients(
    matrix: SymmetricMatrix, right_hand_sides: Floats, precondition: Callable[[Floats], Floats]
) -> Floats:
    """Solve K u = f for (n, k) right-hand sides (Hestenes & Stiefel 1952), each with steps of its own.

    The products are of K with all the vectors that have not converged, so that K passes through memory once
    an iteration.

    Raises
    ------
    StagnationError
        A relative residual did not fall to `TOLERANCE`.
    """
    u = np.zeros_like(right_hand_sides)
    goal = TOLERANCE * np.linalg.norm(right_hand_sides, axis=0)
    active = np.flatnonzero(goal > 0)
    residual = right_hand_sides[:, active].copy()
    direction = np.zeros_like(residual)
    previous = np.ones(len(active))
    for _ in range(MOST_ITERATIONS):
        if not active.size:
            return u
        preconditioned = precondition(residual)
        energy = (residual * preconditioned).sum(axis=0)
        direction = preconditioned + direction * (energy / previous)
        image = matrix @ direction
        step = energy / (direction * image).sum(axis=0)
        u[:, active] += step * direction
        residual -= step * image
        previous = energy
        going = ~(np.linalg.norm(residual, axis=0) <= goal[active])
        if not going.all():
            active, residual, direction = active[going], residual[:, going], direction[:, going]
            previous = previous[going]
    if not active.size:
        return u
    reached = float((TOLERANCE * np.linalg.norm(residual, axis=0) / goal[active]).max())
    message = (
        f"the iterative solver stagnated at a relative residual of {reached:.1e} after {MOST_ITERATIONS} "
        "iterations. Choose --solver pardiso, or a better shaped mesh"
    )
    raise StagnationError(message)
