"""Rods from CAD files whose parts touch: the same as those that the files were written from."""

import math
from dataclasses import replace

import gmsh
import numpy as np
import pytest
from assemblies import NUTS, SCREWS, SIMPLE, write_assembly

from geometry.assembly import Assembly, BoltSeat
from geometry.cad.imported import import_cad
from geometry.errors import GeometryError, InvalidValue
from geometry.imports import RodFile
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror, Surface

pytestmark = pytest.mark.slow


PLAIN = replace(SIMPLE, bushing=0.0, oil_hole=0.0, big_end_chamfer=0.0)
BUSHED = replace(PLAIN, bushing=1.5)
EVERY = Assembly(bushing=True, shell=1.5, bolt=NUTS)
TOUCHING = Assembly(bushing=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("assemblies")


@pytest.fixture(scope="module")
def nuts(folder):
    return write_assembly(BUSHED, EVERY, folder / "nuts.step")


@pytest.fixture(scope="module")
def plain(folder):
    """Rod and cap only, whose holes are all that is known of the bolts."""
    return write_assembly(PLAIN, Assembly(), folder / "plain.step")


def areas(solid):
    """Of the interfaces and of the bolts' seats, on the whole rod, mm²."""
    found = dict.fromkeys((Surface.BOLT_HEAD, Surface.BOLT_THREAD), 0.0)
    for surface in found:
        found[surface] = sum(gmsh.model.occ.getMass(2, face) for face in solid.faces[surface])
    for one in solid.interfaces:
        own = sum(gmsh.model.occ.getMass(2, face) for face in one.faces)
        found[one.sides[0]] = found.get(one.sides[0], 0.0) + own
    return {surface: solid.mirror.copies * area for surface, area in found.items()}


def opened(path, assembly, **said):
    with session():
        solid = import_cad(RodFile(path, **said), assembly=assembly)
        return solid, areas(solid)


@pytest.mark.parametrize("bolt", [NUTS, SCREWS])
def test_a_written_assembly_comes_back(folder, bolt):
    with session():
        drawn = build(BUSHED, Mirror.QUARTER, replace(EVERY, bolt=bolt))
        expected = areas(drawn)
    path = write_assembly(BUSHED, replace(EVERY, bolt=bolt), folder / "rod.step")
    # Where threads begin shows nowhere.
    given = replace(SCREWS, head_diameter=0.0) if bolt is SCREWS else None
    solid, found = opened(path, replace(TOUCHING, bolt=given))
    assert [part.name for part in solid.parts] == [part.name for part in drawn.parts]
    assert solid.mirror is Mirror.QUARTER
    for part, own in zip(solid.parts, drawn.parts, strict=True):
        assert part.mass.mass == pytest.approx(own.mass.mass, rel=1e-5)
    assert found == pytest.approx(expected, rel=1e-6)
    for axis, own in zip(solid.bolts, drawn.bolts, strict=True):
        assert vars(axis) == {key: pytest.approx(value, abs=1e-9) for key, value in vars(own).items()}
    assert not any("assumed" in text or "does not show" in text for text in solid.imported.assumed)


def test_what_is_found_is_said(nuts):
    solid, _ = opened(nuts, TOUCHING)
    said = "\n".join(solid.imported.assembly)
    assert "joint: straight, 1001 mm² on 2 faces, plane" in said
    assert "rod and bushing touch over 2545 mm²" in said
    assert "(0, 36.3, 0) mm from the crank pin: hole of 9 mm, head on 14 mm, grip 40 mm, nut on 13 mm" in said


def test_holes_alone_give_bolts_of_usual_proportions(plain):
    solid, found = opened(plain, Assembly())
    assert [axis.grip for axis in solid.bolts] == pytest.approx([40.0, 40.0])
    assert found[Surface.BOLT_HEAD] == pytest.approx(math.pi / 2 * (13.5**2 - 9**2), rel=1e-6)
    assert "heads, which the file does not show, press on 13.5 mm" in "\n".join(solid.imported.assumed)


def test_a_rod_in_one_piece_is_split_and_gets_shells(folder):
    path = write_assembly(PLAIN, Assembly(split=None), folder / "one.step")
    solid, found = opened(path, Assembly(shell=1.5))
    with session():
        own = areas(build(PLAIN, Mirror.QUARTER, Assembly(shell=1.5, bolt=NUTS)))
    assert [part.name for part in solid.parts] == ["rod", "cap", "upper shell", "lower shell"]
    assert found[Surface.JOINT] == pytest.approx(own[Surface.JOINT], rel=1e-6)
    assert found[Surface.SHELL_SEAT] == pytest.approx(own[Surface.SHELL_SEAT], rel=1e-6)


def test_an_oblique_cap_of_a_file_is_found_with_its_angle(folder):
    """A ring split at 30°, with holes drilled square to the joint."""
    path = folder / "oblique.step"
    angle = math.radians(30.0)
    normal = np.array([math.cos(angle), math.sin(angle), 0.0])
    with session():
        solid = build(replace(PLAIN, cap_bolt=0.0, big_end_ring=30.0), Mirror.NONE, Assembly(split=30.0))
        occ, volumes = gmsh.model.occ, [(3, part.volumes[0]) for part in solid.parts]
        tools = []
        for side in (1, -1):
            start = side * 35.0 * np.array([-normal[1], normal[0], 0.0])
            tools.append((3, occ.addCylinder(*start - 60 * normal, *(80 * normal), 3.5)))
            tools.append((3, occ.addCylinder(*start - 60 * normal, *(52 * normal), 7.0)))  # for the head
        occ.cut(volumes, tools)
        occ.synchronize()
        gmsh.write(str(path))
    found, area = opened(path, Assembly())
    assert found.mirror is Mirror.HALF
    first = found.bolts[0]
    assert first.direction == pytest.approx(tuple(-normal), abs=1e-9)
    assert first.point == pytest.approx((-35.0 * normal[1], 35.0 * normal[0], 0.0), abs=1e-9)
    assert (first.head, first.head_radius) == pytest.approx((8.0, 5.25), abs=1e-9)
    assert first.engaged == pytest.approx(1.5 * 7.0)
    assert area[Surface.BOLT_THREAD] == pytest.approx(2 * math.pi * 7.0 * first.engaged, rel=1e-6)
    assert "joint: oblique by 30°" in found.imported.assembly[0]


def test_a_serrated_joint_is_found_near_its_mean_plane(folder):
    """Rod and cap are divided along a zigzag of 1 mm."""
    path = folder / "serrated.step"
    with session():
        body = build(PLAIN, Mirror.NONE).parts[0].volumes[0]
        occ = gmsh.model.occ
        teeth = [(0.5 * (-1) ** k, -60.0 + 4.0 * k) for k in range(31)]
        corners = [occ.addPoint(x, y, -20) for x, y in [*teeth, (-90, 60), (-90, -60)]]
        lines = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
        face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
        tool = next(entity for entity in occ.extrude([(2, face)], 0, 0, 40) if entity[0] == 3)
        _, (pieces, in_tool) = occ.fragment([(3, body)], [tool])
        occ.remove([piece for piece in in_tool if piece not in pieces], recursive=True)
        occ.synchronize()
        gmsh.write(str(path))
    solid, area = opened(path, Assembly())
    text = solid.imported.assembly[0]
    assert "joint: straight" in text
    assert "within 1 mm of a plane" in text
    slope = math.hypot(4.0, 1.0) / 4.0
    flat = 2 * ((45.3 - 25.0) * 30.0 - math.pi * 4.5**2)
    assert area[Surface.JOINT] == pytest.approx(slope * flat, rel=5e-3)


def test_heads_without_seats_get_them_cut(folder):
    """Bosses whose ends are rounded off leave no plane around the holes."""
    path = folder / "round.step"
    with session():
        solid = build(PLAIN, Mirror.NONE, Assembly())
        occ = gmsh.model.occ
        cap = solid.parts[1].volumes[0]
        tube = occ.addCylinder(-14.0, 0, -20, 0, 0, 40, 60.0)
        round_off = occ.addCylinder(-14.0 + 30.0, 0, -20, 0, 0, 40, 50.0)
        _, _ = occ.cut([(3, tube)], [(3, round_off)])
        occ.cut([(3, cap)], [(3, tube)])
        occ.synchronize()
        gmsh.write(str(path))
    solid, area = opened(path, Assembly())
    assert any("no plane seats for the bolts' heads: they are cut" in text for text in solid.imported.assumed)
    radius = solid.bolts[0].head_radius
    assert area[Surface.BOLT_HEAD] == pytest.approx(2 * math.pi * (radius**2 - 4.5**2), rel=1e-6)


def test_solids_may_be_named_by_the_user(nuts):
    with session():
        told = import_cad(RodFile(nuts), assembly=TOUCHING).imported.solids
    by_role = {str(one.role): one.name for one in told}
    kept = [one.name for one in told if one.kept]
    bolts = [one.name for one in told if not one.kept]
    unclear = refused(GeometryError, nuts, TOUCHING, solids=(*kept, bolts[1]))
    assert f"it is not clear what {bolts[1]} is in the assembly" in str(unclear)
    said = (f"rod: {by_role['rod']}", f"cap: {by_role['cap']}", *(f"nut: {name}" for name in bolts))
    solid, _ = opened(nuts, Assembly(), solids=said)
    assert [part.name for part in solid.parts] == ["rod", "cap"]
    assert [axis.nut_radius for axis in solid.bolts] == pytest.approx([6.5, 6.5])
    wrong = refused(GeometryError, nuts, TOUCHING, solids=("cap: lid",))
    assert "rod.solids names 'lid', but the solids of the file are" in str(wrong)


def refused(error, path, assembly, **said):
    with pytest.raises(error) as caught:
        opened(path, assembly, **said)
    return caught.value


def test_a_cap_that_is_not_there(folder):
    path = write_assembly(BUSHED, EVERY, folder / "nocap.step", bolts=False, without=("cap", "lower shell"))
    assert "Is the cap missing?" in str(refused(GeometryError, path, TOUCHING))


def test_two_different_rods_in_the_file(folder):
    path = folder / "two.step"
    with session():
        build(replace(PLAIN, cap_bolt=0.0), Mirror.NONE)
        gmsh.write(str(folder / "one.brep"))
    with session():
        build(replace(PLAIN, cap_bolt=0.0, length=160.0), Mirror.NONE)
        gmsh.model.occ.translate(gmsh.model.occ.getEntities(3), 0, 0, 100)
        gmsh.model.occ.importShapes(str(folder / "one.brep"))
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    assert "several solids of the file could be the rod" in str(refused(GeometryError, path, TOUCHING))


def test_a_cap_without_holes_for_bolts(folder):
    path = write_assembly(replace(PLAIN, cap_bolt=0.0), Assembly(), folder / "ring.step")
    assert "no hole for a bolt runs through the joint" in str(refused(GeometryError, path, Assembly()))


def test_holes_of_different_sizes(folder):
    path = folder / "dowels.step"
    with session():
        solid = build(replace(PLAIN, big_end_width=60.0), Mirror.NONE, Assembly())
        occ = gmsh.model.occ
        tools = [(3, occ.addCylinder(-60, y, 18, 120, 0, 0, 3.0)) for y in (36.3, -36.3)]
        occ.cut([(3, part.volumes[0]) for part in solid.parts], tools)
        occ.synchronize()
        gmsh.write(str(path))
    said = str(refused(GeometryError, path, Assembly()))
    assert "the holes through the joint differ in size" in said
    assert "6 mm at (0, 36.3, 18); 9 mm at (0, 36.3, 0)" in said


def test_holes_of_dowels_are_no_bolts(folder):
    path = folder / "dowels.step"
    with session():
        solid = build(replace(PLAIN, big_end_width=60.0), Mirror.NONE, Assembly())
        occ = gmsh.model.occ
        tools = [(3, occ.addCylinder(-8, y, 18, 16, 0, 0, 3.0)) for y in (36.3, -36.3)]
        occ.cut([(3, part.volumes[0]) for part in solid.parts], tools)
        occ.synchronize()
        gmsh.write(str(path))
    solid, _ = opened(path, Assembly())
    assert [axis.point for axis in solid.bolts] == [
        pytest.approx((0.0, side * 36.3, 0.0), abs=1e-9) for side in (1, -1)
    ]


def test_a_cap_that_does_not_touch(folder):
    path = folder / "gap.step"
    with session():
        build(PLAIN, Mirror.NONE, Assembly())
        gmsh.write(str(folder / "both.brep"))
    with session():
        both = gmsh.model.occ.importShapes(str(folder / "both.brep"))
        copies = gmsh.model.occ.copy(both)
        gmsh.model.occ.remove(both, recursive=True)
        gmsh.model.occ.synchronize()
        cap = min(copies, key=lambda entity: gmsh.model.occ.getCenterOfMass(*entity)[0])
        gmsh.model.occ.translate([cap], -0.01, 0, 0)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    assert "do not touch (gap 0.01 mm)" in str(refused(GeometryError, path, Assembly()))


SAID = {
    "head wider than the seat": (BoltSeat(head_diameter=16.0, grip=0.0), "assembly.bolt_head_mm"),
    "nut wider than the seat": (
        BoltSeat(head_diameter=0.0, grip=0.0, nut_diameter=16.0),
        "assembly.bolt_nut_mm",
    ),
    "grip of a nut": (BoltSeat(head_diameter=0.0, grip=45.0, nut_diameter=13.0), "assembly.bolt_grip_mm"),
    "thread in the cap": (BoltSeat(head_diameter=0.0, grip=15.0, engaged=9.0), "assembly.bolt_grip_mm"),
    "thread beyond the hole": (
        BoltSeat(head_diameter=0.0, grip=25.0, engaged=19.0),
        "assembly.bolt_engaged_mm",
    ),
}


@pytest.mark.parametrize("case", SAID)
def test_given_bolts_that_do_not_fit_the_file(plain, case):
    bolt, key = SAID[case]
    assert refused(InvalidValue, plain, Assembly(bolt=bolt)).name == key


def test_given_parts_that_the_file_has_otherwise(nuts, plain):
    shell = refused(InvalidValue, nuts, replace(TOUCHING, shell=2.0))
    assert (shell.name, "their thickness, 1.5 mm" in shell.remedy) == ("assembly.shell_thickness_mm", True)
    assert refused(InvalidValue, plain, Assembly(shell=1.5)).name == "assembly.shell_thickness_mm"
    assert refused(InvalidValue, plain, TOUCHING).name == "assembly.bushing_interference_mm"
