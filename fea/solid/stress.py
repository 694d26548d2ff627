"""Scalars of a stress tensor, and the plane that its history opens most."""

import numpy as np

from geometry.arrays import Floats


def matrices(stress: Floats) -> Floats:
    """Symmetric matrices (…, 3, 3) of tensors (…, 6), components XX YY ZZ XY YZ XZ."""
    return np.asarray(stress[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])


def von_mises(stress: Floats) -> Floats:
    """Von Mises stress (…,) of tensors (…, 6), components XX YY ZZ XY YZ XZ."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(squares / 2 + 3 * (xy**2 + yz**2 + xz**2)))


def principal(stress: Floats) -> Floats:
    """Principal stresses (…, 3), largest first, of tensors (…, 6).

    Trigonometric roots of the characteristic cubic (Smith 1961), accurate to 1e-8 of the largest stress where
    two roots coincide and to rounding elsewhere; LAPACK takes three times as long.
    """
    largest = float(np.abs(stress).max(initial=0.0)) or 1.0
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress / largest, -1, 0)  # cubes neither over- nor underflow
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    J2 = (a * a + b * b + c * c) / 2 + xy * xy + yz * yz + xz * xz
    J3 = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    radius = np.sqrt(J2 / 3)
    cube = radius**3
    lode = np.divide(J3, 2 * cube, out=np.ones_like(J3), where=cube > 0)
    angle = np.arccos(np.clip(lode, -1, 1)) / 3
    thirds = 2 * np.pi / 3 * np.array([0, -1, 1])
    roots = mean[..., None] + 2 * radius[..., None] * np.cos(angle[..., None] + thirds)
    return np.asarray(largest * roots)


def opened(stress: Floats) -> Floats:
    """Normals (n, 3) of the planes across the largest principal stress of histories (n, 6, n_instants)."""
    worst = principal(np.moveaxis(stress, 1, -1))[..., 0].argmax(axis=1)
    return np.asarray(np.linalg.eigh(matrices(stress[np.arange(len(stress)), :, worst]))[1][:, :, -1])


def across(stress: Floats, normals: Floats) -> Floats:
    """Stress (n, n_instants) across planes of normals (n, 3) or one for all, of histories as of `opened`."""
    x, y, z = np.broadcast_to(normals, (len(stress), 3)).T
    dyads = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z], axis=1)
    return np.asarray((dyads[:, None] @ stress)[:, 0])
