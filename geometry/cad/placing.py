"""Imported solids, placed in the rod's frame, cut at their mirror planes and made to share faces."""

from collections.abc import Sequence

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.cad.bores import CadHole
from geometry.cad.shapes import ROUND
from geometry.errors import GeometryError
from geometry.faces import Bore, edge_points, parameter_grid
from geometry.holes import rod_frame
from geometry.mass import joined
from geometry.parts import boundary, remove_all
from geometry.solid import Part, whole_mass
from geometry.surfaces import PLANE_AXIS, Mirror

# Of the rod's length: for areas and centres, and for points on the edges, which lie a few micrometres beside
# their faces in the files of some programs.
_SLACK, _BESIDE = 1e-5, 3e-5
# Places along each parameter of a curved face at which it is compared with its mirror image.
_WITHIN = np.linspace(0.05, 0.95, 5)


def smallest_cell(volumes: Sequence[int], length: float) -> Mirror:
    """Return the smallest symmetry cell of volumes in the rod's frame; tolerances scale with its length."""
    solids = [_faces(volume) for volume in volumes]
    # Every solid must be its own image; two that mirror each other may have different materials.
    if not all(_is_mirrored(faces, 2, length) for faces in solids):
        return Mirror.NONE
    return Mirror.QUARTER if all(_is_mirrored(faces, 1, length) for faces in solids) else Mirror.HALF


def cut_to(volumes: Sequence[int], mirror: Mirror, length: float) -> list[list[int]]:
    """Cut every volume to a cell; return what each became.

    Raises `GeometryError`: a volume lies outside the cell.
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
        raise GeometryError('a part of the solid lies outside the symmetry cell. Use symmetry = "none"')
    return kept


# Faces of one solid: tags, areas and centres (n, 4), and points (n_points, 3) on each and its edges.
_Faces = tuple[list[int], Floats, list[Floats]]


def _faces(volume: int) -> _Faces:
    occ = gmsh.model.occ
    tags = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], combined=False, oriented=False)]
    measures = np.array([[occ.getMass(2, tag), *occ.getCenterOfMass(2, tag)] for tag in tags])
    return tags, measures, [np.concatenate([edge_points(tag), _within(tag)]) for tag in tags]


def _within(face: int) -> Floats:
    """Points (n, 3) of a curved face between its edges; a plane is known by its edges."""
    if gmsh.model.getType(2, face) == "Plane":
        return np.zeros((0, 3))
    grid = parameter_grid(face, _WITHIN).reshape(-1, 2)
    on = [place for place in grid if gmsh.model.isInside(2, face, list(place), True)]  # noqa: FBT003 - gmsh's
    if not on:
        return np.zeros((0, 3))
    return np.reshape(gmsh.model.getValue(2, face, np.ravel(on)), (-1, 3))


def _is_mirrored(faces: _Faces, axis: int, length: float) -> bool:
    """Whether every face has an image about the plane normal to `axis`.

    The image must have the same area and centre, which is cheap to test, and contain the images of points on
    the face and its edges: a non-circular hole may be turned about its own axis, and a wall may bulge above
    the plane as far as it is hollow below.
    """
    tags, measures, points_of = faces
    scale = np.array([length**2, length, length, length])
    image = measures.copy()
    image[:, 1 + axis] *= -1
    alike = (np.abs(image[:, None] - measures[None]) / scale).max(axis=2) < _SLACK
    for points, row in zip(points_of, alike, strict=True):
        mirrored = points * np.where(np.arange(3) == axis, -1.0, 1.0)
        for other in np.flatnonzero(row):
            nearest, _ = gmsh.model.getClosestPoint(2, tags[other], mirrored.ravel())
            if np.abs(np.reshape(nearest, (-1, 3)) - mirrored).max(initial=0.0) < _BESIDE * length:
                break
        else:
            return False
    return True


def placed(volumes: Sequence[int], big: CadHole, small: CadHole) -> tuple[Bore, Bore]:
    """Move the solid so that the big-end bore is the origin, x leads to the small end, z along the pins."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 - only imported solids need it

    frame, length = rod_frame(big.direction, small.center - big.center)
    turn = Rotation.from_matrix(frame).as_rotvec()
    angle = float(np.linalg.norm(turn))
    solids = [(kernel.SOLID, tag) for tag in volumes]
    with kernel.attempt("place the solid in the rod's frame"):
        gmsh.model.occ.translate(solids, *(-big.center))
        if angle > 1e-12:
            gmsh.model.occ.rotate(solids, 0, 0, 0, *(turn / angle), angle)
        gmsh.model.occ.synchronize()
    return (
        Bore(0.0, big.radius, big.mean_width, slack=_slack(big)),
        Bore(length, small.radius, small.mean_width, small.taper(frame[0]), slack=_slack(small)),
    )


def _slack(hole: CadHole) -> float:
    """By how much the faces of a bore may differ from its cylinder, mm; 0 where all are the same cylinder."""
    exact = hole.deviation < 1e-6 * hole.radius and not hole.fitted
    return 0.0 if exact else 2 * (hole.deviation + ROUND * hole.radius)


Entity = tuple[int, int]


def parts_of(cells: Sequence[Sequence[int]], names: Sequence[str], mirror: Mirror) -> tuple[Part, ...]:
    """Name the volumes of each part and compute its mass properties."""
    distinct = [
        name if names.count(name) == 1 else f"{name} {names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
    return tuple(
        Part(name, tuple(cell), joined([whole_mass(tag, mirror) for tag in cell]))
        for name, cell in zip(distinct, cells, strict=True)
    )


def sharing(
    cells: Sequence[Sequence[int]], names: Sequence[str], borders: Sequence[Entity] = ()
) -> list[list[int]]:
    """Let touching solids share their faces; return the volumes that each became.

    `cells` are the volume tags of each solid. `borders` are faces whose edges become edges of the solids'
    faces; they are used up. Raises `GeometryError`: solids overlap, or one touches no other.
    """
    volumes = [list(cell) for cell in cells]
    if sum(map(len, volumes)) > 1 or borders:
        every = [(kernel.SOLID, tag) for cell in volumes for tag in cell]
        with kernel.attempt("join the parts at their common faces"):
            _, pieces = gmsh.model.occ.fragment(every, list(borders))
        became = {
            tag: [piece for _, piece in made]
            for (_, tag), made in zip(every, pieces[: len(every)], strict=True)
        }
        volumes = [[piece for tag in cell for piece in became[tag]] for cell in volumes]
        every_piece = [piece for cell in volumes for piece in cell]
        if len(set(every_piece)) < len(every_piece):
            raise GeometryError(
                f"the solids {', '.join(names)} overlap; they may only touch. Correct them in the CAD "
                "program, or keep only some of them with rod.solids"
            )
        remove_all({piece for made in pieces[len(every) :] for piece in made})
    gmsh.model.occ.synchronize()
    faces = [boundary(cell) for cell in volumes]
    joined, loose = [0], list(range(1, len(volumes)))
    while touching := [one for one in loose if any(faces[one] & faces[other] for other in joined)]:
        joined += touching
        loose = [one for one in loose if one not in touching]
    if loose:
        gap, one, other = min(
            (gmsh.model.occ.getDistance(kernel.SOLID, a, kernel.SOLID, b)[0], one, other)
            for one in loose
            for other in joined
            for a in volumes[one]
            for b in volumes[other]
        )
        raise GeometryError(
            f"the solids {names[one]} and {names[other]} do not touch (gap {gap:.3g} mm), so they cannot be "
            "bonded to each other. Close the gap in the CAD program, or keep only solids that touch with "
            "rod.solids"
        )
    return volumes
