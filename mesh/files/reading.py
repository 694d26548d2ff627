"""Read the tetrahedra of a file, through meshio or from the deck itself, or mesh the inside of a surface."""

import io
import math
import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints, Mask
from geometry.holes import place_text
from geometry.session import session
from mesh.creases import SurfaceMesh, apart
from mesh.files.tets import FORMATS, OF_ABAQUS, OF_GMSH, TetFile, tet_file
from mesh.tetmesh import FROM_GMSH, TET_TURN, MeshError

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
    """Fill a surface with straight ten-node tetrahedra. Raises `MeshError`: it cuts itself, or gmsh fails."""
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
            raise MeshError(what_is_wrong(surface, str(error))) from error
        return tets_of_model()


def require_closed(surface: SurfaceMesh) -> None:
    """Refuse a surface with holes, or with sides of more than two triangles."""
    sides = np.sort(surface.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends, uses = np.unique(sides, axis=0, return_counts=True)
    wrong = ends[uses != 2]
    if not len(wrong):
        return
    touching, places = (uses % 2 == 0).all(), _around(surface.points[wrong].mean(axis=1))
    if touching and len(crossings(surface)):
        raise MeshError(what_is_wrong(surface, ""))
    what = f"its surface is not closed: {len(wrong)} sides do not belong to exactly two triangles"
    remedy = _REPAIR
    if touching:
        what = f"bodies touch in its surface: {len(wrong)} sides belong to four triangles"
        remedy = "Export rod and cap to a file each (rod.cap), or the rod as STEP"
    raise MeshError(f"{what}, {places}. {remedy}")


def what_is_wrong(surface: SurfaceMesh, error: str) -> str:
    """Say where a surface cuts itself; if it does not, the `error` with which its inside was not meshed."""
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
        held = f"{len(words)} numbers in {len(lines)} lines"
        raise MeshError(f"an element of {count} nodes is incomplete: {held}")
    table = values.astype(np.int64).reshape(-1, count + 1)
    if not ids.size:
        raise MeshError("it holds elements but no nodes")
    rows = np.minimum(np.searchsorted(ids, table[:, 1:]), ids.size - 1)
    missing = (ids[rows] != table[:, 1:]).any(axis=1)
    if missing.any():
        raise MeshError(f"element {table[missing][0, 0]} has a node that the file does not define")
    return kind, rows, table[:, 0]


# How gmsh's files begin: anything else it would run as a script.
_HEADS = (b"$MeshFormat", b"$NOD", b"$PhysicalNames")
# Formats that gmsh reads better than meshio, and their endings: it knows in which direction MED counts
# vertices, MED files without groups, and second order in Medit.
_BY_GMSH = {"med": ".med", "medit": ".mesh", "unv": ".unv"}


def stl_surface(path: Path) -> SurfaceMesh:
    """Read the surface of an STL file, in a gmsh session of its own. Raises `MeshError`: it is not closed."""
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
        return read_inp(path) if name == "abaqus" else _through_library(path, name)
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
    text = str(error).replace(str(path), path.name)  # the message names the path already
    reason = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return MeshError(
        f"{path} could not be read as a file of the format {name} ({reason}). It may be damaged or cut "
        "off, or of a variant that is not read: write it again, or write Abaqus' .inp or gmsh's .msh instead"
    )


def _through_library(path: Path, name: str) -> TetFile:
    if name not in _BY_GMSH:
        return _through_meshio(path, name)
    try:
        return _through_gmsh(path, _BY_GMSH[name])
    except MeshError:
        raise
    except Exception:  # gmsh raises nothing more specific
        if name == "unv":
            raise
        return _through_meshio(path, name)


def _through_gmsh(path: Path, ending: str) -> TetFile:
    """Read a file in gmsh, which takes the format from the `ending`; one that it does not know, it runs."""
    with TemporaryDirectory() as folder, session():
        named = path
        if path.suffix != ending:
            named = Path(folder, f"mesh{ending}")
            shutil.copyfile(path, named)
        gmsh.merge(str(named))
        file = tets_of_model()
    if _cut_off(path.read_bytes(), ending, len(file.tets)):
        raise MeshError(f"it is cut off: {len(file.tets)} tetrahedra are left. Write it again")
    return file


def _cut_off(data: bytes, ending: str, count: int) -> bool:
    """Whether elements are missing at the end of a file, about which gmsh says nothing in these formats."""
    if ending == ".unv":
        return data.split()[-1:] != [b"-1"]
    announced = re.findall(rb"^\s*Tetrahedra(?:P2)?\s+(\d+)", data, re.MULTILINE)
    return ending == ".mesh" and sum(map(int, announced)) != count


def _bulk_data(path: Path) -> io.StringIO:
    """Nastran's bulk data as meshio insists on it: marked continuation lines, between two other lines."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if "BEGIN BULK" in text and "\nENDDATA" not in text:
        raise MeshError("it is cut off: its bulk data does not end with ENDDATA. Write it again")
    if "\nCTETRA*" in text:
        what = "its CTETRA entries are in large fields, which are not supported"
        raise MeshError(f"{what}. Write them in small ones")
    text = re.sub(r"(?<=[\d.])[Dd](?=[+-]\d)", "E", text)  # double precision
    text = re.sub(r"(?m)^(?: {8}|(?=,))(?=.*\S)", lambda blank: "+".ljust(len(blank[0])), text)
    begin = "" if "BEGIN BULK" in text else "BEGIN BULK\n"
    end = "" if "\nENDDATA" in text else "\nENDDATA\n"
    return io.StringIO(begin + text + end)


def _netgen_sections(path: Path) -> io.StringIO:
    """Nodes and volume elements of a Netgen file; meshio refuses other sections of newer versions."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    words, kept = [line.strip() for line in lines], ["mesh3d", "dimension", "3"]
    if "mesh3d" not in words:
        raise ValueError("it does not say mesh3d")
    for title in ("volumeelements", "points"):
        begin = words.index(title)
        section = words[begin : begin + 2 + int(words[begin + 1])]
        if len(section) < 2 + int(section[1]):
            raise ValueError(f"{title}: {section[1]} announced, {len(section) - 2} found")
        kept += section
    return io.StringIO("\n".join([*kept, "endmesh"]))


# Formats whose files are changed for meshio.
_PREPARED = {"nastran": _bulk_data, "netgen": _netgen_sections}


_VTU_HEAD = 1000  # bytes that hold the first element of a VTU file, which names the compressor
_LZ4 = "its arrays are compressed with LZ4, which is not supported"


def _through_meshio(path: Path, name: str) -> TetFile:
    read = import_module(f"meshio.{name}").read
    if name == "vtu" and b"vtkLZ4DataCompressor" in path.read_bytes()[:_VTU_HEAD]:
        raise MeshError(f"{_LZ4}. Save it with ZLib, or without compression")
    try:
        mesh = read(_PREPARED[name](path) if name in _PREPARED else str(path))
    except Exception:
        data = path.read_bytes()
        if name == "gmsh" and data.startswith(_HEADS):  # for groups of some entities alone, and format 1
            return _through_gmsh(path, ".msh")
        fields = data.find(b"_DATA ", data.find(b"CELL_TYPES"))
        if name != "vtk" or fields < 0:
            raise
        with TemporaryDirectory() as folder:  # binary fields as gmsh and VTK write them
            bare = Path(folder, path.name)
            bare.write_bytes(data[: data.rindex(b"\n", 0, fields) + 1])
            mesh = read(str(bare))
    if name == "nastran":
        frames = mesh.point_data.get("nastran:ref", ())
        if np.any(np.asarray(frames) != 0):
            what = "its GRID entries use coordinate systems (field CP)"
            raise MeshError(f"{what}. Write them in the basic system")
    first = 1
    blocks = []
    for block in mesh.cells:
        rows = np.asarray(block.data)
        if name == "med" and block.type in _TET_NODES:
            rows = rows[:, TET_TURN[_TET_NODES[block.type]]]  # MED numbers their nodes in the other sense
        blocks.append((block.type, rows, np.arange(first, first + len(rows))))
        first += len(rows)
    return tet_file(np.asarray(mesh.points), blocks)
