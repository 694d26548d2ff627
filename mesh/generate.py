"""Mesh the solid in the open gmsh session, and mesh it again with other settings where that fails.

If gmsh fails or makes elements that the mesh checks reject, settings at the faulty places are changed. On a
curved face one or two elements wide, gmsh's frontal surface mesher may leave triangles that span half of it
and cut through the solid and through each other. MeshAdapt, which splits and swaps edges (Geuzaine & Remacle
2009), avoids them, though its triangles are worse elsewhere. Smaller elements help too.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints, vector
from geometry.bodies import Body, draw
from geometry.holes import place_text
from geometry.session import GmshLog, session
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.creases import SurfaceMesh
from mesh.quality import Quality, measure, scaled_jacobian, with_straight_edges
from mesh.sizing import Refinement, RefinementBall, SizeField, Sizing, apply
from mesh.tetmesh import FROM_GMSH, MeshError, TetMesh, numbered, outward

_MESH_ADAPT, _DELAUNAY = 1, 5  # gmsh's numbers
_SURFACE, _CURVE = 2, 1
_ENDS = 2  # of an edge
_SAME = 1e-9  # of the elements' length
_FOLD = np.radians(125.0)  # triangles of one face that turn by more overlap; three around a hole turn by 120°


@dataclass(frozen=True)
class Repair:
    """Settings that differ from those of the first attempt."""

    faces: frozenset[int] = frozenset()  #: gmsh's tags of the faces that MeshAdapt meshes
    balls: tuple[RefinementBall, ...] = ()  #: places with smaller elements
    causes: tuple[str, ...] = ()  #: what was wrong before each attempt, in words
    folded: frozenset[int] = frozenset()  #: gmsh's tags of the faces that Delaunay meshes

    def __add__(self, other: "Repair") -> "Repair":
        faces, folded = self.faces | other.faces, self.folded | other.folded
        return Repair(faces, self.balls + other.balls, self.causes + other.causes, folded)

    @property
    def size(self) -> float | None:
        """Smallest edge length requested, mm; None without balls."""
        return min((ball.size for ball in self.balls), default=None)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for the user; empty if nothing was repaired."""
        if not self.causes:
            return ()
        meshers = ("MeshAdapt", self.faces), ("Delaunay", self.folded)
        what = [f"the {name} mesher on {len(faces)} faces" for name, faces in meshers if faces]
        what += [] if self.size is None else [f"elements down to {self.size:.2g} mm at the faulty places"]
        return (f"the mesh was made again with {' and '.join(what)}, because {'; then '.join(self.causes)}",)

    def prepare(self) -> None:
        """Remove the previous mesh from the open model, and choose the mesher of its faces."""
        gmsh.model.mesh.clear()
        for view in gmsh.view.getTags():
            gmsh.view.remove(view)
        for field in gmsh.model.mesh.field.list():
            gmsh.model.mesh.field.remove(field)
        for mesher, faces in ((_MESH_ADAPT, self.faces), (_DELAUNAY, self.folded)):
            for face in sorted(faces):
                gmsh.model.mesh.setAlgorithm(_SURFACE, face, mesher)


NOTHING = Repair()


class UnsoundMeshError(MeshError):
    """No usable mesh could be made, but the settings `repair` may help."""

    def __init__(self, message: str, repair: Repair) -> None:
        super().__init__(message, repair)  # both, or a copy from another process would lack one
        self.repair = repair

    def __str__(self) -> str:
        return str(self.args[0])


def of_crossing(message: str) -> MeshError:
    """Return the error of a surface mesh that crosses itself, with its places if gmsh reports them."""
    faces = {tag for dimension, tag in gmsh.model.mesh.getLastEntityError() if dimension == _SURFACE}
    places = []
    for node in gmsh.model.mesh.getLastNodeError():
        place, _, dimension, tag = gmsh.model.mesh.getNode(node)
        places.append(place)
        if dimension == _SURFACE:
            faces.add(tag)
        elif dimension == _CURVE:
            faces.update(map(int, gmsh.model.getAdjacencies(_CURVE, tag)[0]))
    if not faces:
        return MeshError(message)
    where = f" near {place_text(np.mean(places, axis=0))} mm" if places else ""
    return UnsoundMeshError(
        message, Repair(frozenset(faces), (), (f"triangles of the surface mesh crossed each other{where}",))
    )


