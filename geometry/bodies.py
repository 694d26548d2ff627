"""Bodies swept from a plane outline, as data."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import gmsh

from geometry.errors import GeometryError
from geometry.kernel import SOLID, attempt, face, in_plan, in_profile
from geometry.segments import Curve, Line, Point
from geometry.surfaces import Surface


@dataclass(frozen=True)
class Side:
    """A piece of an outline, and the name of the surface that it sweeps."""

    curve: Curve
    surface: Surface


@dataclass(frozen=True)
class Prism:
    """An outline in x and y, extruded along z."""

    sides: tuple[Side, ...]  #: A closed chain: each curve starts where the one before ends
    #: z of the bottom, of planes at which the body is split so that nodes lie there, and of the top, mm
    levels: tuple[float, ...]
    #: bottom, top: names of these faces
    bottom: Surface = Surface.SYMMETRY_Z
    top: Surface = Surface.FREE


@dataclass(frozen=True)
class Revolution:
    """An outline in r ≥ 0 and z, turned by a quarter from `Surface.SYMMETRY_Y` to `Surface.SYMMETRY_X`."""

    #: A closed chain; a straight side on the axis sweeps no surface, and its name is not used
    sides: tuple[Side, ...]


@dataclass(frozen=True)
class SideBySide:
    """Bodies that touch, so that a mesh of them has common nodes where they do."""

    #: A face that two of them share lies inside the body, and its name is not used
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


_Named = list[tuple[Surface, int]]


def draw(body: Body) -> dict[Surface, tuple[int, ...]]:
    """Draw a body in a new model; return face tags per surface. Raises `GeometryError`: the kernel failed."""
    gmsh.model.add("body")
    with attempt("sweep the outline"):
        named = _side_by_side(body) if isinstance(body, SideBySide) else _swept(body)
    gmsh.model.occ.synchronize()
    for _, volume in gmsh.model.getEntities(SOLID):
        gmsh.model.mesh.setOutwardOrientation(volume)  # a swept face may point inwards
    faces: dict[Surface, tuple[int, ...]] = {}
    for surface, tag in named:
        faces[surface] = (*faces.get(surface, ()), tag)
    return faces


def _swept(body: Prism | Revolution) -> _Named:
    return _prism(body) if isinstance(body, Prism) else _revolution(body)


def _prism(body: Prism) -> _Named:
    base = face([side.curve for side in body.sides], (), in_plan)
    gmsh.model.occ.translate([(2, base)], 0, 0, body.levels[0])
    named, floor = [(body.bottom, base)], base
    for low, high in pairwise(body.levels):
        floor, *lateral = _faces(gmsh.model.occ.extrude([(2, floor)], 0, 0, high - low))
        named += _by_side(body.sides, lateral)
    return [*named, (body.top, floor)]


def _revolution(body: Revolution) -> _Named:
    base = face([side.curve for side in body.sides], (), in_profile)
    end, *lateral = _faces(gmsh.model.occ.revolve([(2, base)], 0, 0, 0, 0, 0, 1, math.pi / 2))

    def on_axis(one: Curve) -> bool:
        return isinstance(one, Line) and abs(one.start[0]) + abs(one.end[0]) < 1e-12 * one.length

    sweeping = [side for side in body.sides if not on_axis(side.curve)]
    return [(Surface.SYMMETRY_Y, base), (Surface.SYMMETRY_X, end), *_by_side(sweeping, lateral)]


def _side_by_side(body: SideBySide) -> _Named:
    occ = gmsh.model.occ
    middles = [(name, occ.getCenterOfMass(2, tag)) for part in body.parts for name, tag in _swept(part)]
    joined, _ = occ.fragment(occ.getEntities(SOLID), [])
    occ.synchronize()
    outer = gmsh.model.getBoundary(joined, combined=True, oriented=False)

    def named(tag: int) -> Surface:
        middle = occ.getCenterOfMass(2, tag)
        return min(middles, key=lambda drawn: math.dist(drawn[1], middle))[0]

    return [(named(tag), tag) for _, tag in outer]


def _faces(swept: Sequence[tuple[int, int]]) -> list[int]:
    return [tag for dimension, tag in swept if dimension == 2]


def _by_side(sides: Sequence[Side], lateral: Sequence[int]) -> _Named:
    if len(sides) != len(lateral):
        raise GeometryError(f"the CAD kernel swept {len(lateral)} faces from {len(sides)} sides")
    return [(side.surface, tag) for side, tag in zip(sides, lateral, strict=True)]
