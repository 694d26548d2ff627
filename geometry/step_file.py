"""STEP files: export a rod for other programs, and import solids from other programs."""

import errno
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gmsh

from geometry import kernel
from geometry.errors import GeometryError
from geometry.mirror import Mirror
from geometry.rod import Rod
from geometry.solid import build
from geometry.system.files import replaced

_KINDS = ("points", "curves", "surfaces", "solids")


def export_step(rod: Rod, path: Path) -> None:
    """Write the whole rod as a STEP file in millimetres, inside an open session.

    Raises
    ------
    GeometryError
        The CAD kernel failed.
    OSError
        The file cannot be written.
    """
    build(rod, Mirror.NONE)
    with tempfile.TemporaryDirectory() as folder:  # gmsh chooses the format by the file's ending
        written = Path(folder) / "rod.step"
        with kernel.attempt(f"write {path}"), _quiet():
            gmsh.write(str(written))
        content = written.read_bytes()
    if not content.rstrip().endswith(b"END-ISO-10303-21;"):  # the kernel does not notice a full disk
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    with replaced(path) as place:
        place.write_bytes(content)


def read_step(path: Path) -> tuple[list[int], list[str]]:
    """Read the solids of a file, in millimetres, into a new model; return volume tags and names.

    Raises
    ------
    GeometryError
        It is not a STEP file, or holds no solid.
    OSError
        The file cannot be read.
    """
    with path.open("rb") as file:
        if not file.read(200).lstrip().startswith(b"ISO-10303-21"):
            raise GeometryError(
                f"{path} is not a STEP file: it must begin with ISO-10303-21. Export the rod from CAD as STEP"
            )
    gmsh.model.add(path.stem)
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    with kernel.attempt(f"read {path}"), _quiet():
        entities = _imported(path)
    volumes = [tag for dim, tag in entities if dim == kernel.SOLID]
    if not volumes:
        kinds = ", ".join(sorted({_KINDS[dim] for dim, _ in entities})) or "nothing"
        raise GeometryError(f"{path} contains no solid, only {kinds}. Export the rod as a solid body")
    names = [gmsh.model.getEntityName(3, tag).rpartition("/")[2] for tag in volumes]
    if len(names) == 1:
        return volumes, ["rod"]
    unnamed = ("", "Open CASCADE STEP translator")  # the latter stands for no name
    return volumes, [
        f"part {number}" if name.startswith(unnamed[1]) or name == unnamed[0] else name
        for number, name in enumerate(names, 1)
    ]


def _imported(path: Path) -> list[tuple[int, int]]:
    """Let the kernel read a file into the open model."""
    entities = gmsh.model.occ.importShapes(str(path), format="step")
    gmsh.model.occ.synchronize()
    return [(int(dim), int(tag)) for dim, tag in entities]


@contextmanager
def _quiet() -> Iterator[None]:
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
