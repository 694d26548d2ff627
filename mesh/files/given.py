"""A mesh from a file in the rod's frame, with its bores named and its cap completed: what can be solved.

A missing cap is joined to the rod as closed surfaces of triangles: the joint faces are taken away, and their
outlines joined to those of the cap, or by a ring of the same section that is swept from one to the other.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from geometry.arrays import Floats, Ints, vector
from geometry.faces import Bore
from geometry.holes import EQUAL_BORES, Diameters, basis_across, place_text, rod_frame
from geometry.imports import (
    CAP_ASSUMED,
    UNITS,
    BoreLocation,
    ImportReport,
    MissingCap,
    RodFile,
    not_a_length,
    plausible_unit,
)
from geometry.surfaces import Surface
from mesh.creases import SurfaceMesh
from mesh.files.bore_pair import MeshHole, Pair, find_bore_pair, fitted_cylinders, open_wall
from mesh.files.reading import crossings, filled, read_tets, require_closed, stl_surface, what_is_wrong
from mesh.files.tets import Mended, mended
from mesh.quality import Quality, measure, scaled_jacobian, with_straight_edges
from mesh.tetmesh import EDGES, MeshError, TetMesh, boundary_facets, numbered

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
    facets: Ints
    angle: float  #: at which it lies about the bore's axis, rad
    middle: Floats  #: (3,)
    normal: Floats  #: (3,) outwards
    outline: Ints  #: vertices, in the sense of the facets
    holes: tuple[Ints, ...]  #: of bolts, likewise


def with_assumed_cap(rod: SurfaceMesh) -> SurfaceMesh | None:
    """Close the big end by a half ring; None if closed. Raises `MeshError`: no two plane joint faces."""
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
    turns = Rotation.from_rotvec(np.outer(np.linspace(0.0, sweep, steps + 1), wall.direction))
    rings = [wall.center + turn.apply(arm) for turn in turns]
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

    Where the outlines of their joint faces have different vertices, a band of width `gap`, of `GAPS`, stands
    between them. Raises `MeshError`: one has no half bore with two joint faces, or these lie apart.
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
    corners = surface.corners[patch]
    middle = np.average(corners.mean(axis=1), axis=0, weights=surface.areas[patch])
    angle = wall.joint_angle(corners.reshape(-1, 3), middle, _OFF)
    if angle is None:
        return None
    loops = _loops(surface.facets[patch])
    loops.sort(key=lambda loop: -float(np.ptp(surface.points[loop], axis=0).max()))
    vector, center = surface.vectors[patch].sum(axis=0), corners.reshape(-1, 3).mean(axis=0)
    normal = vector / np.linalg.norm(vector)
    return _JointFace(patch, angle, center, normal, loops[0], tuple(loops[1:]))


def _loops(facets: Ints) -> list[Ints]:
    """Closed lines of vertices around some facets, in their sense."""
    sides = set(map(tuple, facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()))
    after = {a: b for a, b in sides if (b, a) not in sides}
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
    return np.delete(surface.facets, np.concatenate([face.facets for face in faces]), axis=0)


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
    """Positions (n + 1,) of the vertices along a closed line, from 0 to 1."""
    steps = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def _partners(places: Floats, other: Floats, radius: float) -> Ints | None:
    """Which vertex of another line lies at each of one; None unless they are the same, but alike."""
    apart = np.linalg.norm(places[:, None] - other[None], axis=2)
    corners = max(float(apart.min(axis=axis).max()) for axis in (0, 1))
    sides = [np.roll(line, -1, axis=0) - line for line in (places, other)]
    edges = max(float(np.linalg.norm(side, axis=1).max()) for side in sides)
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


# Root mean square distance of the vertices of a bore from the fitted cylinder, over its radius. A pressure
# that varies around the bore is meaningless on a rougher one.
_ROUGHEST = 0.01
_SAME_BORE = 5e-3  # relative difference up to which radii count as equal
_ROUGH = 1e-3  # from here on a note says so
_BONDED = "rod and cap are bonded at the joint"
# Below this extent a rod cannot be meant in millimetres.
_LEAST_EXTENT = 3.0


@dataclass(frozen=True)
class GivenMesh:
    """A mesh from a file, ready to be solved."""

    mesh: TetMesh  #: placed in the rod's frame; every boundary facet is on a bore or free
    bores: tuple[Bore, Bore]  #: of the big and the small end
    size: float  #: mean length of the elements' edges, mm
    quality: Quality  #: of the elements
    imported: ImportReport  #: where the bores are in the file, in millimetres, and what was mended or assumed


def given_mesh(file: RodFile) -> GivenMesh:
    """Read a rod's mesh, check it, find its bores and place it in the rod's frame.

    Raises `MeshError`: the file is damaged, its mesh cannot be used, or its bores cannot be
    identified; `OSError` and `ImportError`: see `mesh.files.reading.read_tets`.
    """
    notes: tuple[str, ...] = ()
    try:
        sound, notes = _read(file)
        extent = float(np.ptp(sound.mesh.points, axis=0).max())
        scale = file.unit or ("m" if extent < _LEAST_EXTENT else "mm")
        given = _measured(sound, scale, file)
        usual = file.unit or plausible_unit(given.bores[1].x, scale)
        if usual != scale:
            given = _measured(sound, usual, file)
    except MeshError as error:
        named = str(error).startswith((str(file.path), str(file.cap)))
        raise MeshError(str(error) if named else f"{file.path}: {error}") from error
    if why := not_a_length(given.bores[1].x, usual):
        raise MeshError(f"{file.path}: {why}")
    if file.unit is None and usual != "mm":
        why = "because in mm the rod would have an unusual length (rod.unit)"
        notes = (f"the unit of length of the mesh is taken to be {usual}, {why}", *notes)
    return replace(given, imported=replace(given.imported, assumed=(*notes, *given.imported.assumed)))


def _read(file: RodFile) -> tuple[Mended, tuple[str, ...]]:
    path, cap = file.path, file.cap
    if cap is MissingCap.REFUSED and path.suffix.lower() != ".stl":
        return mended(read_tets(path)), ()
    surface, sound = _surface(path)
    bodies = [part for part in shells(surface) if part.volume > 0]
    if isinstance(cap, Path):
        return _joined(surface, _surface(cap)[0]), (_BONDED,)
    if len(bodies) == 2 and open_wall(bodies[0]) is not None:
        return _joined(*bodies), (_BONDED,)
    if len(bodies) > 1:
        places = ", ".join(place_text(body.center) for body in bodies[:3])
        remedy = "Export the rod alone, and a cap to another file (rod.cap)"
        raise MeshError(
            what_is_wrong(surface, "")
            if len(crossings(surface))
            else f"it holds {len(bodies)} separate bodies, the largest around {places}: only a rod whose "
            f"largest bore is open and its cap can be joined. {remedy}"
        )
    completed = with_assumed_cap(surface) if cap is MissingCap.ASSUMED else None
    if completed is None:
        if not any(file.diameters):
            find_bore_pair(surface)  # refused before its inside is meshed
        return sound or mended(filled(surface)), ()
    require_closed(completed)
    return mended(filled(completed)), (CAP_ASSUMED,)


def _joined(rod: SurfaceMesh, cap: SurfaceMesh) -> Mended:
    """Mesh rod and cap as one body; where gmsh cannot follow a narrow band between them, a wider one."""
    for gap in GAPS:
        completed = with_cap(rod, cap, gap)
        require_closed(completed)
        try:
            return mended(filled(completed))
        except MeshError as error:
            failed = error
    raise failed


def _surface(path: Path) -> tuple[SurfaceMesh, Mended | None]:
    if path.suffix.lower() == ".stl":
        return stl_surface(path), None
    sound = mended(read_tets(path))
    return SurfaceMesh(sound.mesh.points, boundary_facets(sound.mesh.tets)[:, :3]), sound


def _measured(sound: Mended, unit: str, file: RodFile) -> GivenMesh:
    scaled = replace(sound.mesh, points=UNITS[unit] * sound.mesh.points)
    mesh, curved = with_straight_edges(scaled)
    inverted = np.flatnonzero(scaled_jacobian(mesh) <= 0)
    if inverted.size:
        place = place_text(mesh.points[mesh.tets[inverted[0], :4]].mean(axis=0))
        raise MeshError(
            f"{inverted.size} elements are folded over and could not be mended; the first is around "
            f"{place}. Mesh the rod again"
        )
    facets = boundary_facets(mesh.tets)
    surface = SurfaceMesh(mesh.points, facets[:, :3])
    pair = find_bore_pair(surface, file.diameters)
    guessed = pair[0].same_radius(pair[1].radius, _SAME_BORE) and not (file.swap_ends or any(file.diameters))
    pair = pair[::-1] if file.swap_ends else pair
    placed, bores, residual = _placed(mesh, surface, pair)
    whole = replace(placed, facets=_named(facets, pair))
    rough = f"the bores are cylinders to {100 * residual:.2g} % of their radius"
    equal = [EQUAL_BORES] if guessed else []
    assumed = [*equal, *sound.notes, *([rough] if residual > _ROUGH else [])]
    boundaries = surface.patches(np.ones(len(facets), dtype=bool), math.inf)
    if len(boundaries) > 1:
        least = min(boundaries, key=len)
        assumed.append(
            f"the mesh has {len(boundaries) - 1} closed cavities inside, the smallest with {len(least)} "
            f"facets around {place_text(surface.corners[least].reshape(-1, 3).mean(axis=0))} of the file: is "
            "an element missing?"
        )
    big, small = (
        BoreLocation(2 * bore.radius, vector(hole.center), bore.width)
        for hole, bore in zip(pair, bores, strict=True)
    )
    imported = ImportReport(unit, (), (big, small), tuple(assumed))
    return GivenMesh(numbered(whole)[0], bores, mean_edge(placed), measure(whole, curved), imported)


def named_mesh(mesh: TetMesh, diameters: Diameters) -> tuple[TetMesh, tuple[Bore, Bore]]:
    """Find the bores of a run's mesh, and name its surfaces. Raises `MeshError`: it has no such bores."""
    facets = boundary_facets(mesh.tets)
    surface = SurfaceMesh(mesh.points, facets[:, :3])
    pair = find_bore_pair(surface, diameters)
    if pair[0].center[0] > pair[1].center[0]:
        pair = pair[::-1]
    _, bores, _ = _placed(mesh, surface, pair)
    return replace(mesh, facets=_named(facets, pair)), bores


