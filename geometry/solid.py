"""The rod as a tagged solid in an open gmsh session, and its features that need small elements.

What the CAD kernel drew is compared with the dimensions: by its volume, and by the areas of contact faces.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.assembly import Assembly, BoltAxis, bolt_axes, check
from geometry.errors import GeometryError, require
from geometry.faces import SLACK, Bore, Face, Feature, FeatureKind, faces_of, surfaces
from geometry.imports import ImportReport
from geometry.mass import MassProperties, joined
from geometry.outline import Outline, Pocket, space_beside, web_pocket
from geometry.parts import PartInterface, bodies, contact_features, interfaces, parted, with_seats
from geometry.rod import Rod
from geometry.section import HeightField
from geometry.segments import Arc, Line, Segment
from geometry.steps import Rib, RingStep, ring_steps
from geometry.surfaces import PLANE_AXIS, Mirror, Surface

# Relative differences of what is drawn from what the dimensions give. The volume is integrated to 1e-6; areas
# of contact faces are formulas that leave out where holes cross steps and slants.
VOLUME_TOLERANCE, AREA_TOLERANCE = 1e-4, 0.01
_ANGLES = 60  # places of a rule that is exact for periodic functions


# A feature as the dimensions give it, and whether a face, with the ``slack`` of lengths in mm, belongs to it.
_Expected = tuple[Feature, Callable[..., bool]]


def _cylinder(kind: FeatureKind, arc: Arc, sweep: float, wall: float = math.inf) -> _Expected:
    matches = partial(Face.about, x=arc.center[0], y=arc.center[1], radius=arc.radius)
    return Feature(kind, (), arc.radius, sweep, wall), matches


def _expected(rod: Rod, turn: float) -> Iterator[_Expected]:
    outline, full = Outline(rod), 2 * math.pi
    walls = rod.big_end_ring, rod.bushing or rod.small_end_ring
    for bore, wall in zip(outline.bores, walls, strict=True):
        yield _cylinder(FeatureKind.BORE, bore, full, wall)
    for arc in outline.fillets:
        yield _cylinder(FeatureKind.RING_FILLET, arc, abs(arc.sweep))
    holes = [(rod.cap_bolt, turn), *((hole, 0.0) for hole in (rod.oil_hole, rod.oil_gallery, rod.shank_bore))]
    for diameter, angle in holes:
        if diameter:
            matches = partial(Face.lengthwise, radius=diameter / 2, turn=angle)
            yield Feature(FeatureKind.HOLE, (), diameter / 2, full), matches
    arcs = [] if outline.bosses is None else list(outline.bosses.fillets())
    turned = [each.turned(turn) for arc in arcs for each in (arc, arc.mirrored())]
    for arc in turned if turn else arcs:
        yield _cylinder(FeatureKind.BOSS_FILLET, arc, abs(arc.sweep))
    yield from _expected_steps(rod, outline.rib)


def _expected_steps(rod: Rod, rib: Rib | None) -> Iterator[_Expected]:
    """Concave arcs at the feet of ring steps, and beside and between ribs."""
    for step in ring_steps(rod):
        if step.height:
            matches = partial(Face.is_torus, x=step.center, major=step.foot, minor=step.radius)
            yield Feature(FeatureKind.RING_STEP, (), step.radius, step.sweep), matches
    if rib is not None and (rib.side.height or rib.groove):
        matches = partial(Face.is_torus, x=0.0, major=rib.rings[1], minor=rib.side.radius)
        yield Feature(FeatureKind.RING_STEP, (), rib.side.radius, math.pi / 2), matches


def _expected_in_pocket(pocket: Pocket, web: float) -> Iterator[_Expected]:
    """Corners, floor edges and web floors of the two pockets, as seen along their depth."""
    r = pocket.floor_radius
    for arc in pocket.corners():
        yield _cylinder(FeatureKind.POCKET_CORNER, arc, abs(arc.sweep))
    between = pocket.big_end, pocket.small_end
    rounds_floor = partial(Face.rounds, between=between, level=pocket.floor + r, radius=r)
    yield Feature(FeatureKind.POCKET_FLOOR, (), r, math.pi / 2), rounds_floor
    yield Feature(FeatureKind.WEB, (), thickness=web), partial(Face.lies_at, axis=2, level=pocket.floor)


def drawn_features(rod: Rod, faces: Sequence[Face], turn: float = 0.0) -> tuple[Feature, ...]:
    """Find the faces that need small elements; kinds that the rod lacks are absent.

    Bosses and bolts are turned by `turn`, rad. Raises `GeometryError`: no face has a feature's shape.
    """
    slack, features = SLACK * rod.length, []
    expected = [(*each, faces) for each in _expected(rod, turn)]
    if rod.has_pockets:
        pocket = web_pocket(rod, Outline(rod).edge)
        seen = [face.from_side() for face in faces] if pocket.in_sides else faces
        expected += [(*each, seen) for each in _expected_in_pocket(pocket, rod.web_thickness)]
    for feature, matches, among in expected:
        tags = tuple(face.tag for face in among if matches(face, slack=slack))
        if not tags:
            raise GeometryError(
                f"the CAD kernel drew no {feature.kind.replace('_', ' ')} faces, but the dimensions give "
                "some. Change the dimensions of this feature slightly"
            )
        features.append(replace(feature, faces=tags))
    return tuple(features)


def _require_volume(rod: Rod, drawn: float) -> None:
    """Compare the volume of a whole rod, mm³, with that of its dimensions."""
    expected = HeightField(rod).mass().mass
    if not abs(drawn - expected) <= VOLUME_TOLERANCE * expected:
        raise GeometryError(
            f"the CAD kernel drew a rod of {drawn:.6g} mm³, but the dimensions give {expected:.6g} mm³. "
            "Change them slightly"
        )


def check_contacts(
    rod: Rod,
    assembly: Assembly,
    mirror: Mirror,
    interfaces: Sequence[PartInterface],
    named: Mapping[Surface, tuple[int, ...]],
) -> None:
    """Compare areas of contact faces with the dimensions. Raises `GeometryError`: above `AREA_TOLERANCE`."""
    drawn = {surface: [*named.get(surface, ())] for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    for interface in interfaces:
        drawn.setdefault(interface.sides[0], []).extend(interface.faces)
    for surface, expected in contact_areas(rod, assembly).items():
        area = mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in drawn.get(surface, ()))
        if not abs(area - expected) <= AREA_TOLERANCE * expected:
            raise GeometryError(
                f"the CAD kernel drew {surface.replace('_', ' ')} faces of {area:.4g} mm², but the "
                f"dimensions give {expected:.4g} mm². Change the dimensions of this part slightly"
            )


def contact_areas(rod: Rod, assembly: Assembly) -> dict[Surface, float]:
    """Return the area of every interface and of the bolts' seats on the whole rod, mm²."""
    areas: dict[Surface, float] = {}
    if assembly.split is not None:
        areas[Surface.JOINT] = HeightField(rod).section(0.0).area  # a ring's is the same at every angle
    if assembly.bushing:
        radius = rod.small_end_bore / 2 + rod.bushing
        whole = 2 * math.pi * radius * rod.mean_small_end_width
        drilled = _window(radius, rod.oil_hole / 2) + _window(radius, rod.oil_gallery / 2)
        areas[Surface.BUSHING_SEAT] = whole - drilled
    if assembly.shell:
        radius = rod.big_end_bore / 2 + assembly.shell
        whole = 2 * math.pi * radius * rod.big_end_width
        areas[Surface.SHELL_SEAT] = whole - _window(radius, rod.big_end_opening / 2)
    if (seat := assembly.bolt) is not None:
        outer = seat.head_diameter, seat.nut_diameter
        head, nut = (math.pi / 2 * (diameter**2 - rod.cap_bolt**2) for diameter in outer)
        wall = 2 * math.pi * rod.cap_bolt * seat.engaged
        areas |= {Surface.BOLT_HEAD: head, Surface.BOLT_THREAD: wall or nut}
    return areas


