"""The bolts and nuts of an imported assembly, measured before they are taken out of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.bolt_holes import BoltHole
from geometry.cad.cylinders import recognised
from geometry.cad.edges import edge_points, solid_points
from geometry.faces import faces_of

# A fastener's axis is that of its hole within this part of the hole's radius.
_COAXIAL = 0.2


@dataclass(frozen=True, eq=False)
class Fastener:
    """A solid that may be a bolt, a nut or a washer.

    Attributes
    ----------
    points
        (n, 3) along its edges, mm.
    planes
        Per plane face, points (n, 3) along its edges, mm.
    """

    points: Floats
    planes: tuple[Floats, ...]

    @classmethod
    def of(cls, volume: int) -> "Fastener":
        """Measure a volume of the open model."""
        faces = [recognised(face) for face in faces_of((volume,))]
        planes = tuple(edge_points(face.tag) for face in faces if face.shape == "Plane")
        return cls(solid_points(volume), planes)

    def is_in(self, hole: BoltHole) -> bool:
        """Whether its axis is that of a hole."""
        middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        return bool(hole.beside(middle[None])[0] < _COAXIAL * hole.radius)

    def contact(self, hole: BoltHole, level: float) -> float | None:
        """Outer radius, mm, of its plane face at a position along a hole, if it has one wider than the hole.

        Of a hexagon it is that of the inscribed circle.
        """
        slack = 0.05 * hole.radius
        radii = []
        for points in self.planes:
            beside = hole.beside(points)
            if np.abs(hole.along(points) - level).max() < slack and beside.max() > 1.05 * hole.radius:
                rim = points[beside > (beside.min() + beside.max()) / 2]
                radii.append(_inscribed(hole, rim))
        return max(radii, default=None)

    def end(self, hole: BoltHole) -> float:
        """Least position along a hole, mm: where it ends in the rod."""
        return float(hole.along(self.points).min())


def _inscribed(hole: BoltHole, rim: Floats) -> float:
    return float(hole.beside(rim).min())


def removed(volumes: Sequence[int]) -> list[Fastener]:
    """Measure solids and take them out of the model."""
    found = [Fastener.of(volume) for volume in volumes]
    gmsh.model.occ.remove([(3, volume) for volume in volumes], recursive=True)
    gmsh.model.occ.synchronize()
    return found