def _placed(mesh: TetMesh, surface: SurfaceMesh, pair: Pair) -> tuple[TetMesh, tuple[Bore, Bore], float]:
    """Put a mesh in the rod's frame; also the bores, and the residual of the cylinders fitted to them."""
    clouds = [surface.points[np.unique(surface.facets[bore.facets])] for bore in pair]
    axes = fitted_cylinders(clouds, pair[0].direction)
    if axes.residual > _ROUGHEST:
        raise MeshError(
            f"its bores are not round: their vertices are off the fitted cylinders by "
            f"{100 * axes.residual:.2g} % of the radius (root mean square); at most {100 * _ROUGHEST:g} % "
            "are allowed"
        )
    z = axes.direction
    heights = [surface.corners[bore.facets] @ z for bore in pair]
    middles = [(height.min() + height.max()) / 2 for height in heights]
    big, small = (c + (m - c @ z) * z for c, m in zip(axes.centers, middles, strict=True))
    turn, length = rod_frame(z, small - big)
    placed = replace(mesh, points=(mesh.points - big) @ turn.T)
    big_radius, small_radius = axes.radii.tolist()
    width, _ = _width(((surface.corners - big) @ turn.T)[pair[0].facets], big_radius)
    widths = _width(((surface.corners - small) @ turn.T)[pair[1].facets], small_radius)
    return placed, (Bore(0.0, big_radius, width), Bore(length, small_radius, *widths)), axes.residual


