"""Concave radii of a solid of unknown make: where stress gathers, and elements must be small."""

from collections.abc import Iterator, Sequence

import gmsh
import numpy as np

from geometry.faces import Face, Feature, FeatureKind
from geometry.holes import inside


def concave_rounds(faces: Sequence[Face], volumes: Sequence[int], length: float) -> Iterator[Feature]:
    """Find cylinders and tori with a concave radius below a quarter of the rod's length."""
    by_radius: dict[float, list[Face]] = {}
    for face in faces:
        curved = face.shape in ("Cylinder", "Torus") and face.values[-1] < length / 4
        if curved and _is_concave(face, volumes):
            by_radius.setdefault(round(face.values[-1], 4), []).append(face)
    for radius, alike in sorted(by_radius.items()):
        tags = tuple(face.tag for face in alike)
        yield Feature(FeatureKind.ROUND, tags, radius, max(map(_sweep, alike)))


def _sweep(face: Face) -> float:
    """Angle of the arc: the first parameter of a cylinder, the second of a torus."""
    low, high = gmsh.model.getParametrizationBounds(2, face.tag)
    which = 0 if face.shape == "Cylinder" else 1
    return float(high[which] - low[which])


def _is_concave(face: Face, volumes: Sequence[int]) -> bool:
    """Whether the space on the side of the arc's centre is free."""
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face.tag)
    middle = [(u0 + u1) / 2, (v0 + v1) / 2]
    point = np.array(gmsh.model.getValue(2, face.tag, middle))
    normal = np.array(gmsh.model.getNormal(face.tag, middle))
    center, axis, radius = np.array(face.values[:3]), np.array(face.values[3:6]), face.values[-1]
    from_axis = point - center - ((point - center) @ axis) * axis
    if face.shape == "Torus":
        from_axis = point - center - face.values[6] * from_axis / np.linalg.norm(from_axis)
    outwards = normal * np.sign(normal @ from_axis)
    return not inside(point - 1e-3 * radius * outwards, volumes)
