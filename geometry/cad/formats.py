"""Read the solids of CAD files into gmsh; a FreeCAD document is a zip of XML and BREP files."""

import errno
import math
import os
import re
import sys
import tempfile
import zipfile
import zlib
from codecs import BOM_UTF8
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Vector, linked_groups, twins
from geometry.errors import GeometryError
from geometry.imports import CAD_FORMATS, DECLARED, FORMATS, CadFormat
from geometry.rod import Rod
from geometry.solid import build
from geometry.surfaces import Mirror

# Bytes of the description and of all shapes, unpacked: far more than any rod takes.
MOST_DESCRIPTION = 64 * 2**20
MOST_SHAPES = 512 * 2**20
# What the libraries raise where an archive is damaged.
_OF_ZIP = zipfile.BadZipFile, zlib.error, EOFError, KeyError, OSError, RuntimeError
_DAMAGES = (*_OF_ZIP, ET.ParseError, ValueError)
# No placement, mm, is as large.
_FAR = 1e7
_BODY = "PartDesign::Body"
_CONTAINERS = ("App::Part", "App::DocumentObjectGroup", "Assembly::AssemblyObject")


# A turn about an axis through the origin (angle in rad), then a shift in mm.
_Placement = tuple[Vector, float, Vector]


def linked_files(path: Path) -> list[str]:
    """Names of other documents that a FreeCAD document takes parts from; none for a file of another kind."""
    if path.suffix.lower() != ".fcstd":
        return []
    with zipfile.ZipFile(path) as archive:
        files = (link.get("file", "") for link in _description(archive).iter("XLink"))
        return sorted({" ".join(Path(file).name.split()) for file in files if file})


def _description(archive: zipfile.ZipFile) -> ET.Element:
    text = _content(archive, "Document.xml", MOST_DESCRIPTION)
    return ET.fromstring(text)  # noqa: S314 - expat limits the expansion of entities


