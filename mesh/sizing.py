"""How large the elements are, and where they are smaller."""

from collections.abc import Sequence
from dataclasses import dataclass

import gmsh


@dataclass(frozen=True)
class Refinement:
    """Faces on which elements are smaller than elsewhere.

    Attributes
    ----------
    faces
        gmsh's face tags.
    size
        Edge length on the faces, mm.
    """

    faces: tuple[int, ...]
    size: float


@dataclass(frozen=True)
class Sizing:
    """Element size over the solid.

    Attributes
    ----------
    size
        Edge length away from refinements, mm.
    order
        1 or 2.
    growth
        Increase of the edge length per distance from a refined face, mm/mm.
    """

    size: float
    order: int = 2
    growth: float = 0.4


def apply(sizing: Sizing, refinements: Sequence[Refinement]) -> None:
    """Give the open model a background field with this size and these refinements."""
    field = gmsh.model.mesh.field
    bounds = []
    for refinement in refinements:
        if refinement.size >= sizing.size or not refinement.faces:
            continue
        distance = field.add("Distance")
        field.setNumbers(distance, "SurfacesList", refinement.faces)
        field.setNumber(distance, "Sampling", 40)
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", refinement.size)
        field.setNumber(threshold, "SizeMax", sizing.size)
        near = refinement.size / 2
        field.setNumber(threshold, "DistMin", near)
        field.setNumber(threshold, "DistMax", near + (sizing.size - refinement.size) / sizing.growth)
        bounds.append(threshold)
    if bounds:
        least = field.add("Min")
        field.setNumbers(least, "FieldsList", bounds)
        field.setAsBackgroundMesh(least)
    # The field says it all; sizes at CAD points and extension inwards would override its growth.
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", sizing.size)
