"""Straight and circular pieces of plane outlines, exact."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats

Point = tuple[float, float]


@dataclass(frozen=True)
class Line:
    """A straight piece from `start` to `end`, mm."""

    start: Point
    end: Point

    @property
    def length(self) -> float:
        """Length, mm."""
        return math.dist(self.start, self.end)

    def mirrored(self) -> "Line":
        """Reflect about y = 0 and turn round, so that a mirrored chain runs on."""
        return Line(_flip(self.end), _flip(self.start))

    def turned(self, angle: float) -> "Line":
        """Turn it about the origin, anticlockwise by an angle, rad."""
        return Line(_turn(self.start, angle), _turn(self.end, angle))

    def height(self, x: Floats) -> Floats:
        """Return the ordinates at `x`; −∞ beyond the ends and where the piece is vertical."""
        (x0, y0), (x1, y1) = self.start, self.end
        if x0 == x1:
            return np.full_like(x, -np.inf)
        y = y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        return np.where(_within(x, x0, x1), y, -np.inf)


@dataclass(frozen=True)
class Arc:
    """A circular piece about `center`, mm, from angle `begin` by `sweep` (rad, positive anticlockwise)."""

    center: Point
    radius: float
    begin: float
    sweep: float

    @classmethod
    def towards(
        cls, center: Point, radius: float, first: Point, last: Point, *, anticlockwise: bool
    ) -> "Arc":
        """Draw from the direction of `first` to that of `last`, as seen from `center`."""
        begin = math.atan2(first[1] - center[1], first[0] - center[0])
        turn = (math.atan2(last[1] - center[1], last[0] - center[0]) - begin) % (2 * math.pi)
        return cls(center, radius, begin, turn if anticlockwise else turn - 2 * math.pi)

    def at(self, share: float) -> Point:
        """Return the point at a share (0…1) of the sweep."""
        angle, (x, y) = self.begin + share * self.sweep, self.center
        return x + self.radius * math.cos(angle), y + self.radius * math.sin(angle)

    @property
    def start(self) -> Point:
        """First point."""
        return self.at(0)

    @property
    def end(self) -> Point:
        """Last point."""
        return self.at(1)

    @property
    def length(self) -> float:
        """Length, mm."""
        return self.radius * abs(self.sweep)

    def reversed(self) -> "Arc":
        """Run the other way."""
        return Arc(self.center, self.radius, self.begin + self.sweep, -self.sweep)

    def mirrored(self) -> "Arc":
        """Reflect about y = 0 and turn round, so that a mirrored chain runs on."""
        return Arc(_flip(self.center), self.radius, -(self.begin + self.sweep), self.sweep)

    def turned(self, angle: float) -> "Arc":
        """Turn it about the origin, anticlockwise by an angle, rad."""
        return Arc(_turn(self.center, angle), self.radius, self.begin + angle, self.sweep)

    def height(self, x: Floats) -> Floats:
        """Ordinates at `x` of a piece towards +x, −∞ beyond its ends; above its centre if clockwise."""
        across = np.clip(x - self.center[0], -self.radius, self.radius)
        y = self.center[1] - math.copysign(1, self.sweep) * half_chord(self.radius, across)
        return np.where(_within(x, self.start[0], self.end[0]), y, -np.inf)


Segment = Line | Arc


def half_chord(radius: float | Floats, across: Floats) -> Floats:
    """Return √(radius² − across²); 0 where rounding, or the circle, leaves nothing."""
    return np.asarray(np.sqrt(np.maximum(radius**2 - across**2, 0.0)))


def mirrored(chain: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Reflect a chain about y = 0 and turn it round: it ends where the image of its start lies."""
    return tuple(piece.mirrored() for piece in reversed(chain))


def _within(x: Floats, a: float, b: float) -> npt.NDArray[np.bool_]:
    slack = 1e-12 * (abs(a) + abs(b))
    return (x >= min(a, b) - slack) & (x <= max(a, b) + slack)


def _turn(point: Point, angle: float) -> Point:
    (x, y), c, s = point, math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def _flip(point: Point) -> Point:
    return point[0], -point[1]


@dataclass(frozen=True)
class EllipticArc:
    """A piece, less than half, of an ellipse about the origin."""

    semi_axes: tuple[float, float]  #: along the first and the second coordinate, mm
    #: begin, end: values of the parameter t in (a cos t, b sin t), rad
    begin: float
    end: float

    def at(self, share: float) -> Point:
        """Return the point at a share (0…1) of the parameter's range."""
        t = self.begin + share * (self.end - self.begin)
        return self.semi_axes[0] * math.cos(t), self.semi_axes[1] * math.sin(t)

    @property
    def start(self) -> Point:
        """First point."""
        return self.at(0)


Curve = Line | Arc | EllipticArc


@dataclass(frozen=True)
class Circle:
    """A circle in a plane: centre (2,) and radius, mm."""

    center: Floats
    radius: float

    def distance(self, places: Floats) -> Floats:
        """Distance (…,) of places (…, 2) from the circle, mm."""
        return np.asarray(np.abs(np.linalg.norm(places - self.center, axis=-1) - self.radius))


def fitted_circle(places: Floats) -> Circle | None:
    """Least-squares circle through places (n, 2), mm; None for a straight line.

    Source: Kåsa (1976), IEEE Transactions on Instrumentation and Measurement 25(1), 8-14.
    """
    middle = places.mean(axis=0)
    off = places - middle
    table = np.column_stack([2 * off, np.ones(len(off))])
    (a, b, c), _, rank, _ = np.linalg.lstsq(table, (off**2).sum(axis=1), rcond=1e-10)
    square = c + a * a + b * b
    return None if rank < 3 or square <= 0 else Circle(middle + np.array([a, b]), float(np.sqrt(square)))
