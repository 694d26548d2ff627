"""Bodies swept from a plane outline, as data."""

import math
from dataclasses import dataclass

from geometry.segments import Arc, Line, Point
from geometry.surfaces import Surface


@dataclass(frozen=True)
class EllipticArc:
    """A piece, less than half, of an ellipse about the origin.

    Attributes
    ----------
    semi_axes
        Along the first and the second coordinate, mm.
    begin, end
        Values of the parameter t in (a cos t, b sin t), rad.
    """

    semi_axes: tuple[float, float]
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
class Side:
    """A piece of an outline, and the name of the surface that it sweeps."""

    curve: Curve
    surface: Surface


@dataclass(frozen=True)
class Prism:
    """An outline in x and y, extruded along z.

    Attributes
    ----------
    sides
        A closed chain: each curve starts where the one before ends.
    levels
        z of the bottom, of planes at which the body is split so that nodes lie there, and of the top, mm.
    bottom, top
        Names of these faces.
    """

    sides: tuple[Side, ...]
    levels: tuple[float, ...]
    bottom: Surface = Surface.SYMMETRY_Z
    top: Surface = Surface.FREE


@dataclass(frozen=True)
class Revolution:
    """An outline in r and z, r ≥ 0, turned about the z axis by a quarter from y = 0 to x = 0.

    The end faces are `Surface.SYMMETRY_Y` and `Surface.SYMMETRY_X`.

    Attributes
    ----------
    sides
        A closed chain; a straight side on the axis sweeps no surface, and its name is not used.
    """

    sides: tuple[Side, ...]


@dataclass(frozen=True)
class SideBySide:
    """Bodies that touch, so that a mesh of them has common nodes where they do.

    Attributes
    ----------
    parts
        A face that two of them share lies inside the body, and its name is not used.
    """

    parts: tuple[Prism | Revolution, ...]


Body = Prism | Revolution | SideBySide


def polygon(*corners: tuple[Point, Surface]) -> tuple[Side, ...]:
    """Join corners by straight sides, each named with the corner it starts from."""
    starts = [corner for corner, _ in corners]
    ends = starts[1:] + starts[:1]
    return tuple(Side(Line(a, b), name) for (a, name), b in zip(corners, ends, strict=True))


def block(length: float, width: float, height: float, name: Surface = Surface.FREE) -> Prism:
    """Box from the origin to (`length`, `width`, `height`), all of whose faces are called `name`."""
    corners = ((0.0, 0.0), (length, 0.0), (length, width), (0.0, width))
    return Prism(polygon(*((corner, name) for corner in corners)), (0.0, height), name, name)
