"""The mirror planes that an imported solid has, and cutting it there."""

from collections.abc import Sequence

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats, Mask
from geometry.errors import GeometryError
from geometry.faces import edge_points, parameter_grid
from geometry.surfaces import PLANE_AXIS, Mirror

# Of the rod's length: for areas and centres, and for points on the edges, which lie a few micrometres beside
# their faces in the files of some programs.
_SLACK, _BESIDE = 1e-5, 3e-5
# Places along each parameter of a curved face at which it is compared with its mirror image.
_WITHIN = np.linspace(0.05, 0.95, 3)


def smallest_cell(volumes: Sequence[int], length: float) -> Mirror:
    """Return the smallest symmetry cell of volumes in the rod's frame; tolerances scale with its length."""
    solids = [_faces(volume) for volume in volumes]
    # Every solid must be its own image; two that mirror each other may have different materials.
    if not all(_is_mirrored(faces, 2, length) for faces in solids):
        return Mirror.NONE
    return Mirror.QUARTER if all(_is_mirrored(faces, 1, length) for faces in solids) else Mirror.HALF


def cut_to(volumes: Sequence[int], mirror: Mirror, length: float) -> list[list[int]]:
    """Cut volumes to a cell; return what each became. Raises `GeometryError`: one lies outside the cell."""
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
        raise GeometryError('a part of the solid lies outside the symmetry cell. Use symmetry = "none"')
    return kept


# Faces of one solid: tags, areas and centres (n, 4), points (n_points, 3) on each and its edges; its centre.
_Faces = tuple[list[int], Floats, list[Floats], Floats]


def _faces(volume: int) -> _Faces:
    occ = gmsh.model.occ
    tags = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], combined=False, oriented=False)]
    measures = np.array([[occ.getMass(2, tag), *occ.getCenterOfMass(2, tag)] for tag in tags])
    points = [np.concatenate([edge_points(tag), _within(tag)]) for tag in tags]
    return tags, measures, points, np.array(occ.getCenterOfMass(3, volume))


def _within(face: int) -> Floats:
    """Points (n, 3) of a curved face between its edges; none of a plane, which its edges determine."""
    if gmsh.model.getType(2, face) == "Plane":
        return np.zeros((0, 3))
    grid = parameter_grid(face, _WITHIN).reshape(-1, 2)
    on = [place for place in grid if gmsh.model.isInside(2, face, list(place), True)]  # noqa: FBT003 - gmsh's
    return np.reshape(gmsh.model.getValue(2, face, np.ravel(on)) if on else [], (-1, 3))


def _is_mirrored(faces: _Faces, axis: int, length: float) -> bool:
    """Whether every face has an image about the plane normal to `axis`.

    It has the same area and centre, which is cheap to test, and contains the images of points on the face and
    its edges: a non-circular hole may be turned about its axis, and a wall bulge instead of being hollow.
    Faces without such an image may be divided differently on the other side: then their points must lie on
    each other's images, or on the edges of one that is alike.
    """
    tags, measures, points_of, centre = faces
    scale = np.array([length**2, length, length, length])
    image = measures.copy()
    image[:, 1 + axis] *= -1
    alike = (np.abs(image[:, None] - measures[None]) / scale).max(axis=2) < _SLACK
    flipped = [points * np.where(np.arange(3) == axis, -1.0, 1.0) for points in points_of]
    alone = [
        at
        for at, row in enumerate(alike)
        if not any(_beside(flipped[at], (2, tags[other]), length)[0].all() for other in np.flatnonzero(row))
    ]
    balanced = abs(centre[axis]) < _SLACK * length
    among = {at: [tags[other] for other in {*alone, *np.flatnonzero(alike[at])}] for at in alone}
    return not alone or (balanced and all(_lie_on(flipped[at], among[at], length) for at in alone))


def _beside(points: Floats, entity: tuple[int, int], length: float) -> tuple[Mask, Floats]:
    """Whether each of some points (n, 3) is on the surface of a face, or on an edge between its ends.

    Also the parameters there (k, dimension of the entity) of those that are. The kernel is asked only for
    those in the entity's box: of a large file, all of them take minutes.
    """
    slack = _BESIDE * length
    low, high = np.reshape(gmsh.model.getBoundingBox(*entity), (2, 3))
    beside = ((low - slack < points) & (points < high + slack)).all(axis=1)
    places = np.zeros((0, entity[0]))
    if beside.any():
        nearest, at = gmsh.model.getClosestPoint(*entity, points[beside].ravel())
        near = np.abs(np.reshape(nearest, (-1, 3)) - points[beside]).max(axis=1) < slack
        beside[beside], places = near, np.reshape(at, (-1, entity[0]))[near]
    return np.asarray(beside), places


def _lie_on(points: Floats, faces: Sequence[int], length: float) -> bool:
    """Whether each of some points (n, 3) is on one of the faces, or on one of their edges.

    The kernel takes a plane for infinite, and misses other faces at the corners of their parameters.
    """
    for edge in gmsh.model.getBoundary([(2, face) for face in faces], combined=False, oriented=False):
        points = points[~_beside(points, edge, length)[0]]
    for face in faces:
        on, places = _beside(points, (2, face), length)
        on[on] = [gmsh.model.isInside(2, face, at, True) for at in places.tolist()]  # noqa: FBT003 - gmsh's
        points = points[~on]
    return not len(points)
