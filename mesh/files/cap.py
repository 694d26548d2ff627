"""A rod without its cap as a closed surface of triangles: the cap from its own surface, or an assumed one.

The joint faces are taken away, and their outlines joined: to those of the cap, or by a ring of the same
section that is swept from one to the other. What comes out is one closed surface.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.holes import basis_across, place_text
from mesh.files.bore_pair import MeshHole, open_wall
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import MeshError

# Angle, rad, by which triangles of a joint face turn at most; lengths over the radius of the bore: how far a
# joint face may be from the bore's axis and wall, and two faces of a joint from each other; up to where
# vertices of two outlines are one.
_FLAT = math.radians(3.0)
_OFF, _APART, _SAME = 0.06, 0.05, 1e-3
GAPS = (2e-3, 4e-3, 8e-3)  # over the radius, by which outlines of different vertices are moved apart
# Outlines differ by this at most, over the radius; steps of a swept ring, rad.
_OUTLINE, _STEP = 0.35, math.radians(5.0)
_LEAD = 'Give the cap (cap = "cap.stl", --cap cap.stl), or cap = "assumed"; best is the solid as STEP'


@dataclass(frozen=True)
class _JointFace:
    """A joint face of a half bore."""

    facets: Ints
    angle: float  #: at which it lies about the bore's axis, rad
    middle: Floats  #: (3,)
    normal: Floats  #: (3,) outwards
    outline: Ints  #: vertices, in the sense of the facets
    holes: tuple[Ints, ...]  #: of bolts, likewise


def with_assumed_cap(rod: SurfaceMesh) -> SurfaceMesh | None:
    """Close the big end by a half ring of the section at the joint; None for a rod whose bores are closed.

    Raises `MeshError`: the bore has no two plane joint faces.
    """
    wall = open_wall(rod)
    if wall is None:
        return None
    first, last = _joint_faces(rod, wall, "rod")
    sweep = (last.angle - first.angle) % (2 * math.pi)
    x, y = basis_across(wall.direction)
    arms = rod.corners[wall.facets].reshape(-1, 3).mean(axis=0) - wall.center
    if (math.atan2(float(arms @ y), float(arms @ x)) - first.angle) % (2 * math.pi) < sweep:
        sweep -= 2 * math.pi
    steps = max(8, math.ceil(abs(sweep) / _STEP))
    arm = rod.points[first.outline] - wall.center
    rings = [wall.center + _turned(arm, wall.direction, sweep * k / steps) for k in range(steps + 1)]
    count, size = len(rod.points), len(arm)
    numbers = [first.outline, *(count + size * k + np.arange(size) for k in range(steps - 1))]
    facets = [_kept(rod, [first, last])]
    for one, other in pairwise(numbers):
        after, beyond = np.roll(one, -1), np.roll(other, -1)
        facets += [np.column_stack([one, after, beyond]), np.column_stack([one, beyond, other])]
    facets.append(_band(numbers[-1], rings[-1], last.outline, rod.points[last.outline]))
    closed = SurfaceMesh(np.concatenate([rod.points, *rings[1:-1]]), np.concatenate(facets))
    return _filled(closed, [*first.holes, *last.holes])


def with_cap(rod: SurfaceMesh, cap: SurfaceMesh, gap: float = GAPS[0]) -> SurfaceMesh:
    """Join the surface of a rod and that of its cap, which lie as they are assembled.

    `gap`, of `GAPS`: where the outlines of their joint faces have different vertices, a band of this width
    stands between them. Raises `MeshError`: one of them has no half bore with two joint faces, or these do
    not lie on each other.
    """
    wall = open_wall(rod)
    if wall is None:
        raise MeshError("a cap is given, but the largest bore of the rod is closed: leave rod.cap out")
    of_rod, of_cap = _joint_faces(rod, wall, "rod"), _joint_faces(cap, wall, "cap")
    near, far = (np.linalg.norm(of_rod[0].middle - face.middle) for face in of_cap)
    pairs = list(zip(of_rod, of_cap if near < far else of_cap[::-1], strict=True))
    for one, other in pairs:
        off, facing = abs(float((other.middle - one.middle) @ one.normal)), float(one.normal @ other.normal)
        if off > _APART * wall.radius or facing > -0.99:
            what = f"is {off:.3g} away from it" if facing < 0 else "faces the same way"
            raise MeshError(
                f"the cap does not lie on the rod's joint at {place_text(one.middle)}, but {what}. Export "
                "both in the coordinates of the assembly"
            )
    count = len(rod.points)
    number = np.arange(count + len(cap.points))
    apart = False  # whether a narrow band stands between outlines of different vertices
    facets = [_kept(rod, of_rod), count + _kept(cap, of_cap)]
    open_holes: list[Ints] = []
    for one, other in pairs:
        loops = [(one.outline, other.outline)]
        left = list(other.holes)
        for hole in one.holes:
            middle = rod.points[hole].mean(axis=0)
            away = [np.linalg.norm(middle - cap.points[each].mean(axis=0)) for each in left]
            at = next((at for at, distance in enumerate(away) if distance < _OFF * wall.radius), None)
            if at is not None:
                loops.append((hole, left.pop(at)))
            else:
                open_holes.append(hole)
        open_holes += [count + each for each in left]
        for mine, its in loops:
            partner = _partners(rod.points[mine], cap.points[its], wall.radius)
            if partner is None:
                apart = True
                facets.append(_band(mine, rod.points[mine], count + its, cap.points[its]))
            else:
                number[count + its[partner]] = mine
    moved = cap.points + (gap * wall.radius * of_rod[0].normal if apart else 0.0)
    joined = SurfaceMesh(np.concatenate([rod.points, moved]), number[np.concatenate(facets)])
    return _filled(joined, open_holes)


def shells(surface: SurfaceMesh) -> list[SurfaceMesh]:
    """Return the closed parts of a surface, the largest volume first."""
    parts = surface.patches(np.ones(len(surface.facets), dtype=bool), math.inf)
    made = [SurfaceMesh(surface.points, surface.facets[part]) for part in parts]
    return sorted(made, key=lambda part: -abs(part.volume))


def _joint_faces(surface: SurfaceMesh, wall: MeshHole, what: str) -> tuple[_JointFace, _JointFace]:
    patches = surface.patches(np.ones(len(surface.facets), dtype=bool), _FLAT)
    faces = [face for patch in patches if (face := _joint_face(surface, patch, wall)) is not None]
    if len(faces) != 2:
        raise MeshError(
            f"the {what} has {len(faces)} plane faces, not 2, at the open ends of the bore ({wall.text()}): "
            f"no cap can be joined to it. {_LEAD}"
        )
    return faces[0], faces[1]


def _joint_face(surface: SurfaceMesh, patch: Ints, wall: MeshHole) -> _JointFace | None:
    """Return a patch as a joint face; None if it is none."""
    corners = surface.corners[patch]
    middle = np.average(corners.mean(axis=1), axis=0, weights=surface.areas[patch])
    angle = wall.joint_angle(corners.reshape(-1, 3), middle, _OFF)
    if angle is None:
        return None
    loops = _loops(surface.facets[patch])
    loops.sort(key=lambda loop: -float(np.ptp(surface.points[loop], axis=0).max()))
    vector = surface.vectors[patch].sum(axis=0)
    return _JointFace(
        patch,
        angle,
        corners.reshape(-1, 3).mean(axis=0),
        vector / np.linalg.norm(vector),
        loops[0],
        tuple(loops[1:]),
    )


def _loops(facets: Ints) -> list[Ints]:
    """Closed lines of vertices around some facets, in their sense."""
    sides = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    known = {(int(a), int(b)) for a, b in sides}
    after = {a: b for a, b in known if (b, a) not in known}
    loops = []
    while after:
        start, place = next(iter(after.items()))
        loop = [start]
        del after[start]
        while place in after:
            loop.append(place)
            place = after.pop(place)
        loops.append(np.array(loop, dtype=np.int64))
    return loops


def _kept(surface: SurfaceMesh, faces: Sequence[_JointFace]) -> Ints:
    keep = np.ones(len(surface.facets), dtype=bool)
    for face in faces:
        keep[face.facets] = False
    return surface.facets[keep]


def _turned(arms: Floats, axis: Floats, angle: float) -> Floats:
    """Turn vectors (n, 3) about a unit vector (Rodrigues)."""
    along = (arms @ axis)[:, None] * axis
    across = np.cross(axis, arms)
    return np.asarray(along + math.cos(angle) * (arms - along) + math.sin(angle) * across)


def _band(one: Ints, places: Floats, other: Ints, other_places: Floats) -> Ints:
    """Triangles between two closed lines that run against each other, by where they are along them."""
    back, its = other[::-1], other_places[::-1]
    start = int(np.linalg.norm(its - places[0], axis=1).argmin())
    back, its = np.roll(back, -start), np.roll(its, -start, axis=0)
    here, there = _share(places), _share(its)
    made, i, j = [], 0, 0
    while i < len(one) or j < len(back):
        a, b = one[i % len(one)], back[j % len(back)]
        if j == len(back) or (i < len(one) and here[i + 1] <= there[j + 1]):
            made.append((a, one[(i + 1) % len(one)], b))
            i += 1
        else:
            made.append((a, back[(j + 1) % len(back)], b))
            j += 1
    return np.array(made, dtype=np.int64)


def _share(places: Floats) -> Floats:
    """How far along a closed line its vertices are (n + 1,), from 0 to 1."""
    steps = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def _partners(places: Floats, other: Floats, radius: float) -> Ints | None:
    """Which vertex of another line lies at each of one; None unless they are the same, but alike."""
    apart = np.linalg.norm(places[:, None] - other[None], axis=2)
    corners = max(float(apart.min(axis=axis).max()) for axis in (0, 1))
    edges = max(
        float(np.linalg.norm(np.roll(each, -1, axis=0) - each, axis=1).max()) for each in (places, other)
    )
    if corners > _OUTLINE * radius + edges / 2:
        raise MeshError(
            f"the outlines of rod and cap at the joint differ by {corners:.3g}. Join the two in the CAD "
            "program, and export one surface, or STEP"
        )
    partner = apart.argmin(axis=1)
    same = len(places) == len(other) and apart.min(axis=1).max() < _SAME * radius
    return np.asarray(partner) if same and len(np.unique(partner)) == len(partner) else None


def _filled(surface: SurfaceMesh, holes: Sequence[Ints]) -> SurfaceMesh:
    """Close bolt holes at the joint, each by a fan around its middle."""
    points, facets = [surface.points], [surface.facets]
    for number, hole in enumerate(holes):
        points.append(surface.points[hole].mean(axis=0)[None])
        middle = np.full(len(hole), len(surface.points) + number)
        facets.append(np.column_stack([hole, np.roll(hole, -1), middle]))
    return SurfaceMesh(np.concatenate(points), np.concatenate(facets))
