"""Places on a rod: in words, and whether they lie on the bores, on the faces beside them, or on the rest.

The regions of the surface are found by geometry, for rods of any origin. Machined like the bores themselves
are surfaces around their axes that face them (chamfers and rounds of their ends, grooves) and the faces where
parts meet. The faces beside the bores are plane, adjoin a bore or its chamfer, lie roughly across the pins,
and end where the ring ends.
"""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from fea.base.choices import Region
from fea.base.material import Material, support_factor
from fea.rod.meshed_rod import Bores, MeshedRod
from fea.solid.surface_gradient import relative_gradient
from fea.study.assembly_table import BUSHING, UPPER_SHELL
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.creases import SurfaceMesh
from mesh.tetmesh import FACET_EDGES, TetMesh

# Surfaces of a bore's ends and grooves are within this multiple of its radius.
_END = 1.2
# Cosines of normals: with the direction to the axis, at least; across that direction, at most; with the pins,
# at least (the faces of a slanted small end are turned). Angle between facets of one plane, rad, at most.
_FACING, _AROUND, _ACROSS_PINS, _PLANE = 0.1, 0.2, 0.7, 1.414e-3


@dataclass(frozen=True)
class SurfaceRegions:
    """The regions that each node belongs to."""

    #: (n_nodes, 3) whether it lies on each `Region`; on several at edges, on none inside the solid
    touched: Mask
    #: (n_nodes,) relative gradient of the stress amplitude, 1/mm, where it supports the surface; None where
    #: it is not known
    gradient: Floats | None = None

    @classmethod
    def of(cls, mesh: TetMesh, bores: Bores) -> "SurfaceRegions":
        """Find the regions of a meshed rod or of its symmetry cell."""
        touched = np.zeros((len(Region), len(mesh.points)), dtype=bool)
        bore, face, rest = touched  # in the order of `Region`
        bore[mesh.facets[Surface.BIG_END_BORE]] = True
        bore[mesh.facets[Surface.SMALL_END_BORE]] = True
        if mesh.part is not None:  # the faces where parts meet
            nodes, owner = mesh.tets.ravel(), np.repeat(mesh.part, mesh.tets.shape[1])
            part = np.zeros(len(mesh.points), dtype=np.int64)
            part[nodes] = owner  # of several parts any
            bore[nodes[part[nodes] != owner]] = True
        facets = mesh.facets.get(Surface.FREE, np.zeros((0, 3), dtype=np.int64))
        flat = SurfaceMesh(mesh.points, facets[:, :3])
        center, normal = flat.corners.mean(axis=1), flat.normals
        machined = np.zeros(len(facets), dtype=bool)
        ends = ((0.0, bores.big_radius, -1), (bores.rod_length, bores.small_radius, 1))
        within = [float((outwards * (mesh.points[:, 0] - x)).max()) for x, _, outwards in ends]
        for x, radius, _ in ends:
            radial = (center[:, :2] - [x, 0.0]) / _away(center, x)[:, None]
            outward = (normal[:, :2] * radial).sum(axis=1)
            around = normal[:, 1] * radial[:, 0] - normal[:, 0] * radial[:, 1]
            facing = (outward < -_FACING) & (np.abs(around) < _AROUND) & (_away(center, x) <= _END * radius)
            bore[facets[facing]] = True
            machined |= facing
        for (x, _, _), reach in zip(ends, within, strict=True):
            near = ~machined & (np.abs(normal[:, 2]) > _ACROSS_PINS) & (_away(center, x) <= reach)
            for patch in flat.patches(near, _PLANE):
                edges = facets[patch][:, FACET_EDGES]
                if bore[edges].all(axis=2).any():  # the plane adjoins a bore along an edge
                    face[facets[patch]] = True
                    machined[patch] = True
        rest[facets[~machined]] = True
        return cls(touched.T.copy())

    def at(self, nodes: Ints) -> "SurfaceRegions":
        """Return those of some nodes, which may repeat."""
        gradient = None if self.gradient is None else self.gradient[nodes]
        return SurfaceRegions(self.touched[nodes], gradient)

    def factors(self, material: Material) -> Floats:
        """Return k_a (n_nodes,) of a material: at an edge the least, 1 inside, where there is no surface.

        It is multiplied by the support of the gradient, where that is known and the material has it.
        """
        least = np.where(self.touched, _every(material), np.inf).min(axis=1)
        return np.where(np.isinf(least), 1.0, least) * self.support(material)

    def factor(self, node: int, material: Material) -> float:
        """Return what `factors` has for one node."""
        return float(self.at(np.array([node])).factors(material)[0])

    def support(self, material: Material) -> Floats:
        """Return n_σ (n_nodes,) of a material; 1 where there is none."""
        if self.gradient is None or not material.support or material.ultimate_strength is None:
            return np.ones(len(self.touched))
        return support_factor(self.gradient, material.ultimate_strength)

    @property
    def on_bores(self) -> Mask:
        """Whether each node lies on the bores, where no gradient supports: the pins press there."""
        return self.touched[:, list(Region).index(Region.BORES)]

    def supported(self, mesh: TetMesh, amplitude: Floats, masked: Mask) -> "SurfaceRegions":
        """Return the same places of a mesh with the gradients of an amplitude (n_nodes,); none if masked."""
        if (free := mesh.facets.get(Surface.FREE)) is None:
            return self
        found = np.maximum(relative_gradient(mesh, free, amplitude[:, None]), 0.0)
        return replace(self, gradient=np.where(masked | self.on_bores, 0.0, found))

    def without_support(self) -> "SurfaceRegions":
        """Return the same places, where the local stress counts fully."""
        return replace(self, gradient=None)

    def region(self, node: int, material: Material) -> Region | None:
        """Return the region with the least k_a at a node; None inside the solid."""
        if not self.touched[node].any():
            return None
        return list(Region)[int(np.where(self.touched[node], _every(material), np.inf).argmin())]


