"""Cylindrical holes of an imported solid, closed or open on one side, and which two of them are the bores."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.shapes import ROUND, Interior, mismeasured, recognised_faces, wall_area
from geometry.errors import GeometryError
from geometry.faces import Face, edge_points, face_middle, loop_points
from geometry.holes import (
    CLOSED,
    NAME_BORES,
    PARALLEL,
    UNKNOWN,
    Axis,
    Diameters,
    RoundHole,
    bore_pairs,
    heavier_first,
    off_the_rod,
    pin_wall,
    place_text,
)
from geometry.segments import fitted_circle

# Largest distance of two axes, and difference of two radii, that count as one, relative to the radius: bores
# of rod and cap are drawn apart, and some are fitted.
_COAXIAL, _ALIKE = 1e-3, 2e-4
# Least part of a turn that a wall open on one side covers, more than which a fillet does not cover.
_OPEN = 0.3


@dataclass(frozen=True, eq=False, kw_only=True)
class CadHole(RoundHole):
    """A cylindrical hole of a solid."""

    moment: Floats  #: (3,) first moment of the wall's area about `center`, mm³
    faces: tuple[int, ...]  #: gmsh's tags of its wall, the largest first
    deviation: float = 0.0  #: by how much the axes and radii of its faces differ, mm
    fitted: bool = False  #: whether it is fitted to a face that is a surface of another kind

    @property
    def mean_width(self) -> float:
        """Mean length of its wall along the axis (the ends may be slanted, an oil hole cut into it), mm."""
        return self.area / (2 * math.pi * self.radius)

    def taper(self, direction: Floats) -> float:
        """Length of a wall with slanted ends on the side of a unit vector, over its mean length, mm."""
        return float(self.moment @ direction) / (math.pi * self.radius**2)

    def text(self) -> str:
        """Say where it is and how large."""
        return f"diameter {2 * self.radius:.5g} mm at {place_text(self.center)}, {self.width:.4g} mm long"


def through_holes(interior: Interior, faces: Sequence[Face]) -> list[CadHole]:
    """Return the cylindrical through-holes, one per axis, the largest radius first."""
    holes: list[CadHole] = []
    for group in _coaxial(faces):
        walls = [wall for wall in _walls(group) if wall.turn > CLOSED and _is_hollow(wall, interior)]
        ends = 0.55 * np.linspace(-1, 1, 5)  # a little beyond the wall's
        walls = [w for w in walls if not any(interior.contains(w.at(end * w.width)) for end in ends)]
        if walls:
            holes.append(pin_wall(walls))
    return sorted(holes, key=lambda hole: -hole.radius)


def wall_groups(faces: Sequence[Face], *, at_most: float = math.inf) -> list[list[CadHole]]:
    """Return cylindrical walls of ⅓ turn to `at_most` turns, by their axes, hollow or not."""
    groups = [[wall for wall in _walls(axis) if _OPEN < wall.turn <= at_most] for axis in _coaxial(faces)]
    return [group for group in groups if group]


def hollow_wall(interior: Interior, group: Sequence[CadHole]) -> CadHole | None:
    """Return the widest of coaxial walls with material outside them; None if there is none."""
    hollow = [wall for wall in group if _is_hollow(wall, interior)]
    return pin_wall(hollow) if hollow else None


def _coaxial(faces: Sequence[Face]) -> list[list[Face]]:
    groups: list[list[Face]] = []
    for face in faces:
        if face.shape != "Cylinder":
            continue
        for group in groups:
            point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
            offset = np.cross(np.array(face.values[:3]) - point, direction)
            turned = np.cross(np.array(face.values[3:6]), direction)
            if np.linalg.norm(offset) < _COAXIAL * group[0].values[6] and np.linalg.norm(turned) < PARALLEL:
                group.append(face)
                break
        else:
            groups.append([face])
    return groups


def _walls(group: Sequence[Face]) -> Iterator[CadHole]:
    point, direction = np.array(group[0].values[:3]), np.array(group[0].values[3:6])
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    alike: list[list[Face]] = []
    for face in sorted(group, key=lambda face: face.values[6]):
        if alike and face.values[6] - alike[-1][0].values[6] < _ALIKE * face.values[6]:
            alike[-1].append(face)
        else:
            alike.append([face])
    for same in alike:
        measured = [(face, *_area(face, point, direction)) for face in same]
        measured.sort(key=lambda each: -each[1])
        faces = [face for face, *_ in measured]
        areas, middles = (np.array([each[item] for each in measured]) for item in (1, 2))
        extents = np.array([_extent(face, point, direction) for face in faces])
        low, high = float(extents.min()), float(extents.max())
        covered, end = 0.0, -math.inf  # of the axis: a groove divides the wall of a bore into several
        for begin, stop in sorted(map(sorted, extents.tolist())):
            covered += max(0.0, stop - max(begin, end))
            end = max(end, stop)
        center, radius = point + (low + high) / 2 * direction, faces[0].values[6]
        apart = [np.cross(np.array(face.values[:3]) - point, direction) for face in faces]
        yield CadHole(
            center=center,
            direction=direction,
            radius=radius,
            width=high - low,
            area=float(areas.sum()),
            moment=areas @ (middles - center),
            faces=tuple(face.tag for face in faces),
            turn=float(areas.sum()) / (2 * math.pi * radius * covered),
            deviation=float(max(np.linalg.norm(apart, axis=1)) + np.ptp([face.values[6] for face in faces])),
            fitted=any(face.fitted for face in faces),
        )


def _area(face: Face, point: Floats, direction: Floats) -> tuple[float, Floats]:
    """Area, mm², and centroid (3,) of a cylindrical face about an axis."""
    if mismeasured(face):
        return wall_area(face.tag, point, direction, face.values[6])
    occ = gmsh.model.occ
    return float(occ.getMass(2, face.tag)), np.array(occ.getCenterOfMass(2, face.tag))


def _extent(face: Face, point: Floats, direction: Floats) -> Floats:
    if face.fitted:
        along = (edge_points(face.tag) - point) @ direction
        return np.array([along.min(), along.max()])
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face.tag)
    ends = np.reshape(gmsh.model.getValue(2, face.tag, [u0, v0, u1, v1]), (2, 3))
    return np.asarray((ends - point) @ direction)


def _is_hollow(wall: CadHole, interior: Interior) -> bool:
    """Whether there is material outside the largest face of a wall, and none before it."""
    point, normal = face_middle(wall.faces[0])
    out = point - wall.center
    out -= (out @ wall.direction) * wall.direction
    if gmsh.model.getAdjacencies(2, wall.faces[0])[0].size == 1:  # its normal points out of its only volume
        if out @ normal > 0:
            return False
        if len(interior.volumes) == 1:
            return True
    return not interior.contains(point - 2e-3 * out) and interior.contains(point + 2e-3 * out)


@dataclass(frozen=True)
class CylindricalFaces:
    """Cylindrical walls of a solid, the largest radius first: of a thousand faces, all take long."""

    interior: Interior
    groups: tuple[list[CadHole], ...]  #: walls with the same axis, those with the largest radius first

    def hollow(self) -> Iterator[CadHole]:
        """Find the hollow walls, one per axis, the largest radius first."""
        hollow: list[CadHole] = []
        for group in self.groups:
            least = max(wall.radius for wall in group)
            while hollow and hollow[0].radius >= least:
                yield hollow.pop(0)
            wall = hollow_wall(self.interior, group)
            hollow = sorted([*hollow, *([] if wall is None else [wall])], key=lambda wall: -wall.radius)
        yield from hollow

    def about(self, bore: CadHole, slack: float) -> Iterator[CadHole]:
        """Find the hollow wall on the axis of a bore, up to a distance relative to the bore's radius."""
        for group in self.groups:
            if group[0].parallel(bore) and group[0].apart(bore) < slack * bore.radius:
                wall = hollow_wall(self.interior, group)
                yield from () if wall is None else (wall,)


