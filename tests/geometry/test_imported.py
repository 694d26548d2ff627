import math

import gmsh
import pytest

from geometry.cad.formats import step_file
from geometry.cad.imported import import_cad
from geometry.errors import GeometryError
from geometry.faces import FeatureKind
from geometry.holes import EQUAL_BORES
from geometry.imports import RodFile
from geometry.presets import PRESETS
from geometry.rod import proportioned
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror, Surface

pytestmark = pytest.mark.slow

LEON_2001 = PRESETS["leon-2001"]

CENTER = (12.0, -30.0, 7.0)


@pytest.fixture(scope="module")
def leon(tmp_path_factory):
    path = tmp_path_factory.mktemp("step") / "leon.step"
    with session():
        path.write_bytes(step_file(LEON_2001))
    return path


@pytest.fixture(scope="module")
def mass():
    with session():
        return build(LEON_2001, Mirror.NONE).mass


def write(path, draw):
    """Write what `draw(occ)` leaves in the model."""
    with session():
        gmsh.model.add("drawn")
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def strap(occ, holes=((0, 10), (100, 5)), thickness=12):
    """A bar with holes (x, radius) along z."""
    bar = occ.addBox(-25, -20, -thickness / 2, 150, 40, thickness)
    tools = [(3, occ.addCylinder(x, 0, -50, 0, 0, 100, r)) for x, r in holes]
    return occ.cut([(3, bar)], tools)[0] if tools else [(3, bar)]


def test_a_written_rod_comes_back_with_the_same_mass(leon, mass):
    with session():
        solid = import_cad(RodFile(leon))
    assert solid.mass.mass == pytest.approx(mass.mass, rel=1e-6)
    assert solid.mass.center == pytest.approx(mass.center, rel=1e-6, abs=1e-5)
    assert solid.mass.inertia_z == pytest.approx(mass.inertia_z, rel=1e-6)
    assert [part.name for part in solid.parts] == ["rod"]


def test_a_slanted_small_end_is_measured(tmp_path):
    rod = proportioned(140, 45, 22, small_end_crown_width=12.0)
    with session():
        (tmp_path / "slanted.step").write_bytes(step_file(rod))
    with session():
        imported = import_cad(RodFile(tmp_path / "slanted.step")).bores[1]
    assert imported.width == pytest.approx(rod.pin_bearing_width, rel=1e-6)
    assert imported.taper == pytest.approx(rod.pin_bearing_taper, rel=1e-6)
    assert rod.pin_bearing_taper < 0


def test_chamfers_are_not_a_part_of_the_bores(tmp_path):
    rod = proportioned(140, 45, 22, big_end_chamfer=1.2, small_end_chamfer=0.6)
    with session():
        (tmp_path / "chamfered.step").write_bytes(step_file(rod))
    with session():
        solid = import_cad(RodFile(tmp_path / "chamfered.step"))
    widths = [bore.width for bore in solid.bores]
    assert widths == pytest.approx([rod.crank_bearing_width, rod.pin_bearing_width], rel=1e-9)
    assert widths[0] == pytest.approx(rod.big_end_width - 2.4)
    assert solid.mirror is Mirror.QUARTER


def test_mirror_planes_are_found_and_cut(leon, mass):
    with session():
        solid = import_cad(RodFile(leon))
    assert solid.mirror is Mirror.QUARTER
    bores = {Surface.BIG_END_BORE, Surface.SMALL_END_BORE}
    assert set(solid.faces) == {*Mirror.QUARTER.planes, *bores, Surface.FREE}
    assert solid.mass.mass == pytest.approx(mass.mass, rel=1e-6)
    assert [2 * bore.radius for bore in solid.bores] == pytest.approx([50, 24])
    assert [bore.width for bore in solid.bores] == pytest.approx([30, 30])
    assert solid.bores[1].x == pytest.approx(141)
    radii = {round(item.radius, 3) for item in solid.features if item.kind is FeatureKind.ROUND}
    assert radii == {2.0, 2.4, 10.0, 22.0, 30.0}