def _content(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    with archive.open(name) as member:
        content = member.read(most + 1)
    if len(content) > most:
        raise GeometryError(f"{name} in the FreeCAD file unpacks to more than {most // 2**20} MiB")
    return content


class _Object:
    """An object of a FreeCAD document."""

    def __init__(self, kind: str, item: ET.Element) -> None:
        properties = {each.get("name"): each for each in item.iterfind("Properties/Property")}
        shape, label, placement = (
            properties[name].find(value) if name in properties else None
            for name, value in (("Shape", "Part"), ("Label", "String"), ("Placement", "PropertyPlacement"))
        )
        name = item.get("name", "")
        self.kind, self.label = kind, name if label is None else label.get("value", name)
        self.shape = "" if shape is None else shape.get("file", "")  # name of its file
        members = properties["Group"].iter("Link") if "Group" in properties else ()
        self.members = [link.get("value", "") for link in members]
        self.placement = [] if placement is None else [_placement(placement)]


def _placement(value: ET.Element) -> _Placement:
    x, y, z, w = (float(value.get(f"Q{i}", "0")) for i in range(4))
    shift = (float(value.get("Px", "0")), float(value.get("Py", "0")), float(value.get("Pz", "0")))
    if not all(abs(number) < _FAR for number in (x, y, z, w, *shift)):
        raise ValueError(f"a placement is out of range: {value.attrib}")
    size = math.hypot(x, y, z)
    axis = (x / size, y / size, z / size) if size else (0.0, 0.0, 1.0)
    return axis, 2 * math.atan2(size, w), shift


def _results(archive: zipfile.ZipFile) -> Iterator[tuple[str, bytes, list[_Placement]]]:
    """Labels of a document's results, BREP content, and placements of their containers, innermost first."""
    root = _description(archive)
    kinds = {item.get("name", ""): item.get("type", "") for item in root.iterfind("Objects/Object")}
    uses = {
        item.get("Name", ""): {dep.get("Name", "") for dep in item.iterfind("Dep")}
        for item in root.iterfind("Objects/ObjectDeps")
    }
    items = {item.get("name", ""): item for item in root.iterfind("ObjectData/Object")}
    objects = {name: _Object(kinds.get(name, ""), item) for name, item in items.items()}
    shaped = {name for name, each in objects.items() if each.shape}
    bodies = {name for name in shaped if objects[name].kind == _BODY}
    inside = {member for body in bodies for member in objects[body].members}
    free = shaped - bodies - inside
    used = {other for name in free | bodies for other in uses.get(name, set()) if name not in inside}
    # The shapes of containers only repeat those of their members.
    containers = {name: each for name, each in objects.items() if each.kind in _CONTAINERS}
    left = MOST_SHAPES
    for name in (
        each for each in objects if each in bodies - used or each in free - used - containers.keys()
    ):
        content, holder, placements, seen = _content(archive, objects[name].shape, left), name, [], {name}
        left -= len(content)
        while around := [other for other, each in containers.items() if holder in each.members]:
            holder = around[0]
            if holder in seen:
                break
            seen.add(holder)
            placements += containers[holder].placement
        yield objects[name].label, content, placements


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the kernel's own messages off standard output, where they would spoil `--json`."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with tempfile.TemporaryFile() as drain:
            os.dup2(drain.fileno(), 1)
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


_KINDS = ("points", "curves", "surfaces", "solids")
_UNNAMED = "Open CASCADE STEP translator"  # stands for no name
_GMSH_FORMATS = {CadFormat.STEP: "step", CadFormat.IGES: "iges", CadFormat.BREP: "brep"}
# Largest gap between the edges of surfaces that are sewn together, over their extent.
_SEWN = 1e-5
_PREFIXES = {b"$": "m", b".CENTI.": "cm", b".DECI.": "dm", b".KILO.": "km", b".MICRO.": "µm"}
# Units that the kernel can convert the numbers of a STEP file to, mm.
_TARGETS = {"MM": 1.0, "M": 1000.0, "CM": 10.0, "KM": 1e6, "UM": 1e-3, "INCH": 25.4, "FT": 304.8}
_START = 400  # bytes from which a format is recognised


class NamedSolid(NamedTuple):
    """A solid of the open model."""

    tag: int  #: gmsh's volume tag
    name: str  #: in the file; empty if it has none


def read_solids(path: Path, unit: str | None = None, *, beside: bool = False) -> list[NamedSolid]:
    """Read the solids of a file into a new model, lengths in mm; a `unit` replaces the one that it declares.

    `beside`: read them into the open model, beside its solids. Raises `GeometryError`: it is not what its
    ending says, or holds no solid; `OSError`: the file cannot be read.
    """
    kind = FORMATS.get(path.suffix.lower(), CadFormat.STEP)
    rules = CAD_FORMATS["read"][kind]
    with path.open("rb") as file:
        if not re.match(rules["begins"], file.read(_START).decode("latin-1"), re.ASCII):
            raise GeometryError(f"{path} is not {rules['name']}: {rules['remedy']}")
    if not beside:
        gmsh.model.add(path.stem)
    with quiet(), _in_millimetres(path, kind, unit):
        solids, kinds = _freecad(path) if kind is CadFormat.FREECAD else _imported(path, kind)
    if not solids:
        held = ", only " + ", ".join(_KINDS[dim] for dim in sorted(kinds)) if kinds else ""
        remedy = "Export the rod as a solid body, in a STEP file"
        if 2 in kinds:
            remedy += " (its surfaces do not close a volume)"
        raise GeometryError(f"{path} contains no solid{held}. {remedy}")
    return [_right_way_round(solid) for solid in solids]


def _right_way_round(solid: NamedSolid) -> NamedSolid:
    """Turn a solid that is inside out, which fills the space around it."""
    if gmsh.model.occ.getMass(kernel.SOLID, solid.tag) > 0:
        return solid
    with kernel.attempt("turn a solid that is inside out", "Export the rod again, as STEP"):
        off = dict.fromkeys(("fixDegenerated", "fixSmallEdges", "fixSmallFaces", "sewFaces"), False)
        made = gmsh.model.occ.healShapes([(kernel.SOLID, solid.tag)], **off)
        gmsh.model.occ.synchronize()
    tags = [tag for dim, tag in made if dim == kernel.SOLID]
    if len(tags) != 1 or gmsh.model.occ.getMass(kernel.SOLID, tags[0]) <= 0:
        what = f"{f'the solid {solid.name}' if solid.name else 'a solid'} has no positive volume"
        raise GeometryError(f"{what}. Repair it in the CAD program, and export it again")
    return NamedSolid(tags[0], solid.name)


@contextmanager
def _in_millimetres(path: Path, kind: CadFormat, unit: str | None) -> Iterator[None]:
    """Let the kernel convert the numbers of a file from a unit, whatever the file declares.

    The factor is part of the declared unit over another one: scaling afterwards would round once more, and
    files that differ in the declared unit alone give the same bits.
    """
    declared = declared_unit(path)
    factor = DECLARED[unit or declared]
    target, scale = "", factor / DECLARED[declared]
    if kind is CadFormat.STEP:  # reading another format, the kernel does not know this option
        wanted = DECLARED[declared] / factor
        exact = next((name for name, length in _TARGETS.items() if math.isclose(length, wanted)), None)
        target, scale = exact or "MM", scale if exact is None else 1.0
    elif kind is CadFormat.IGES:
        _forget_unit()
    gmsh.option.setString("Geometry.OCCTargetUnit", target)
    gmsh.option.setNumber("Geometry.OCCScaling", scale)
    try:
        yield
    finally:
        gmsh.option.setNumber("Geometry.OCCScaling", 1.0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")


def _forget_unit() -> None:
    """Let the kernel read in mm again: its IGES reader uses the unit of the last STEP file of the process.

    Neither an option nor a new session of gmsh resets that; reading a STEP file in mm does.
    """
    usual, name = gmsh.option.getString("Geometry.OCCTargetUnit"), gmsh.model.getCurrent()
    with tempfile.TemporaryDirectory() as folder:
        cube = str(Path(folder) / "cube.step")
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.model.add("unit")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(cube)
        gmsh.model.remove()
        gmsh.model.add("unit")
        gmsh.model.occ.importShapes(cube, format="step")
        gmsh.model.remove()
    gmsh.model.setCurrent(name)
    gmsh.option.setString("Geometry.OCCTargetUnit", usual)


def _plain(name: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in name).split())


def declared_unit(path: Path) -> str:
    """Return the unit of length that a file declares, of `DECLARED`; mm where it declares none or another."""
    kind = FORMATS.get(path.suffix.lower(), CadFormat.STEP)
    if kind is CadFormat.STEP:
        content = path.read_bytes()
        metres = re.search(
            rb"LENGTH_UNIT\s*\(\s*\)[^;]*?SI_UNIT\s*\(\s*(\$|\.[A-Z]+\.)\s*,\s*\.METRE\.", content
        )
        other = re.search(rb"CONVERSION_BASED_UNIT\s*\(\s*'(INCH|FOOT|FEET)", content, re.IGNORECASE)
        if other:
            return "in" if other[1].upper() == b"INCH" else "ft"
        return _PREFIXES.get(metres[1], "mm") if metres else "mm"
    if kind is not CadFormat.IGES:
        return "mm"
    lines = [line[:72] for line in path.read_bytes().splitlines() if line[72:73] == b"G"]
    named = re.search(rb"\d*H(MM|INCH|IN|M|CM|KM|FT|UM)[,;]", b"".join(lines).upper())
    unit = named[1].decode().lower() if named else "mm"
    return {"inch": "in", "um": "µm"}.get(unit, unit)


def _imported(path: Path, kind: CadFormat) -> tuple[list[NamedSolid], set[int]]:
    remedy = "The file may be damaged or cut short: export the rod again, as STEP"
    if kind is CadFormat.BREP:  # the kernel would not stop at the end of a shape in text
        content = path.read_bytes()
        text = re.search(rb"^\s*(?:DBRep_DrawableShape\s+)?CASCADE Topology V", content[:_START])
        if text and not re.search(rb"[+-]\d+ \d+\s+(?:0\s*)?\Z", content[-_START:]):
            raise GeometryError(f"{path.name} ends before its last line, which names its shape. {remedy}")
    with kernel.attempt(f"read {path.name}", remedy):
        entities = _shapes(path, kind)
        loose = {dim for dim, _ in entities} == {2}
        if loose and kind in (CadFormat.IGES, CadFormat.STEP):
            entities = _closed(path, kind, entities)
        gmsh.model.occ.synchronize()
        beside = [entity for entity in entities if entity[0] != kernel.SOLID]
        if len(beside) < len(entities):  # planes and axes beside the solids would be meshed
            gmsh.model.occ.remove(beside, recursive=True)
            gmsh.model.occ.synchronize()
    solids = []
    for tag in (tag for dim, tag in entities if dim == kernel.SOLID):
        name = gmsh.model.getEntityName(3, tag).rpartition("/")[2]
        solids.append(NamedSolid(tag, "" if name.startswith(_UNNAMED) else _plain(name)))
    return solids, {dim for dim, _ in entities}


def _shapes(path: Path, kind: CadFormat) -> list[tuple[int, int]]:
    with path.open("rb") as file, ExitStack() as stack:
        if file.read(len(BOM_UTF8)) == BOM_UTF8:  # some editors put this mark before the text
            path = Path(stack.enter_context(tempfile.TemporaryDirectory()), path.name)
            path.write_bytes(file.read())
        entities = gmsh.model.occ.importShapes(str(path), format=_GMSH_FORMATS[kind])
    return [(int(dim), int(tag)) for dim, tag in entities]


def _closed(path: Path, kind: CadFormat, loose: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Read surfaces again and sew them into a solid, which IGES files leave to the reader."""
    boxes = np.reshape([gmsh.model.occ.getBoundingBox(*entity) for entity in loose], (-1, 3))
    gap, usual = _SEWN * float(np.ptp(boxes, axis=0).max()), gmsh.option.getNumber("Geometry.Tolerance")
    if gmsh.model.occ.getEntities(kernel.SOLID):  # beside what was read before
        gmsh.model.occ.remove(loose, recursive=True)
    else:
        name = gmsh.model.getCurrent()
        gmsh.model.remove()
        gmsh.model.add(name)
    gmsh.option.setNumber("Geometry.OCCSewFaces", 1)
    gmsh.option.setNumber("Geometry.Tolerance", gap)
    try:
        faces = [tag for dim, tag in _shapes(path, kind) if dim == 2]
        edges_of = [np.concatenate([*gmsh.model.occ.getCurveLoops(tag)[1], []]) for tag in faces]
        edges = np.concatenate(edges_of).astype(np.int64)
        owner = np.repeat(np.arange(len(faces)), [len(bounding) for bounding in edges_of])
        group = linked_groups(len(faces), *(owner[side] for side in twins(edges)))
        solids = []
        for number in range(group.max() + 1):
            uses = np.unique(edges[group[owner] == number], return_counts=True)[1]
            if (uses == 2).all():  # every edge belongs to two faces, or twice to one
                shell = gmsh.model.occ.addSurfaceLoop(np.array(faces)[group == number].tolist())
                solids.append(gmsh.model.occ.addVolume([shell]))
        loops = [loop for solid in solids for loop in gmsh.model.occ.getSurfaceLoops(solid)[1]]
        # Faces that the kernel has repaired copies of in a solid would be meshed beside it.
        loose_faces = [(2, tag) for tag in faces if not any(tag in loop for loop in loops)]
        if len(loose_faces) < len(faces):
            gmsh.model.occ.remove(loose_faces)
    finally:
        gmsh.option.setNumber("Geometry.OCCSewFaces", 0)
        gmsh.option.setNumber("Geometry.Tolerance", usual)
    return [(kernel.SOLID, int(tag)) for tag in solids] or [(2, tag) for tag in faces]


def _freecad(path: Path) -> tuple[list[NamedSolid], set[int]]:
    """Read the results of a document. Raises `GeometryError`: damaged, or more than `MOST_SHAPES`."""
    try:
        with zipfile.ZipFile(path) as archive:
            results = list(_results(archive))
    except _DAMAGES as error:
        if isinstance(error, OSError) and error.errno != errno.EINVAL:  # a place before the file's start
            raise
        reason = str(error).strip("'\"") or type(error).__name__
        raise GeometryError(
            f"{path.name} is not a readable FreeCAD file ({reason}). Save it again, or export the rod as STEP"
        ) from error
    named, kinds = [], set()
    scale = gmsh.option.getNumber("Geometry.OCCScaling")
    with tempfile.TemporaryDirectory() as folder:
        for number, (label, content, placements) in enumerate(results):
            file = Path(folder, f"{number}.brep")
            file.write_bytes(content)
            solids, dimensions = _imported(file, CadFormat.BREP)
            entities = [(kernel.SOLID, solid.tag) for solid in solids]
            for axis, angle, shift in placements if entities else ():
                if angle:
                    gmsh.model.occ.rotate(entities, 0, 0, 0, *axis, angle)
                gmsh.model.occ.translate(entities, *(scale * value for value in shift))
            kinds |= dimensions
            named += [NamedSolid(solid.tag, _plain(label)) for solid in solids]
    gmsh.model.occ.synchronize()
    return named, kinds


def step_file(rod: Rod) -> bytes:
    """Draw a rod in an open session, and return it as a STEP file in mm.

    Raises `GeometryError`: the kernel failed; `OSError`: the disk of temporary files is full.
    """
    build(rod, Mirror.NONE)
    with tempfile.TemporaryDirectory() as folder:  # gmsh chooses the format by the file's ending
        written = Path(folder) / "rod.step"
        with kernel.attempt("write the rod as STEP"), quiet():
            gmsh.write(str(written))
        content = written.read_bytes()
    if not content.rstrip().endswith(b"END-ISO-10303-21;"):  # the kernel does not notice a full disk
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), folder)
    return content
