"""A cap in place of one that is missing: the section at the joint, turned about the bore's axis."""

import math
from collections.abc import Sequence

import gmsh
import numpy as np

from geometry import kernel
from geometry.cad.edges import edge_points
from geometry.cad.holes import Hole
from geometry.errors import GeometryError
from geometry.faces import Face
from geometry.frame import basis_across

# Largest distance of the joint from the bore's axis, and from the wall of the bore, over its radius.
_OFF = 0.05


def assumed_cap(faces: Sequence[Face], wall: Hole) -> int:
    """Draw a half ring of the section at the joint, which closes a bore; return its volume tag.

    Parameters
    ----------
    faces
        Of the rod.
    wall
        The wall that is open on one side.

    Raises
    ------
    GeometryError
        The rod has no two plane faces at the open ends of the wall.
    """
    joints = [(face, angle) for face in faces if (angle := _joint_angle(face, wall)) is not None]
    if len(joints) != 2:
        raise GeometryError(
            f"no cap can be assumed: {len(joints)} plane faces, not 2, lie at the open ends of the bore's "
            f"wall ({wall.text()}). Add the cap to the file"
        )
    (face, start), (_, end) = joints
    sweep = (end - start) % (2 * math.pi)
    if _is_covered(wall, start + sweep / 2):  # the other way round
        sweep -= 2 * math.pi
    with kernel.attempt("draw the assumed cap"):
        _, curves = gmsh.model.occ.getCurveLoops(face.tag)
        outer = max(curves, key=_extent)  # the others are bolt holes
        section = gmsh.model.occ.addPlaneSurface([gmsh.model.occ.addCurveLoop([int(tag) for tag in outer])])
        swept = gmsh.model.occ.revolve([(2, section)], *wall.center, *wall.direction, sweep)
        gmsh.model.occ.remove([(2, section)])
        gmsh.model.occ.synchronize()
    return next(int(tag) for dim, tag in swept if dim == kernel.SOLID)


def _extent(curves: Sequence[int]) -> float:
    """Largest extent of a loop of curves, mm."""
    boxes = np.reshape([gmsh.model.occ.getBoundingBox(1, int(tag)) for tag in curves], (-1, 3))
    return float(np.ptp(boxes, axis=0).max())


def _joint_angle(face: Face, wall: Hole) -> float | None:
    """Angle about the axis, rad, at which a face lies that is a joint; None if it is none."""
    if face.shape != "Plane":
        return None
    points = edge_points(face.tag) - wall.center
    points -= (points @ wall.direction)[:, None] * wall.direction
    radius = np.linalg.norm(points, axis=1)
    middle = points.mean(axis=0)
    if np.linalg.norm(middle) < wall.radius / 2:
        return None
    middle /= np.linalg.norm(middle)
    aside = np.abs(points @ np.cross(wall.direction, middle)).max()
    touches = abs(radius.min() / wall.radius - 1) < _OFF
    if aside > _OFF * wall.radius or not touches or np.ptp(radius) < _OFF * wall.radius:
        return None
    x, y = basis_across(wall.direction)
    return math.atan2(float(middle @ y), float(middle @ x))


def _is_covered(wall: Hole, angle: float) -> bool:
    """Whether the middle of the wall lies in a direction about the axis, rather than opposite."""
    x, y = basis_across(wall.direction)
    return bool(wall.moment @ (math.cos(angle) * x + math.sin(angle) * y) > 0)