def _width(corners: Floats, radius: float) -> tuple[float, float]:
    """Mean width of a wall and its taper (see `Bore`), from its corners (n, 3, 3) about the bore's centre."""
    angle = np.arctan2(corners[..., 1], corners[..., 0])
    unrolled = angle[:, :1] + (angle - angle[:, :1] + np.pi) % (2 * np.pi) - np.pi
    spans, rises = unrolled[:, 1:] - unrolled[:, :1], corners[:, 1:, 2] - corners[:, :1, 2]
    areas = radius * np.abs(spans[:, 0] * rises[:, 1] - spans[:, 1] * rises[:, 0]) / 2
    around = np.cos(unrolled).mean(axis=1)
    return float(areas.sum() / (2 * np.pi * radius)), float(areas @ around / (np.pi * radius))


def _named(facets: Ints, pair: Pair) -> dict[Surface, Ints]:
    big, small = (bore.facets for bore in pair)
    free = np.delete(facets, np.concatenate([big, small]), axis=0)
    return {Surface.BIG_END_BORE: facets[big], Surface.SMALL_END_BORE: facets[small], Surface.FREE: free}


def mean_edge(mesh: TetMesh) -> float:
    """Mean length of the elements' straight edges, mm."""
    ends = mesh.points[mesh.tets[:, EDGES]]
    return float(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean())
