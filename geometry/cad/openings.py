"""Openings in plane faces that look like those of bores, but are not those of cylinders."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.cylinders import ROUND
from geometry.cad.edges import loop_points
from geometry.cad.holes import Hole, place_text
from geometry.cad.interior import Interior
from geometry.circle import fitted_circle
from geometry.faces import Face

# Largest deviation from a circle, relative to the radius, with which an opening is meant to be round: that of
# a polygon with eight sides.
_NEARLY = 0.04
# Largest distance of its centre from the axis of a hole that it belongs to, relative to its radius.
_COAXIAL = 0.02


@dataclass(frozen=True, eq=False)
class Opening:
    """A nearly round opening in a plane face.

    Attributes
    ----------
    center, direction
        mm, and the unit normal of the face.
    radius, deviation
        Of the fitted circle, and the largest distance of the edge from it, mm.
    """

    center: Floats
    direction: Floats
    radius: float
    deviation: float

    def coaxial(self, other: "Opening") -> bool:
        """Whether it is the other end of the same hole."""
        away = np.cross(self.center - other.center, other.direction)
        return bool(np.linalg.norm(away) < _COAXIAL * other.radius)

    def text(self) -> str:
        """Say where it is and why it is no bore."""
        place = f"diameter {2 * self.radius:.5g} mm at {place_text(self.center)}"
        if self.deviation <= ROUND * self.radius:
            return f"{place}, whose wall is not a cylinder"
        share = 100 * self.deviation / self.radius
        return f"{place}, which differs from a circle by {self.deviation:.2g} mm, {share:.2g} % of its radius"


def odd_openings(interior: Interior, faces: Sequence[Face], holes: Sequence[Hole]) -> list[Opening]:
    """Return the openings that lead through, but not to a cylindrical hole; the largest first."""
    found = [opening for face in faces if face.shape == "Plane" for opening in _openings(face.tag)]
    odd = [one for one in found if not any(_belongs(one, hole) for hole in holes)]
    reach = float(np.ptp([corner for face in faces for corner in (face.low, face.high)], axis=0).max())
    through = sorted((one for one in odd if _is_free(one, interior, reach)), key=lambda one: -one.radius)
    return [one for place, one in enumerate(through) if not any(map(one.coaxial, through[:place]))]


def _openings(face: int) -> Iterator[Opening]:
    """The nearly round openings in a plane face: the loops of its edge but the outer one."""
    _, loops = gmsh.model.occ.getCurveLoops(face)
    if len(loops) < 2:
        return
    outlines = sorted((loop_points(loop) for loop in loops), key=lambda one: np.ptp(one, axis=0).max())
    for points in outlines[:-1]:
        middle = points.mean(axis=0)
        across = np.linalg.svd(points - middle, full_matrices=False)[2]
        places = (points - middle) @ across[:2].T
        circle = fitted_circle(places)
        if circle and (deviation := float(circle.distance(places).max())) < _NEARLY * circle.radius:
            yield Opening(middle + circle.center @ across[:2], across[2], circle.radius, deviation)


def _belongs(opening: Opening, hole: Hole) -> bool:
    """Whether an opening is that of a hole, or of a chamfer or counterbore about it."""
    away = np.cross(opening.center - hole.center, hole.direction)
    along = abs(float(opening.direction @ hole.direction))
    return bool(along > 1 - _COAXIAL and np.linalg.norm(away) < _COAXIAL * opening.radius)


def _is_free(opening: Opening, interior: Interior, reach: float) -> bool:
    """Whether its axis meets no material near the face."""
    steps = np.linspace(-1, 1, 9) * min(2 * opening.radius, reach)
    return not any(interior.contains(opening.center + step * opening.direction) for step in steps)