def _window(radius: float, hole: float) -> float:
    """Area that a hole across the axis of a cylinder cuts out of one side of it, mm²."""
    angle: Floats = (np.arange(_ANGLES) + 0.5) * math.pi / _ANGLES
    depth = (1 - (hole / radius * np.sin(angle)) ** 2) ** -0.5
    return float(2 * math.pi * (hole * np.cos(angle)) ** 2 @ depth) / _ANGLES


@dataclass(frozen=True)
class Part:
    """A part of the solid, with one material."""

    name: str  #: ``"rod"``, ``"bushing"``, another of `geometry.parts`, or the name in the imported file
    volumes: tuple[int, ...]  #: gmsh's volume tags
    #: Of the whole part (also when a cell was drawn) for density 1: the mass is the volume, mm³
    mass: MassProperties


@dataclass(frozen=True)
class Solid:
    """A rod that is drawn in the open session."""

    mirror: Mirror  #: the cell that was drawn
    bores: tuple[Bore, Bore]  #: of the big and the small end; the distance of their centres is `bores[1].x`
    parts: tuple[Part, ...]  #: by material; at least one
    #: gmsh's face tags of every surface of the boundary, cut planes included
    faces: dict[Surface, tuple[int, ...]]
    features: tuple[Feature, ...]  #: the faces that need small elements
    #: Of the whole rod (also when a cell was drawn) for density 1: the mass is the volume, mm³
    mass: MassProperties
    #: What was made of the file that it comes from; None for a rod drawn from dimensions
    imported: ImportReport | None = None
    #: Of the whole rod, also when a cell was drawn; empty for a rod without an assembly
    bolts: tuple[BoltAxis, ...] = ()
    interfaces: tuple[PartInterface, ...] = ()  #: where parts touch without being joined

    @property
    def bodies(self) -> list[list[int]]:
        """Volume tags of each separate body; empty if all parts are joined."""
        return bodies([part.volumes for part in self.parts], self.interfaces)


