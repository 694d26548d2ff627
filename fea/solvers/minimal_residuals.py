"""Preconditioned minimal residuals (MINRES) for many right-hand sides and an indefinite matrix."""

import numpy as np

from fea.solid.errors import StagnationError
from fea.solvers.linear.conjugate_gradients import Operator
from geometry.arrays import Floats

MOST_ITERATIONS = 600


def minimal_residuals(
    operator: Operator, precondition: Operator, right_hand_sides: Floats, *, tolerance: float, remedy: str
) -> Floats:
    """Solve A x = b for (n, k) right-hand sides (Paige & Saunders 1975), iterated independently.

    The Lanczos recurrence and Givens rotations follow Elman, Silvester & Wathen (2014, algorithm 4.1).
    Vectors that have converged are left out.

    Parameters
    ----------
    operator, precondition
        A, symmetric, and an approximate inverse of its absolute value, symmetric and positive definite, on
        (n, k) vectors.
    right_hand_sides
        b.
    tolerance
        Of the residual in the preconditioner's norm, relative to that of b.
    remedy
        The remedy in the error message.

    Raises
    ------
    StagnationError
        A residual did not reach the tolerance.
    """
    x = np.zeros_like(right_hand_sides)
    active = np.flatnonzero(right_hand_sides.any(axis=0))
    if not active.size:
        return x
    v = right_hand_sides[:, active]
    z = precondition(v)
    gamma = np.sqrt((z * v).sum(axis=0))
    v_last, w_last, w = np.zeros_like(v), np.zeros_like(v), np.zeros_like(v)
    gamma_last, eta, goal = np.ones_like(gamma), gamma, tolerance * gamma
    c_last = c = np.ones_like(gamma)
    s_last = s = np.zeros_like(gamma)
    for _ in range(MOST_ITERATIONS):
        z /= gamma
        image = operator(z)
        delta = (image * z).sum(axis=0)
        v_next = image - v * (delta / gamma) - v_last * (gamma / gamma_last)
        z_next = precondition(v_next)
        gamma_next = np.sqrt((z_next * v_next).sum(axis=0))
        diagonal = c * delta - c_last * s * gamma
        size = np.hypot(diagonal, gamma_next)
        w_next = (z - w_last * (s_last * gamma) - w * (s * delta + c_last * c * gamma)) / size
        c_next, s_next = diagonal / size, gamma_next / size
        x[:, active] += w_next * (c_next * eta)
        eta = -s_next * eta
        going = ~(np.abs(eta) <= goal)
        if not going.any():
            return x
        active, goal, eta = active[going], goal[going], eta[going]
        v_last, v, z = v[:, going], v_next[:, going], z_next[:, going]
        w_last, w = w[:, going], w_next[:, going]
        gamma_last, gamma = gamma[going], gamma_next[going]
        c_last, c, s_last, s = c[going], c_next[going], s[going], s_next[going]
    reached = tolerance * float((np.abs(eta) / goal).max())
    message = (
        f"minimal residuals stagnated at a relative residual of {reached:.1e} after {MOST_ITERATIONS} steps. "
    )
    raise StagnationError(message + remedy)
