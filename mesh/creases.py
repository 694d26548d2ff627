"""The boundary of a mesh as flat triangles, and the creases of the solid: edges where its surface turns.

Which edges are sharp is read from the faces of the solid, and so depends neither on the size of the elements
nor on how the solid was put together.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints, Mask, linked_groups, twins
from geometry.surfaces import INTERFACES, PLANE_AXIS, Surface
from mesh.tetmesh import FACET_EDGES, TetMesh

# Angle up to which two facets lie on each other, rad.
_TWIN = 1e-6


@dataclass(frozen=True)
class SurfaceMesh:
    """Boundary triangles, by the vertices of the facets."""

    points: Floats  #: (n_nodes, 3), mm
    facets: Ints  #: (n, 3) vertices, anticlockwise from outside

    @cached_property
    def corners(self) -> Floats:
        """(n, 3, 3) mm."""
        return np.asarray(self.points[self.facets])

    @cached_property
    def vectors(self) -> Floats:
        """(n, 3) outward normals as long as the areas, mm²."""
        corners = self.corners
        return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2)

    @cached_property
    def areas(self) -> Floats:
        """(n,) mm²."""
        return np.asarray(np.linalg.norm(self.vectors, axis=1))

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) outward unit normals."""
        return np.asarray(self.vectors / np.maximum(self.areas, 1e-300)[:, None])

    @property
    def volume(self) -> float:
        """Enclosed volume, mm³, by the divergence theorem."""
        return float((self.corners.mean(axis=1) * self.vectors).sum() / 3)

    @property
    def center(self) -> Floats:
        """Centre of gravity (3,) of the enclosed volume, mm."""
        corners = self.corners
        pairs = corners + np.roll(corners, 1, axis=1)
        square = (pairs**2).sum(axis=1) / 12  # ∫x² over a triangle, per area
        return np.asarray((square * self.vectors).sum(axis=0) / (2 * self.volume))

    def hinges(self, facets: Ints) -> tuple[Ints, Ints, Floats]:
        """Pairs of facets (n,) with an edge in common, and the cosines of the angles by which they turn."""
        edges = np.sort(self.facets[facets][:, FACET_EDGES], axis=2).reshape(-1, 2)
        one, other = (side // 3 for side in twins(edges[:, 0] * len(self.points) + edges[:, 1]))
        return one, other, (self.normals[facets[one]] * self.normals[facets[other]]).sum(axis=1)

    def patches(self, chosen: Mask, sharpest: float) -> list[Ints]:
        """Groups of facets (n,) joined by edges at which they turn by less, rad; from π on by every edge."""
        facets = np.flatnonzero(chosen)
        one, other, cosines = self.hinges(facets)
        smooth = cosines > (np.cos(sharpest) if sharpest < np.pi else -np.inf)
        label = linked_groups(len(facets), one[smooth], other[smooth])
        by_label = np.argsort(label, kind="stable")
        starts = np.flatnonzero(np.diff(label[by_label])) + 1
        return [facets[group] for group in np.split(by_label, starts)]


def apart(surface: SurfaceMesh) -> SurfaceMesh:
    """Give bodies that have sides in common nodes of their own.

    Of the four facets at such a side, those belong together that are next to each other through material.
    """
    sides = surface.facets[:, FACET_EDGES].reshape(-1, 2)
    _, which, uses = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.ravel(), kind="stable")
    of_side = np.split(order // 3, np.cumsum(uses)[:-1])
    links = [rows for rows in of_side if len(rows) == 2]
    for number in np.flatnonzero(uses == 4):
        links += _through_material(surface, of_side[number], *sides[order[np.cumsum(uses)[number] - 1]])
    body = linked_groups(len(surface.facets), *np.array(links, dtype=np.int64).reshape(-1, 2).T)
    count = len(surface.points)
    keys, facets = np.unique(body[:, None] * count + surface.facets, return_inverse=True)
    return SurfaceMesh(surface.points[keys % count], facets.reshape(-1, 3))


def _through_material(surface: SurfaceMesh, rows: Ints, start: int, end: int) -> list[Ints]:
    """Pairs of facets at a side, each with the next one through the material behind it."""
    along = surface.points[end] - surface.points[start]
    along = along / np.linalg.norm(along)
    arms = surface.corners[rows].mean(axis=1) - surface.points[start]
    arms -= np.outer(arms @ along, along)
    forwards = (np.cross(along, arms) * surface.normals[rows]).sum(axis=1) > 0
    pairs = []
    for facet in np.flatnonzero(forwards):
        arm, normal = arms[facet], surface.normals[rows[facet]]
        turned = np.arctan2(-arms @ normal, arms @ arm / np.linalg.norm(arm))
        turned = np.where(forwards, np.inf, (turned - _TWIN) % (2 * np.pi))  # one that lies on it comes last
        pairs.append(rows[[facet, turned.argmin()]])
    return pairs


# The surface is folded at a crease by more than this; at a smaller angle stress hardly rises (as r^-0.25
# at 30°), and CAD programs leave such edges where faces were meant to be tangent.
LEAST_FOLD = math.radians(30.0)
# Cosine beyond which a direction counts as that of an axis.
_ALONG = 1 - 1e-6
_LINES = {1: 1, 2: 8}  # gmsh's element types


@dataclass(frozen=True)
class Creases:
    """Edges of the mesh that lie on creases of the solid."""

    nodes: Ints  #: (n, 2) the vertices at their ends
    #: (n,) angle between the tangent planes of the two faces there, rad, at most π/2. Which way they face is
    #: not told by them (normals flip where a face is singular) but by the elements.
    fold: Floats
    label: Ints  #: (n,) number of the crease each belongs to
    between: tuple[tuple[str, str], ...]  #: per crease, the two faces that meet there, in words
    #: (n_nodes,) where the mesh consists of images, the original of each node, by which `nodes` count
    source: Ints | None = None

    def on(self, source: Ints) -> "Creases":
        """Return the creases for a mesh of images: `source` (n_nodes,) is the original of each node."""
        return replace(self, source=source)

    def find(self, ends: Ints) -> Ints:
        """Number (n,) of the crease edge between each two nodes (n, 2) of the mesh; −1 without one."""
        if not len(self.nodes):
            return np.full(len(ends), -1)
        ends = ends if self.source is None else self.source[ends]
        most = int(max(self.nodes.max(), ends.max(initial=0))) + 1
        keys = self.nodes.min(axis=1) * most + self.nodes.max(axis=1)
        wanted = ends.min(axis=1) * most + ends.max(axis=1)
        order = np.argsort(keys)
        at = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
        return np.where(keys[order][at] == wanted, order[at], -1)


def creases(
    surfaces: Mapping[Surface, Sequence[int]], mesh: TetMesh, bodies: Sequence[Sequence[int]] = ()
) -> Creases:
    """Find the creases of the open model, which has been meshed; the mesh may be numbered differently.

    `surfaces` are gmsh's face tags of outer faces and mirror planes. `bodies` are the volume tags of each
    body, if there are several that only touch: the faces between them are outer faces of both.
    """
    axis_of = {face: PLANE_AXIS.get(name, -1) for name, faces in surfaces.items() for face in faces}
    cut = {axis for axis in axis_of.values() if axis >= 0}
    skins = []  # axis of the mirror plane that each face of a body lies on, −1 for none
    for body in bodies:
        boundary = gmsh.model.getBoundary([(3, volume) for volume in body], combined=True, oriented=False)
        skins.append({face: axis_of.get(face, -1) for _, face in boundary})
    order, rows, folds, labels = mesh.order, [], [], []
    between: list[tuple[str, str]] = []
    for axes, curve, faces in ((skin, *pair) for skin in skins or [axis_of] for pair in _shared(skin)):
        _, line_nodes = gmsh.model.mesh.getElementsByType(_LINES[order], curve)
        tags, places, _ = gmsh.model.mesh.getNodes(1, curve, includeBoundary=True)
        rising = np.argsort(tags)
        ends = line_nodes.reshape(-1, order + 1)[:, :2]
        ends = np.asarray(places.reshape(-1, 3)[rising[np.searchsorted(tags[rising], ends)]])
        fold = _fold(curve, ends.mean(axis=1), faces, axes)
        sharp = fold > LEAST_FOLD
        if sharp.any():
            rows.append(ends[sharp])
            folds.append(fold[sharp])
            labels.append(np.full(np.count_nonzero(sharp), len(between)))
            outer = [face for face in faces if axes[face] < 0]
            between.append((_in_words(outer[0], cut), _in_words(outer[-1], cut)))
    if not rows:
        return Creases(np.zeros((0, 2), int), np.zeros(0), np.zeros(0, int), ())
    return Creases(
        _numbers(np.concatenate(rows), mesh), np.concatenate(folds), np.concatenate(labels), tuple(between)
    )


def _numbers(ends: Floats, mesh: TetMesh) -> Ints:
    """Nodes (n, 2) of a mesh at places (n, 2, 3), the nearest where none is exactly there."""
    count, places = len(mesh.points), ends.reshape(-1, 3)
    together = np.concatenate([mesh.points, places]) + 0.0  # no negative zeros
    _, place = np.unique(together, axis=0, return_inverse=True)
    node_at = np.full(len(together), -1)
    node_at[place[:count]] = np.arange(count)
    nodes = node_at[place[count:]]
    for row in np.flatnonzero(nodes < 0):
        nodes[row] = np.linalg.norm(mesh.points - places[row], axis=1).argmin()
    return np.asarray(nodes, dtype=np.int64).reshape(-1, 2)


def _shared(axis_of: Mapping[int, int]) -> list[tuple[int, tuple[int, int]]]:
    """Curves between two faces, at least one of them not on a mirror plane."""
    faces_of: dict[int, list[int]] = {}
    for face in axis_of:
        for _, curve in gmsh.model.getBoundary([(2, face)], combined=False, oriented=False):
            faces_of.setdefault(curve, []).append(face)
    return [
        (curve, (faces[0], faces[1]))
        for curve, faces in sorted(faces_of.items())
        if len(faces) == 2 and faces[0] != faces[1] and min(axis_of[face] for face in faces) < 0
    ]


def _fold(curve: int, places: Floats, faces: tuple[int, int], axis_of: Mapping[int, int]) -> Floats:
    """Angle (n,) between two faces at places on their curve; at a mirror plane, a face and its image."""
    if not len(places):
        return np.zeros(0)
    at = gmsh.model.getParametrization(1, curve, places.ravel())
    outer = [face for face in faces if axis_of[face] < 0]
    one, other = (
        np.reshape(gmsh.model.getNormal(face, gmsh.model.reparametrizeOnSurface(1, curve, at, face)), (-1, 3))
        for face in (outer[0], outer[-1])
    )
    if len(outer) == 1:
        plane = next(axis_of[face] for face in faces if axis_of[face] >= 0)
        other = other * np.where(np.arange(3) == plane, -1.0, 1.0)
    return np.asarray(np.arccos(np.clip(np.abs((one * other).sum(axis=1)), 0.0, 1.0)))


def _in_words(face: int, cut: set[int]) -> str:
    kind = gmsh.model.getType(2, face)
    if kind == "Plane":
        (u, v), _ = gmsh.model.getParametrizationBounds(2, face)
        normal = np.array(gmsh.model.getNormal(face, [u, v]))
        normal_axis = int(np.abs(normal).argmax())
        if abs(normal[normal_axis]) > _ALONG:
            return f"plane {_level(normal_axis, gmsh.model.getValue(2, face, [u, v])[normal_axis], cut)} mm"
        x, y, z = np.where(np.isin(np.arange(3), list(cut)), np.abs(normal), normal).round(2) + 0.0
        return f"plane facing ({x:g}, {y:g}, {z:g})"
    if kind != "Cylinder":
        return "curved face" if kind == "Unknown" else f"{kind.lower()} face"
    _, values = gmsh.model.getEntityProperties(2, face)
    axis = int(np.abs(values[3:6]).argmax())
    about = ", ".join(_level(k, values[k], cut) for k in range(3) if k != axis)
    about = f" about {about} mm" if abs(values[3 + axis]) > _ALONG else ""
    return f"cylinder of radius {values[6]:.4g} mm{about}"


def _level(axis: int, value: float, cut: set[int]) -> str:
    name, value = "xyz"[axis], round(float(value), 3) + 0.0
    return f"{f'|{name}|' if axis in cut and value else name} = {abs(value) if axis in cut else value:.4g}"


_JOINT = (Surface.JOINT, Surface.JOINT_CAP)
# In words, by the surface that ends there.
_OF_INTERFACES = "outline of the joint", "rim of the bushing's seat", "rim of the shells' seat"
_NAMES = {
    **{side: name for sides, name in zip(INTERFACES, _OF_INTERFACES, strict=True) for side in sides},
    Surface.BOLT_HEAD: "rim of the bolt head's seat",
    Surface.BOLT_THREAD: "rim of the nut's seat or run-out of the thread",
}
_AT_BORE = "rim of the joint at the bore"


@dataclass(frozen=True)
class Rim:
    """The rim of an interface or of a bolt's seat, on one of the bodies that meet there."""

    name: str  #: in words; the same on both bodies
    surface: Surface  #: the surface that ends there
    edges: Ints  #: (n, 2) vertices at the ends of the mesh's edges on it
    nodes: Ints  #: (n_nodes,) all nodes on it, with those amid its edges


def rims(mesh: TetMesh) -> tuple[Rim, ...]:
    """Find the rims on a mesh of separate bodies (`mesh.tetmesh`); none lies across a mirror plane."""
    cut = [_sides(mesh.facets[plane])[0] for plane in mesh.planes]
    bore = _sides(mesh.facets.get(Surface.BIG_END_BORE, np.zeros((0, 3), dtype=np.int64)))[0]
    every_rim = []
    for surface, name in _NAMES.items():
        if surface not in mesh.facets:
            continue
        ends, middle = _sides(mesh.facets[surface])
        _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
        ends, middle = ends[first[count == 1]], middle[first[count == 1]]
        free = ~_within(ends, cut)
        ends, middle = ends[free], middle[free]
        inner = _within(ends, [bore]) if surface in _JOINT else np.zeros(len(ends), dtype=bool)
        for what, chosen in ((_AT_BORE, inner), (name, ~inner)):
            if chosen.any():
                nodes = np.unique(np.concatenate([ends[chosen].ravel(), middle[chosen].ravel()]))
                every_rim.append(Rim(what, surface, ends[chosen], nodes))
    return tuple(every_rim)


def _sides(facets: Ints) -> tuple[Ints, Ints]:
    """Ends (n, 2), the lower number first, and middles (n, 0 or 1) of the sides of facets."""
    ends = np.sort(facets[:, FACET_EDGES].reshape(-1, 2), axis=1)
    return ends, facets[:, 3:].reshape(len(ends), (facets.shape[1] - 3) // 3)


def _within(ends: Ints, sets: list[Ints]) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether each edge (n, 2) is among those of any of some sets (m, 2)."""
    if not sets or not len(ends):
        return np.zeros(len(ends), dtype=bool)
    every = np.concatenate(sets)
    most = int(max(every.max(initial=0), ends.max())) + 1
    return np.isin(ends @ [most, 1], every @ [most, 1])