def cylindrical_faces(volume: int) -> CylindricalFaces:
    """Return the walls of a volume of the open model."""
    groups = wall_groups(recognised_faces((volume,)))
    groups.sort(key=lambda group: -max(wall.radius for wall in group))
    return CylindricalFaces(Interior((volume,)), tuple(groups))


# Largest deviation from a circle, relative to the radius, with which an opening is meant to be round: that of
# a polygon with eight sides.
_NEARLY = 0.04
# Largest distance of its centre from the axis of a hole that it belongs to, relative to its radius.
_ABOUT = 0.02
# Relative tolerance of diameters that the user gives.
SAME_DIAMETER = 1e-3
_LISTED = 8  # holes in a message
_TO_WITHIN = f"to within {100 * ROUND:g} % of the radius"
_ROUND = f"Bores must be cylinders, {_TO_WITHIN}: correct them in the CAD program"

Pair = tuple[CadHole, CadHole]


@dataclass(frozen=True, eq=False, kw_only=True)
class _Opening(Axis):
    """An inner edge of a plane face, normal to it."""

    radius: float  #: of the fitted circle, mm
    deviation: float  #: largest distance of the edge from it, mm

    def text(self) -> str:
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
    splines = sum("spline" in face.shape.lower() for face in faces)
    if splines and not (odd or holes):
        raise GeometryError(
            f"no through-hole is a cylinder, and {splines} of {len(faces)} faces are splines. Export the "
            "solid again with cylindrical bores that are not converted to splines"
        )
    if diameters == UNKNOWN:
        walls = [hollow_wall(interior, group) for group in wall_groups(faces, at_most=CLOSED)]
        _require_closed(sorted(filter(None, walls), key=lambda wall: -wall.radius), holes)
    pairs = list(bore_pairs(holes, diameters, SAME_DIAMETER))
    if not pairs:
        remedy = f"Not a cylinder: {_list(odd)}. {_ROUND}" if odd and len(holes) < 2 else NAME_BORES
        raise GeometryError(f"no two parallel bores were found. Through-holes: {_list(holes)}. {remedy}")
    best = pairs[0]
    twice = len(pairs) > 1 and all(
        bore.same_radius(again.radius, SAME_DIAMETER) for bore, again in zip(best, pairs[1], strict=True)
    )
    if twice or (diameters[1] is None and _is_amid(best, holes)):
        raise GeometryError(f"more than one pair of holes could be the bores: {_list(holes)}. {NAME_BORES}")
    mass = np.array([gmsh.model.occ.getMass(3, volume) for volume in volumes])
    centers = np.array([gmsh.model.occ.getCenterOfMass(3, volume) for volume in volumes])
    middle = np.asarray(mass @ centers / mass.sum())
    ordered = heavier_first(best, middle) if best[0].same_radius(best[1].radius, SAME_DIAMETER) else best
    if diameters == UNKNOWN:
        larger = [hole for hole in odd if hole.radius > min(bore.radius for bore in ordered)]
        if larger:
            raise GeometryError(
                f"the bores would be: {_list(ordered)}; but a larger hole is unused. Not a cylinder: "
                f"{_list(larger)}. {_ROUND}, or give the diameters of the bores as rod.big_end_bore_mm and "
                "rod.small_end_bore_mm"
            )
        if why := off_the_rod(ordered, middle):
            raise GeometryError(
                f"the two largest parallel holes ({_list(ordered)}) are not the bores of a rod: "
                f"{why}. {NAME_BORES}, or keep only the rod with rod.solids"
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
    openings = [opening for face in faces if face.shape == "Plane" for opening in _openings(face.tag)]
    odd = [  # neither of a hole, nor of a chamfer or counterbore about it
        opening
        for opening in openings
        if not any(
            abs(float(opening.direction @ hole.direction)) > 1 - _ABOUT
            and hole.apart(opening) < _ABOUT * opening.radius
            for hole in holes
        )
    ]
    reach = float(np.ptp([corner for face in faces for corner in (face.low, face.high)], axis=0).max())
    through: list[_Opening] = []  # those that lead through, the largest of each axis
    for opening in sorted(odd, key=lambda opening: -opening.radius):
        if any(larger.apart(opening) < _ABOUT * larger.radius for larger in through):
            continue
        steps = np.linspace(-1, 1, 9) * min(2 * opening.radius, reach)
        if not any(interior.contains(opening.at(step)) for step in steps):
            through.append(opening)
    return through


def _openings(face: int) -> Iterator[_Opening]:
    _, loops = gmsh.model.occ.getCurveLoops(face)
    if len(loops) < 2:
        return
    outlines = sorted((loop_points(loop) for loop in loops), key=lambda points: np.ptp(points, axis=0).max())
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
    return "; ".join([*(hole.text() for hole in holes[:_LISTED]), *more]) or "none"


def _is_amid(bores: Pair, holes: Sequence[CadHole]) -> bool:
    """Whether one of the bores lies between the other and another hole of similar size.

    It may then be a hole in the shank that is larger than the pin bore, or even than the crank-pin bore. The
    holes of a master rod, close around its bore, are not meant.
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
