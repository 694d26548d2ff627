"""Which two through-holes of an imported solid are the bores."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.cad.holes import CadHole, hollow_wall, through_holes, wall_groups
from geometry.cad.shapes import ROUND, Interior
from geometry.errors import GeometryError
from geometry.faces import Face, loop_points
from geometry.holes import (
    CLOSED,
    NAME_BORES,
    UNKNOWN,
    Axis,
    Balance,
    Diameters,
    bore_pairs,
    heavier_first,
    place_text,
)
from geometry.segments import fitted_circle

# Largest deviation from a circle, relative to the radius, with which an opening is meant to be round: that of
# a polygon with eight sides.
_NEARLY = 0.04
# Largest distance of its centre from the axis of a hole that it belongs to, relative to its radius.
_COAXIAL = 0.02
# Relative tolerance of diameters that the user gives.
SAME_DIAMETER = 1e-3
_LISTED = 8  # holes in a message
_ROUND = (
    f"Bores must be cylinders, to within {100 * ROUND:g} % of the radius: correct them in the CAD program"
)

Pair = tuple[CadHole, CadHole]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Opening(Axis):
    """An inner edge of a plane face, normal to it."""

    radius: float  #: of the fitted circle, mm
    deviation: float  #: largest distance of the edge from it, mm

    def text(self) -> str:
        """Say where it is and why it is no bore."""
        place = f"diameter {2 * self.radius:.5g} mm at {place_text(self.center)}"
        if self.deviation <= ROUND * self.radius:
            return f"{place}, whose wall is not a cylinder"
        share = 100 * self.deviation / self.radius
        return f"{place}, which differs from a circle by {self.deviation:.2g} mm, {share:.2g} % of its radius"


def find_bores(volumes: Sequence[int], faces: Sequence[Face], diameters: Diameters = UNKNOWN) -> Pair:
    """Find the two largest parallel through-holes; the larger, or that of the heavier end, is the big end's.

    Raises `HalfOpenError`: the largest hollow wall is open on one side; `GeometryError`: the bores cannot be
    identified; the message lists the holes and the keys that name the bores.
    """
    interior = Interior(volumes)
    holes = through_holes(interior, faces)
    odd = _odd_openings(interior, faces, holes)
    if not odd:
        splines = sum("spline" in face.shape.lower() for face in faces)
        if not holes and splines:
            raise GeometryError(
                f"no through-hole is a cylinder, and {splines} of {len(faces)} faces are splines. Export the "
                "solid again with cylindrical bores that are not converted to splines"
            )
    if diameters == UNKNOWN:
        walls = [hollow_wall(interior, group) for group in wall_groups(faces, at_most=CLOSED)]
        _require_closed(sorted(filter(None, walls), key=lambda wall: -wall.radius), holes)
    pairs = list(bore_pairs(holes, diameters, SAME_DIAMETER))
    if not pairs:
        remedy = f"{_not_round(odd)}. {_ROUND}" if odd and len(holes) < 2 else NAME_BORES
        raise GeometryError(f"no two parallel bores were found. Through-holes: {_list(holes)}. {remedy}")
    best = pairs[0]
    twice = len(pairs) > 1 and all(map(_alike, best, pairs[1]))
    if twice or (diameters[1] is None and _is_amid(best, holes)):
        raise GeometryError(f"more than one pair of holes could be the bores: {_list(holes)}. {NAME_BORES}")
    mass = np.array([gmsh.model.occ.getMass(3, volume) for volume in volumes])
    centers = np.array([gmsh.model.occ.getCenterOfMass(3, volume) for volume in volumes])
    middle = np.asarray(mass @ centers / mass.sum())
    ordered = heavier_first(best, middle) if _alike(*best) else best
    if diameters == UNKNOWN:
        larger = [one for one in odd if one.radius > min(bore.radius for bore in ordered)]
        if larger:
            raise GeometryError(
                f"the bores would be: {_list(ordered)}; but a larger hole is unused. {_not_round(larger)}. "
                f"{_ROUND}, or give the diameters of the bores as rod.big_end_bore_mm and "
                "rod.small_end_bore_mm"
            )
        balance = Balance.of(ordered, middle)
        if not balance.is_that_of_a_rod:
            raise GeometryError(
                f"the two largest parallel holes ({_list(ordered)}) are not the bores of a rod: "
                f"{balance.text()}. {NAME_BORES}, or keep only the rod with rod.solids"
            )
    return ordered


class HalfOpenError(GeometryError):
    """The wall of the largest bore, `wall`, is open on one side."""

    def __init__(self, wall: CadHole) -> None:
        self.wall = wall
        super().__init__(
            f"the largest bore is half open: its wall, {wall.text()}, covers only {360 * wall.turn:.0f}°. Is "
            'the cap missing? Give its file as rod.cap (--cap FILE), or rod.cap = "assumed" (--cap assumed) '
            "for a ring of the section at the joint. If another hole is the bore, give its diameter as "
            "rod.big_end_bore_mm"
        )

    def __reduce__(self) -> tuple[type["HalfOpenError"], tuple[CadHole]]:
        """Pickle the wall, for errors that come from another process."""
        return type(self), (self.wall,)


def _odd_openings(interior: Interior, faces: Sequence[Face], holes: Sequence[CadHole]) -> list[_Opening]:
    """Return the openings that lead through, but not to a cylindrical hole; the largest first."""
    openings = [opening for face in faces if face.shape == "Plane" for opening in _openings(face.tag)]
    odd = [  # neither of a hole, nor of a chamfer or counterbore about it
        one
        for one in openings
        if not any(
            abs(float(one.direction @ hole.direction)) > 1 - _COAXIAL
            and hole.apart(one) < _COAXIAL * one.radius
            for hole in holes
        )
    ]
    reach = float(np.ptp([corner for face in faces for corner in (face.low, face.high)], axis=0).max())
    through: list[_Opening] = []  # those that lead through, the largest of each axis
    for one in sorted(odd, key=lambda one: -one.radius):
        steps = np.linspace(-1, 1, 9) * min(2 * one.radius, reach)
        known = any(other.apart(one) < _COAXIAL * other.radius for other in through)
        if not known and not any(interior.contains(one.at(step)) for step in steps):
            through.append(one)
    return through


def _openings(face: int) -> Iterator[_Opening]:
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
            center = middle + circle.center @ across[:2]
            yield _Opening(center=center, direction=across[2], radius=circle.radius, deviation=deviation)


def _require_closed(open_walls: Sequence[CadHole], holes: Sequence[CadHole]) -> None:
    largest = max((hole.radius for hole in holes), default=0.0)
    if not open_walls or open_walls[0].radius <= largest:
        return
    wall, others = open_walls[0], (*holes, *open_walls[1:])
    if any(wall.parallel(other) and wall.apart(other) > wall.radius for other in others):
        raise HalfOpenError(wall)
    raise GeometryError(
        f"the largest hollow wall, {wall.text()}, covers only {360 * wall.turn:.0f}°, and no bore is "
        f"parallel to it: this is a cap, or another part of a rod. Add the rest to the file, or give the "
        "diameters of other holes as rod.big_end_bore_mm and rod.small_end_bore_mm"
    )


def _list(holes: Sequence[CadHole | _Opening]) -> str:
    more = [f"{len(holes) - _LISTED} smaller ones"] if len(holes) > _LISTED else []
    return "; ".join([*(one.text() for one in holes[:_LISTED]), *more]) or "none"


def _not_round(odd: Sequence[_Opening]) -> str:
    return f"Not a cylinder: {_list(odd)}"


def _is_amid(bores: Pair, holes: Sequence[CadHole]) -> bool:
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


def _alike(one: CadHole, other: CadHole) -> bool:
    return math.isclose(one.radius, other.radius, rel_tol=1e-3)
