"""Nodes and tetrahedra of an Abaqus or CalculiX deck.

meshio reads such files too, but only with a single block of nodes and no element type that it does not know,
of which gmsh writes some (CPS6), and it drops the numbers of the elements.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from geometry.arrays import Floats, Ints
from mesh.files.tet_file import TetFile, tet_file
from mesh.tetmesh import MeshError

# The shape of solid elements by the number in their name (C3D10M, C3D20R; DC3D10 for heat).
_SOLIDS = {
    "4": "tetra",
    "5": "pyramid",
    "6": "wedge",
    "8": "hexahedron",
    "10": "tetra10",
    "15": "wedge15",
    "20": "hexahedron20",
}
_TET_NODES = {"tetra": 4, "tetra10": 10}
# Keywords that make nodes or elements out of others: what they make would be missing.
_GENERATORS = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}


def read_inp(path: Path) -> TetFile:
    """Read the mesh of a deck; its materials, sets and steps are ignored.

    Raises
    ------
    MeshError
        The mesh is not complete in this file, contradicts itself, or has no tetrahedra.
    OSError
        The file cannot be read.
    ValueError
        A line does not hold the numbers that it should.
    """
    nodes: list[Floats] = []
    blocks: list[tuple[str, list[str]]] = []
    included = ""
    with path.open(encoding="utf-8", errors="replace") as file:
        for keyword, options, lines in _cards(file):
            if keyword in _GENERATORS:
                raise MeshError(
                    f"it makes nodes or elements with *{keyword}, which is not supported. Write all nodes "
                    "and elements out"
                )
            if keyword == "NODE" and lines:
                if options.get("SYSTEM", "R").upper() != "R":
                    raise MeshError("its nodes are not in Cartesian coordinates (*NODE, SYSTEM=…)")
                nodes.append(_coordinates(lines))
            elif keyword == "ELEMENT":
                blocks.append((_kind(options.get("TYPE", "")), lines))
            elif keyword == "INCLUDE":
                included = options.get("INPUT", "")
    if included and not (nodes and blocks):
        raise MeshError(f"its mesh is in another file (*INCLUDE, INPUT={included}). Name that file")
    table = np.concatenate(nodes) if nodes else np.empty((0, 4))
    ids, points = _unique_nodes(table)
    return tet_file(points, [_elements(kind, lines, ids) for kind, lines in blocks])


def _cards(lines: Iterable[str]) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keyword, options and data lines of each card."""
    keyword, options, data = "", dict[str, str](), list[str]()
    for line in map(str.lstrip, chain(lines, ["*END"])):
        if line.startswith("**") or not line:
            continue
        if not line.startswith("*"):
            data.append(line)
            continue
        if keyword:
            yield keyword, options, data
        name, *given = line[1:].split(",")
        pairs = (option.partition("=") for option in given)
        keyword = name.strip().upper()
        options = {key.strip().upper(): value.strip() for key, _, value in pairs}
        data = []


def _kind(name: str) -> str:
    """Meshio's name of an element type; the type itself where it is not a solid."""
    name = name.upper()
    solid = re.search(r"C3D(\d+)", name)
    return _SOLIDS.get(solid[1], name) if solid else name


def _coordinates(lines: Sequence[str]) -> Floats:
    """Numbers and coordinates (n, 4) of nodes."""
    return np.asarray(np.loadtxt(lines, delimiter=",", usecols=range(4), ndmin=2))


def _unique_nodes(table: Floats) -> tuple[Ints, Floats]:
    """Rising numbers (n,) and coordinates (n, 3) of nodes; one node may be defined twice at one place."""
    number = table[:, 0]
    if not (number == np.round(number)).all():
        raise MeshError("a node has a number that is not whole")
    ids, first, which = np.unique(number.astype(np.int64), return_index=True, return_inverse=True)
    points = table[first, 1:]
    moved = (points[which] != table[:, 1:]).any(axis=1) & ~np.isnan(table[:, 1:]).any(axis=1)
    if moved.any():
        raise MeshError(
            f"node {ids[which[moved][0]]} is defined twice, at different places: the file probably holds "
            "several parts. Write the rod's mesh as one part"
        )
    return ids, points


def _elements(kind: str, lines: Sequence[str], ids: Ints) -> tuple[str, Ints, Ints]:
    """Kind, rows of nodes and numbers of the elements; those of other kinds than tetrahedra are counted."""
    count = _TET_NODES.get(kind)
    if count is None:
        nothing = np.zeros(len(lines), dtype=np.int64)
        return kind, nothing[:, None], nothing
    words = [word for line in lines for word in line.split(",") if word.strip()]
    values = np.array(words, dtype=float) if words else np.empty(0)
    if values.size % (count + 1) or not (values == np.round(values)).all():
        raise MeshError(
            f"an element of {count} nodes is incomplete: {len(words)} numbers in {len(lines)} lines"
        )
    table = values.astype(np.int64).reshape(-1, count + 1)
    if not ids.size:
        raise MeshError("it holds elements but no nodes")
    rows = np.minimum(np.searchsorted(ids, table[:, 1:]), ids.size - 1)
    missing = (ids[rows] != table[:, 1:]).any(axis=1)
    if missing.any():
        raise MeshError(f"element {table[missing][0, 0]} has a node that the file does not define")
    return kind, rows, table[:, 0]
