"""Mirror planes of an imported solid: found from its faces, and used to cut it."""

from collections.abc import Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.cad.edges import edge_points
from geometry.errors import GeometryError
from geometry.mirror import PLANE_AXIS, Mirror

# Of the rod's length.
_SLACK = 1e-5


def smallest_cell(volumes: Sequence[int], length: float) -> Mirror:
    """Return the smallest mirror cell about z = 0 and y = 0.

    Parameters
    ----------
    volumes
        Placed in the rod's frame.
    length
        Of the rod, mm; the tolerance is relative to it.
    """
    solids = [_faces(volume) for volume in volumes]

    def mirrored(axis: int) -> bool:
        """Whether every solid is its own image; two that mirror each other may have different materials."""
        return all(_is_mirrored(faces, axis, length) for faces in solids)

    if not mirrored(2):
        return Mirror.NONE
    return Mirror.QUARTER if mirrored(1) else Mirror.HALF


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
        corner[PLANE_AXIS[plane]], size[PLANE_AXIS[plane]] = 0.0, far
    kept = []
    with kernel.attempt("cut the solid at its mirror planes"):
        for volume in volumes:
            box = gmsh.model.occ.addBox(*corner, *size)
            left, _ = gmsh.model.occ.intersect([(3, volume)], [(3, box)])
            kept.append([tag for dim, tag in left if dim == 3])
    if not all(kept):
        raise GeometryError('a part of the solid lies outside the mirror cell. Use symmetry = "none"')
    return kept


@dataclass(frozen=True)
class _Faces:
    """Faces of one solid: tags, areas and centres (n, 4), and points (n_points, 3) on the edges of each."""

    tags: tuple[int, ...]
    measures: Floats
    points: tuple[Floats, ...]


def _faces(volume: int) -> _Faces:
    occ = gmsh.model.occ
    boundary = gmsh.model.getBoundary([(3, volume)], combined=False, oriented=False)
    tags = tuple(int(tag) for _, tag in boundary)
    measures = np.array([[occ.getMass(2, tag), *occ.getCenterOfMass(2, tag)] for tag in tags])
    return _Faces(tags, measures, tuple(edge_points(tag) for tag in tags))


def _is_mirrored(faces: _Faces, axis: int, length: float) -> bool:
    """Whether every face has an image about the plane normal to `axis`.

    The image must have the same area and centre, which is cheap to test, and contain the images of the
    face's edges, because a non-circular hole may be turned about its own axis.
    """
    scale = np.array([length**2, length, length, length])
    image = faces.measures.copy()
    image[:, 1 + axis] *= -1
    alike = (np.abs(image[:, None] - faces.measures[None]) / scale).max(axis=2) < _SLACK
    return all(
        any(_holds(faces.tags[other], points, axis, _SLACK * length) for other in np.flatnonzero(row))
        for points, row in zip(faces.points, alike, strict=True)
    )


def _holds(face: int, points: Floats, axis: int, slack: float) -> bool:
    """Whether the images of points (n, 3) lie on a face."""
    image = points.copy()
    image[:, axis] *= -1
    nearest, _ = gmsh.model.getClosestPoint(2, face, image.ravel())
    return bool(np.abs(np.reshape(nearest, (-1, 3)) - image).max(initial=0.0) < slack)
