"""Shapes and measures of imported solids: planes, cylinders and concave rounds among their faces."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats, vector
from geometry.faces import (
    Face,
    Feature,
    FeatureKind,
    edge_points,
    face_middle,
    faces_of,
    parameter_grid,
    solid_points,
)
from geometry.holes import basis_across
from geometry.mass import MassProperties
from geometry.segments import fitted_circle


class Interior:
    """The inside of volumes; the kernel is asked only for those whose bounding box holds the point."""

    def __init__(self, volumes: Sequence[int]) -> None:
        self.volumes = tuple(volumes)
        boxes = np.reshape([gmsh.model.getBoundingBox(3, volume) for volume in volumes], (-1, 6))
        self._low, self._high = np.hsplit(boxes, 2)

    def contains(self, point: Floats) -> bool:
        """Whether a point lies in any of the volumes."""
        near = ((self._low <= point) & (point <= self._high)).all(axis=1)
        return any(gmsh.model.isInside(3, self.volumes[at], list(point)) for at in np.flatnonzero(near))


# Largest deviation of a face from its cylinder, relative to the radius.
ROUND = 1e-3
# Largest mean component of its normals along the axis, and least spread of the normals of a curved face
# (about a sixth of a right angle).
_ALONG, _SPREAD = 3e-3, 0.07
# Largest height of a plane over its extent.
_FLAT = 1e-6
_SAMPLES = 9  # along each parameter
_KNOWN = ("Plane", "Cylinder", "Torus", "Cone", "Sphere")


def recognised(face: Face) -> Face:
    """Return the face as a plane or cylinder if it has that shape and the kernel does not know it.

    The box of a plane is that of its edges: the kernel's is wider by the tolerance of the file.
    """
    if face.shape == "Plane":
        points = edge_points(face.tag)
        return replace(face, low=vector(points.min(axis=0)), high=vector(points.max(axis=0)))
    if face.shape in _KNOWN:
        return face
    places = parameter_grid(face.tag, np.linspace(0.01, 0.99, _SAMPLES)).ravel()
    points = np.reshape(gmsh.model.getValue(2, face.tag, places), (-1, 3))
    normals = np.reshape(gmsh.model.getNormal(face.tag, places), (-1, 3))
    sound = np.isfinite(normals).all(axis=1) & (np.abs(np.linalg.norm(normals, axis=1) - 1) < 1e-6)
    if sound.sum() < 2 * _SAMPLES:
        return face
    points, normals = points[sound], normals[sound]
    if np.ptp(points @ normals.mean(axis=0)) < _FLAT * np.ptp(points, axis=0).max():
        return recognised(replace(face, shape="Plane", fitted=True))
    values = _fitted_cylinder(points, normals)
    return face if values is None else replace(face, shape="Cylinder", values=values, fitted=True)


def recognised_faces(volumes: Sequence[int]) -> list[Face]:
    """Describe the outer faces of volumes, with the planes and cylinders among them."""
    return [recognised(face) for face in faces_of(volumes)]


# The kernel itself misses the measures of solids whose faces are splines by up to a per cent.

# Nodes of the triangles: three vertices, and the middles of their sides.
_TRIANGLE6 = 9
# Degree of exactness of the quadrature on a triangle; cubic moments of quadratic triangles have more, and are
# integrated to 1e-6 with elements of this size, over the extent, and so many around a circle.
_QUADRATURE = "Gauss8"
_SIZE, _AROUND = 0.05, 24
# Samples along an edge of a face.
_ALONG_EDGE = np.linspace(0.0, 1.0, 129)


def wall_area(face: int, point: Floats, direction: Floats, radius: float) -> tuple[float, Floats]:
    """Area, mm², and centroid (3,) of a face on a cylinder, by an integral along its edges.

    The cylinder's axis goes through a point. By Green's theorem on the unrolled face the area is the integral
    of the height times the radius over the angle; edges along the axis have no part in it.
    """
    x, y = basis_across(direction)
    total, moment = 0.0, np.zeros(3)
    for _, signed in gmsh.model.getBoundary([(2, face)], combined=False, oriented=True):
        edge, sign = abs(signed), math.copysign(1.0, signed)
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
        places = np.reshape(gmsh.model.getValue(1, edge, low + (high - low) * _ALONG_EDGE), (-1, 3)) - point
        height, angle = places @ direction, np.unwrap(np.arctan2(places @ y, places @ x))
        step = sign * radius * np.diff(angle)
        middle = (height[1:] + height[:-1]) / 2
        turn = (angle[1:] + angle[:-1]) / 2
        total += float(step @ middle)
        moment += np.array([
            radius * float(step @ (middle * np.cos(turn))),
            radius * float(step @ (middle * np.sin(turn))),
            float(step @ middle**2) / 2,
        ])  # fmt: skip
    centroid = moment / total
    return abs(total), point + centroid[0] * x + centroid[1] * y + centroid[2] * direction


def triangulated_mass(volume: int) -> MassProperties:
    """Volume, centre and second moments of a volume of the open model, which is not meshed yet.

    By the divergence theorem, from the quadratic triangles of a mesh of its faces, which is cleared again.
    """
    points, normals = _quadrature(volume)
    cell = float((points * normals).sum()) / 3
    center = (points**2 * normals).sum(axis=0) / 2 / cell
    away = points - center
    square = (away**3 * normals).sum(axis=0) / 3
    xy, yz, xz = (
        float((away[:, i] ** 2 * away[:, j] * normals[:, i]).sum()) / 2 for i, j in ((0, 1), (1, 2), (0, 2))
    )
    xx, yy, zz = square.tolist()
    inertia = ((yy + zz, -xy, -xz), (-xy, xx + zz, -yz), (-xz, -yz, xx + yy))
    x, y, z = center.tolist()
    return MassProperties(cell, (x, y, z), inertia)


def _quadrature(volume: int) -> tuple[Floats, Floats]:
    """Points (n, 3) on the boundary, and outward normals (n, 3) there as long as their weights, mm²."""
    faces = gmsh.model.getBoundary([(kernel.SOLID, volume)], combined=False, oriented=False)
    # The other solids may be so much larger that a mesh of theirs with these elements would not end.
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility([(kernel.SOLID, volume)], 1, recursive=True)
    size = _SIZE * float(np.ptp(solid_points(volume), axis=0).max())
    changed = {"MeshOnlyVisible": 1, "MeshSizeMax": size, "MeshSizeFromCurvature": _AROUND}
    kept = {name: gmsh.option.getNumber(f"Mesh.{name}") for name in changed}
    try:
        for name, value in changed.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        with kernel.attempt("mesh the faces of the solid", "Export the rod again, as STEP"):
            gmsh.model.mesh.clear()
            gmsh.model.mesh.generate(2)
            gmsh.model.mesh.setOutwardOrientation(volume)
            gmsh.model.mesh.setOrder(2)
        places, weights = gmsh.model.mesh.getIntegrationPoints(_TRIANGLE6, _QUADRATURE)
        points, normals = [], []
        for _, tag in faces:
            jacobians, _, at = gmsh.model.mesh.getJacobians(_TRIANGLE6, places, tag)
            columns = np.reshape(jacobians, (-1, 3, 3))  # column by column
            area = np.cross(columns[:, 0], columns[:, 1])
            points.append(np.reshape(at, (-1, 3)))
            normals.append(np.tile(weights, len(area) // len(weights))[:, None] * area)
    finally:
        gmsh.model.mesh.clear()
        gmsh.model.setVisibility(gmsh.model.getEntities(), 1)
        for name, value in kept.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
    return np.concatenate(points), np.concatenate(normals)


# Relative difference of areas from which on the kernel's are wrong.
_WRONG = 5e-4


def mismeasured(face: Face) -> bool:
    """Whether the kernel measures a cylinder wrongly, as it does rational splines of few pieces."""
    if not face.fitted or face.shape != "Cylinder":
        return False
    area, _ = wall_area(face.tag, np.array(face.values[:3]), np.array(face.values[3:6]), face.values[6])
    return bool(abs(gmsh.model.occ.getMass(2, face.tag) - area) > _WRONG * area)


def has_mismeasured(volume: int) -> bool:
    """Whether the kernel measures a face of a volume wrongly, and so the volume."""
    return any(mismeasured(face) for face in recognised_faces((volume,)))


def _fitted_cylinder(points: Floats, normals: Floats) -> tuple[float, ...] | None:
    """Axis point (3), direction (3), radius of a cylinder through points with normals (n, 3), or None."""
    size, axes = np.linalg.eigh(normals.T @ normals / len(normals))
    if size[0] > _ALONG**2 or size[1] < _SPREAD**2:
        return None
    direction, across = axes[:, 0], axes[:, 1:]
    middle = points.mean(axis=0)
    places = (points - middle) @ across
    circle = fitted_circle(places)
    if circle is None or float(circle.distance(places).max()) > ROUND * circle.radius:
        return None
    on_axis = middle + across @ circle.center
    return *on_axis.tolist(), *direction.tolist(), circle.radius


# Rounds: concave radii, where stress concentrates and elements must be small.

# Largest difference of the radii of two strips of one round, relatively, and of their normals at the edge.
_SAME_ROUND, _SMOOTH = 0.05, 0.05
# The edge between two strips runs along the round: largest cosine of its angle with the arc.
_MOST_ALONG = 0.5


def _whole_sweeps(rounds: Mapping[int, tuple[float, float]]) -> dict[int, float]:
    """Angle of the arc (rad) that each face of a round belongs to, from the radius (mm) and angle of each.

    Of strips it is at most a quarter turn, or their own angle: two fillets that meet in a groove keep theirs.
    """
    sweeps = {tag: sweep for tag, (_, sweep) in rounds.items()}
    pairs = list(_neighbours(rounds))
    if not pairs:
        return sweeps
    from scipy import sparse  # noqa: PLC0415 - only divided rounds need it

    place = {tag: at for at, tag in enumerate(rounds)}
    sweep = np.array(list(sweeps.values()))
    one, other = np.array([[place[tag] for tag in pair] for pair in pairs]).T
    between = sparse.csr_array(((sweep[one] + sweep[other]) / 2, (one, other)), shape=(len(sweep),) * 2)
    apart = sparse.csgraph.shortest_path(between, directed=False)  # from middle to middle
    arcs = apart + (sweep[:, None] + sweep) / 2
    _, group = sparse.csgraph.connected_components(between, directed=False)
    widest = {int(one): float(arcs[np.ix_(group == one, group == one)].max()) for one in np.unique(group)}
    return {tag: max(sweeps[tag], min(widest[int(group[at])], np.pi / 2)) for tag, at in place.items()}


def _neighbours(rounds: Mapping[int, tuple[float, float]]) -> Iterator[tuple[int, int]]:
    """Pairs of faces of the same radius that go over into each other along an edge across their arc."""
    faces_at: dict[int, list[int]] = {}
    for tag in rounds:
        for _, edge in gmsh.model.getBoundary([(2, tag)], oriented=False):
            faces_at.setdefault(int(edge), []).append(tag)
    for edge, faces in faces_at.items():
        for first, second in combinations(faces, 2):
            radii = rounds[first][0], rounds[second][0]
            if abs(radii[0] - radii[1]) < _SAME_ROUND * min(radii) and _continues(edge, first, second):
                yield first, second


def _continues(edge: int, first: int, second: int) -> bool:
    """Whether two faces have the same normal at the middle of an edge, which runs along the round."""
    (low,), (high,) = gmsh.model.getParametrizationBounds(1, edge)
    middle = [(low + high) / 2]
    along = np.array(gmsh.model.getDerivative(1, edge, middle))
    along /= np.linalg.norm(along)
    places = [gmsh.model.reparametrizeOnSurface(1, edge, middle, face) for face in (first, second)]
    normals = [gmsh.model.getNormal(face, place) for face, place in zip((first, second), places, strict=True)]
    most, least, toward_most, toward_least = gmsh.model.getPrincipalCurvatures(first, places[0])
    arc = toward_most if abs(most[0]) > abs(least[0]) else toward_least
    smooth = np.linalg.norm(np.cross(*normals)) < _SMOOTH
    return bool(smooth and abs(along @ arc) < _MOST_ALONG)


# Sampling steps, in each parameter, over a face whose radius varies.
_STEPS = 8


def concave_rounds(faces: Sequence[Face], length: float) -> Iterator[Feature]:
    """Find outer faces with a concave radius below a quarter of the rod's length; one feature per radius.

    These are cylinders, tori, and blends of varying radius, drafted corners and splines; the radius of the
    latter is the smallest one between neighbouring normals.
    """
    measured = {face.tag: _round(face) for face in faces}
    arcs = {tag: arc for tag, arc in measured.items() if arc is not None and arc[0] < length / 4}
    sweeps = _whole_sweeps(arcs)
    by_radius: dict[float, list[int]] = {}
    for tag, (radius, _) in arcs.items():
        by_radius.setdefault(round(radius, 4), []).append(tag)
    for radius, alike in sorted(by_radius.items()):
        yield Feature(FeatureKind.ROUND, tuple(alike), radius, max(sweeps[tag] for tag in alike))


def _round(face: Face) -> tuple[float, float] | None:
    """Concave radius (mm) and the angle of its arc; None if the face is flat or convex."""
    if face.shape == "Plane":
        return None
    if face.shape not in ("Cylinder", "Torus") or face.fitted:
        return _tightest(face)
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face.tag)
    point, normal = face_middle(face.tag)
    center, axis = np.array(face.values[:3]), np.array(face.values[3:6])
    from_axis = point - center - ((point - center) @ axis) * axis
    if face.shape == "Torus":
        from_axis = point - center - face.values[6] * from_axis / np.linalg.norm(from_axis)
    if not normal @ from_axis < 0:  # gmsh's normals point out of the only volume of a face
        return None
    return face.values[-1], float(u1 - u0 if face.shape == "Cylinder" else v1 - v0)  # v: along a torus's tube


def _tightest(face: Face) -> tuple[float, float] | None:
    """Smallest concave radius along the parameter lines, and the angle by which the normal turns there."""
    steps = np.linspace(0.02, 0.98, _STEPS + 1)  # a cone's tip has no normal
    places = parameter_grid(face.tag, steps)
    flat = places.ravel()
    points = np.reshape(gmsh.model.getValue(2, face.tag, flat), (*places.shape[:2], 3))
    normals = np.reshape(gmsh.model.getNormal(face.tag, flat), points.shape)
    grid = places.reshape(-1, 2).tolist()
    if not any(gmsh.model.isInside(2, face.tag, place, True) for place in grid):  # noqa: FBT003 - gmsh's
        return None
    best: tuple[float, float] | None = None
    for axis in (0, 1):
        along, turning = np.diff(points, axis=axis), np.diff(normals, axis=axis)
        square = np.maximum((along**2).sum(axis=-1), 1e-300)
        curvature = -(along * turning).sum(axis=-1) / square  # normals converge on a hollow face
        at = np.unravel_index(curvature.argmax(), curvature.shape)
        if curvature[at] > 0 and (best is None or 1 / curvature[at] < best[0]):
            turned = np.linalg.norm(turning, axis=-1).sum(axis=axis)[at[1 - axis]]
            best = (float(1 / curvature[at]), float(min(turned / np.ptp(steps), math.pi)))
    return best
