"""Tetrahedra inside the closed surface of an STL file, made by gmsh."""

import math
from pathlib import Path

import gmsh
import numpy as np

from geometry.session import session
from mesh.errors import MeshError
from mesh.files.msh_file import tets_of_model
from mesh.files.tet_file import TetFile

# Length of the body over the size of the elements: the surface is made of flat triangles, so that smaller
# elements would follow those rather than the solid.
PER_LENGTH = 70
# Angle at which the surface is divided into faces.
_FACE_ANGLE = math.radians(35.0)


def read_stl(path: Path) -> TetFile:
    """Mesh the volume inside a surface with straight-sided ten-node tetrahedra, in a gmsh session of its own.

    Raises
    ------
    MeshError
        The surface does not close a volume that gmsh can mesh.
    """
    with session():
        try:
            gmsh.merge(str(path))
            gmsh.model.mesh.removeDuplicateNodes()
            _require_closed()
            gmsh.model.mesh.classifySurfaces(_FACE_ANGLE, True, True, math.pi)  # noqa: FBT003 - gmsh's order
            gmsh.model.mesh.createGeometry()
            faces = [tag for _, tag in gmsh.model.getEntities(2)]
            gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(faces)])
            gmsh.model.geo.synchronize()
            box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
            size = float(np.ptp(box, axis=0).max()) / PER_LENGTH
            for name in ("MeshSizeMin", "MeshSizeMax"):
                gmsh.option.setNumber(f"Mesh.{name}", size)
            gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
            gmsh.model.mesh.generate(3)
            gmsh.model.mesh.setOrder(2)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises nothing more specific
            message = f"its surface could not be meshed ({error}). Export the rod as STEP"
            raise MeshError(message) from error
        return tets_of_model()


def _require_closed() -> None:
    """Refuse a surface with edges that do not belong to two triangles."""
    _, nodes = gmsh.model.mesh.getElementsByType(2)
    corners = nodes.reshape(-1, 3).astype(np.int64)
    sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(sides, axis=0, return_counts=True)
    if not len(corners):
        raise MeshError("it holds no triangles. Export the rod as STEP")
    if (uses != 2).any():
        open_sides = int((uses != 2).sum())
        raise MeshError(
            f"its surface is not closed: {open_sides} sides do not belong to exactly two triangles. Export "
            "the rod as STEP, or repair the surface"
        )
