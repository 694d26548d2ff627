"""Chebyshev iteration: a polynomial of a matrix that approximates its inverse."""

from collections.abc import Callable

import numpy as np

from geometry.arrays import Floats


def chebyshev(
    operator: Callable[[Floats], Floats],
    diagonal: Floats,
    right_hand_sides: Floats,
    bounds: tuple[float, float],
    steps: int,
) -> Floats:
    """Approximate A⁻¹ b, starting from zero, by a symmetric linear operator (Saad 2003, algorithm 12.1).

    Parameters
    ----------
    operator
        A on (n, k) vectors.
    diagonal
        (n,) D, by which A is scaled.
    right_hand_sides
        (n, k).
    bounds
        Bounds of the eigenvalues of D⁻¹A to be damped.
    steps
        Degree of the polynomial plus one.
    """
    low, high = bounds
    middle, half = (high + low) / 2, (high - low) / 2
    inverse = 1 / diagonal[:, None]
    ratio = rho = half / middle
    step = inverse * right_hand_sides / middle
    x = step.copy()
    for _ in range(steps - 1):
        last, rho = rho, 1 / (2 / ratio - rho)
        step = rho * last * step + (2 * rho / half) * inverse * (right_hand_sides - operator(x))
        x += step
    return np.asarray(x)
