"""Small drawing steps with gmsh's OpenCASCADE kernel, inside an open session."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import gmsh

from geometry.errors import GeometryError
from geometry.outline import Outline
from geometry.rod import Rod
from geometry.segments import Arc, Line, Point, Segment
from geometry.side_faces import Pocket, RingStep, ring_steps, space_beside, web_pocket
from geometry.surfaces import Mirror

Place = tuple[float, float, float]
Placing = Callable[[Point], Place]
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


def in_plan(point: Point) -> Place:
    """Place a point of the plan at z = 0."""
    return point[0], point[1], 0.0


def in_profile(point: Point) -> Place:
    """Place a point (x, z) of the side view at y = 0."""
    return point[0], 0.0, point[1]


def face(outer: Sequence[Segment], holes: Sequence[Sequence[Segment]], place: Placing) -> int:
    """Draw a plane face bounded by closed chains of segments."""
    return int(gmsh.model.occ.addPlaneSurface([_loop(chain, place) for chain in (outer, *holes)]))


def prism(outer: Sequence[Segment], holes: Sequence[Sequence[Segment]], bottom: float, top: float) -> int:
    """Extrude a plan along z."""
    base = face(outer, holes, in_plan)
    gmsh.model.occ.translate([(2, base)], 0, 0, bottom)
    swept = gmsh.model.occ.extrude([(2, base)], 0, 0, top - bottom)
    return _only_volume(swept)


def prism_along_y(profile: Sequence[Segment], half: float) -> int:
    """Extrude a side view (x, z) along y from −half to half."""
    base = face(profile, (), in_profile)
    gmsh.model.occ.translate([(2, base)], 0, -half, 0)
    return _only_volume(gmsh.model.occ.extrude([(2, base)], 0, 2 * half, 0))


def revolution(profile: Sequence[Segment], x: float, sector: float = math.pi) -> int:
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


def bottom_rounded(body: int, z: float, radius: float) -> int:
    """Round the edges of a body that lie in the plane `z`."""
    gmsh.model.occ.synchronize()
    slack = 1e-6 * (1 + abs(z))
    edges = []
    for _, tag in gmsh.model.getBoundary([(SOLID, body)], combined=False, oriented=False, recursive=False):
        for _, edge in gmsh.model.getBoundary([(2, tag)], oriented=False):
            _, _, low, _, _, high = gmsh.model.getBoundingBox(1, edge)
            if max(abs(low - z), abs(high - z)) < slack:
                edges.append(edge)
    rounded = gmsh.model.occ.fillet([body], sorted(set(edges)), [radius])
    return _only_volume(rounded)


def _loop(chain: Sequence[Segment], place: Placing) -> int:
    occ = gmsh.model.occ
    corners = [occ.addPoint(*place(piece.start)) for piece in chain]
    curves, helpers = [], []
    for piece, begin, end in zip(chain, corners, corners[1:] + corners[:1], strict=True):
        match piece:
            case Line():
                curves.append(occ.addLine(begin, end))
            case Arc():  # through its middle: any sweep below a full turn
                middle = occ.addPoint(*place(piece.at(0.5)))
                helpers.append((0, middle))
                curves.append(occ.addCircleArc(begin, middle, end, center=False))
    occ.remove(helpers)  # else they would be meshed as loose nodes
    return int(occ.addCurveLoop(curves))


def _only_volume(entities: Sequence[tuple[int, int]]) -> int:
    volumes = [tag for dim, tag in entities if dim == SOLID]
    if len(volumes) != 1:
        raise GeometryError(
            f"the CAD kernel made {len(volumes)} solids instead of one. Change the rod's dimensions slightly"
        )
    return int(volumes[0])


def tools_above(rod: Rod, turn: float = 0.0) -> list[int]:
    """Draw the volumes cut away above z = 0; below it, their mirror images are cut.

    Bosses are turned by `turn`, rad.
    """
    tools = []
    big, small = ring_steps(rod)
    top = max(big.ring, small.ring)
    if top > rod.shank_width / 2:
        # Their common part is what lies above both rings' faces: no seam where they meet on the shank.
        with attempt("draw the ring steps"):
            around = _above(big, top, rod, Outline(rod, turn).shank_sector)
            tools.append(common(around, _above(small, top, rod)))
    if rod.has_pockets:
        with attempt("round the pocket floor (rod.pocket_floor_radius_mm)"):
            tools.append(_pocket_tool(web_pocket(rod, Outline(rod).edge), top))
    if profile := space_beside(rod):
        with attempt("slant the small end (rod.small_end_crown_width_mm)"):
            tools.append(prism_along_y(profile, rod.small_end_radius * 2))
    return tools


def holes(rod: Rod, turn: float = 0.0) -> list[int]:
    """Draw the holes that lie on the plane z = 0; those of bolts are turned by `turn`, rad."""
    occ, tools = gmsh.model.occ, []
    if rod.oil_hole:
        tools.append(occ.addCylinder(rod.length, 0, 0, 2 * rod.small_end_radius, 0, 0, rod.oil_hole / 2))
    if rod.cap_bolt:
        length, at = 2 * rod.cap_boss_length, rod.cap_bolt_spacing / 2
        bolts = [occ.addCylinder(-length / 2, y, 0, length, 0, 0, rod.cap_bolt / 2) for y in (at, -at)]
        if turn:
            occ.rotate([(SOLID, bolt) for bolt in bolts], 0, 0, 0, 0, 0, 1, turn)
        tools += bolts
    return tools


def chamfers(rod: Rod, mirror: Mirror) -> list[int]:
    """Draw the cones that chamfer the ends of the bores above z = 0, and below it for the whole rod."""
    cones = []
    for x, bore, width, size in (
        (0.0, rod.big_end_bore, rod.big_end_width, rod.big_end_chamfer),
        (rod.length, rod.small_end_bore, rod.small_end_width, rod.small_end_chamfer),
    ):
        if size:  # from inside the bore to above the face, so that it crosses both at an angle
            start, end = (x, 0, width / 2 - 2 * size), (0, 0, 3 * size)
            cones.append(gmsh.model.occ.addCone(*start, *end, bore / 2 - size, bore / 2 + 2 * size))
    return cones if mirror is not Mirror.NONE else [*cones, *map(turned_over, cones)]


def bushed(rod: Rod, body: int) -> dict[str, int]:
    """Separate the bushing from the rod; they share the faces where they touch."""
    if not rod.bushing:
        return {"rod": body}
    occ, far = gmsh.model.occ, 2 * rod.small_end_width
    core = occ.addCylinder(rod.length, 0, -far / 2, 0, 0, far, rod.small_end_bore / 2 + rod.bushing)
    # The cylinder's seam must not lie where the oil hole will be.
    occ.rotate([(SOLID, core)], rod.length, 0, 0, 0, 0, 1, -math.pi / 2)
    _, (of_body, of_core) = occ.fragment([(SOLID, body)], [(SOLID, core)])
    occ.remove([piece for piece in of_core if piece not in of_body], recursive=True)
    (outer,) = (tag for dim, tag in of_body if (dim, tag) not in of_core)
    (inner,) = (tag for dim, tag in of_body if (dim, tag) in of_core)
    return {"rod": outer, "bushing": inner}


def _above(step: RingStep, top: float, rod: Rod, sector: float = math.pi) -> int:
    """Draw the space above a ring's face, its step and the plane of the shank's face."""
    far = 3 * (rod.length + rod.big_end_radius + rod.small_end_radius)
    return revolution(step.space_above(top, far), step.center, sector)


def _pocket_tool(pocket: Pocket, top: float) -> int:
    tool = prism(pocket.outline(), (), pocket.floor, pocket.floor + 1.1 * (top - pocket.floor))
    return bottom_rounded(tool, pocket.floor, pocket.floor_radius)
