"""Export a rod as a STEP file."""

import errno
import os
import tempfile
from pathlib import Path

import gmsh

from geometry import kernel
from geometry.cad.quiet import quiet
from geometry.mirror import Mirror
from geometry.rod import Rod
from geometry.solid import build
from geometry.system.files import replaced


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
        with kernel.attempt(f"write {path}"), quiet():
            gmsh.write(str(written))
        content = written.read_bytes()
    if not content.rstrip().endswith(b"END-ISO-10303-21;"):  # the kernel does not notice a full disk
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    with replaced(path) as place:
        place.write_bytes(content)
