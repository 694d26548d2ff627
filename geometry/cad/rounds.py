"""Concave radii of an imported solid, where stress concentrates and elements must be small."""

import math
from collections.abc import Iterator, Sequence

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.interior import Interior
from geometry.cad.strips import whole_sweeps
from geometry.faces import Face, Feature, FeatureKind

# Sampling steps, in each parameter, over a face whose radius varies.
_STEPS = 8


def concave_rounds(faces: Sequence[Face], interior: Interior, length: float) -> Iterator[Feature]:
    """Find faces with a concave radius below a quarter of the rod's length; one feature per radius.

    These are cylinders, tori, and blends of varying radius, drafted corners and splines; the radius of the
    latter is the smallest one found from neighbouring normals.
    """
    measured = {face.tag: _round(face, interior) for face in faces}
    found = {tag: arc for tag, arc in measured.items() if arc is not None and arc[0] < length / 4}
    sweeps = whole_sweeps(found)
    by_radius: dict[float, list[int]] = {}
    for tag, (radius, _) in found.items():
        by_radius.setdefault(round(radius, 4), []).append(tag)
    for radius, alike in sorted(by_radius.items()):
        yield Feature(FeatureKind.ROUND, tuple(alike), radius, max(sweeps[tag] for tag in alike))


def _round(face: Face, interior: Interior) -> tuple[float, float] | None:
    """Concave radius (mm) and the angle of its arc; None if the face is flat or convex."""
    if face.shape == "Plane":
        return None
    if face.shape in ("Cylinder", "Torus") and not face.fitted:
        return (face.values[-1], _sweep(face)) if _is_concave(face, interior) else None
    return _tightest(face, interior)


def _sweep(face: Face) -> float:
    """Angle of the arc: the first parameter of a cylinder, the second of a torus."""
    low, high = gmsh.model.getParametrizationBounds(2, face.tag)
    which = 0 if face.shape == "Cylinder" else 1
    return float(high[which] - low[which])


def _is_concave(face: Face, interior: Interior) -> bool:
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
    return not interior.contains(point - 1e-3 * radius * outwards)


def _tightest(face: Face, interior: Interior) -> tuple[float, float] | None:
    """Smallest concave radius along the parameter lines, and the angle by which the normal turns there."""
    low, high = gmsh.model.getParametrizationBounds(2, face.tag)
    steps = np.linspace(0.02, 0.98, _STEPS + 1)  # a cone's tip has no normal
    u, v = (a + (b - a) * steps for a, b in zip(low, high, strict=True))
    places = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    flat = places.ravel()
    points = np.reshape(gmsh.model.getValue(2, face.tag, flat), (*places.shape[:2], 3))
    normals = np.reshape(gmsh.model.getNormal(face.tag, flat), points.shape)
    on = next((at for at in np.ndindex(points.shape[:2]) if _is_on(face, places[at])), None)
    if on is None:
        return None
    reach = 1e-3 * float(np.ptp(points.reshape(-1, 3), axis=0).max())
    outwards = -1 if interior.contains(points[on] + reach * normals[on]) else 1
    best: tuple[float, float] | None = None
    for axis in (0, 1):
        along, turning = np.diff(points, axis=axis), outwards * np.diff(normals, axis=axis)
        square = np.maximum((along**2).sum(axis=-1), 1e-300)
        curvature = -(along * turning).sum(axis=-1) / square  # normals converge on a hollow face
        at = np.unravel_index(curvature.argmax(), curvature.shape)
        if curvature[at] > 0 and (best is None or 1 / curvature[at] < best[0]):
            turned = np.linalg.norm(turning, axis=-1).sum(axis=axis)[at[1 - axis]]
            best = (float(1 / curvature[at]), float(min(turned / np.ptp(steps), math.pi)))
    return best


def _is_on(face: Face, place: Floats) -> bool:
    """Whether a point of the underlying surface lies within the face."""
    return bool(gmsh.model.isInside(2, face.tag, list(place), True))  # noqa: FBT003 - gmsh's own order
