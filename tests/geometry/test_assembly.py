"""Rods drawn in the parts that they are assembled from."""

import math
from dataclasses import replace

import gmsh
import numpy as np
import pytest
from assemblies import BOLTED, NUTS, SCREWS, STUBBY, random_assembly
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.assembly import Assembly, BoltSeat, bolt_axes
from geometry.dimensions import dimensions
from geometry.errors import InvalidValue
from geometry.faces import edge_points
from geometry.presets import PRESETS
from geometry.section import HeightField
from geometry.session import session
from geometry.solid import build, contact_areas
from geometry.surfaces import Mirror, Surface

LEON_2001 = PRESETS["leon-2001"]

EVERY = Assembly(bushing=True, shell=1.5, bolt=NUTS)
NAMES = ["rod", "cap", "bushing", "upper shell", "lower shell"]
# The kernel's own quadrature of a volume; a fillet that is missing is a hundred times as much.
VOLUME = 3e-7


def area(faces):
    return sum(gmsh.model.occ.getMass(2, face) for face in faces)


def drawn_area(solid, surface):
    """Of an interface, by its first side, or of a seat, on the whole rod."""
    sides = [face for one in solid.interfaces if one.sides[0] is surface for face in one.faces]
    return solid.mirror.copies * area([*sides, *solid.faces.get(surface, ())])


def annulus(outer, inner):
    return math.pi / 4 * (outer**2 - inner**2)


@pytest.mark.parametrize("mirror", [Mirror.QUARTER, Mirror.NONE])
def test_the_parts_fill_the_rod_in_one_piece(mirror):
    with session():
        one_piece = build(BOLTED, mirror)
    with session():
        solid = build(BOLTED, mirror, EVERY)
        every = area([tag for _, tag in gmsh.model.getEntities(2)])
        named = [face for faces in solid.faces.values() for face in faces]
        between = [face for one in solid.interfaces for face in one.faces]
        assert area([*named, *between]) == pytest.approx(every, rel=1e-12)  # nothing loose is left
        assert len({*named, *between}) == len(named) + len(between)
    assert [part.name for part in solid.parts] == NAMES
    assert solid.mass.mass == pytest.approx(one_piece.mass.mass, rel=VOLUME)
    assert solid.mass.center == pytest.approx(one_piece.mass.center, rel=1e-6, abs=1e-6)
    volumes = {part.name: part.mass.mass for part in solid.parts}
    radius, width, chamfer = BOLTED.big_end_bore / 2, BOLTED.big_end_width, BOLTED.big_end_chamfer
    shells = annulus(2 * radius + 3.0, 2 * radius) * width
    shells -= 2 * math.pi * chamfer**2 * (radius + chamfer / 3)  # Pappus: the triangle of each chamfer
    for name in ("upper shell", "lower shell"):
        assert volumes[name] == pytest.approx(shells / 2, rel=1e-9)


@pytest.mark.parametrize("bolt", [NUTS, SCREWS])
def test_interfaces_and_seats_have_the_areas_of_the_dimensions(bolt):
    rod = replace(BOLTED, oil_hole=0.0)
    boss = rod.cap_bolt_spacing / 2 + rod.cap_bolt - rod.big_end_bore / 2
    joint = 2 * (boss * rod.big_end_width - rod.big_end_chamfer**2 - annulus(rod.cap_bolt, 0.0))
    with session():
        solid = build(rod, Mirror.QUARTER, replace(EVERY, bolt=bolt))
        found = {surface: drawn_area(solid, surface) for surface in Surface}
    assert found[Surface.JOINT] == pytest.approx(joint, rel=1e-9)
    seat = math.pi * (rod.small_end_bore + 2 * rod.bushing) * rod.small_end_width
    assert found[Surface.BUSHING_SEAT] == pytest.approx(seat, rel=1e-9)
    back = math.pi * (rod.big_end_bore + 2 * EVERY.shell) * rod.big_end_width
    assert found[Surface.SHELL_SEAT] == pytest.approx(back, rel=1e-9)
    head = 2 * annulus(bolt.head_diameter, rod.cap_bolt)
    assert found[Surface.BOLT_HEAD] == pytest.approx(head, rel=1e-9)
    wall = 2 * math.pi * rod.cap_bolt * bolt.engaged
    thread = wall or 2 * annulus(bolt.nut_diameter, rod.cap_bolt)
    assert found[Surface.BOLT_THREAD] == pytest.approx(thread, rel=1e-9)


