"""The volume inside a closed surface of triangles, meshed by gmsh, or what is wrong with the surface."""

import math

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints, Mask
from geometry.holes import place_text
from geometry.session import session
from mesh.files.tets import OF_GMSH, TetFile, tet_file
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import FROM_GMSH, MeshError

# Length of the body over the size of the elements: the surface is made of flat triangles, so that smaller
# elements would follow those rather than the solid.
PER_LENGTH = 70
# Angle at which the surface is divided into faces.
_FACE_ANGLE = math.radians(35.0)
_SHOWN = 3  # places in a message
_TOUCH = 1e-9  # share of a side up to which triangles touch and do not cross
_REPAIR = "Repair the surface (FreeCAD: Mesh, Analyze, Evaluate and repair), or better export the rod as STEP"


def tets_of_model() -> TetFile:
    """Nodes and tetrahedra of the open model; `MeshError` if there are none, or other solid elements too."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    ids = tags[order].astype(np.int64)
    blocks = []
    for number, kind in OF_GMSH.items():
        elements, nodes = gmsh.model.mesh.getElementsByType(number)
        if len(elements):
            rows = np.searchsorted(ids, nodes.astype(np.int64)).reshape(len(elements), -1)
            ours = rows[:, FROM_GMSH[2]] if kind == "tetra10" else rows
            blocks.append((kind, ours, elements.astype(np.int64)))
    return tet_file(coordinates.reshape(-1, 3)[order], blocks)


def filled(surface: SurfaceMesh) -> TetFile:
    """Mesh the volume inside a surface with straight-sided ten-node tetrahedra, in a gmsh session of its own.

    Raises `MeshError`: the surface cuts itself, or gmsh cannot mesh its inside.
    """
    used, local = np.unique(surface.facets, return_inverse=True)
    with session():
        try:
            gmsh.model.addDiscreteEntity(2, 1)
            gmsh.model.mesh.addNodes(2, 1, np.arange(1, len(used) + 1), surface.points[used].ravel())
            gmsh.model.mesh.addElementsByType(1, 2, [], local.ravel() + 1)
            gmsh.model.mesh.classifySurfaces(_FACE_ANGLE, True, True, math.pi)  # noqa: FBT003 - gmsh's order
            gmsh.model.mesh.createGeometry()
            faces = [tag for _, tag in gmsh.model.getEntities(2)]
            gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(faces)])
            gmsh.model.geo.synchronize()
            size = float(np.ptp(surface.points[used], axis=0).max()) / PER_LENGTH
            for name in ("MeshSizeMin", "MeshSizeMax"):
                gmsh.option.setNumber(f"Mesh.{name}", size)
            gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
            gmsh.model.mesh.generate(3)
            gmsh.model.mesh.setOrder(2)
        except Exception as error:  # gmsh raises nothing more specific
            raise MeshError(_what_is_wrong(surface, str(error))) from error
        return tets_of_model()


def require_closed(surface: SurfaceMesh) -> None:
    """Refuse a surface with holes, or with sides of more than two triangles."""
    sides = np.sort(surface.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends, uses = np.unique(sides, axis=0, return_counts=True)
    wrong = ends[uses != 2]
    if len(wrong) and (uses % 2 == 0).all() and len(crossings(surface)):
        raise MeshError(_what_is_wrong(surface, ""))
    if len(wrong) and (uses % 2 == 0).all():
        raise MeshError(
            f"bodies touch in its surface: {len(wrong)} sides belong to four triangles, "
            f"{_around(surface.points[wrong].mean(axis=1))}. Export rod and cap to a file each (rod.cap), or "
            "the rod as STEP"
        )
    if len(wrong):
        raise MeshError(
            f"its surface is not closed: {len(wrong)} sides do not belong to exactly two triangles, "
            f"{_around(surface.points[wrong].mean(axis=1))}. {_REPAIR}"
        )


def _what_is_wrong(surface: SurfaceMesh, error: str) -> str:
    pairs = crossings(surface)
    if not len(pairs):
        return f"the inside of its surface could not be meshed ({error}). {_REPAIR}"
    places = surface.corners[pairs[:, 0]].mean(axis=1)
    count = f"{len(pairs)} pairs of triangles" if len(pairs) > 1 else "a pair of triangles"
    return f"its surface cuts itself: {count} cross each other, {_around(places)}. {_REPAIR}"


def _around(places: Floats) -> str:
    listed = ", ".join(place_text(place) for place in places[:_SHOWN])
    return f"around {listed}{' and elsewhere' if len(places) > _SHOWN else ''}"


def crossings(surface: SurfaceMesh) -> Ints:
    """Return the pairs (n, 2) of facets that cross and share no vertex."""
    corners = surface.corners
    low, high = corners.min(axis=1), corners.max(axis=1)
    axis = int(np.ptp(surface.points[surface.facets.ravel()], axis=0).argmax())
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    ends = np.searchsorted(low[:, axis], high[:, axis], side="right")
    rows = [np.empty((0, 2), dtype=np.int64)]
    for k in range(len(order)):
        near = slice(k + 1, ends[k])
        meet = ((low[near] <= high[k]) & (high[near] >= low[k])).all(axis=1)
        others = k + 1 + np.flatnonzero(meet)
        rows.append(np.column_stack([np.full(len(others), k), others]))
    pairs = order[np.concatenate(rows)]
    one, other = surface.facets[pairs[:, 0]], surface.facets[pairs[:, 1]]
    pairs = pairs[~(one[:, :, None] == other[:, None, :]).any(axis=(1, 2))]
    first, second = corners[pairs[:, 0]], corners[pairs[:, 1]]
    return np.asarray(pairs[_pierces(first, second) | _pierces(second, first)])


def _pierces(one: Floats, other: Floats) -> Mask:
    """Whether a side of each of some triangles (n, 3, 3) passes through another (Möller & Trumbore 1997)."""
    along, up = other[:, 1] - other[:, 0], other[:, 2] - other[:, 0]
    through = np.zeros(len(one), dtype=bool)
    for k in range(3):
        start, ray = one[:, k], one[:, (k + 1) % 3] - one[:, k]
        across = np.cross(ray, up)
        volume = (along * across).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            arm = start - other[:, 0]
            u = (arm * across).sum(axis=1) / volume
            turned = np.cross(arm, along)
            v, t = (ray * turned).sum(axis=1) / volume, (up * turned).sum(axis=1) / volume
            inside = (np.minimum(u, v) > _TOUCH) & (u + v < 1 - _TOUCH)
            through |= inside & (t > _TOUCH) & (t < 1 - _TOUCH)
    return np.asarray(through)
