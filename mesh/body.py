"""Mesh a simple body in the same way as a rod."""

from collections.abc import Mapping
from dataclasses import dataclass

from geometry.bodies import Body, draw
from geometry.session import session
from geometry.surfaces import Surface
from mesh.generate import tetrahedralise
from mesh.sizing import Refinement, Sizing
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class Fine:
    """Smaller elements on a surface.

    Attributes
    ----------
    size
        Edge length on it, mm.
    reach
        Distance from the surface's edges within which the size stays, mm.
    """

    size: float
    reach: float = 0.0


def mesh_body(
    body: Body,
    size: float,
    *,
    order: int = 2,
    fine: Mapping[Surface, Fine] | None = None,
    growth: float = 0.4,
) -> TetMesh:
    """Draw and mesh a body in a gmsh session of its own.

    Parameters
    ----------
    body
        What to mesh.
    size
        Edge length away from fine surfaces, mm.
    order
        1 or 2.
    fine
        Surfaces with smaller elements.
    growth
        Increase of the edge length per distance from them, mm/mm.

    Raises
    ------
    GeometryError, MeshError
        No solid or no usable mesh could be made.
    """
    with session():
        faces = draw(body)
        refinements = [
            Refinement(faces[surface], asked.size, 4 * asked.reach) for surface, asked in (fine or {}).items()
        ]
        mesh, _ = tetrahedralise(faces, refinements, Sizing(size, order, growth))
    return mesh