def of_elements(corners: Floats, what: str) -> Repair:
    """Repair the mesh of the open model around elements (n, 4, 3), mm; `what` is wrong with them."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - only a mesh that is repaired needs it

    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    centers = corners.mean(axis=1)
    balls = tuple(
        RefinementBall(vector(center), float(length) / 2, float(length) / 3)
        for center, length in zip(centers, longest, strict=True)
    )
    faces = set()  # those that have an edge of an element
    for _, tag in gmsh.model.getEntities(_SURFACE):
        _, places, _ = gmsh.model.mesh.getNodes(_SURFACE, tag, includeBoundary=True)
        distance, _ = KDTree(places.reshape(-1, 3)).query(corners)
        if ((distance < _SAME * longest.min()).sum(axis=1) >= _ENDS).any():
            faces.add(tag)
    return Repair(frozenset(faces), balls, (f"{what} near {place_text(centers[0])} mm",))


def of_folds() -> Repair | None:
    """Repair the faces of the open model whose triangles are folded over each other; None without such.

    The stress there is wrong, and its error bar wide. gmsh's frontal mesher and MeshAdapt fold alike on long
    narrow rounds, its Delaunay mesher does not.
    """
    tags, places, _ = gmsh.model.mesh.getNodes()
    number, folded = np.zeros(int(tags.max()) + 1, dtype=np.int64), set[int]()
    number[tags] = np.arange(len(tags))
    for _, face in gmsh.model.getEntities(_SURFACE):
        for elements, nodes in zip(*gmsh.model.mesh.getElements(_SURFACE, face)[1:], strict=True):
            surface = SurfaceMesh(places.reshape(-1, 3), number[nodes.reshape(len(elements), -1)[:, :3]])
            if (surface.hinges(np.arange(len(elements)))[2] < np.cos(_FOLD)).any():
                folded.add(face)
    cause = "triangles of the surface mesh were folded over each other"
    return Repair(causes=(cause,), folded=frozenset(folded)) if folded else None


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

    `surfaces` are gmsh's face tags per named surface, `parts` the volume tags of each of several parts. At
    every point the smallest size `wanted` by earlier solutions applies. Edges of inverted elements are
    straightened, with `keep_bow` as in `mesh.quality.with_straight_edges`. Raises `MeshError`: gmsh failed,
    or inverted elements could not be repaired; an `UnsoundMeshError` if other settings may help.
    """
    repair.prepare()
    apply(sizing, refinements, wanted, repair.balls)
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
    mesh, straightened = with_straight_edges(
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
    used, local = np.unique(tets, return_inverse=True)

    def facets(faces: Sequence[int]) -> Ints:
        blocks = [gmsh.model.mesh.getElementsByType(_TRIANGLE[order], face)[1] for face in faces]
        nodes = place[np.concatenate(blocks)] if blocks else np.empty(0, dtype=np.int64)
        return np.searchsorted(used, nodes).reshape(-1, 3 * order)

    return TetMesh(
        coordinates.reshape(-1, 3)[used],
        local.reshape(tets.shape),
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


# Each round costs another mesh; most repairs that succeed at all take one.
MAX_ROUNDS = 4


@dataclass(frozen=True)
class Meshed:
    """A mesh and how it was made."""

    #: mesh, quality: the repaired mesh and its quality
    mesh: TetMesh
    quality: Quality
    repair: Repair  #: settings that differ from those of the first attempt
    warnings: tuple[str, ...]  #: warnings of gmsh about this mesh


def repaired(
    attempt: Callable[..., tuple[TetMesh, Quality]],
    flaws: Callable[[TetMesh, Quality], Repair | None],
    log: GmshLog,
    tell: Callable[[str], None],
    repair: Repair = NOTHING,
) -> Meshed:
    """Mesh the open model; after a failure or with flaws, mesh it again with the changes they call for.

    `attempt` meshes it with the settings ``repair=``, at first those of an earlier mesh. `flaws` returns the
    changes; None for a sound mesh. If every attempt has flaws, the first mesh is returned, whose checks will
    fail. `tell` is called with the cause of each new attempt. Raises `MeshError`: the first failure, where no
    attempt produced a mesh.
    """
    first, failure = None, None
    for rounds in count():
        begin = len(log.lines)
        try:
            mesh, quality = attempt(repair=repair)
        except MeshError as error:
            failure = failure or error
            more = error.repair if isinstance(error, UnsoundMeshError) else None
        else:
            meshed = Meshed(mesh, quality, repair, log.warnings(begin))
            more = flaws(mesh, quality)
            if more is None or not (more.balls or more.faces - repair.faces or more.folded - repair.folded):
                return meshed
            first = first or meshed
        if more is None or rounds == MAX_ROUNDS:
            break
        repair += more
        tell(more.causes[0])
    if first is not None:
        return first
    if failure is not None and not rounds:
        raise failure
    tries = f"{rounds} further attempts with other settings at the faulty places failed too"
    raise MeshError(f"{failure} ({tries})")


@dataclass(frozen=True)
class LocalSize:
    """Smaller elements on a surface."""

    size: float  #: edge length on it, mm
    reach: float = 0.0  #: distance from the surface's edges within which the size stays, mm


def mesh_body(
    body: Body,
    size: float,
    *,
    order: int = 2,
    fine: Mapping[Surface, LocalSize] | None = None,
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
