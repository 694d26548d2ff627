"""Element size: general, and smaller on features."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints
from geometry.faces import Feature, FeatureKind

# Neighbours considered when limiting the growth of sizes: the smallest sizes matter, and they are near.
_NEIGHBOURS = 64


def added(kind: str, **numbers: float) -> int:
    """Add a field of sizes of a kind, with its numbers, to the open gmsh model; return its tag."""
    field: int = gmsh.model.mesh.field.add(kind)
    for name, number in numbers.items():
        gmsh.model.mesh.field.setNumber(field, name, number)
    return field


@dataclass(frozen=True)
class RefinementBall:
    """A ball in which elements are no larger than `size`."""

    center: tuple[float, float, float]  #: (x, y, z) mm
    #: radius, size: mm
    radius: float
    size: float

    def add(self, largest: float, growth: float) -> int:
        """Add it to the open gmsh model, with sizes that grow to `largest`, mm; return its tag."""
        x, y, z = self.center
        ball = {"XCenter": x, "YCenter": y, "ZCenter": z, "Radius": self.radius}
        around = {"Thickness": max(largest - self.size, 0) / growth, "VOut": largest}
        return added("Ball", **ball, **around, VIn=min(self.size, largest))


@dataclass(frozen=True)
class SizeField:
    """Wanted edge lengths on a mesh of the solid as it is drawn."""

    points: Floats  #: (n_nodes, 3), mm
    tets: Ints  #: (n_elements, 4) vertices
    size: Floats  #: (n_nodes,) wanted edge length, mm, linear in between; used at vertices only

    def graded(self, growth: float) -> "SizeField":
        """Return the field with sizes that grow by at most `growth` per distance (mm/mm)."""
        vertices = np.unique(self.tets)
        places, wanted = self.points[vertices], self.size[vertices]
        small = np.flatnonzero(wanted < wanted.max())
        if not small.size:
            return self
        from scipy.spatial import KDTree  # noqa: PLC0415 - only a refined mesh needs it

        # An exact limit would need an advancing front; the nearest seeds give practically the same bound.
        seeds, sizes = places[small], wanted[small]
        distance, nearest = KDTree(seeds).query(places, k=min(_NEIGHBOURS, small.size))
        distance, nearest = distance.reshape(len(places), -1), nearest.reshape(len(places), -1)
        bound = np.minimum(wanted, (sizes[nearest] + growth * distance).min(axis=1))
        # Far from a large cluster of seeds, the smallest of all may not be among the nearest.
        least = int(sizes.argmin())
        bound = np.minimum(bound, sizes[least] + growth * np.linalg.norm(places - seeds[least], axis=1))
        size = self.size.copy()
        size[vertices] = bound
        return SizeField(self.points, self.tets, size)

    def add(self) -> int:
        """Add it to the open gmsh model; returns the tag of the background field."""
        view = gmsh.view.add("wanted sizes")
        corners = self.points[self.tets].transpose(0, 2, 1).reshape(len(self.tets), 12)
        rows = np.hstack([corners, self.size[self.tets]])
        gmsh.view.addListData(view, "SS", len(rows), rows.ravel())
        # Curved boundaries reach beyond the straight tetrahedra of the view.
        return added("PostView", ViewTag=view, UseClosest=1)


# Number of second-order elements along an arc, around a bore or a small hole, across a web, along the rod.
PER_ARC, PER_BORE, PER_HOLE, PER_WEB, PER_LENGTH = 4, 32, 12, 2, 28
# Across the ring at its joint with the cap, and around the seat of a bolt. An element between a bushing or
# shell and the rod is this many times as long as they are thick, but at least this part of one around a bore.
PER_JOINT, PER_SEAT, PER_THICKNESS, LEAST_FIT = 4, 14, 3.0, 0.4
# Around a bore that a pin touches, at least: sixteen on half of it give the largest pressure to half a
# percent. For a mesh that is to be refined half as many do. The cost of a crank cycle grows with the square.
PER_TOUCHED_BORE = 36

# Refinements coarsen with the general size up to this factor: coarser curved elements cannot follow an arc.
COARSEST = 2.4

_PER_THICKNESS = {FeatureKind.WEB: PER_WEB, FeatureKind.JOINT: PER_JOINT}
_PER_LENGTH = {FeatureKind.BORE: PER_BORE, FeatureKind.HOLE: PER_HOLE, FeatureKind.BOLT_SEAT: PER_SEAT}


@dataclass(frozen=True)
class Refinement:
    """Faces on which elements are smaller than elsewhere."""

    faces: tuple[int, ...]  #: gmsh's face tags
    size: float  #: edge length on the faces, mm
    #: Distance between the edges of the faces, mm: no point on them is farther than half of it from an edge
    width: float


@dataclass(frozen=True)
class Sizing:
    """Element size over the solid."""

    size: float  #: edge length away from refinements, mm
    order: int = 2  #: 1 or 2
    growth: float = 0.5  #: increase of the edge length per distance from a refined face, mm/mm


def default_size(rod_length: float) -> float:
    """Element size away from features for a rod of this length, mm."""
    return rod_length / PER_LENGTH


def feature_size(feature: Feature) -> float:
    """Element size that resolves a feature at the default general size, mm."""
    if feature.kind is FeatureKind.FIT:
        around = feature.arc_length / PER_BORE
        return min(max(PER_THICKNESS * feature.thickness, LEAST_FIT * around), around)
    if feature.kind in _PER_THICKNESS:
        return feature.thickness / _PER_THICKNESS[feature.kind]
    return feature.arc_length / _PER_LENGTH.get(feature.kind, PER_ARC)


def refinements(
    features: Sequence[Feature], size: float, rod_length: float, *, per_touched_bore: int = 0
) -> tuple[Refinement, ...]:
    """Refinements for these features, in proportion to `size`: halving it halves every element.

    On bores that a pin touches, elements are small enough for at least `per_touched_bore`.
    """
    scale = min(size / default_size(rod_length), COARSEST)
    wanted = []
    for feature in features:
        size = scale * feature_size(feature)
        if per_touched_bore and feature.kind is FeatureKind.BORE:
            size = min(size, feature.arc_length / per_touched_bore)
        wanted.append(Refinement(feature.faces, size, _width(feature)))
    return tuple(wanted)


def _width(feature: Feature) -> float:
    if feature.kind is FeatureKind.JOINT:
        return feature.thickness
    if feature.kind not in (FeatureKind.WEB, FeatureKind.BORE, FeatureKind.FIT):
        return feature.arc_length
    boxes = [gmsh.model.getBoundingBox(2, face) for face in feature.faces]
    extents = sorted(max(box[i + 3] for box in boxes) - min(box[i] for box in boxes) for i in range(3))
    return float(extents[1] if feature.kind is FeatureKind.WEB else extents[0])  # the web is flat


def apply(
    sizing: Sizing,
    refinements: Sequence[Refinement],
    wanted: Sequence[SizeField] = (),
    balls: Sequence[RefinementBall] = (),
) -> None:
    """Give the open model a background field of this size, these refinements, balls and wanted sizes."""
    field = gmsh.model.mesh.field
    finer = [each for each in refinements if each.size < sizing.size and each.faces]
    bounds = [_bound(refinement, sizing) for refinement in finer]
    bounds += [field.graded(sizing.growth).add() for field in wanted]
    bounds += [ball.add(sizing.size, sizing.growth) for ball in balls]
    if bounds:
        least = field.add("Min")
        field.setNumbers(least, "FieldsList", bounds)
        field.setAsBackgroundMesh(least)
    # The field alone decides; sizes at CAD points and extension inwards would override its growth.
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", sizing.size)
    # Curves are divided by an integral of 1/size: at gmsh's own 1e-9 it takes longer than the surfaces, for
    # numbers of elements that differ by less than 1 %.
    gmsh.option.setNumber("Mesh.LcIntegrationPrecision", 1e-3)


def _bound(refinement: Refinement, sizing: Sizing) -> int:
    size, near = refinement.size, refinement.width / 4  # the middle is reached from both edges
    edges = gmsh.model.getBoundary([(2, face) for face in refinement.faces], combined=False, oriented=False)
    curves = sorted({tag for _, tag in edges})
    longest = max(gmsh.model.occ.getMass(1, curve) for curve in curves)
    # Distance to the edges of the faces: gmsh samples curves a hundred times faster than faces.
    distance = added("Distance", Sampling=int(min(max(20, 2 * longest / size), 400)))
    gmsh.model.mesh.field.setNumbers(distance, "CurvesList", curves)
    far = near + (sizing.size - size) / sizing.growth
    grown = {"SizeMin": size, "SizeMax": sizing.size, "DistMin": near, "DistMax": far}
    return added("Threshold", InField=distance, **grown)


# Volume of a regular tetrahedron with unit edges; gmsh's elements have about two thirds of it.
_VOLUME = sqrt(2) / 12 * 2 / 3


def estimate(refinements: Sequence[Refinement], sizing: Sizing) -> float:
    """Estimate the number of elements that the open model will have.

    The edge length grows with the distance d from a refined face, h = s + g d. Per unit area of the face, the
    integral of h⁻³ over d adds (s⁻² - h∞⁻²) / 2 g to the element density h∞⁻³ of the rest of the volume.
    """
    kernel, size = gmsh.model.occ, sizing.size
    volume = sum(kernel.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    density = volume / size**3
    for refinement in refinements:
        if refinement.size < size:
            area = sum(kernel.getMass(2, face) for face in refinement.faces)
            density += area * (refinement.size**-2 - size**-2) / (2 * sizing.growth)
    return float(density / _VOLUME)
