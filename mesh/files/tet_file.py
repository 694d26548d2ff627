"""Tetrahedra as a file of another program holds them, before they are checked."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import Floats, Ints
from mesh.tetmesh import MeshError

# More than this cannot be solved on any workstation: ten million elements, as for meshes that gmsh makes.
MOST_TETS = 10_000_000


@dataclass(frozen=True)
class TetFile:
    """Nodes and tetrahedra, unchecked.

    Attributes
    ----------
    points
        (n_nodes, 3), in the file's unit of length.
    tets
        (n_elements, 4) or (n_elements, 10) rows of `points`, in VTK's order of nodes.
    numbers
        (n_elements,) the file's own numbers of the elements, by which messages name them.
    """

    points: Floats
    tets: Ints
    numbers: Ints


def tet_file(points: Floats, blocks: list[tuple[str, Ints, Ints]]) -> TetFile:
    """Take the tetrahedra out of blocks of elements of one kind each.

    Parameters
    ----------
    points
        (n_nodes, 3).
    blocks
        meshio's name of the kind (``"tetra10"``), rows of `points`, and numbers of the elements.

    Raises
    ------
    MeshError
        There are no tetrahedra, solid elements of other kinds, or both four-node and ten-node ones.
    """
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError("its nodes do not have three coordinates: a mesh of solid elements is needed")
    count = Counter[str]()
    for kind, rows, _ in blocks:
        count[kind] += len(rows)
    tets = [block for block in blocks if block[0] in ("tetra", "tetra10")]
    others = {kind: number for kind, number in count.items() if _is_other_solid(kind)}
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
        raise MeshError(
            "some of its tetrahedra have neither four nor ten nodes. Give all of them ten, or all four"
        )
    rows = np.concatenate([rows for _, rows, _ in tets]).astype(np.int64)
    if len(rows) > MOST_TETS:
        raise MeshError(
            f"it holds {len(rows)} tetrahedra; at most {MOST_TETS} are supported. Use a coarser mesh"
        )
    return TetFile(np.asarray(points, dtype=float), rows, np.concatenate([own for *_, own in tets]))


def _is_other_solid(kind: str) -> bool:
    solids = ("tetra", "hexahedron", "wedge", "pyramid", "VTK_LAGRANGE_TETRA", "VTK_LAGRANGE_HEXAHEDRON")
    return kind.startswith((*solids, "polyhedron")) and kind not in ("tetra", "tetra10")


def _listed(count: Counter[str] | dict[str, int]) -> str:
    return ", ".join(f"{number} {_WORDS.get(kind, kind)}" for kind, number in count.items())


_WORDS = {
    "tetra": "four-node tetrahedra",
    "tetra10": "ten-node tetrahedra",
    "hexahedron": "hexahedra",
    "hexahedron20": "20-node hexahedra",
    "wedge": "wedges",
    "wedge15": "15-node wedges",
    "pyramid": "pyramids",
    "triangle": "triangles",
    "triangle6": "six-node triangles",
    "quad": "quadrilaterals",
    "line": "lines",
    "vertex": "points",
}


# meshio's module for each suffix. It could guess them, but `meshio.read` prints errors and ends the program.
FORMATS = {
    ".inp": "abaqus",
    ".msh": "gmsh",
    ".bdf": "nastran",
    ".nas": "nastran",
    ".fem": "nastran",
    ".med": "med",
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".xdmf": "xdmf",
    ".xmf": "xdmf",
    ".mesh": "medit",
    ".meshb": "medit",
    ".vol": "netgen",
    ".stl": "stl",
}


def is_mesh(path: Path) -> bool:
    """Whether the ending is that of a mesh file that can be read."""
    return path.suffix.lower() in FORMATS