def test_a_rod_lying_anywhere_is_placed_in_its_frame(tmp_path, leon, mass):
    def moved(occ):
        entities = occ.importShapes(str(leon))
        occ.rotate(entities, 0, 0, 0, 1, 2, 3, 1.1)
        occ.translate(entities, *CENTER)

    path = write(tmp_path / "moved.step", moved)
    with session():
        solid = import_cad(RodFile(path))
    assert solid.mirror is Mirror.QUARTER
    assert solid.mass.center == pytest.approx(mass.center, rel=1e-6, abs=1e-5)
    assert solid.mass.inertia_z == pytest.approx(mass.inertia_z, rel=1e-6)


@pytest.mark.parametrize(
    ("declared", "given", "scale"),
    [
        ("SI_UNIT(.CENTI.,.METRE.)", None, 10),  # 1.41 m is a rod's length
        ("SI_UNIT($,.METRE.)", None, 1),  # 141 m is none, 141 mm is
        ("SI_UNIT($,.METRE.)", "cm", 10),
        ("SI_UNIT(.MILLI.,.METRE.)", "in", 25.4),
    ],
)
def test_the_unit_of_the_file_is_respected_if_it_can_be(tmp_path, leon, declared, given, scale):
    path = tmp_path / "unit.step"
    path.write_text(leon.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", declared))
    with session():
        solid = import_cad(RodFile(path, unit=given))
    assert solid.bores[1].x == pytest.approx(141 * scale)
    assert solid.mass.mass == pytest.approx(101968.5 * scale**3, rel=1e-5)
    said = " ".join(solid.imported.assumed)
    assert ("taken to be mm" in said) == (scale == 1)
    assert ("though the file declares" in said) == (given is not None)


def test_several_solids_stay_parts_that_share_their_faces(tmp_path):
    def bushed(occ):
        strap(occ, ((0, 20 / 2), (100, 8)))
        outer = occ.addCylinder(100, 0, -6, 0, 0, 12, 8)
        occ.cut([(3, outer)], [(3, occ.addCylinder(100, 0, -50, 0, 0, 100, 6))])

    path = write(tmp_path / "bushed.step", bushed)
    with session():
        solid = import_cad(RodFile(path))
        shared = math.prod([2, math.pi, 8, 12]) / solid.mirror.copies
        boundary = [{tag for _, tag in gmsh.model.getBoundary([(3, v) for v in part.volumes], oriented=False)}
                    for part in solid.parts]  # fmt: skip
        common = boundary[0] & boundary[1]
        assert sum(gmsh.model.occ.getMass(2, tag) for tag in common) == pytest.approx(shared)
    assert [part.name for part in solid.parts] == ["part 1", "part 2"]
    assert solid.parts[1].mass.mass == pytest.approx(math.pi * (64 - 36) * 12)
    assert solid.bores[1].radius == pytest.approx(6)
    assert solid.mirror is Mirror.QUARTER


def test_a_lopsided_solid_is_not_cut(tmp_path):
    def lopsided(occ):
        bar = strap(occ)
        occ.cut(bar, [(3, occ.addCylinder(50, 12, 0, 0, 0, 50, 3))])

    path = write(tmp_path / "lopsided.step", lopsided)
    with session():
        assert import_cad(RodFile(path)).mirror is Mirror.NONE


def ellipse(occ, angle):
    """A strap with an elliptical hole, turned about its own axis."""
    section = occ.addPlaneSurface([occ.addCurveLoop([occ.addEllipse(50, 0, -50, 9, 4)])])
    occ.rotate([(2, section)], 50, 0, 0, 0, 0, 1, angle)
    tool = [entity for entity in occ.extrude([(2, section)], 0, 0, 100) if entity[0] == 3]
    occ.cut(strap(occ), tool)


@pytest.mark.parametrize(("angle", "mirror"), [(0.0, Mirror.QUARTER), (0.5, Mirror.HALF)])
def test_a_hole_turned_about_its_own_axis_is_no_mirror_image(tmp_path, angle, mirror):
    """Its wall keeps area and centre."""
    path = write(tmp_path / "ellipse.step", lambda occ: ellipse(occ, angle))
    with session():
        assert import_cad(RodFile(path)).mirror is mirror


def test_named_parts_that_are_images_of_each_other_are_not_cut_away(tmp_path):
    """They may be of different materials; solids that nobody names are pieces of one rod."""

    def halves(occ):
        bar = strap(occ)
        other = occ.copy(bar)
        occ.cut(bar, [(3, occ.addBox(-50, 0, -50, 200, 50, 100))])
        occ.cut(other, [(3, occ.addBox(-50, -50, -50, 200, 50, 100))])

    path = write(tmp_path / "halves.step", halves)
    for names, mirror, count in (((), Mirror.QUARTER, 1), (("part 1", "part 2"), Mirror.HALF, 2)):
        with session():
            solid = import_cad(RodFile(path, solids=names))
        assert (solid.mirror, len(solid.parts)) == (mirror, count)


@pytest.mark.parametrize("width", [2.0, 6.0])
def test_a_groove_is_not_taken_for_the_bore_that_has_it(tmp_path, width):
    def grooved(occ):
        occ.cut(strap(occ), [(3, occ.addCylinder(0, 0, -width / 2, 0, 0, width, 11))])

    path = write(tmp_path / "grooved.step", grooved)
    with session():
        big = import_cad(RodFile(path)).bores[0]
    assert big.radius == pytest.approx(10)
    assert big.width == pytest.approx(12 - width)


def test_counterbores_are_not_taken_for_the_bore(tmp_path):
    def bored(occ):
        tools = [(3, occ.addCylinder(100, 0, z, 0, 0, 2, 7)) for z in (-6, 4)]
        occ.cut(strap(occ), tools)

    path = write(tmp_path / "bored.step", bored)
    with session():
        small = import_cad(RodFile(path)).bores[1]
    assert (small.radius, small.width) == pytest.approx((5, 8))


@pytest.mark.parametrize("side", [-1, 1])
def test_of_two_bores_alike_the_big_ends_is_nearer_to_the_centre_of_gravity(tmp_path, side):
    def drawn(occ):
        bar = strap(occ, ((0, 8), (100, 8)))
        occ.fuse(bar, [(3, occ.addBox(50 + side * 75, -20, -6, side * 60, 40, 12))])

    path = write(tmp_path / "alike.step", drawn)
    with session():
        found = import_cad(RodFile(path))
        assert found.mass.center[0] < 40
        assert EQUAL_BORES in found.imported.assumed
    with session():
        other = import_cad(RodFile(path, swap_ends=True))
        assert other.mass.center[0] > 60
        assert EQUAL_BORES not in other.imported.assumed


def test_bores_that_cannot_be_told_are_listed_with_the_keys_that_name_them(tmp_path):
    path = write(tmp_path / "one.step", lambda occ: strap(occ, ((0, 10),)))
    with session(), pytest.raises(GeometryError) as refusal:
        import_cad(RodFile(path))
    for text in ("diameter 20 mm", "rod.big_end_bore_mm", "rod.small_end_bore_mm"):
        assert text in str(refusal.value)


def test_alike_holes_are_told_apart_by_the_diameters_given(tmp_path):
    holes = ((0, 10), (100, 5), (50, 5))
    path = write(tmp_path / "three.step", lambda occ: strap(occ, holes))
    with session(), pytest.raises(GeometryError, match="more than one pair"):
        import_cad(RodFile(path))
    holes = ((0, 10), (100, 5), (50, 7))
    path = write(tmp_path / "large.step", lambda occ: strap(occ, holes))
    with (
        session(),
        pytest.raises(GeometryError, match="more than one pair"),
    ):  # a hole of the shank, or the pin's
        import_cad(RodFile(path))
    with session():
        assert import_cad(RodFile(path, small_end_bore=10)).bores[1].x == pytest.approx(100)
    with session(), pytest.raises(GeometryError, match="no two parallel bores"):
        import_cad(RodFile(path, small_end_bore=11))


def test_a_blind_hole_and_a_boss_are_no_bores(tmp_path):
    def draw(occ):
        bar = strap(occ)
        occ.cut(bar, [(3, occ.addCylinder(50, 0, 2, 0, 0, 50, 12))])

    path = write(tmp_path / "blind.step", draw)
    with session():
        solid = import_cad(RodFile(path))
    assert [bore.radius for bore in solid.bores] == pytest.approx([10, 5])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a STEP file"),
        (b"solid stl", "not a STEP file"),
        (b"ISO-10303-21;\nrubbish", "could not read"),
    ],
)
def test_a_file_that_is_no_step_file_is_refused(tmp_path, content, message):
    path = tmp_path / "bad.step"
    path.write_bytes(content)
    with session(), pytest.raises(GeometryError, match=message):
        import_cad(RodFile(path))


