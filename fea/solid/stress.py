"""Scalars of a stress tensor."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def von_mises(stress: Floats) -> Floats:
    """Von Mises stress (…,) of tensors (…, 6), components XX YY ZZ XY YZ XZ."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(squares / 2 + 3 * (xy**2 + yz**2 + xz**2)))


def principal(stress: Floats) -> Floats:
    """Principal stresses (…, 3), largest first, of tensors (…, 6)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    tensor = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*stress.shape[:-1], 3, 3)
    return np.asarray(np.linalg.eigvalsh(tensor)[..., ::-1])
