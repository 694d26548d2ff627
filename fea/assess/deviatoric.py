"""Stress as a vector of five deviatoric components and the mean stress (Ilyushin 1963).

    q = (σxx − (σyy + σzz)/2,  ½√3 (σyy − σzz),  √3 σxy,  √3 σyz,  √3 σxz),    σ_m = (σxx + σyy + σzz)/3

The von Mises stress is the length of q, and a history of stress is a curve in that space: products of
deviators are scalar products, and the smallest ball round the curve measures its amplitude.
"""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_ROOT = 3**0.5
# Rows q₁…q₅ and σ_m, columns XX YY ZZ XY YZ XZ.
FROM_TENSOR = np.array(
    [
        [1, -1 / 2, -1 / 2, 0, 0, 0],
        [0, _ROOT / 2, -_ROOT / 2, 0, 0, 0],
        [0, 0, 0, _ROOT, 0, 0],
        [0, 0, 0, 0, _ROOT, 0],
        [0, 0, 0, 0, 0, _ROOT],
        [1 / 3, 1 / 3, 1 / 3, 0, 0, 0],
    ]
)
TO_TENSOR = np.linalg.inv(FROM_TENSOR)


def deviatoric(history: Floats) -> Floats:
    """Return q and σ_m (…, 6, n) of stress (…, 6, n), components XX YY ZZ XY YZ XZ."""
    return np.asarray(FROM_TENSOR @ history)


def tensor(components: Floats) -> Floats:
    """Return stress (…, 6, n) of q and σ_m (…, 6, n)."""
    return np.asarray(TO_TENSOR @ components)