def test_the_oil_hole_is_missing_from_the_bushing_seat():
    with session():
        solid = build(BOLTED, Mirror.QUARTER, Assembly(bushing=True, bolt=NUTS))
        found = drawn_area(solid, Surface.BUSHING_SEAT)
    radius, hole = BOLTED.small_end_bore / 2 + BOLTED.bushing, BOLTED.oil_hole / 2
    y, weights = np.polynomial.legendre.leggauss(40)
    angle = y * math.pi / 2  # y = hole · sin(angle)
    window = weights @ (2 * (hole * np.cos(angle)) ** 2 / np.sqrt(1 - (hole / radius * np.sin(angle)) ** 2))
    full = 2 * math.pi * radius * BOLTED.small_end_width
    # The kernel's own quadrature; a plane circle would be 3e-3 smaller.
    assert full - found == pytest.approx(window * math.pi / 2, rel=1e-4)


@pytest.mark.parametrize("bolt", [NUTS, SCREWS])
def test_seats_lie_on_the_axes_of_the_bolts(bolt):
    with session():
        solid = build(BOLTED, Mirror.NONE, Assembly(bolt=bolt))
        heads = [edge_points(face) for face in solid.faces[Surface.BOLT_HEAD]]
        threads = np.concatenate([edge_points(face) for face in solid.faces[Surface.BOLT_THREAD]])
    assert [axis.point for axis in solid.bolts] == [(0.0, 36.3, 0.0), (0.0, -36.3, 0.0)]
    for axis in solid.bolts:
        assert axis.direction == (-1.0, 0.0, 0.0)
        assert axis.grip == bolt.grip
        (own,) = (points for points in heads if np.sign(points[0, 1]) == np.sign(axis.point[1]))
        beside = np.hypot(own[:, 1] - axis.point[1], own[:, 2])
        assert own[:, 0] == pytest.approx(axis.at(axis.head)[0], abs=1e-9)
        assert (beside.min(), beside.max()) == pytest.approx((4.5, bolt.head_diameter / 2))
    ends = {round(float(x), 9) for x in threads[:, 0]}
    assert (max(ends), min(ends)) == (-solid.bolts[0].thread_end, -solid.bolts[0].grip_end)


def test_an_oblique_split_has_its_plane_through_the_big_end():
    assembly = Assembly(split=40.0, shell=1.5)
    with session():
        solid = build(LEON_2001, Mirror.HALF, assembly)
        (joint,) = ([f for one in solid.interfaces if one.parts == (0, 1) for f in one.faces],)
        points = np.concatenate([edge_points(face) for face in joint])
        found = drawn_area(solid, Surface.JOINT)
    nx, ny = math.cos(math.radians(40)), math.sin(math.radians(40))
    assert points[:, :2] @ [nx, ny] == pytest.approx(0, abs=1e-9)
    assert found == pytest.approx(2 * LEON_2001.big_end_ring * LEON_2001.big_end_width, rel=1e-9)
    with pytest.raises(InvalidValue, match="smallest symmetry cell of this rod is half"), session():
        build(LEON_2001, Mirror.QUARTER, assembly)


@pytest.mark.parametrize(
    ("angle", "rod"), [(35.0, STUBBY), (-10.0, replace(STUBBY, shank_section="H", oil_gallery=2.0))]
)
def test_bosses_turn_with_an_oblique_split(angle, rod):
    bolt = BoltSeat(head_diameter=14.0, grip=14.0, engaged=10.0)
    assembly = Assembly(split=angle, shell=1.5, bolt=bolt)
    with session():
        solid = build(rod, Mirror.HALF, assembly)
        found = {surface: drawn_area(solid, surface) for surface in contact_areas(rod, assembly)}
        heads = np.concatenate([edge_points(face) for face in solid.faces[Surface.BOLT_HEAD]])
    # About the big end's centre, mass, centre of gravity and I_z do not change as both bosses turn.
    straight = HeightField(rod).mass()
    assert solid.mass.mass == pytest.approx(straight.mass, rel=1e-6)
    assert solid.mass.center == pytest.approx(straight.center, abs=1e-3)
    assert solid.mass.inertia_z == pytest.approx(straight.inertia_z, rel=1e-6)
    assert found == pytest.approx(contact_areas(rod, assembly), rel=1e-6)
    normal = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0])
    assert heads @ normal == pytest.approx(-12.0, abs=1e-9)
    for axis, side in zip(solid.bolts, (1, -1), strict=True):
        assert axis.direction == pytest.approx(tuple(-normal))
        assert axis.point == pytest.approx((-side * 41.0 * normal[1], side * 41.0 * normal[0], 0.0))


def test_a_bonded_bushing_has_no_interface_and_its_body_is_the_rod():
    with session():
        solid = build(BOLTED, Mirror.QUARTER, Assembly(bolt=NUTS))
        bodies = solid.bodies
    assert {one.sides[0] for one in solid.interfaces} == {Surface.JOINT}
    volumes = {part.name: part.volumes[0] for part in solid.parts}
    assert bodies == [[volumes["cap"]], [volumes["rod"], volumes["bushing"]]]


