"""Tetrahedra as a file of another program holds them, before they are checked."""

import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats, Ints, Mask, linked_groups
from geometry.errors import InvalidValue
from geometry.holes import place_text
from mesh.quality import shape
from mesh.tetmesh import EDGES, FROM_GMSH, TET_TURN, MeshError, TetMesh, face_counts, folded

# More than this cannot be solved on any workstation: ten million elements, as for meshes that gmsh makes.
MOST_TETS = 10_000_000
# Those of `formats.toml`.
_TABLES = tomllib.loads(Path(__file__).with_name("formats.toml").read_text(encoding="utf-8"))
_KINDS: dict[str, dict[str, Any]] = _TABLES["kinds"]
FORMATS: dict[str, str] = _TABLES["formats"]
OF_ABAQUS = {names["abaqus"]: kind for kind, names in _KINDS.items() if "abaqus" in names}
OF_GMSH = {names["gmsh"]: kind for kind, names in _KINDS.items() if "gmsh" in names}
# How meshio's names of solid elements begin.
_SOLIDS: tuple[str, ...] = ("tetra", "hexahedron", "wedge", "pyramid", "polyhedron")
_SOLIDS += ("VTK_LAGRANGE_TETRA", "VTK_LAGRANGE_HEXAHEDRON")


@dataclass(frozen=True)
class TetFile:
    """Nodes and tetrahedra, unchecked."""

    points: Floats  #: (n_nodes, 3), in the file's unit of length
    tets: Ints  #: (n_elements, 4) or (n_elements, 10) rows of `points`, in VTK's order of nodes
    numbers: Ints  #: (n_elements,) the file's own numbers of the elements, by which messages name them


def tet_file(points: Floats, blocks: list[tuple[str, Ints, Ints]]) -> TetFile:
    """Take the tetrahedra out of blocks of elements: meshio's name of the kind, rows of `points`, numbers.

    Raises `MeshError`: no tetrahedra, solid elements of other kinds, or four- and ten-node ones.
    """
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError("its nodes do not have three coordinates: a mesh of solid elements is needed")
    count = Counter[str]()
    for kind, rows, _ in blocks:
        count[kind] += len(rows)
    tets = [block for block in blocks if block[0] in ("tetra", "tetra10")]
    solid = {kind: number for kind, number in count.items() if kind.startswith(_SOLIDS)}
    others = {kind: number for kind, number in solid.items() if kind not in ("tetra", "tetra10")}
    if others:
        raise MeshError(
            f"it holds {_listed(others)}; only tetrahedra with four or ten nodes (C3D4, C3D10) are "
            "supported. Mesh the rod with tetrahedra"
        )
    if not tets:
        what = f"it holds {_listed(count)} but no tetrahedra" if count else "it holds no elements"
        raise MeshError(f"{what}. Mesh the volume of the rod with tetrahedra of four or ten nodes")
    if len({kind for kind, *_ in tets}) > 1:
        raise MeshError(
            f"it holds {_listed(count)}: first- and second-order tetrahedra together are not supported. Use "
            "one order for the whole mesh"
        )
    nodes = 4 if tets[0][0] == "tetra" else 10
    if any(rows.shape[1:] != (nodes,) for _, rows, _ in tets):
        raise MeshError("some of its tetrahedra have neither four nor ten nodes. Give all ten, or all four")
    rows = np.concatenate([rows for _, rows, _ in tets]).astype(np.int64)
    if len(rows) > MOST_TETS:
        raise MeshError(f"it holds {len(rows)} tetrahedra, at most {MOST_TETS} are read. Use a coarser mesh")
    return TetFile(np.asarray(points, dtype=float), rows, np.concatenate([ids for *_, ids in tets]))


def _listed(count: Counter[str] | dict[str, int]) -> str:
    words = {kind: names["words"] for kind, names in _KINDS.items()}
    return ", ".join(f"{number} {words.get(kind, kind)}" for kind, number in count.items())


def require_known(name: str, path: Path) -> None:
    """Refuse a mesh in a format that is not read (`InvalidValue`); `name` is what gives it."""
    program = _TABLES["unread"].get(path.suffix.lower())
    if program is not None:
        rule = f"is in a mesh format that is not read ({program})"
        remedy = f"Write the mesh as .inp (Abaqus), .msh (gmsh) or .unv; read are {', '.join(FORMATS)}."
        raise InvalidValue(name, str(path), rule, remedy)


def is_mesh(path: Path) -> bool:
    """Whether the ending is that of a mesh file that can be read."""
    return path.suffix.lower() in FORMATS


# Nodes closer than this part of the mesh's extent are one: text files often hold seven digits.
_SAME = 1e-7
# Mean ratio below which a tetrahedron has no volume but for rounding.
_FLAT = 1e-10
# Distance of a mid-side node from the middle of its edge, in parts of the edge. An arc of 90° takes 0.21.
_FARTHEST_MIDDLE = 0.45
_FARTHEST = 1e9  # coordinate of a node
_SHOWN = 5


@dataclass(frozen=True)
class Mended:
    """A sound mesh and what was done for it."""

    #: Positively oriented tetrahedra in one piece that share whole faces; unused nodes are gone
    mesh: TetMesh
    notes: tuple[str, ...]  #: what was changed, for the user