def test_a_missing_file_is_the_systems_error(tmp_path):
    with session(), pytest.raises(FileNotFoundError):
        import_cad(RodFile(tmp_path / "none.step"))


def test_nothing_is_printed(leon, tmp_path, capfd):
    with session():
        (tmp_path / "again").write_bytes(step_file(LEON_2001))
    with session():
        import_cad(RodFile(tmp_path / "again"))
    assert capfd.readouterr().out == ""


def drafted(occ, angle):
    """A strap with a pocket whose walls lean outwards by an angle, rad, and corners of 2 mm at its floor."""

    def rim(z, grown):
        section = occ.addRectangle(35 - grown, -8 - grown, z, 30 + 2 * grown, 16 + 2 * grown, -1, 2 + grown)
        return occ.addCurveLoop([edge for _, edge in gmsh.model.occ.getEntities(1)][-8:]), section

    bar = strap(occ)
    loops = [rim(z, (z - 2) * math.tan(angle))[0] for z in (2, 8)]
    tool = [entity for entity in occ.addThruSections(loops, makeRuled=True) if entity[0] == 3]
    occ.cut(bar, tool)
    occ.remove(occ.getEntities(2), recursive=True)


def test_drafted_corners_and_blends_of_varying_radius_get_small_elements(tmp_path):
    """The corner's radius at the floor, across the leaning wall, and that of a blend's thin end."""
    path = write(tmp_path / "drafted.step", lambda occ: drafted(occ, 0.4))
    with session():
        rounds = [item for item in import_cad(RodFile(path)).features if item.kind is FeatureKind.ROUND]
    assert [item.radius for item in rounds] == [pytest.approx(2.0 / math.cos(0.4), rel=0.03)]
    assert rounds[0].sweep == pytest.approx(math.pi / 2, rel=0.1)

    def blended(occ):
        plate, wall = occ.addBox(-25, -20, -6, 150, 40, 12), occ.addBox(45, -20, 0, 10, 40, 15)
        tools = [(3, occ.addCylinder(x, 0, -50, 0, 0, 100, r)) for x, r in ((0, 10), (100, 5))]
        body, _ = occ.fuse(occ.cut([(3, plate)], tools)[0], [(3, wall)])
        occ.synchronize()
        corner = [e for _, e in gmsh.model.getEntitiesInBoundingBox(44, -21, 5, 46, 21, 7, 1)]
        occ.fillet([body[0][1]], corner, [2.0, 4.0])

    path = write(tmp_path / "blended.step", blended)
    with session():
        rounds = [item for item in import_cad(RodFile(path)).features if item.kind is FeatureKind.ROUND]
    assert [item.radius for item in rounds] == [pytest.approx(2.0, rel=0.1)]


def test_bores_that_are_splines_are_cylinders_all_the_same(tmp_path):
    def converted(occ):
        occ.mirror(strap(occ), 1, 0.3, 0, 2)  # which the kernel writes as splines

    path = write(tmp_path / "splines.step", converted)
    assert "B_SPLINE_SURFACE" in path.read_text()
    with session():
        solid = import_cad(RodFile(path))
    assert [(bore.radius, bore.width) for bore in solid.bores] == [
        pytest.approx((10, 12), rel=5e-3),  # the kernel integrates the area of splines coarsely
        pytest.approx((5, 12), rel=5e-3),
    ]
    assert solid.bores[1].x == pytest.approx(100, rel=1e-6)
    assert solid.mirror is Mirror.QUARTER
    walls = [solid.faces[surface] for surface in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)]
    assert all(walls)
