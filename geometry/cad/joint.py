"""The joint of rod and cap of an imported assembly: a set of faces near a plane."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.cad.holes import CadHole
from geometry.errors import GeometryError
from geometry.faces import Face, edge_points, parameter_grid
from geometry.holes import basis_across
from geometry.parts import boundary

# A plane lies farther from the big end's centre than this part of the bore's radius only by mistake; faces
# of serrations and fractures lie within this part of it from their mean plane.
_OFF, _ROUGH = 0.5, 0.2


@dataclass(frozen=True, eq=False)
class Joint:
    """The mean plane of the faces that rod and cap share."""

    normal: Floats  #: unit vector (3,) from the cap to the rod
    offset: float  #: distance of the plane from the big end's centre along the normal, mm
    area: float  #: of the faces, mm²
    flatness: float  #: distance of the two planes parallel to it that enclose the faces' edges, mm
    faces: int  #: how many there are

    @property
    def angle(self) -> float:
        """Of the normal in the plane of motion from +x, degrees."""
        return float(np.degrees(np.arctan2(self.normal[1], self.normal[0]))) + 0.0

    def text(self) -> str:
        """Say where it is."""
        plane = "plane" if self.flatness < 1e-3 else f"within {self.flatness:.3g} mm of a plane"
        turned = "straight" if abs(self.angle) < 0.05 else f"oblique by {self.angle:.4g}°"
        off = f", {self.offset:+.3g} mm from the big end's centre" if abs(self.offset) > 5e-4 else ""
        return f"joint: {turned}{off}, {self.area:.4g} mm² on {self.faces} faces, {plane}"


def joint_of(rod: Sequence[int], cap: Sequence[int], radius: float) -> Joint:
    """Find the joint of a rod and a cap (volume tags, without shells) at a bore of some radius, mm.

    Raises `GeometryError`: they share no face, or the faces are no joint through the bore.
    """
    faces = sorted(boundary(rod) & boundary(cap))
    if not faces:
        gap = min(gmsh.model.occ.getDistance(kernel.SOLID, a, kernel.SOLID, b)[0] for a in rod for b in cap)
        raise GeometryError(
            f"rod and cap do not touch (gap {gap:.3g} mm), so there is no joint. Close the gap in the CAD "
            "program"
        )
    points = np.concatenate([edge_points(face) for face in faces])
    areas = np.array([gmsh.model.occ.getMass(2, face) for face in faces])
    normal = _normal(faces, points, areas)
    away = np.mean([gmsh.model.occ.getCenterOfMass(3, tag) for tag in cap], axis=0) - points.mean(axis=0)
    normal = -normal if normal @ away > 0 else normal
    height = points @ normal
    middles = np.array([gmsh.model.occ.getCenterOfMass(2, face) for face in faces])
    joint = Joint(
        normal + 0.0,
        float(areas @ (middles @ normal) / areas.sum()),
        float(areas.sum()),
        float(np.ptp(height)),
        len(faces),
    )
    if abs(joint.normal[2]) > 1e-3 or joint.flatness > _ROUGH * radius or abs(joint.offset) > _OFF * radius:
        raise GeometryError(
            f"the faces that rod and cap share are no joint across the big end: their mean normal is "
            f"({', '.join(f'{value:.3g}' for value in joint.normal)}) in the rod's frame (x to the small "
            f"end, z along the pins), {joint.offset:.3g} mm from the bore's centre, and they lie within "
            f"{joint.flatness:.3g} mm of a plane. Name the solids that belong to the rod with rod.solids"
        )
    return joint


def _normal(faces: Sequence[int], points: Floats, areas: Floats) -> Floats:
    """Mean normal (3,) of faces that roughly lie in a plane, whichever way each is oriented."""
    rough = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    total = np.zeros(3)
    for face, area in zip(faces, areas, strict=True):
        places = parameter_grid(face, np.linspace(0.1, 0.9, 5)).ravel()
        normals = np.reshape(gmsh.model.getNormal(face, places), (-1, 3))
        mean = normals.mean(axis=0)
        total += area * mean * np.sign(mean @ rough)
    return np.asarray(total / np.linalg.norm(total))


# Largest distance of the joint from the bore's axis, and from the wall of the bore, over its radius.
_CAP_OFF = 0.05


def assumed_cap(faces: Sequence[Face], wall: CadHole) -> int:
    """Draw a half ring of the section at the joint, which closes a wall open on one side; its volume tag.

    Raises `GeometryError`: the rod has no two plane faces at the open ends of the wall.
    """
    planes = [(face, edge_points(face.tag)) for face in faces if face.shape == "Plane"]
    angles = [(face, wall.joint_angle(at, at.mean(axis=0), _CAP_OFF)) for face, at in planes]
    joints = [(face, angle) for face, angle in angles if angle is not None]
    if len(joints) != 2:
        raise GeometryError(
            f"no cap can be assumed: {len(joints)} plane faces, not 2, lie at the open ends of the bore's "
            f"wall ({wall.text()}). Add the cap to the file"
        )
    (face, start), (_, end) = joints
    sweep = (end - start) % (2 * math.pi)
    x, y = basis_across(wall.direction)
    middle = math.cos(start + sweep / 2) * x + math.sin(start + sweep / 2) * y
    if wall.moment @ middle > 0:  # the wall lies there: the other way round
        sweep -= 2 * math.pi
    occ = gmsh.model.occ
    with kernel.attempt("draw the assumed cap"):
        _, curves = occ.getCurveLoops(face.tag)
        boxes = [[occ.getBoundingBox(1, int(tag)) for tag in loop] for loop in curves]
        extents = [np.ptp(np.reshape(box, (-1, 3)), axis=0).max() for box in boxes]
        outer = curves[int(np.argmax(extents))]  # the others are bolt holes
        section = occ.addPlaneSurface([occ.addCurveLoop([int(tag) for tag in outer])])
        swept = occ.revolve([(2, section)], *wall.center, *wall.direction, sweep)
        occ.remove([(2, section)])
        occ.synchronize()
    return next(int(tag) for dim, tag in swept if dim == kernel.SOLID)
