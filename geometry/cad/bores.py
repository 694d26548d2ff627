"""Which two through-holes of an imported solid are the bores."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.cylinders import ROUND
from geometry.cad.holes import CLOSED, Hole, Interior, hollow_walls, place_text, through_holes
from geometry.errors import GeometryError
from geometry.faces import Face, loop_points
from geometry.holes import Balance
from geometry.segments import fitted_circle

# Largest deviation from a circle, relative to the radius, with which an opening is meant to be round: that of
# a polygon with eight sides.
_NEARLY = 0.04
# Largest distance of its centre from the axis of a hole that it belongs to, relative to its radius.
_COAXIAL = 0.02


@dataclass(frozen=True, eq=False)
class Opening:
    """A nearly round opening in a plane face."""

    # center, direction: mm, and the unit normal of the face
    center: Floats
    direction: Floats
    # radius, deviation: of the fitted circle, and the largest distance of the edge from it, mm
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


_LISTED = 8  # holes in a message
_ROUND = (
    f"Bores must be cylinders, to within {100 * ROUND:g} % of the radius: correct them in the CAD program"
)
_REMEDY = "Give the diameters of the bores as rod.big_end_bore_mm and rod.small_end_bore_mm"


def find_bores(
    volumes: Sequence[int], faces: Sequence[Face], named: tuple[float | None, float | None] = (None, None)
) -> tuple[Hole, Hole]:
    """Find the bores of the big and the small end: the two largest parallel through-holes.

    Of two with the same diameter, the one nearer to the centre of gravity is taken for the big end's.

    Parameters
    ----------
    volumes, faces
        Of the solid.
    named
        Diameters of the big-end and the small-end bore, mm, if the user has given them.

    Raises
    ------
    HalfOpenError
        The largest hollow wall is open on one side.
    GeometryError
        The bores cannot be identified; the message lists the holes found and the keys that name the bores.
    """
    interior = Interior(volumes)
    holes = through_holes(interior, faces)
    odd = odd_openings(interior, faces, holes)
    if not odd:
        _require_cylinders(holes, faces)
    if named == (None, None):
        _require_closed(hollow_walls(interior, faces, at_most=CLOSED), holes)
    big, small = ([hole for hole in holes if hole.has_diameter(name)] for name in named)
    pairs = [
        (one, other)
        for one, other in combinations(holes, 2)
        if one.parallel(other) and one.apart(other) > max(one.radius, other.radius)
    ]
    fitting = [
        pair if pair[0] in big and pair[1] in small else pair[::-1]
        for pair in pairs
        if (pair[0] in big and pair[1] in small) or (pair[1] in big and pair[0] in small)
    ]
    if not fitting:
        remedy = f"{_not_round(odd)}. {_ROUND}" if odd and len(holes) < 2 else _REMEDY
        raise GeometryError(f"no two parallel bores were found. Through-holes: {_texts(holes)}. {remedy}")
    best = fitting[0]
    twice = len(fitting) > 1 and _alike(best[1], fitting[1][1]) and _alike(best[0], fitting[1][0])
    if twice or (named[1] is None and _is_amid(best, holes)):
        raise GeometryError(f"more than one pair of holes could be the bores: {_texts(holes)}. {_REMEDY}")
    ordered = _heavier_first(best, volumes) if _alike(*best) else best
    if named == (None, None):
        _require_round(odd, ordered)
        _require_between(ordered, _middle(volumes))
    return ordered


class HalfOpenError(GeometryError):
    """The wall of the largest bore is open on one side.

    Attributes
    ----------
    wall
        The wall.
    """

    def __init__(self, wall: Hole) -> None:
        self.wall = wall
        super().__init__(
            f"the largest bore is half open: its wall, {wall.text()}, covers only {360 * wall.turn:.0f}°. Is "
            'the cap missing? Add it to the file, or set rod.cap = "assumed" for a ring of the section at '
            "the joint. If another hole is the bore, give its diameter as rod.big_end_bore_mm"
        )

    def __reduce__(self) -> tuple[type["HalfOpenError"], tuple[Hole]]:
        """Pickle the wall, for errors that come from another process."""
        return type(self), (self.wall,)


def _require_closed(open_walls: Sequence[Hole], holes: Sequence[Hole]) -> None:
    """Refuse a wall that is open on one side and larger than every hole."""
    largest = max((hole.radius for hole in holes), default=0.0)
    for wall in open_walls[:1]:
        if wall.radius <= largest:
            return
        others = (*holes, *open_walls[1:])
        if any(wall.parallel(other) and wall.apart(other) > wall.radius for other in others):
            raise HalfOpenError(wall)
        raise GeometryError(
            f"the largest hollow wall, {wall.text()}, covers only {360 * wall.turn:.0f}°, and no bore is "
            f"parallel to it: this is a cap, or another part of a rod. Add the rest to the file, or give the "
            "diameters of other holes as rod.big_end_bore_mm and rod.small_end_bore_mm"
        )


def _require_round(odd: Sequence[Opening], bores: tuple[Hole, Hole]) -> None:
    """Refuse openings larger than the smaller bore that are no cylinders: one of them may be the bore."""
    larger = [one for one in odd if one.radius > min(bore.radius for bore in bores)]
    if larger:
        found = "; ".join(bore.text() for bore in bores)
        raise GeometryError(
            f"the bores would be: {found}; but a larger hole is unused. {_not_round(larger)}. {_ROUND}, or "
            "give the diameters of the bores as rod.big_end_bore_mm and rod.small_end_bore_mm"
        )


def _not_round(odd: Sequence[Opening]) -> str:
    """List openings that are no cylinders."""
    return f"Not a cylinder: {_texts(odd)}"


def _texts(found: Sequence[Hole | Opening]) -> str:
    """List the largest."""
    more = [f"{len(found) - _LISTED} smaller ones"] if len(found) > _LISTED else []
    return "; ".join([*(one.text() for one in found[:_LISTED]), *more]) or "none"


def _require_between(bores: tuple[Hole, Hole], middle: Floats) -> None:
    """Refuse bores with the centre of gravity far from the line between them."""
    big, small = bores
    balance = Balance.of(big.direction, big.center, small.center, middle)
    if not balance.is_that_of_a_rod:
        raise GeometryError(
            f"the two largest parallel holes ({big.text()}; {small.text()}) are not the bores of a rod: "
            f"{balance.text()}. {_REMEDY}, or keep only the rod with rod.solids"
        )


def _require_cylinders(holes: Sequence[Hole], faces: Sequence[Face]) -> None:
    """Refuse a solid without cylindrical holes if it has spline faces: its bores may be splines."""
    splines = sum("spline" in face.shape.lower() for face in faces)
    if not holes and splines:
        raise GeometryError(
            f"no through-hole is a cylinder, and {splines} of {len(faces)} faces are splines. Export the "
            "solid again with cylindrical bores that are not converted to splines"
        )


def _is_amid(bores: tuple[Hole, Hole], holes: Sequence[Hole]) -> bool:
    """Whether one of the bores lies between the other and another hole of similar size.

    It may then be a hole in the shank that is larger than the pin bore, or even than the crank-pin bore. The
    holes of a master rod, close around its bore, are no such holes.
    """
    big, small = bores
    distance = big.apart(small)
    return any(
        (hole.radius > small.radius / 2 and hole.apart(big) > max(distance, hole.apart(small)))
        or (
            hole.radius > small.radius / 3 and hole.apart(small) > distance and hole.apart(big) > distance / 2
        )
        for hole in holes
        if hole.parallel(small)
    )


def _heavier_first(bores: tuple[Hole, Hole], volumes: Sequence[int]) -> tuple[Hole, Hole]:
    """Of two equal bores, take the one nearer to the centre of gravity for the big end's."""
    middle = _middle(volumes)
    one, other = bores
    along = (other.center - one.center) / np.linalg.norm(other.center - one.center)
    nearer_other = (middle - (one.center + other.center) / 2) @ along > 1e-6 * one.apart(other)
    return (other, one) if nearer_other else bores


def _middle(volumes: Sequence[int]) -> Floats:
    """Centre of gravity (3,) of volumes of one density."""
    mass = np.array([gmsh.model.occ.getMass(3, volume) for volume in volumes])
    centers = np.array([gmsh.model.occ.getCenterOfMass(3, volume) for volume in volumes])
    return np.asarray(mass @ centers / mass.sum())


def _alike(one: Hole, other: Hole) -> bool:
    return math.isclose(one.radius, other.radius, rel_tol=1e-3)
