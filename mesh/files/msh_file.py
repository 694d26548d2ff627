"""Nodes and tetrahedra of a .msh file through gmsh, for those that meshio does not take."""

from pathlib import Path

import gmsh
import numpy as np

from geometry.session import session
from mesh.files.tet_file import TetFile, tet_file
from mesh.tetmesh import FROM_GMSH

# Kinds of solid elements, by gmsh's numbers.
_KINDS = {
    4: "tetra",
    11: "tetra10",
    5: "hexahedron",
    12: "hexahedron27",
    17: "hexahedron20",
    6: "wedge",
    7: "pyramid",
}
_HEAD = b"$MeshFormat"


def is_msh(path: Path) -> bool:
    """Whether a file begins as a .msh file; gmsh would run any other as a script."""
    with path.open("rb") as file:
        return file.read(len(_HEAD)) == _HEAD


def read_msh(path: Path) -> TetFile:
    """Read a file, for which `is_msh` holds, in a gmsh session of its own.

    Raises
    ------
    MeshError
        It holds no tetrahedra, or other solid elements too.
    Exception
        gmsh cannot read it.
    """
    with session():
        gmsh.open(str(path))
        return tets_of_model()


def tets_of_model() -> TetFile:
    """Nodes and tetrahedra of the open model.

    Raises
    ------
    MeshError
        There are no tetrahedra, or other solid elements too.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    ids = tags[order].astype(np.int64)
    blocks = []
    for number, kind in _KINDS.items():
        own, nodes = gmsh.model.mesh.getElementsByType(number)
        if len(own):
            rows = np.searchsorted(ids, nodes.astype(np.int64)).reshape(len(own), -1)
            ours = rows[:, FROM_GMSH[2]] if kind == "tetra10" else rows
            blocks.append((kind, ours, own.astype(np.int64)))
    return tet_file(coordinates.reshape(-1, 3)[order], blocks)