def mended(file: TetFile) -> Mended:
    """Make a mesh of what a file holds.

    Doubled nodes are merged, nodes without elements and doubled elements dropped, elements that are inside
    out turned over. Raises `MeshError`: nodes that are missing or not finite, flat or overlapping elements,
    mid-side nodes that are not on their edges, or several pieces; with the numbers of elements.
    """
    stray = (file.tets < 0) | (file.tets >= len(file.points))
    _refuse(stray.any(axis=1), file.numbers, "nodes that do not exist")
    usable = np.abs(file.points) < _FARTHEST  # not so for NaN
    sound = np.asarray(usable.all(axis=1))[file.tets].all(axis=1)
    _refuse(np.logical_not(sound), file.numbers, "nodes whose coordinates are no usable numbers")
    used, local = np.unique(file.tets, return_inverse=True)
    places = file.points[used]
    grid = _SAME * max(float(np.ptp(places, axis=0).max()), 1e-300)
    cell = np.round((places - places.min(axis=0)) / grid).astype(np.int64)
    _, first, which = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    order = np.sort(first)  # nodes keep their order
    place = np.argsort(np.argsort(first))
    points, merged = places[order], len(used) - len(first)
    tets: Ints = place[which.ravel()][local].reshape(file.tets.shape)
    ordered = np.sort(tets, axis=1)
    _refuse((ordered[:, 1:] == ordered[:, :-1]).any(axis=1), file.numbers, "the same node twice")
    single = np.sort(np.unique(np.sort(tets[:, :4], axis=1), axis=0, return_index=True)[1])
    dropped = len(tets) - len(single)
    tets, numbers = tets[single], file.numbers[single]
    ratio = shape(TetMesh(points, tets))
    _refuse(np.abs(ratio) < _FLAT, numbers, "no volume: their vertices lie in a plane")
    inverted = ratio < 0
    tets = np.where(inverted[:, None], tets[:, TET_TURN[tets.shape[1]]], tets)
    swapped = False
    if tets.shape[1] > 4:
        wrong = _astray(points, tets)
        reordered = tets[:, FROM_GMSH[2]]
        swapped = bool(wrong.mean() > 0.5) and not _astray(points, reordered).any()
        _refuse(wrong & (not swapped), numbers, "mid-side nodes that do not stand on their edges")
        tets = reordered if swapped else tets
    _require_conforming(tets, numbers, points)
    label = linked_groups(len(points), np.repeat(tets[:, 0], 3), tets[:, 1:4].ravel())
    bodies, example, sizes = np.unique(label[tets[:, 0]], return_index=True, return_counts=True)
    if len(bodies) > 1:
        listed = []
        for n in np.argsort(-sizes, kind="stable")[:_SHOWN]:
            middle = place_text(points[tets[label[tets[:, 0]] == bodies[n]]].reshape(-1, 3).mean(axis=0))
            listed.append(f"{sizes[n]} elements around {middle}, among them number {numbers[example[n]]}")
        raise MeshError(
            f"it consists of {len(bodies)} bodies that share no nodes: {'; '.join(listed)}. Give the rod and "
            "its cap as one body with common nodes, and leave out all others"
        )
    counts = {
        "nodes at the place of another, merged with it": merged,
        "elements that occurred twice, dropped": dropped,
        "elements that were inside out, turned over": int(inverted.sum()),
    }
    notes = [f"{what}: {count}" for what, count in counts.items() if count]
    exchanged = "the last two mid-side nodes of every element were exchanged, to stand on their edges"
    return Mended(TetMesh(points, tets), (*notes, exchanged) if swapped else tuple(notes))


def _refuse(wrong_elements: npt.ArrayLike, numbers: Ints, what: str) -> None:
    wrong = np.asarray(wrong_elements, dtype=bool)
    if not wrong.any():
        return
    refused = numbers[wrong]
    listed = ", ".join(map(str, refused[:_SHOWN])) + (", …" if len(refused) > _SHOWN else "")
    word = "element has" if len(refused) == 1 else "elements have"
    raise MeshError(f"{len(refused)} {word} {what} (number {listed}). Mesh the rod again")


def _astray(points: Floats, tets: Ints) -> Mask:
    ends = points[tets[:, EDGES]]
    off = np.linalg.norm(points[tets[:, 4:]] - ends.mean(axis=2), axis=2)
    lengths = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    return np.asarray((off > _FARTHEST_MIDDLE * lengths).any(axis=1))


def _require_conforming(tets: Ints, numbers: Ints, points: Floats) -> None:
    """Require that no face has three elements, and that an edge has one mid-side node, not a vertex."""
    which, counts = face_counts(tets)
    what = "a face that belongs to more than two elements: they overlap"
    _refuse((counts[which] > 2).any(axis=1), numbers, what)
    what = "a neighbour on the same side of their common face: they overlap. Is a node misplaced?"
    _refuse(folded(tets), numbers, what)
    if tets.shape[1] == 4:
        return
    vertex = np.zeros(len(points), dtype=bool)
    vertex[tets[:, :4]] = True
    what = "a mid-side node that is a vertex of another element"
    _refuse(vertex[tets[:, 4:]].any(axis=1), numbers, what)
    ends = np.sort(tets[:, EDGES], axis=2)
    _, edge = np.unique(ends[..., 0] * len(points) + ends[..., 1], return_inverse=True)
    edge, middle = edge.ravel(), tets[:, 4:].ravel()
    _, local = np.unique(middle, return_inverse=True)
    last_middle, last_edge = (np.empty(each.max() + 1, dtype=np.int64) for each in (edge, local))
    last_middle[edge], last_edge[local] = middle, edge
    differs = (last_middle[edge] != middle) | (last_edge[local] != edge)
    what = "an edge on which other elements have another mid-side node"
    _refuse(differs.reshape(-1, len(EDGES)).any(axis=1), numbers, what)
