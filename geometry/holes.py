"""Round holes of solids and meshes from files, and which two of them are the bores of a rod."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

import numpy as np

from geometry.arrays import Floats

# Sine of the angle between parallel axes.
PARALLEL = 1e-4
# Part of a turn from which on a wall is as good as closed: an oil hole or a notch may be missing from it.
CLOSED = 0.8
# Bores that identify themselves need nothing else; the others are named by the user.
EQUAL_BORES = (
    "the bores are of equal diameter, and the heavier end is taken for the big end's: swap_ends = true in "
    "[rod], or --swap-ends, takes the other one"
)
NAME_BORES = "Give the diameters of the bores as rod.big_end_bore_mm and rod.small_end_bore_mm"

# Diameters of the big-end and the small-end bore, mm, where the user has given them.
Diameters = tuple[float | None, float | None]
UNKNOWN: Diameters = (None, None)


@dataclass(frozen=True, eq=False, kw_only=True)
class Axis:
    """A straight line with a point from which positions along it count."""

    center: Floats  #: (3,), mm
    direction: Floats  #: unit vector (3,)

    def at(self, position: float) -> Floats:
        """Return the point (3,) at a position, mm."""
        return np.asarray(self.center + position * self.direction)

    def along(self, points: Floats) -> Floats:
        """Positions (n,) of points (n, 3), mm."""
        return np.asarray((points - self.center) @ self.direction)

    def beside(self, points: Floats) -> Floats:
        """Distances (n,) of points (n, 3) from it, mm."""
        away = points - self.center
        return np.asarray(np.linalg.norm(away - self.along(points)[:, None] * self.direction, axis=1))

    def parallel(self, other: "Axis") -> bool:
        """Whether it is parallel to another."""
        return bool(np.linalg.norm(np.cross(self.direction, other.direction)) < PARALLEL)

    def apart(self, other: "Axis") -> float:
        """Return the distance of a parallel axis, mm."""
        between = other.center - self.center
        return float(np.linalg.norm(between - (between @ self.direction) * self.direction))


@dataclass(frozen=True, eq=False, kw_only=True)
class RoundHole(Axis):
    """The wall of a cylindrical hole; its centre is at half its width."""

    radius: float  #: mm
    width: float  #: length along the axis, at its longest, mm
    area: float  #: of the wall, mm²
    turn: float = 1.0  #: part of a full turn that the wall covers: ½ for half a bore

    def joint_angle(self, places: Floats, middle: Floats, slack: float) -> float | None:
        """Angle about the axis, rad, of the joint face at an open end of the wall; None for another face.

        The face is plane, with places (n, 3) on it around a middle (3,). It begins at the wall, leads away
        and is aside of the axis by at most `slack`, over the radius.
        """
        arms = places - self.center - self.along(places)[:, None] * self.direction
        distance = np.linalg.norm(arms, axis=1)
        middle = middle - self.center - ((middle - self.center) @ self.direction) * self.direction
        off = float(np.linalg.norm(middle))
        if off < self.radius / 2 or np.ptp(distance) < slack * self.radius:
            return None
        aside = np.abs(arms @ np.cross(self.direction, middle / off)).max()
        if aside > slack * self.radius or abs(distance.min() / self.radius - 1) > slack:
            return None
        x, y = basis_across(self.direction)
        return math.atan2(float(middle @ y), float(middle @ x))

    def same_radius(self, radius: float | None, slack: float) -> bool:
        """Whether it has this radius, mm, to a relative tolerance; true where none is given."""
        return radius is None or math.isclose(self.radius, radius, rel_tol=slack)


Hole = TypeVar("Hole", bound=RoundHole)


def pin_wall(walls: Sequence[Hole]) -> Hole:
    """Return the coaxial wall that a pin touches: the narrowest one that is not just a lip."""
    most = max(wall.area for wall in walls)
    return min((wall for wall in walls if wall.area > most / 2), key=lambda wall: wall.radius)


def bore_pairs(holes: Sequence[Hole], diameters: Diameters, slack: float) -> Iterator[tuple[Hole, Hole]]:
    """Pairs of parallel holes that may be the bores, big end first; given diameters must be met."""
    radii = [None if diameter is None else diameter / 2 for diameter in diameters]
    for first, second in combinations(holes, 2):
        if first.parallel(second) and first.apart(second) > max(first.radius, second.radius):
            for pair in ((first, second), (second, first)):
                if all(hole.same_radius(radius, slack) for hole, radius in zip(pair, radii, strict=True)):
                    yield pair
                    break


def heavier_first(bores: tuple[Hole, Hole], middle: Floats) -> tuple[Hole, Hole]:
    """Of two equal bores, take the one nearer to the centre of gravity (3,) for the big end's."""
    first, second = bores
    along = (second.center - first.center) / np.linalg.norm(second.center - first.center)
    nearer_other = (middle - (first.center + second.center) / 2) @ along > 1e-6 * first.apart(second)
    return (second, first) if nearer_other else bores


