"""Mesh the solid in the open gmsh session and return the mesh as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import gmsh
import numpy as np

from geometry.arrays import Ints
from geometry.bodies import Body, draw
from geometry.session import session
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.quality import Quality, measure, mended, scaled_jacobian
from mesh.repair import NOTHING, Repair, UnsoundMeshError, of_crossing, of_elements
from mesh.sizing import Refinement, SizeField, Sizing, apply
from mesh.tetmesh import FROM_GMSH, MeshError, TetMesh, numbered, outward

_ON_ERROR, _STOP = "General.AbortOnError", 1  # stop meshing without throwing
_TET = {1: 4, 2: 11}  # gmsh's element types
_TRIANGLE = {1: 2, 2: 9}


def tetrahedralise(
    surfaces: Mapping[Surface, Sequence[int]],
    refinements: Sequence[Refinement],
    sizing: Sizing,
    parts: Sequence[Sequence[int]] = (),
    wanted: Sequence[SizeField] = (),
    *,
    keep_bow: bool = False,
    repair: Repair = NOTHING,
) -> tuple[TetMesh, Quality]:
    """Mesh every volume of the open model, and measure the quality of the mesh.

    `surfaces` are gmsh's face tags per named surface, `parts` the volume tags of each part, if there are
    several. At every point the smallest size `wanted` by earlier solutions applies. Elements that raising the
    order had inverted are mended, with `keep_bow` as `mesh.quality.mended` does; nodes stand in the order of
    `mesh.tetmesh`. Raises `MeshError`: gmsh failed, or inverted elements could not be repaired; an
    `UnsoundMeshError` if other settings may help.
    """
    repair.prepare()
    apply(sizing, refinements, wanted, repair.spots)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)  # Delaunay: with one thread, the same mesh every time
    throwing = gmsh.option.getNumber(_ON_ERROR)
    gmsh.option.setNumber(_ON_ERROR, _STOP)
    failed = f"gmsh could not mesh the solid at size {sizing.size:g} mm"
    remedy = "Try a smaller --size"
    try:
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber(_ON_ERROR, throwing)
        complaint = gmsh.logger.getLastError()
        if not complaint:
            gmsh.model.mesh.setOrder(sizing.order)
    except Exception as error:  # gmsh raises nothing more specific
        raise MeshError(f"{failed}: {error}. {remedy}") from error
    if complaint:
        raise of_crossing(f"{failed}: {complaint}. {remedy}")
    mesh, straightened = mended(
        snapped(outward(mesh_of_model(surfaces, sizing.order, parts))), keep_bow=keep_bow
    )
    quality = measure(mesh, straightened)
    if not quality.least_scaled_jacobian > 0:
        inverted = mesh.points[mesh.tets[scaled_jacobian(mesh) <= 0, :4]]
        more = of_elements(inverted, "elements were inverted")
        message = (
            f"{more.causes[0]} and could not be repaired: the smallest scaled Jacobian is "
            f"{quality.least_scaled_jacobian:.3g} and must exceed 0. Try a smaller --size"
        )
        raise UnsoundMeshError(message, more)
    return numbered(mesh)[0], quality


def mesh_of_model(
    surfaces: Mapping[Surface, Sequence[int]], order: int, parts: Sequence[Sequence[int]] = ()
) -> TetMesh:
    """Return the mesh of the open model; facets may point inwards. Raises `MeshError`: no tetrahedra."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    part: Ints | None = None
    if len(parts) < 2:
        tet_nodes = gmsh.model.mesh.getElementsByType(_TET[order])[1]
    else:
        blocks = [gmsh.model.mesh.getElementsByType(_TET[order], tag)[1] for tags in parts for tag in tags]
        numbers = [number for number, volumes in enumerate(parts) for _ in volumes]
        tet_nodes = np.concatenate(blocks)
        part = np.repeat(numbers, [nodes.size // len(FROM_GMSH[order]) for nodes in blocks])
    if not len(tet_nodes):
        raise MeshError("gmsh made no tetrahedra. Try a smaller --size")
    place = np.empty(int(tags.max()) + 1, dtype=np.int64)
    place[tags] = np.arange(tags.size)
    tets = place[tet_nodes].reshape(-1, len(FROM_GMSH[order]))[:, FROM_GMSH[order]]
    used = np.unique(tets)
    compact = np.full(tags.size, -1)
    compact[used] = np.arange(used.size)

    def facets(faces: Sequence[int]) -> Ints:
        blocks = [gmsh.model.mesh.getElementsByType(_TRIANGLE[order], face)[1] for face in faces]
        nodes = place[np.concatenate(blocks)] if blocks else np.empty(0, dtype=np.int64)
        return np.asarray(compact[nodes].reshape(-1, 3 * order))

    return TetMesh(
        coordinates.reshape(-1, 3)[used],
        compact[tets],
        {surface: facets(faces) for surface, faces in surfaces.items() if len(faces)},
        part,
    )


def snapped(mesh: TetMesh) -> TetMesh:
    """Put the nodes of the cut planes exactly on them, so that reflections share them."""
    points = mesh.points.copy()
    for plane, axis in PLANE_AXIS.items():
        if plane in mesh.facets:
            points[mesh.facets[plane].ravel(), axis] = 0.0
    return replace(mesh, points=points)


@dataclass(frozen=True)
class Fine:
    """Smaller elements on a surface."""

    size: float  #: edge length on it, mm
    reach: float = 0.0  #: distance from the surface's edges within which the size stays, mm


def mesh_body(
    body: Body,
    size: float,
    *,
    order: int = 2,
    fine: Mapping[Surface, Fine] | None = None,
    growth: float = 0.4,
) -> TetMesh:
    """Draw and mesh a body in a gmsh session of its own.

    `size` is the edge length away from the surfaces `fine`, mm, from which it grows per distance by `growth`.
    Raises `GeometryError` and `MeshError`: no solid or no usable mesh could be made.
    """
    with session():
        faces = draw(body)
        finer = (fine or {}).items()
        refinements = [Refinement(faces[surface], each.size, 4 * each.reach) for surface, each in finer]
        mesh, _ = tetrahedralise(faces, refinements, Sizing(size, order, growth))
    return mesh
