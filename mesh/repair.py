"""Changed settings for meshing again, if gmsh failed or made elements that the mesh checks reject.

On a curved face one or two elements wide, gmsh's frontal surface mesher may leave triangles that span half
the face and cut through the solid and through each other. MeshAdapt, which splits and swaps edges (Geuzaine
& Remacle 2009), avoids them, though its triangles are worse elsewhere. Smaller elements help too, because
shorter edges are less curved.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import gmsh
import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import Floats, vector
from geometry.session import GmshLog
from mesh.quality import Quality
from mesh.sizing import Spot
from mesh.surface_mesh import SurfaceMesh
from mesh.tetmesh import MeshError, TetMesh

_MESH_ADAPT, _DELAUNAY = 1, 5  # gmsh's numbers
_SURFACE, _CURVE = 2, 1
_ENDS = 2  # of an edge
_SAME = 1e-9  # of the elements' length
_FOLD = np.radians(125.0)  # triangles of one face that turn by more overlap; three around a hole turn by 120°


@dataclass(frozen=True)
class Repair:
    """Settings that differ from those of the first attempt."""

    faces: frozenset[int] = frozenset()  #: gmsh's tags of the faces that MeshAdapt meshes
    spots: tuple[Spot, ...] = ()  #: places with smaller elements
    causes: tuple[str, ...] = ()  #: what was wrong before each attempt, in words
    folded: frozenset[int] = frozenset()  #: gmsh's tags of the faces that Delaunay meshes

    def __add__(self, other: "Repair") -> "Repair":
        faces, folded = self.faces | other.faces, self.folded | other.folded
        return Repair(faces, self.spots + other.spots, self.causes + other.causes, folded)

    @property
    def size(self) -> float | None:
        """Smallest edge length requested, mm; None without spots."""
        return min((spot.size for spot in self.spots), default=None)

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
    where = f" near {_place(np.mean(places, axis=0))}" if places else ""
    return UnsoundMeshError(
        message, Repair(frozenset(faces), (), (f"triangles of the surface mesh crossed each other{where}",))
    )


def of_elements(corners: Floats, what: str) -> Repair:
    """Repair the mesh of the open model around elements (n, 4, 3), mm; `what` is wrong with them."""
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    centers = corners.mean(axis=1)
    spots = tuple(
        Spot(vector(center), float(length) / 2, float(length) / 3)
        for center, length in zip(centers, longest, strict=True)
    )
    faces = set()  # those that have an edge of an element
    for _, tag in gmsh.model.getEntities(_SURFACE):
        _, places, _ = gmsh.model.mesh.getNodes(_SURFACE, tag, includeBoundary=True)
        distance, _ = KDTree(places.reshape(-1, 3)).query(corners)
        if ((distance < _SAME * longest.min()).sum(axis=1) >= _ENDS).any():
            faces.add(tag)
    return Repair(frozenset(faces), spots, (f"{what} near {_place(centers[0])}",))


def of_folds() -> Repair | None:
    """Repair the faces of the open model whose triangles are folded over each other; None without such.

    The stress there is wrong, and its error bar wide. gmsh's frontal mesher and MeshAdapt fold alike on long
    narrow rounds, its Delaunay mesher does not.
    """
    tags, places, _ = gmsh.model.mesh.getNodes()
    number, folded = np.zeros(int(tags.max()) + 1, dtype=np.int64), set[int]()
    number[tags] = np.arange(len(tags))
    for _, face in gmsh.model.getEntities(_SURFACE):
        for own, nodes in zip(*gmsh.model.mesh.getElements(_SURFACE, face)[1:], strict=True):
            surface = SurfaceMesh(places.reshape(-1, 3), number[nodes.reshape(len(own), -1)[:, :3]])
            if (surface.hinges(np.arange(len(own)))[2] < np.cos(_FOLD)).any():
                folded.add(face)
    cause = "triangles of the surface mesh were folded over each other"
    return Repair(causes=(cause,), folded=frozenset(folded)) if folded else None


def _place(point: Floats) -> str:
    x, y, z = point
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


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

    `attempt` meshes it with the changed settings that it is given as ``repair=``; `repair` is what an earlier
    mesh of the model needed, to begin with. `flaws` returns the changes; None for a sound mesh. If every
    attempt has flaws, the first mesh is returned, and the checks of the run will fail on it. `tell` is called
    with the cause of each new attempt. Raises `MeshError`: no attempt produced a mesh; this is the first
    failure.
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
            if more is None or not (more.spots or more.faces - repair.faces or more.folded - repair.folded):
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
