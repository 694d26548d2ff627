"""Stress as a vector of five deviatoric components and the mean stress (Ilyushin 1963).

    q = (σxx − (σyy + σzz)/2,  ½√3 (σyy − σzz),  √3 σxy,  √3 σyz,  √3 σxz),    σ_m = (σxx + σyy + σzz)/3

The von Mises stress is the length of q, and a stress history is a curve in that space: products of deviators
are scalar products, and the radius of the smallest ball that encloses the curve is its amplitude.
"""

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats, Reals

Real = TypeVar("Real", bound=np.floating[Any])

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
    return np.asarray(FROM_TENSOR.astype(history.dtype) @ history)


def tensor(components: Floats) -> Floats:
    """Return stress (…, 6, n) of q and σ_m (…, 6, n)."""
    return np.asarray(TO_TENSOR @ components)


def deviator_norm(components: npt.NDArray[Real]) -> npt.NDArray[Real]:
    """Return the von Mises stress (n, n_instants) of q and σ_m (n, 6, n_instants)."""
    q = components[:, :5]
    return np.asarray(np.sqrt(np.einsum("nct,nct->nt", q, q)))


def extreme_principals(components: Reals, equivalent: Reals) -> tuple[Reals, Reals]:
    """Largest and least principal stress (…, n) of q and σ_m (…, 6, n) with their von Mises stress (…, n).

    σ₁ = σ_m + ⅔ σ_vM cos θ and σ₃ = σ_m − ⅔ σ_vM cos(60° − θ) with the Lode angle θ in 0…60°: cos 3θ is
    the determinant of the deviator over its largest at that von Mises stress (Smith 1961).
    """
    q1, q2, xy, yz, xz, mean = np.moveaxis(components, -2, 0)
    first = q1 / _ROOT
    b, c = q2 - first, -q2 - first
    determinant = 2 * first * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    cube = 2 / _ROOT**3 * equivalent**3
    cosine = np.divide(determinant, cube, out=np.ones_like(cube), where=cube > 0)
    theta = np.arccos(np.clip(cosine, -1, 1)) / 3
    radius = 2 / 3 * equivalent
    return mean + radius * np.cos(theta), mean - radius * np.cos(np.pi / 3 - theta)