def build(rod: Rod, mirror: Mirror | None = None, assembly: Assembly | None = None) -> Solid:
    """Draw a rod, or a symmetry cell of it, by default the smallest, in a new model of the open session.

    Without an assembly the rod is one piece, with its bushing bonded to it. Raises `InvalidValue`: the rod
    does not have the symmetry, or the parts do not go together; `GeometryError`: the CAD kernel failed.
    """
    if assembly is not None:
        check(rod, assembly)
    smallest = Mirror.HALF if assembly is not None and assembly.split else Mirror.QUARTER
    mirror, cells = mirror or smallest, list(Mirror)
    rule = f"the smallest symmetry cell of this rod is {smallest}"
    possible = cells.index(mirror) <= cells.index(smallest)
    require(possible, "symmetry", str(mirror), rule, "Choose that or a larger part.")
    gmsh.model.add("rod")
    turn = 0.0 if assembly is None else math.radians(assembly.split or 0.0)
    outline, body = Outline(rod, turn), _plan(rod, mirror, turn)
    with kernel.attempt("cut ring steps and web pockets"):
        body = kernel.cut(body, _beside(rod, mirror, outline))
    with kernel.attempt("separate the bushing from the rod (rod.bushing_mm)"):
        volumes = _bushed(rod, body)
    with kernel.attempt("drill and chamfer (rod.cap_bolt_mm, rod.oil_hole_mm, rod.…_chamfer_mm)"):
        cutters = [*_holes(rod, turn), *_chamfers(rod, mirror)]
        volumes = dict(zip(volumes, kernel.drilled(list(volumes.values()), cutters), strict=True))
    bolts = () if assembly is None else bolt_axes(rod, assembly)
    volumes = volumes if assembly is None else parted(rod, volumes, assembly, bolts)
    gmsh.model.occ.synchronize()
    parts = tuple(Part(name, (tag,), whole_mass(tag, mirror)) for name, tag in volumes.items())
    faces = faces_of(tuple(volumes.values()))
    features = drawn_features(rod, faces, turn)
    bores = (
        Bore(0.0, rod.big_end_bore / 2, rod.crank_bearing_width),
        Bore(rod.length, rod.small_end_bore / 2, rod.pin_bearing_width, rod.pin_bearing_taper),
    )
    mass = joined([part.mass for part in parts])
    _require_volume(rod, mass.mass)
    named = with_seats(surfaces(bores, mirror, faces), faces, bolts)
    solid = Solid(mirror, bores, parts, named, features, mass, bolts=bolts)
    if assembly is None:
        return solid
    walls = {Surface.JOINT: rod.big_end_ring, Surface.BUSHING_SEAT: rod.bushing}
    walls[Surface.SHELL_SEAT] = assembly.shell
    solid = with_contacts(solid, assembly, lambda _: walls)
    check_contacts(rod, assembly, mirror, solid.interfaces, solid.faces)
    return solid


