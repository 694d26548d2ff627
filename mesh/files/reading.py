"""Read the tetrahedra of a file, through meshio or, for Abaqus and CalculiX, from the deck itself."""

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from itertools import chain
from pathlib import Path

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints
from geometry.session import session
from mesh.files.fill import filled, require_closed, tets_of_model
from mesh.files.tets import FORMATS, OF_ABAQUS, TetFile, tet_file
from mesh.surface_mesh import SurfaceMesh, apart
from mesh.tetmesh import MeshError

_TET_NODES = {"tetra": 4, "tetra10": 10}
# Keywords that make nodes or elements out of others: what they make would be missing.
_GENERATORS = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}


def read_inp(path: Path) -> TetFile:
    """Read the mesh of a deck; its materials, sets and steps are ignored.

    Raises `MeshError`: the mesh is not complete in this file, contradicts itself, or has no tetrahedra;
    `OSError` and `ValueError`: the file cannot be read, or a line does not hold the numbers that it should.
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
                nodes.append(np.asarray(np.loadtxt(lines, delimiter=",", usecols=range(4), ndmin=2)))
            elif keyword == "ELEMENT":
                kind = options.get("TYPE", "").upper()
                solid = re.search(r"C3D(\d+)", kind)
                blocks.append((OF_ABAQUS.get(solid[1], kind) if solid else kind, lines))
            elif keyword == "INCLUDE":
                included = options.get("INPUT", "")
    if included and not (nodes and blocks):
        raise MeshError(f"its mesh is in another file (*INCLUDE, INPUT={included}). Name that file")
    table = np.concatenate(nodes) if nodes else np.empty((0, 4))
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
    return tet_file(points, [_elements(kind, lines, ids) for kind, lines in blocks])


def _cards(lines: Iterable[str]) -> Iterator[tuple[str, dict[str, str], list[str]]]:
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


_HEAD = b"$MeshFormat"


def stl_surface(path: Path) -> SurfaceMesh:
    """Read the closed surface of an STL file, in a gmsh session of its own.

    Raises `MeshError`: it is not closed.
    """
    with session():
        gmsh.merge(str(path))
        gmsh.model.mesh.removeDuplicateNodes()
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(2)
    order = np.argsort(tags)
    facets = np.searchsorted(tags[order], nodes).reshape(-1, 3).astype(np.int64)
    every = SurfaceMesh(coordinates.reshape(-1, 3)[order], facets)
    if not len(facets):
        raise MeshError("it holds no triangles. Export the rod as STEP")
    # Facets that lie on each other are those of a joint between two bodies.
    _, which, counts = np.unique(np.sort(facets, axis=1), axis=0, return_inverse=True, return_counts=True)
    surface = replace(every, facets=facets[counts[which.ravel()] != 2])
    try:
        require_closed(surface)
    except MeshError:
        surface = apart(every)
        require_closed(surface)
    return surface if surface.volume > 0 else SurfaceMesh(surface.points, surface.facets[:, ::-1])


def read_tets(path: Path) -> TetFile:
    """Read the tetrahedra of a mesh file; its suffix is one of `FORMATS`.

    Raises `MeshError`: the file is damaged, or holds no mesh that is supported; the message names it;
    `OSError` and `ImportError`: it cannot be read, or a library that the format needs is not installed.
    """
    name = FORMATS[path.suffix.lower()]
    try:
        if name == "stl":
            return filled(stl_surface(path))
        return read_inp(path) if name == "abaqus" else _through_meshio(path, name)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
    except ImportError as error:
        missing = error.name or "a library"
        raise ImportError(f"{path} cannot be read without {missing}. Type: pip install {missing}") from error
    except (OSError, MemoryError) as error:
        if isinstance(error, OSError) and error.errno is None:  # h5py's, for files that are not HDF5
            raise _damaged(path, name, error) from error
        raise
    except Exception as error:  # what meshio and its parsers raise is not documented
        raise _damaged(path, name, error) from error


def _damaged(path: Path, name: str, error: Exception) -> MeshError:
    reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return MeshError(
        f"{path} could not be read as a file of the format {name} ({reason}). It may be damaged or cut off: "
        "write it again, or choose another format"
    )


def _through_meshio(path: Path, name: str) -> TetFile:
    read = import_module(f"meshio.{name}").read
    try:
        mesh = read(_bulk_data(path) if name == "nastran" else str(path))
    except Exception:
        if name != "gmsh":
            raise
        with path.open("rb") as file:
            if file.read(len(_HEAD)) != _HEAD:  # gmsh would run it as a script
                raise
        with session():  # for files in which some entities alone have physical groups
            gmsh.open(str(path))
            return tets_of_model()
    if name == "nastran":
        frames = mesh.point_data.get("nastran:ref", ())
        if np.any(np.asarray(frames) != 0):
            raise MeshError(
                "its GRID entries use coordinate systems (field CP). Write them in the basic system"
            )
    first = 1
    blocks = []
    for block in mesh.cells:
        blocks.append((block.type, np.asarray(block.data), np.arange(first, first + len(block.data))))
        first += len(block.data)
    return tet_file(np.asarray(mesh.points), blocks)


def _bulk_data(path: Path) -> io.StringIO:
    """Nastran's bulk data as meshio insists on it: marked continuation lines, between two other lines."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if "\nCTETRA*" in text:
        raise MeshError(
            "its CTETRA entries are in large fields, which are not supported. Write them in small ones"
        )
    text = re.sub(r"(?m)^(?: {8}|(?=,))(?=.*\S)", lambda blank: "+".ljust(len(blank[0])), text)
    begin = "" if "BEGIN BULK" in text else "BEGIN BULK\n"
    end = "" if "\nENDDATA" in text else "\nENDDATA\n"
    return io.StringIO(begin + text + end)