def place_text(place: Floats) -> str:
    """Write coordinates, mm, without the remainders of rounding."""
    x, y, z = np.round(place, 4) + 0.0
    return f"({x:.4g}, {y:.4g}, {z:.4g})"


def rod_frame(axis: Floats, between: Floats) -> tuple[Floats, float]:
    """Unit vectors (3, 3) along the rod, across it and along its pins, as rows, and its length, mm.

    `axis` is the unit vector along the pins, `between` leads from the big end's axis to the small end's.
    """
    x = between - (between @ axis) * axis
    length = float(np.linalg.norm(x))
    x = x / length
    return np.stack([x, np.cross(axis, x), axis]), length


def basis_across(direction: Floats) -> Floats:
    """Two unit vectors (2, 3) across a direction and across each other, right-handed with it."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


# Largest distance of a rod's centre of gravity from the line between its bores, and from the ends of that
# line, over the distance of the bores: 0.06 and 0 on rods.
_OFF_LINE = 0.2


def off_the_rod(bores: tuple[RoundHole, RoundHole], middle: Floats) -> str:
    """Reason why holes cannot be the bores of a rod with a centre of gravity (3,); empty if they can."""
    big, small = bores
    frame, distance = rod_frame(big.direction, small.center - big.center)
    along, aside, _ = (frame @ (middle - big.center)).tolist()
    beyond = max(-along, along - distance, 0.0)
    if max(abs(aside), beyond) <= _OFF_LINE * distance:
        return ""
    return (
        f"the centre of gravity lies {abs(aside):.4g} mm beside and {beyond:.4g} mm beyond the line "
        f"between them, which is {distance:.4g} mm long"
    )


# Holes for the pins of other rods: their radius over that of the small end's bore at least, the length of
# their wall over the big end's, and their distance from its axis over its radius at most. Pins of master
# rods have 0.5 to 0.9 of the piston pin's radius; dowels and lightening holes are smaller, thinner, or in
# the shank.
_PIN, _PIN_LENGTH, _PIN_REACH = 0.3, 0.3, 2.5
# Half the width of the shank over the big end's radius: holes within it, on the shank's side, lighten it.
_SHANK = 0.4
_MASTER = 4  # pins from which on the rod is that of a radial engine


def carried_rods(bores: tuple[RoundHole, RoundHole], holes: Sequence[RoundHole]) -> str:
    """Describe the holes of pins about the big end that carry other rods; empty if there are none."""
    big, small = bores
    frame, length = rod_frame(big.direction, small.center - big.center)
    pins = []
    for hole in holes:
        if not hole.parallel(big) or min(hole.apart(bore) for bore in bores) < small.radius / 2:
            continue
        along, aside, _ = frame @ (hole.center - big.center)
        in_shank = along > big.radius and abs(aside) < _SHANK * big.radius
        large = hole.radius > _PIN * small.radius and hole.width > _PIN_LENGTH * big.width
        beside = hole.apart(big) < min(_PIN_REACH * big.radius, length)
        pins += [hole] if large and beside and not in_shank else []
    alike = [hole for hole in pins if hole.same_radius(pins[0].radius, 0.02)]
    if not pins or (len(alike) < _MASTER and max(pin.radius for pin in pins) < small.radius / 2):
        return ""
    kind = "a master rod of a radial engine" if len(alike) >= _MASTER else "a rod with articulated rods"
    sizes = ", ".join(dict.fromkeys(f"{2 * pin.radius:.4g} mm" for pin in pins))
    return (
        f"{len(pins)} hole{'s' * (len(pins) > 1)} of {sizes} beside the big end: this is {kind}, and the "
        "forces of the rods that hang on it are not analysed"
    )