def _beside(rod: Rod, mirror: Mirror, outline: Outline) -> list[int]:
    """Draw what is cut off the extruded outline beside shank, rib and small end."""
    above: list[int] = []
    big, small = ring_steps(rod)
    top = max(big.ring, small.ring)
    if top > rod.shank_width / 2:
        # Their common part is what lies above both rings' faces: no seam where they meet on the shank.
        with kernel.attempt("draw the ring steps"):
            around = _above(big, top, rod, outline.shank_sector)
            above.append(kernel.common(around, _above(small, top, rod)))
    if rod.has_pockets and not rod.has_side_pockets:
        above.append(_pocket(rod))
    if profile := space_beside(rod):
        with kernel.attempt("slant the small end (rod.small_end_crown_width_mm)"):
            above.append(kernel.prism_along_y(profile, rod.small_end_radius * 2))
    if mirror is Mirror.NONE:
        above += [kernel.turned_over(tool) for tool in above]
    if rod.has_side_pockets:
        aside = _pocket(rod)
        above += [aside] if mirror is Mirror.QUARTER else [aside, kernel.turned_over(aside)]
    if outline.rib is not None:
        above += _beside_rib(outline.rib, top, rod, mirror, outline.turn)
    return above


def with_contacts(
    solid: Solid, assembly: Assembly, thickness: Callable[[Sequence[PartInterface]], Mapping[Surface, float]]
) -> Solid:
    """Add the interfaces, and the faces there and under bolts as features.

    `thickness` of what lies behind the interfaces, mm, is by the first surface of each.
    """
    parts = solid.parts
    touching = interfaces([part.name for part in parts], [part.volumes for part in parts], assembly)
    small = contact_features(touching, solid.faces, solid.bolts, thickness(touching))
    return replace(solid, features=(*solid.features, *small), interfaces=touching)


def _plan(rod: Rod, mirror: Mirror, turn: float) -> int:
    top = max(rod.big_end_width, rod.small_end_width) / 2
    outline = Outline(rod, turn)
    with kernel.attempt("extrude the rod's outline"):
        if mirror is Mirror.QUARTER:
            big, small = (bore.reversed() for bore in outline.bores)
            cap, crown = outline.upper[0].start, outline.upper[-1].end
            back = (Line(crown, small.start), small, Line(small.end, big.start), big, Line(big.end, cap))
            body = kernel.prism((*outline.upper, *back), (), 0.0, top)
        else:
            holes = [(bore, bore.mirrored()) for bore in outline.bores]
            body = kernel.prism(outline.whole, holes, 0.0 if mirror is Mirror.HALF else -top, top)
    if (boss := outline.bosses) is None or not boss.round:
        return body
    slack = SLACK * rod.length

    def outermost(x: float, y: float, z: float) -> bool:
        return abs(math.hypot(x, y) - boss.top) < slack and abs(abs(z) - boss.width) < slack

    with kernel.attempt("round the bosses (rod.cap_boss_round_mm)"):
        return kernel.rounded(body, boss.round, outermost)


def _pocket(rod: Rod) -> int:
    pocket = web_pocket(rod, Outline(rod).edge)
    outside = max(rod.big_end_width, rod.small_end_width) / 2
    if pocket.in_sides:  # the shank and its fillets are within the circles round the rings
        outside = max(rod.big_end_radius, rod.small_end_radius)
    with kernel.attempt("round the pocket floor (rod.pocket_floor_radius_mm)"):
        tool = kernel.prism(pocket.outline(), (), pocket.floor, pocket.floor + 1.1 * (outside - pocket.floor))
        slack = 1e-6 * (1 + pocket.floor)
        tool = kernel.rounded(tool, pocket.floor_radius, lambda _x, _y, z: abs(z - pocket.floor) < slack)
    if pocket.in_sides:
        gmsh.model.occ.rotate([(kernel.SOLID, tool)], 0, 0, 0, 1, 0, 0, -math.pi / 2)
    return tool