def test_without_an_assembly_nothing_is_separate():
    with session():
        solid = build(BOLTED)
        assert (solid.bolts, solid.interfaces, solid.bodies) == ((), (), [])


WRONG = {
    "no bushing": (replace(BOLTED, bushing=0.0), EVERY, "assembly.bushing_interference_mm"),
    "no holes": (LEON_2001, Assembly(bolt=NUTS), "assembly.bolt_head_mm"),
    "shell too thick": (BOLTED, replace(EVERY, shell=5.0), "assembly.shell_thickness_mm"),
    "shell as thin as foil": (BOLTED, replace(EVERY, shell=0.1), "assembly.shell_thickness_mm"),
    "chamfer through the shell": (BOLTED, replace(EVERY, shell=0.9), "assembly.shell_thickness_mm"),
    "bolt through the shell": (
        replace(BOLTED, cap_bolt_spacing=68.0),
        replace(EVERY, shell=4.0),
        "rod.cap_bolt_spacing_mm",
    ),
    "head beyond the boss": (
        BOLTED,
        Assembly(bolt=replace(NUTS, head_diameter=16.0)),
        "assembly.bolt_head_mm",
    ),
    "head through the hole": (
        BOLTED,
        Assembly(bolt=replace(NUTS, head_diameter=9.5)),
        "assembly.bolt_head_mm",
    ),
    "nut beyond the boss": (BOLTED, Assembly(bolt=replace(NUTS, nut_diameter=16.0)), "assembly.bolt_nut_mm"),
    "nut and thread": (BOLTED, Assembly(bolt=replace(NUTS, engaged=9.0)), "assembly.bolt_nut_mm"),
    "neither": (BOLTED, Assembly(bolt=replace(NUTS, nut_diameter=0.0)), "assembly.bolt_nut_mm"),
    "grip beyond the boss": (BOLTED, Assembly(bolt=replace(NUTS, grip=45.0)), "assembly.bolt_grip_mm"),
    "thread in the cap": (BOLTED, Assembly(bolt=replace(SCREWS, grip=19.0)), "assembly.bolt_grip_mm"),
    "thread beyond the boss": (
        BOLTED,
        Assembly(bolt=replace(SCREWS, engaged=17.0)),
        "assembly.bolt_engaged_mm",
    ),
    "plane through the shank": (LEON_2001, Assembly(split=60.0), "assembly.split"),
    "plane along the rod": (LEON_2001, Assembly(split=-90.0), "assembly.split"),
    "boss in the shank": (BOLTED, Assembly(split=45.0), "assembly.split"),
    "boss in a pocket": (replace(STUBBY, shank_section="H"), Assembly(split=35.0), "assembly.split"),
    "shells in one piece": (BOLTED, Assembly(split=None, shell=1.5), "assembly.shell_thickness_mm"),
    "bolts in one piece": (BOLTED, Assembly(split=None, bolt=NUTS), "assembly.bolt_head_mm"),
}


@pytest.mark.parametrize("case", WRONG)
def test_parts_that_do_not_go_together_are_refused_by_name(case):
    rod, assembly, key = WRONG[case]
    with pytest.raises(InvalidValue) as refused, session():
        build(rod, assembly=assembly)
    assert refused.value.name == key


def test_the_remedy_for_a_head_beyond_the_boss_works():
    narrow = replace(BOLTED, cap_bolt_spacing=68.0)
    with pytest.raises(InvalidValue) as refused, session():
        build(narrow, Mirror.QUARTER, Assembly(bolt=NUTS))
    advised = float(refused.value.remedy.split("rod.cap_bolt_spacing_mm to ")[1].split(" mm")[0])
    with session():
        build(replace(narrow, cap_bolt_spacing=advised), Mirror.QUARTER, Assembly(bolt=NUTS))


@settings(max_examples=10)
@given(st.integers(0, 10**6))
@pytest.mark.slow
def test_a_random_assembly_is_drawn_or_refused_by_name(seed):
    drawn = random_assembly(seed)
    if isinstance(drawn, InvalidValue):
        return
    rod, assembly = drawn
    try:
        with session():
            solid = build(rod, assembly=assembly)
    except InvalidValue as refused:
        table, key = refused.name.split(".")
        assert table == "assembly" or key.removesuffix("_mm") in dimensions()
        return
    with session():
        one_piece = build(rod, solid.mirror)
    assert solid.mass.mass == pytest.approx(one_piece.mass.mass, rel=1e-5)
    assert len(solid.bolts) == len(bolt_axes(rod, assembly)) == (2 if assembly.bolt else 0)
