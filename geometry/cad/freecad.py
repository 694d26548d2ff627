"""Shapes of a FreeCAD document: a zip archive with an XML description and Open CASCADE's BREP files."""

import errno
import math
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from geometry.errors import GeometryError

# Bytes of the description and of all shapes, unpacked: far more than any rod takes.
MOST_DESCRIPTION = 64 * 2**20
MOST_SHAPES = 512 * 2**20
# What the libraries raise where an archive is damaged.
_DAMAGES = (
    zipfile.BadZipFile,
    zlib.error,
    ET.ParseError,
    KeyError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    OSError,
)
# No placement, mm, is as large.
_FAR = 1e7
_BODY = "PartDesign::Body"
_CONTAINERS = ("App::Part", "App::DocumentObjectGroup", "Assembly::AssemblyObject")


@dataclass(frozen=True)
class Placement:
    """A turn about an axis through the origin (angle in rad), then a shift in mm."""

    axis: tuple[float, float, float]
    angle: float
    shift: tuple[float, float, float]


@dataclass(frozen=True)
class Shape:
    """A shape that is a result of the document."""

    label: str  #: of its object
    path: Path  #: A BREP file, as long as `shapes_of` is open
    placements: tuple[Placement, ...]  #: of the containers that hold it, the innermost first


@dataclass(frozen=True)
class _Object:
    kind: str
    label: str
    shape: str | None
    members: tuple[str, ...]
    placement: Placement | None


@contextmanager
def shapes_of(path: Path) -> Iterator[list[Shape]]:
    """Unpack the shapes that are results: bodies, and what no other shape is made from.

    Raises `GeometryError`: the archive is damaged, holds no description, or unpacks to more than
    `MOST_SHAPES`.
    """
    with tempfile.TemporaryDirectory() as folder:
        try:
            with zipfile.ZipFile(path) as archive:
                shapes = list(_unpacked(archive, Path(folder)))
        except _DAMAGES as error:
            if isinstance(error, OSError) and error.errno != errno.EINVAL:  # a place before the file's start
                raise
            reason = str(error).strip("'\"") or type(error).__name__
            raise GeometryError(
                f"{path.name} is not a readable FreeCAD file ({reason}). Save it again, or export the rod as "
                "STEP"
            ) from error
        yield shapes


def linked_files(path: Path) -> list[str]:
    """Names of other documents that a FreeCAD document takes parts from; none for a file of another kind."""
    if path.suffix.lower() != ".fcstd":
        return []
    with zipfile.ZipFile(path) as archive:
        root = ET.fromstring(_content(archive, "Document.xml", MOST_DESCRIPTION))  # noqa: S314 - as below
    files = (link.get("file", "") for link in root.iter("XLink"))
    return sorted({" ".join(Path(file).name.split()) for file in files if file})


def _content(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    with archive.open(name) as member:
        content = member.read(most + 1)
    if len(content) > most:
        raise GeometryError(f"{name} in the FreeCAD file unpacks to more than {most // 2**20} MiB")
    return content


def _described(text: bytes) -> tuple[dict[str, _Object], dict[str, set[str]]]:
    """Objects by name, and the names that each uses."""
    root = ET.fromstring(text)  # noqa: S314 - expat limits the expansion of entities
    kinds = {item.get("name", ""): item.get("type", "") for item in root.iterfind("Objects/Object")}
    uses = {
        item.get("Name", ""): {dep.get("Name", "") for dep in item.iterfind("Dep")}
        for item in root.iterfind("Objects/ObjectDeps")
    }
    objects = {}
    for item in root.iterfind("ObjectData/Object"):
        name = item.get("name", "")
        properties = {one.get("name"): one for one in item.iterfind("Properties/Property")}
        part = properties["Shape"].find("Part") if "Shape" in properties else None
        label = properties["Label"].find("String") if "Label" in properties else None
        group = properties.get("Group")
        objects[name] = _Object(
            kind=kinds.get(name, ""),
            label=name if label is None else label.get("value", name),
            shape=None if part is None else part.get("file") or None,
            members=() if group is None else tuple(link.get("value", "") for link in group.iter("Link")),
            placement=_placement(properties.get("Placement")),
        )
    return objects, uses


def _placement(element: ET.Element | None) -> Placement | None:
    value = None if element is None else element.find("PropertyPlacement")
    if value is None:
        return None
    x, y, z, w = (float(value.get(f"Q{i}", "0")) for i in range(4))
    shift = tuple(float(value.get(f"P{axis}", "0")) for axis in "xyz")
    if not all(abs(number) < _FAR for number in (x, y, z, w, *shift)):
        raise ValueError(f"a placement is out of range: {value.attrib}")
    size = math.sqrt(x * x + y * y + z * z)
    axis = (x / size, y / size, z / size) if size else (0.0, 0.0, 1.0)
    return Placement(axis, 2 * math.atan2(size, w), (shift[0], shift[1], shift[2]))


def _unpacked(archive: zipfile.ZipFile, folder: Path) -> Iterator[Shape]:
    objects, uses = _described(_content(archive, "Document.xml", MOST_DESCRIPTION))
    shaped = {name for name, one in objects.items() if one.shape}
    bodies = {name for name in shaped if objects[name].kind == _BODY}
    inside = {member for body in bodies for member in objects[body].members}
    free = shaped - bodies - inside
    used = {other for name in free | bodies for other in uses.get(name, set()) if name not in inside}
    # The shapes of containers only repeat those of their members.
    containers = {name for name, one in objects.items() if one.kind in _CONTAINERS}
    results = [name for name in objects if name in bodies - used or name in free - used - containers]
    left = MOST_SHAPES
    for number, name in enumerate(results):
        file = objects[name].shape
        content = _content(archive, str(file), left)
        left -= len(content)
        target = folder / f"{number}.brep"
        target.write_bytes(content)
        yield Shape(objects[name].label, target, tuple(_placements(objects, name)))


def _placements(objects: Mapping[str, _Object], name: str) -> Iterator[Placement]:
    """Placements of the containers around an object, the innermost first."""
    seen = {name}
    while True:
        around = [other for other, one in objects.items() if one.kind in _CONTAINERS and name in one.members]
        if not around or around[0] in seen:
            return
        name = around[0]
        seen.add(name)
        placement = objects[name].placement
        if placement is not None:
            yield placement