def _holes(rod: Rod, turn: float = 0.0) -> list[int]:
    occ, tools = gmsh.model.occ, []
    if rod.oil_gallery:
        tools.append(occ.addCylinder(0, 0, 0, rod.length, 0, 0, rod.oil_gallery / 2))
    if rod.shank_bore:
        radius, round_, end = rod.shank_bore / 2, rod.shank_bore_round, rod.shank_bore_end
        arc = Arc((radius - round_, end - round_), round_, 0.0, math.pi / 2)
        corners = [arc.end, (0.0, end), (0.0, 0.0), (radius, 0.0), arc.start]
        profile: tuple[Segment, ...] = (arc, *(Line(a, b) for a, b in pairwise(corners)))
        bore = kernel.revolution(profile, 0.0)
        gmsh.model.occ.rotate([(kernel.SOLID, bore)], 0, 0, 0, 0, 1, 0, math.pi / 2)
        tools.append(bore)
    if rod.oil_hole:
        tools.append(occ.addCylinder(rod.length, 0, 0, 2 * rod.small_end_radius, 0, 0, rod.oil_hole / 2))
    if rod.cap_bolt:
        length, at = 2 * rod.cap_boss_length, rod.cap_bolt_spacing / 2
        bolts = [occ.addCylinder(-length / 2, y, 0, length, 0, 0, rod.cap_bolt / 2) for y in (at, -at)]
        if turn:
            occ.rotate([(kernel.SOLID, bolt) for bolt in bolts], 0, 0, 0, 0, 0, 1, turn)
        tools += bolts
    return tools


def _chamfers(rod: Rod, mirror: Mirror) -> list[int]:
    cones = []
    for x, bore, width, size in (
        (0.0, rod.big_end_bore, rod.big_end_width, rod.big_end_chamfer),
        (rod.length, rod.small_end_bore, rod.small_end_width, rod.small_end_chamfer),
    ):
        if size:  # from inside the bore to above the face, so that it crosses both at an angle
            start, end = (x, 0, width / 2 - 2 * size), (0, 0, 3 * size)
            cones.append(gmsh.model.occ.addCone(*start, *end, bore / 2 - size, bore / 2 + 2 * size))
    return cones if mirror is not Mirror.NONE else [*cones, *map(kernel.turned_over, cones)]


def _bushed(rod: Rod, body: int) -> dict[str, int]:
    if not rod.bushing:
        return {"rod": body}
    occ, far = gmsh.model.occ, 2 * rod.small_end_width
    core = occ.addCylinder(rod.length, 0, -far / 2, 0, 0, far, rod.small_end_bore / 2 + rod.bushing)
    # The cylinder's seam must not lie where the oil hole will be.
    occ.rotate([(kernel.SOLID, core)], rod.length, 0, 0, 0, 0, 1, -math.pi / 2)
    _, (of_body, of_core) = occ.fragment([(kernel.SOLID, body)], [(kernel.SOLID, core)])
    occ.remove([piece for piece in of_core if piece not in of_body], recursive=True)
    (outer,) = (tag for dim, tag in of_body if (dim, tag) not in of_core)
    (inner,) = (tag for dim, tag in of_body if (dim, tag) in of_core)
    return {"rod": outer, "bushing": inner}


def _above(step: RingStep, top: float, rod: Rod, sector: float = math.pi) -> int:
    far = 3 * (rod.length + rod.big_end_radius + rod.small_end_radius)
    return kernel.revolution(step.space_above(top, far), step.center, sector)


def _beside_rib(rib: Rib, top: float, rod: Rod, mirror: Mirror, turn: float) -> list[int]:
    tools = []
    with kernel.attempt("draw the rib of the cap (rod.cap_rib_mm)"):
        if rib.side.height:
            tools.append(_above(rib.side, top, rod, rib.sector))
            tools += [kernel.turned_over(tools[0])] if mirror is Mirror.NONE else []
        if rib.groove:
            tools.append(kernel.revolution(rib.groove_profile(2 * rod.length), 0.0, rib.sector))
    gmsh.model.occ.rotate([(kernel.SOLID, tool) for tool in tools], 0, 0, 0, 0, 0, 1, math.pi + turn)
    return tools


def whole_mass(body: int, mirror: Mirror) -> MassProperties:
    """Return the kernel's own mass properties of a cell's volume, completed by reflection."""
    occ = gmsh.model.occ
    with kernel.attempt("integrate the volume"):
        volume = occ.getMass(kernel.SOLID, body)
        x, y, z = occ.getCenterOfMass(kernel.SOLID, body)
        a, b, c, d, e, f, g, h, i = occ.getMatrixOfInertia(kernel.SOLID, body)
    if not volume > 0:
        raise GeometryError(f"the CAD kernel made a solid of volume {volume:g} mm³; it must be positive")
    return reflected(MassProperties(volume, (x, y, z), ((a, b, c), (d, e, f), (g, h, i))), mirror)


def reflected(mass: MassProperties, mirror: Mirror) -> MassProperties:
    """Complete the mass properties of a cell by reflection."""
    for plane in mirror.planes:
        mass = mass.reflected(PLANE_AXIS[plane])
    return mass
