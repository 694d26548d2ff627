"""Drawing steps with gmsh's OpenCASCADE kernel, inside an open session."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import gmsh

from geometry.arrays import Vector
from geometry.errors import GeometryError
from geometry.segments import Arc, Curve, EllipticArc, Line, Point

Placing = Callable[[Point], Vector]
SOLID = 3


@contextmanager
def attempt(what: str, remedy: str = "Change the dimensions involved slightly") -> Iterator[None]:
    """Turn any error of the kernel while it tries to do `what` into a `GeometryError`."""
    try:
        yield
    except GeometryError:
        raise
    except Exception as error:  # gmsh raises nothing more specific
        message = f"the CAD kernel could not {what}: {error}. {remedy}"
        raise GeometryError(message) from error


def in_plan(point: Point) -> Vector:
    """Place a point of the plan at z = 0."""
    return point[0], point[1], 0.0


def in_profile(point: Point) -> Vector:
    """Place a point (x, z) of the side view at y = 0."""
    return point[0], 0.0, point[1]


def face(outer: Sequence[Curve], holes: Sequence[Sequence[Curve]], place: Placing) -> int:
    """Draw a plane face bounded by closed chains of segments."""
    return int(gmsh.model.occ.addPlaneSurface([_loop(chain, place) for chain in (outer, *holes)]))


def prism(outer: Sequence[Curve], holes: Sequence[Sequence[Curve]], bottom: float, top: float) -> int:
    """Extrude a plan along z."""
    base = face(outer, holes, in_plan)
    gmsh.model.occ.translate([(2, base)], 0, 0, bottom)
    swept = gmsh.model.occ.extrude([(2, base)], 0, 0, top - bottom)
    return _only_volume(swept)


def prism_along_y(profile: Sequence[Curve], half: float) -> int:
    """Extrude a side view (x, z) along y from −half to half."""
    base = face(profile, (), in_profile)
    gmsh.model.occ.translate([(2, base)], 0, -half, 0)
    return _only_volume(gmsh.model.occ.extrude([(2, base)], 0, 2 * half, 0))


def revolution(profile: Sequence[Curve], x: float, sector: float = math.pi) -> int:
    """Turn a profile (distance, z) about the z-parallel axis at `x`, from −sector to sector (rad)."""
    base = face(profile, (), in_profile)
    gmsh.model.occ.translate([(2, base)], x, 0, 0)
    if sector < math.pi:
        gmsh.model.occ.rotate([(2, base)], x, 0, 0, 0, 0, 1, -sector)
    swept = gmsh.model.occ.revolve([(2, base)], x, 0, 0, 0, 0, 1, 2 * sector)
    if sector == math.pi:
        gmsh.model.occ.remove([(2, base)], recursive=True)  # else it would be meshed as a loose face
    return _only_volume(swept)


def cut(body: int, tools: Sequence[int]) -> int:
    """Subtract tools from a body; they are used up."""
    if not tools:
        return body
    left, _ = gmsh.model.occ.cut([(SOLID, body)], [(SOLID, tool) for tool in tools])
    return _only_volume(left)


def drilled(bodies: Sequence[int], tools: Sequence[int]) -> list[int]:
    """Subtract tools from several bodies at once, which keep their common faces; the tools are used up."""
    if not tools:
        return list(bodies)
    _, pieces = gmsh.model.occ.cut([(SOLID, body) for body in bodies], [(SOLID, tool) for tool in tools])
    return [_only_volume(pieces[number]) for number in range(len(bodies))]


def common(one: int, other: int) -> int:
    """Return the intersection of two bodies, which are used up."""
    left, _ = gmsh.model.occ.intersect([(SOLID, one)], [(SOLID, other)])
    return _only_volume(left)


def turned_over(body: int) -> int:
    """Draw a copy turned half round about the x axis: the image about z = 0 if symmetric about y = 0."""
    copies = gmsh.model.occ.copy([(SOLID, body)])
    gmsh.model.occ.rotate(copies, 0, 0, 0, 1, 0, 0, math.pi)  # occ.mirror would make splines of cylinders
    return _only_volume(copies)


def rounded(body: int, radius: float, chosen: Callable[[float, float, float], bool]) -> int:
    """Round the edges of a body that are `chosen` by the middles of their bounding boxes."""
    gmsh.model.occ.synchronize()
    edges = []
    for _, tag in gmsh.model.getBoundary([(SOLID, body)], combined=False, oriented=False, recursive=False):
        for _, edge in gmsh.model.getBoundary([(2, tag)], oriented=False):
            low_x, low_y, low_z, x, y, z = gmsh.model.getBoundingBox(1, edge)
            if chosen((low_x + x) / 2, (low_y + y) / 2, (low_z + z) / 2):
                edges.append(edge)
    return _only_volume(gmsh.model.occ.fillet([body], sorted(set(edges)), [radius]))


def _loop(chain: Sequence[Curve], place: Placing) -> int:
    occ = gmsh.model.occ
    corners = [occ.addPoint(*place(piece.start)) for piece in chain]
    curves: list[int] = []
    helpers: list[int] = []
    for piece, begin, end in zip(chain, corners, corners[1:] + corners[:1], strict=True):
        match piece:
            case Line():
                curves.append(occ.addLine(begin, end))
            case Arc():  # through its middle: any sweep below a full turn
                helpers.append(occ.addPoint(*place(piece.at(0.5))))
                curves.append(occ.addCircleArc(begin, helpers[-1], end, center=False))
            case EllipticArc():  # about the origin, with a point of the major axis
                a, b = piece.semi_axes
                center = occ.addPoint(*place((0.0, 0.0)))
                major = occ.addPoint(*place((a, 0.0) if a >= b else (0.0, b)))
                helpers += [center, major]
                curves.append(occ.addEllipseArc(begin, center, major, end))
    occ.remove([(0, helper) for helper in helpers])  # else they would be meshed as loose nodes
    return int(occ.addCurveLoop(curves))


def _only_volume(entities: Sequence[tuple[int, int]]) -> int:
    volumes = [tag for dim, tag in entities if dim == SOLID]
    if len(volumes) != 1:
        raise GeometryError(
            f"the CAD kernel made {len(volumes)} solids instead of one. Change the rod's dimensions slightly"
        )
    return int(volumes[0])
