"""How large the elements are, and where they are smaller."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import gmsh

from geometry.faces import Feature, FeatureKind

# Second-order elements through an arc, around a bore, across a web, along the rod.
PER_ARC, PER_BORE, PER_WEB, PER_LENGTH = 3, 32, 2, 40


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


def default_size(rod_length: float) -> float:
    """Element size away from features for a rod of this length, mm."""
    return rod_length / PER_LENGTH


def feature_size(feature: Feature) -> float:
    """Element size on a feature that resolves it at the default size, mm."""
    if feature.kind is FeatureKind.WEB:
        return feature.thickness / PER_WEB
    if feature.kind is FeatureKind.BORE:
        return feature.arc_length / PER_BORE
    return feature.arc_length / PER_ARC


def refinements(features: Sequence[Feature], size: float, rod_length: float) -> tuple[Refinement, ...]:
    """Refinements for these features; they follow `size` in proportion, so that halving it halves every element."""
    scale = size / default_size(rod_length)
    return tuple(
        Refinement(feature.faces, scale * feature_size(feature))
        for feature in features
        if math.isfinite(feature_size(feature))
    )


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
