"""Mirror planes of a solid of unknown make: found on its faces, and cut at."""

from collections.abc import Sequence

import gmsh
import numpy as np
import numpy.typing as npt

from geometry import kernel
from geometry.errors import GeometryError
from geometry.mirror import AXIS, Mirror

_SLACK = 1e-5


def smallest_cell(volumes: Sequence[int], length: float) -> Mirror:
    """Return the smallest mirror cell about z = 0 and y = 0.

    Parameters
    ----------
    volumes
        Placed in the rod's frame.
    length
        Of the rod, mm: the scale of what counts as equal.
    """
    faces = _faces(volumes)
    if not _is_mirrored(faces, 2, length):
        return Mirror.NONE
    return Mirror.QUARTER if _is_mirrored(faces, 1, length) else Mirror.HALF


def cut_to(volumes: Sequence[int], mirror: Mirror, length: float) -> list[list[int]]:
    """Cut every volume to a cell; return what each became.

    Raises
    ------
    GeometryError
        A volume lies outside the cell.
    """
    if not mirror.planes:
        return [[volume] for volume in volumes]
    far = 10 * length
    corner, size = [-far] * 3, [2 * far] * 3
    for plane in mirror.planes:
        corner[AXIS[plane]], size[AXIS[plane]] = 0.0, far
    kept = []
    with kernel.attempt("cut the solid at its mirror planes"):
        for volume in volumes:
            box = gmsh.model.occ.addBox(*corner, *size)
            left, _ = gmsh.model.occ.intersect([(3, volume)], [(3, box)])
            kept.append([tag for dim, tag in left if dim == 3])
    if not all(kept):
        raise GeometryError('a part of the solid lies beyond the mirror planes: use symmetry = "none"')
    return kept


def _faces(volumes: Sequence[int]) -> npt.NDArray[np.float64]:
    """Return area and centre (n, 4) of every face."""
    boundary = gmsh.model.getBoundary([(3, tag) for tag in volumes], combined=False, oriented=False)
    occ = gmsh.model.occ
    return np.array([[occ.getMass(2, tag), *occ.getCenterOfMass(2, tag)] for _, tag in boundary])


def _is_mirrored(faces: npt.NDArray[np.float64], axis: int, length: float) -> bool:
    """Whether every face has an image of the same area about the plane normal to `axis`."""
    scale = np.array([length**2, length, length, length])
    image = faces.copy()
    image[:, 1 + axis] *= -1
    difference = np.abs(faces[:, None] - image[None]) / scale
    return bool((difference.max(axis=2).min(axis=1) < _SLACK).all())