def _every(material: Material) -> Floats:
    """k_a (3,) of every `Region`."""
    return np.array([material.marin.surfaces[region].factor for region in Region])


def _away(places: Floats, x: float) -> Floats:
    """Distance (n,) of places (n, 3) from the axis of a bore."""
    return np.hypot(places[:, 0] - x, places[:, 1])


# Surfaces by which a place is known; where several meet, the first.
_NAMES = {
    Surface.BIG_END_BORE: "big-end bore",
    Surface.SMALL_END_BORE: "small-end bore",
    Surface.BOLT_HEAD: "seat of a bolt head",
    Surface.BOLT_THREAD: "seat of a nut or thread",
    Surface.JOINT: "joint",
    Surface.JOINT_CAP: "joint",
    Surface.BUSHING_SEAT: "seat of the bushing",
    Surface.BUSHING_BACK: "seat of the bushing",
    Surface.SHELL_SEAT: "seat of the shells",
    Surface.SHELL_BACK: "seat of the shells",
}
# What lines a bore, where the rod has such a part.
_LININGS = {
    Surface.BIG_END_BORE: (UPPER_SHELL, "bore of the bearing shells"),
    Surface.SMALL_END_BORE: (BUSHING, "bore of the bushing"),
}
# Shares of the length between the rings up to which a place on the shank is at its end, and towards it.
_AT_END, _TOWARDS_END = 0.1, 0.4


def place_name(mesh: MeshedRod, node: int) -> str:
    """Return where a node of the whole rod is: a bore or a seat, an end, the cap, or a part of the shank."""
    return place_names(mesh, np.array([node]))[0]


def place_names(mesh: MeshedRod, nodes: Ints) -> list[str]:
    """Return `place_name` of several nodes (n,)."""
    whole = mesh.whole
    points, along = whole.points[nodes], whole.points[:, 0]
    length = mesh.bores.rod_length
    big, small = -float(along.min()), float(along.max()) - length  # outer radii of the ends
    names = [_between_bores(place, length, big, small) for place in points.tolist()]
    for surface, name in reversed(_NAMES.items()):
        if surface in whole.facets:
            part, lining = _LININGS.get(surface, ("", name))
            for row in np.flatnonzero(np.isin(nodes, whole.facets[surface])):
                names[row] = lining if part in mesh.parts else name
    return names


def _between_bores(place: list[float], length: float, big: float, small: float) -> str:
    x, y, _ = place
    if hypot(x, y) <= big:
        return "cap" if x < 0 else "big end"
    if hypot(x - length, y) <= small:
        return "small end"
    share = float(np.clip((x - big) / (length - small - big), 0.0, 1.0))
    end = "big end" if share < 1 / 2 else "small end"
    from_end = min(share, 1 - share)
    if from_end > _TOWARDS_END:
        return "middle of the shank"
    return f"shank at the {end}" if from_end < _AT_END else f"shank towards the {end}"
