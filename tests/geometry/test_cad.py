"""Files of any CAD program: assemblies, other formats and units, bores that are cylinders by shape alone."""

import math
import re
import zipfile
from itertools import pairwise

import gmsh
import numpy as np
import pytest
from cad_files import freecad_document

from geometry.cad.bores import HalfOpenError
from geometry.cad.formats import declared_unit
from geometry.cad.imported import import_cad
from geometry.errors import GeometryError
from geometry.faces import FeatureKind
from geometry.imports import MissingCap, RodFile, Role
from geometry.session import session
from geometry.surfaces import Mirror

pytestmark = pytest.mark.slow

LENGTH, BIG, SMALL, WIDTH = 150.0, 25.0, 11.0, 20.0
# Of a link: place along it and radius, the largest one between the others.
HOLES = ((0, 25), (70, 28), (150, 11))


def written(path, draw, scale=1.0):
    """Write what `draw(occ)` leaves in the model, times a scale."""
    with session():
        gmsh.model.add("drawn")
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
        if scale != 1.0:  # while reading, as the kernel would make splines of a dilated model
            gmsh.model.add("scaled")
            gmsh.option.setNumber("Geometry.OCCScaling", scale)
            gmsh.model.occ.importShapes(str(path))
            gmsh.model.occ.synchronize()
            gmsh.write(str(path))
    return path


def rod(occ, *, cap="fused", z=0.0, gap=0.0, bores=None):
    """A plain rod, its axis along x: whole, split into rod and cap at x = 0, or without its cap."""
    ring = occ.addCylinder(0, 0, z - WIDTH / 2, 0, 0, WIDTH, BIG + 9)
    eye = occ.addCylinder(LENGTH, 0, z - WIDTH / 2, 0, 0, WIDTH, SMALL + 6)
    bar = occ.addBox(20, -9, z - 6, LENGTH - 30, 18, 12)
    body, _ = occ.fuse([(3, ring)], [(3, eye), (3, bar)])
    tools = bores or [bore(occ, x, r, z) for x, r in ((0, BIG), (LENGTH, SMALL))]
    body, _ = occ.cut(body, tools)
    if cap == "fused":
        return
    copy = occ.copy(body) if cap == "split" else []
    occ.cut(body, [(3, occ.addBox(-100, -100, z - 50, 100, 200, 100))])
    if copy:
        occ.cut(copy, [(3, occ.addBox(-gap, -100, z - 50, 300, 200, 100))])


def bore(occ, x, radius, z=0.0):
    return 3, occ.addCylinder(x, 0, z - 50, 0, 0, 100, radius)


def prism(occ, edges):
    """A hole along z inside a closed loop of edges at z = -50."""
    face = occ.addPlaneSurface([occ.addCurveLoop(edges)])
    return next(made for made in occ.extrude([(2, face)], 0, 0, 100) if made[0] == 3)


def ellipse(occ, radius, share):
    return prism(occ, [occ.addEllipse(0, 0, -50, radius * (1 + share), radius * (1 - share))])


def polygon(occ, radius, sides):
    angles = [2 * math.pi * place / sides for place in range(sides)]
    corners = [occ.addPoint(radius * math.cos(a), radius * math.sin(a), -50) for a in angles]
    edges = [occ.addLine(*ends) for ends in zip(corners, corners[1:] + corners[:1], strict=True)]
    return prism(occ, edges)


def cone(occ, radius):
    return 3, occ.addCone(0, 0, -WIDTH / 2, 0, 0, WIDTH, radius, 1.02 * radius)


def sleeve(occ, x, radii, width, z=0.0):
    outer, inner = radii
    occ.cut([(3, occ.addCylinder(x, 0, z - width / 2, 0, 0, width, outer))], [bore(occ, x, inner, z)])


def crank_drive(occ):
    """A rod and its cap, with a bushing, a piston pin, two bolts, a crank pin with its webs, and a piston."""
    rod(occ, cap="split")
    bushing = occ.addCylinder(LENGTH, 0, -WIDTH / 2, 0, 0, WIDTH, SMALL)
    occ.cut([(3, bushing)], [(3, occ.addCylinder(LENGTH, 0, -50, 0, 0, 100, SMALL - 2))])
    pin = occ.addCylinder(LENGTH, 0, -35, 0, 0, 70, SMALL - 2)
    occ.cut([(3, pin)], [(3, occ.addCylinder(LENGTH, 0, -50, 0, 0, 100, 4))])
    for y in (-29.5, 29.5):
        occ.addCylinder(-30, y, 0, 60, 0, 0, 2.5)
    webs = [(3, occ.addBox(-120, -30, z, 150, 60, 15)) for z in (-26, 11)]
    occ.fuse([(3, occ.addCylinder(0, 0, -30, 0, 0, 60, BIG))], webs)
    piston = occ.addCylinder(LENGTH - 25, 0, 0, 60, 0, 0, 42)
    room = [(3, occ.addBox(LENGTH - 60, -50, -12, 80, 100, 24))]
    occ.cut([(3, piston)], [*room, (3, occ.addCylinder(LENGTH, 0, -50, 0, 0, 100, SMALL - 2))])


def imported(path, **said):
    with session():
        return import_cad(RodFile(path, **said))


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    return written(tmp_path_factory.mktemp("cad") / "drive.step", crank_drive)


def test_the_rod_and_what_belongs_to_it_are_picked_out_of_an_assembly(drive):
    found = imported(drive)
    roles = [one.role for one in found.imported.solids]
    assert sorted(role for role in roles if role is not Role.OTHER) == sorted(
        [Role.ROD, Role.CAP, Role.BUSHING, Role.PIN, Role.BOLT, Role.BOLT]
    )
    assert roles.count(Role.OTHER) == 2
    kept = {one.role for one in found.imported.solids if one.kept}
    assert kept == {Role.ROD, Role.CAP, Role.BUSHING}
    assert [bore.radius for bore in found.bores] == pytest.approx([BIG, SMALL - 2])
    assert found.bores[1].x == pytest.approx(LENGTH)
    assert found.mirror is Mirror.QUARTER
    (left,) = (text for text in found.imported.assumed if "left out of drive.step" in text)
    assert left.endswith(" and 2 more solids (rod.solids)")


def test_named_solids_override_the_choice(drive):
    names = [one.name for one in imported(drive).imported.solids if one.role in (Role.ROD, Role.CAP)]
    found = imported(drive, solids=tuple(names))
    assert [one.name for one in found.imported.solids if one.kept] == names
    assert found.bores[1].radius == pytest.approx(SMALL)
    with session(), pytest.raises(GeometryError, match=r"rod\.solids names 'rot', but the solids .* are: "):
        import_cad(RodFile(drive, solids=("rot",)))


def test_a_cap_apart_gives_the_rod_in_one_piece(tmp_path):
    whole = imported(written(tmp_path / "whole.step", rod))
    split = imported(written(tmp_path / "split.step", lambda occ: rod(occ, cap="split")))
    assert split.mass.mass == pytest.approx(whole.mass.mass, rel=1e-9)
    assert split.bores[0].width == pytest.approx(whole.bores[0].width, rel=1e-9)
    assert len(split.parts) == 2


def test_a_rod_without_its_cap_is_refused_or_given_one(tmp_path):
    path = written(tmp_path / "capless.step", lambda occ: rod(occ, cap="none"))
    with (
        session(),
        pytest.raises(HalfOpenError, match=r"diameter 50 mm .* covers only 180°\. Is the cap missing"),
    ):
        import_cad(RodFile(path))
    found = imported(path, cap=MissingCap.ASSUMED)
    ring = math.pi / 2 * ((BIG + 9) ** 2 - BIG**2) * WIDTH
    assert found.imported.solids[1].volume == pytest.approx(ring, rel=1e-9)
    assert found.mirror is Mirror.QUARTER
    whole = imported(written(tmp_path / "whole.step", rod))
    assert found.mass.mass == pytest.approx(whole.mass.mass, rel=1e-9)


def test_two_rods_alike_are_one_and_different_ones_must_be_chosen(tmp_path):
    def twice(occ):
        rod(occ)
        rod(occ, z=40)

    found = imported(written(tmp_path / "twice.step", twice))
    assert [one.kept for one in found.imported.solids] == [True, False]

    def different(occ):
        rod(occ)
        before = occ.getEntities(3)
        rod(occ, z=40)
        other = [solid for solid in occ.getEntities(3) if solid not in before]
        occ.dilate(other, 0, 0, 40, 1.2, 1.2, 1.0)

    path = written(tmp_path / "different.step", different)
    with session(), pytest.raises(GeometryError, match=r"several solids .* could be the rod.*rod\.solids"):
        import_cad(RodFile(path))


@pytest.mark.parametrize("ending", ["step", "brep", "igs", "FCStd"])
def test_every_format_gives_the_same_rod(tmp_path, ending):
    path = tmp_path / f"rod.{ending}"
    if ending == "FCStd":
        written(tmp_path / "rod.brep", rod)
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("Document.xml", freecad_document("rod.brp"))
            archive.write(tmp_path / "rod.brep", "rod.brp")
    else:
        written(path, rod)
    found, said = imported(path), imported(written(tmp_path / "same.step", rod))
    assert found.mass.mass == pytest.approx(said.mass.mass, rel=1e-6)
    assert found.bores[1].x == pytest.approx(LENGTH, rel=1e-6)
    assert [bore.radius for bore in found.bores] == pytest.approx([BIG, SMALL], rel=1e-6)


@pytest.mark.parametrize("ending", ["step", "igs"])
def test_surfaces_that_close_volumes_become_solids(tmp_path, ending):
    def shells(occ):
        rod(occ)
        occ.addBox(200, 0, 0, 20, 20, 20)
        occ.remove(occ.getEntities(3))

    found = imported(written(tmp_path / f"shells.{ending}", shells))
    assert [one.kept for one in found.imported.solids] == [True, False]
    assert found.mass.mass == pytest.approx(imported(written(tmp_path / "rod.step", rod)).mass.mass, rel=1e-3)

    def half_open(occ):
        shells(occ)
        occ.remove(occ.getEntities(2)[:1])

    path = written(tmp_path / f"open.{ending}", half_open)
    with session(), pytest.raises(GeometryError):
        import_cad(RodFile(path))


KINDS = ("step", "igs", "brep", "surfaces.igs")


def half(path, which, scale=1.0):
    """Write the body or the cap of the rod, as a solid or as surfaces."""

    def draw(occ):
        rod(occ, cap="split")
        solids = occ.getEntities(3)
        middle = [occ.getCenterOfMass(*solid)[0] for solid in solids]
        body, cap = (solids[k] for k in np.argsort(middle)[::-1])
        occ.remove([cap if which == "body" else body], recursive=True)
        if path.name.endswith("surfaces.igs"):
            occ.remove(occ.getEntities(3))

    return written(path, draw, scale)


@pytest.mark.parametrize("of_cap", KINDS)
@pytest.mark.parametrize("of_body", KINDS)
def test_body_and_cap_of_any_two_kinds_are_one_rod(tmp_path, of_body, of_cap):
    body, cap = half(tmp_path / f"body.{of_body}", "body"), half(tmp_path / f"cap.{of_cap}", "cap")
    whole = imported(written(tmp_path / "whole.step", rod))
    found = imported(body, cap=cap)
    assert found.mass.mass == pytest.approx(
        whole.mass.mass, rel=1e-3 if "surfaces" in of_body + of_cap else 1e-6
    )
    assert len(found.parts) == 2


def test_the_unit_of_an_earlier_file_does_not_scale_a_later_one(tmp_path):
    """The kernel keeps the unit to which it converted the last STEP file, also when gmsh is closed."""
    metres = {which: half(tmp_path / f"{which}_m.step", which, 1e-3) for which in ("body", "cap")}
    iges = {which: half(tmp_path / f"{which}.igs", which) for which in ("body", "cap")}
    whole = imported(written(tmp_path / "whole.step", rod)).mass.mass
    in_metres = imported(metres["body"], cap=metres["cap"], unit="m")
    assert in_metres.mass.mass == pytest.approx(whole, rel=1e-6)
    assert imported(iges["body"], cap=iges["cap"]).mass.mass == pytest.approx(whole, rel=1e-6)
    both = imported(metres["body"], cap=half(tmp_path / "cap_m.igs", "cap", 1e-3), unit="m")
    assert both.mass.mass == pytest.approx(whole, rel=1e-6)


@pytest.mark.parametrize(("of_body", "of_cap"), [("m", "mm"), ("mm", "m")])
def test_body_and_cap_that_declare_different_units_are_one_rod(tmp_path, of_body, of_cap):
    def declared(which, unit):
        path = half(tmp_path / f"{which}_{unit}.step", which, 1e-3 if unit == "m" else 1.0)
        if unit == "m":
            path.write_text(path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"))
        return path

    body, cap = declared("body", of_body), declared("cap", of_cap)
    whole = imported(written(tmp_path / "whole.step", rod))
    found = imported(body, cap=cap)
    assert found.mass.mass == pytest.approx(whole.mass.mass, rel=1e-6)
    with session(), pytest.raises(GeometryError, match=rf"{cap.name}.*does not close.*--unit"):
        import_cad(RodFile(body, cap=cap, unit="mm"))


def test_a_length_that_no_unit_explains_asks_for_another_scale(tmp_path):
    path = written(tmp_path / "rod.step", rod, 1e3)
    with session(), pytest.raises(GeometryError, match=r"in mm .* 1.5e\+05 mm apart.*Scale the rod"):
        import_cad(RodFile(path))


@pytest.mark.parametrize(("unit", "length"), [("m", "1.5e\\+05 mm"), ("in", None)])
def test_a_length_of_no_rod_asks_for_the_unit(tmp_path, unit, length):
    path = written(tmp_path / "rod.step", rod)
    if length is None:
        assert imported(path, unit=unit).bores[1].x == pytest.approx(25.4 * LENGTH)
        return
    with (
        session(),
        pytest.raises(GeometryError, match=rf"in m the bores are {length} apart.*--unit.*mm \(150 mm\)"),
    ):
        import_cad(RodFile(path, unit=unit))


def test_a_rod_of_splines_has_the_measures_of_the_rod(tmp_path):
    """Rational splines, to which programs convert whole solids: the kernel's own volume is off by 0.5 %."""

    def splines(occ):
        rod(occ)
        occ.convertToNURBS(occ.getEntities(3))

    path = written(tmp_path / "splines.step", splines)
    found, exact = imported(path), imported(written(tmp_path / "rod.step", rod))
    assert found.mass.mass == pytest.approx(exact.mass.mass, rel=2e-5)
    assert found.mass.center == pytest.approx(exact.mass.center, abs=2e-3)
    assert found.mass.inertia_z == pytest.approx(exact.mass.inertia_z, rel=1e-4)
    for bore, known in zip(found.bores, exact.bores, strict=True):
        assert (bore.x, bore.radius) == pytest.approx((known.x, known.radius), abs=1e-4)
        assert bore.width == pytest.approx(known.width, rel=1e-4)
    assert found.imported.solids[0].size == pytest.approx(exact.imported.solids[0].size, rel=1e-3)
    assert found.imported.solids[0].volume == pytest.approx(exact.imported.solids[0].volume, rel=2e-5)


def test_surfaces_beside_those_that_close_a_volume_are_not_meshed(tmp_path):
    def shell_and_plane(occ):
        rod(occ)
        occ.addRectangle(0, 0, 60, 50, 50)
        occ.remove(occ.getEntities(3))

    path = written(tmp_path / "beside.igs", shell_and_plane)
    with session():
        import_cad(RodFile(path))
        walls = set(gmsh.model.getBoundary(gmsh.model.getEntities(3), combined=False, oriented=False))
        assert set(gmsh.model.getEntities(2)) == walls


def test_a_round_in_strips_is_measured_as_one(tmp_path):
    def notched(occ):
        corner = [(65 - 5 * math.cos(a), 9 - 5 * math.sin(a)) for a in np.linspace(0, math.pi / 2, 9)]
        points = [occ.addPoint(x, y, 10) for x, y in [*corner, (90, 4), (90, 34), (60, 34)]]
        center = occ.addPoint(65, 9, 10)
        arcs = [occ.addCircleArc(one, center, other) for one, other in pairwise(points[:9])]
        lines = [occ.addLine(one, other) for one, other in pairwise([*points[8:], points[0]])]
        pocket = occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop([*arcs, *lines])]))], 0, 0, -8)
        bar = [(3, occ.addBox(-40, -40, -10, 230, 80, 20))]
        occ.cut(bar, [pocket[1], bore(occ, 0, BIG), bore(occ, LENGTH, SMALL)])
        occ.remove(occ.getEntities(2), recursive=True)
        occ.remove([(0, center)])

    found = imported(written(tmp_path / "strips.step", notched)).features
    rounds = [one for one in found if one.kind is FeatureKind.ROUND]
    assert [(len(one.faces), one.radius) for one in rounds] == [(8, pytest.approx(5))]
    assert rounds[0].sweep == pytest.approx(math.pi / 2, rel=1e-3)


@pytest.mark.parametrize(("scale", "unit"), [(1e-3, "m"), (1 / 25.4, "in"), (1.0, "mm")])
def test_a_wrong_unit_is_told_by_the_rods_length(tmp_path, scale, unit):
    path = written(tmp_path / "rod.step", rod, scale)
    found = imported(path)
    assert found.imported.unit == unit
    assert found.bores[1].x == pytest.approx(LENGTH, rel=1e-6)
    assert found.bores[0].radius == pytest.approx(BIG, rel=1e-3)
    assert any("taken to be" in text for text in found.imported.assumed) == (unit != "mm")


def test_a_file_in_metres_is_the_same_as_one_in_millimetres(tmp_path):
    path = written(tmp_path / "metres.step", rod, 1e-3)
    path.write_text(path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"))
    metres, millimetres = imported(path), imported(written(tmp_path / "mm.step", rod))
    assert (metres.imported.unit, metres.imported.assumed) == ("m", ())
    assert metres.bores[1].x == pytest.approx(millimetres.bores[1].x, rel=1e-12)
    assert metres.mass.mass == pytest.approx(millimetres.mass.mass, rel=1e-9)


@pytest.mark.parametrize(("declared", "unit"), [("$", None), (".MICRO.", None), (".CENTI.", "mm")])
def test_the_same_numbers_in_millimetres_give_the_same_bits_whatever_the_file_declares(
    tmp_path, declared, unit
):
    plain, told = written(tmp_path / "plain.step", rod), tmp_path / "told.step"
    told.write_text(plain.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", f"SI_UNIT({declared},.METRE.)"))

    def bits(path, unit=None):
        with session():
            solid = import_cad(RodFile(path, unit=unit))
            gmsh.option.setNumber("Mesh.MeshSizeMax", 10)
            gmsh.model.mesh.generate(2)
            nodes = gmsh.model.mesh.getNodes()[1].tobytes()
        return solid.imported.unit, solid.mass, solid.bores, nodes

    assert bits(told, unit) == bits(plain)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"PK nothing", "not a readable FreeCAD file"),
        (b"", "is not a FreeCAD file: it must be a zip archive"),
    ],
)
def test_a_damaged_archive_is_refused(tmp_path, content, message):
    path = tmp_path / "rod.FCStd"
    path.write_bytes(content)
    with session(), pytest.raises(GeometryError, match=message):
        import_cad(RodFile(path))


def test_a_document_of_links_names_the_files_that_hold_its_parts(tmp_path):
    shape = written(tmp_path / "screw.brep", lambda occ: occ.addCylinder(0, 0, 0, 0, 0, 20, 3))
    text = freecad_document("a.brp").replace(
        "</Properties>",
        '<Property name="LinkedObject"><XLink file="parts/Rod.FCStd" name="Model"/></Property></Properties>',
    )
    path = tmp_path / "assembly.FCStd"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("Document.xml", text)
        archive.write(shape, "a.brp")
    with session(), pytest.raises(GeometryError, match=r"links to other files.*\(Rod.FCStd\): read the file"):
        import_cad(RodFile(path))


def test_a_placement_that_leads_nowhere_is_damage(tmp_path):
    written(tmp_path / "rod.brep", rod)
    placed = '<Property name="Placement"><PropertyPlacement Px="nan" Q3="1"/></Property></Properties>'
    group = """<Object name="Part"><Properties>
<Property name="Group"><LinkList><Link value="Body"/></LinkList></Property>"""
    text = freecad_document("rod.brp")
    text = text.replace("</Objects>", '<Object type="App::Part" name="Part"/></Objects>')
    path = tmp_path / "rod.FCStd"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "Document.xml", text.replace("</ObjectData>", f"{group}{placed}</Object></ObjectData>")
        )
        archive.write(tmp_path / "rod.brep", "rod.brp")
    refused(path, "is not a readable FreeCAD file .a placement is out of range")


def test_a_shape_that_is_cut_short_is_refused_at_once(tmp_path, monkeypatch):
    path = written(tmp_path / "rod.brep", rod)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    monkeypatch.setattr(gmsh.model.occ, "importShapes", None)  # it would not return
    refused(path, r"rod\.brep ends before its last line")


def test_a_solid_that_is_inside_out_is_turned(tmp_path):
    path = written(tmp_path / "rod.brep", rod)
    upright = imported(path)
    path.write_text(re.sub(r"\n\+(\d+ 0)\s*$", r"\n-\1\n", path.read_text().rstrip() + "\n"))
    found = imported(path)
    assert found.mass.mass == pytest.approx(upright.mass.mass, rel=1e-9)
    assert found.mirror is Mirror.QUARTER


def test_an_archive_neither_fills_the_disk_nor_writes_elsewhere(tmp_path, monkeypatch):
    monkeypatch.setattr("geometry.cad.formats.MOST_SHAPES", 10_000)
    path = tmp_path / "bomb.FCStd"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Document.xml", freecad_document("../../outside.brp"))
        archive.writestr("../../outside.brp", b"0" * 100_000)
    with session(), pytest.raises(GeometryError, match="unpacks to more than"):
        import_cad(RodFile(path))
    assert [entry.name for entry in tmp_path.iterdir()] == ["bomb.FCStd"]


def test_holes_that_are_no_bores_of_a_rod_are_refused(tmp_path):
    def bracket(occ):  # two holes in one corner of a large plate
        plate = occ.addBox(0, 0, 0, 400, 300, 12)
        tools = [(3, occ.addCylinder(x, 20, -50, 0, 0, 100, r)) for x, r in ((20, 8), (60, 5))]
        occ.cut([(3, plate)], tools)

    path = written(tmp_path / "bracket.step", bracket)
    with (
        session(),
        pytest.raises(GeometryError, match="are not the bores of a rod: the centre of gravity lies"),
    ):
        import_cad(RodFile(path))
    named = imported(path, big_end_bore=16.0, small_end_bore=10.0)
    assert named.bores[1].x == pytest.approx(40)


def refused(path, message, **said):
    with session(), pytest.raises(GeometryError, match=message):
        import_cad(RodFile(path, **said))


def test_a_hollow_pin_shorter_than_the_bore_is_no_bushing(tmp_path):
    def draw(occ):
        rod(occ)
        sleeve(occ, LENGTH, (SMALL, SMALL - 2), WIDTH)
        sleeve(occ, LENGTH, (SMALL - 2, 5), WIDTH - 2)

    found = imported(written(tmp_path / "pin.step", draw))
    assert [one.role for one in found.imported.solids] == [
        Role.ROD,
        Role.BUSHING,
        Role.PIN,
    ]
    assert found.bores[1].radius == pytest.approx(SMALL - 2)


def test_what_belongs_to_the_rod_beside_is_left_out(tmp_path):
    def draw(occ):
        for z in (0, WIDTH):
            rod(occ, cap="split", z=z)
            sleeve(occ, 0, (BIG, BIG - 2), WIDTH, z)

    found = imported(written(tmp_path / "pair.step", draw))
    assert [one.role for one in found.imported.solids if one.kept] == [
        Role.ROD,
        Role.CAP,
        Role.BUSHING,
    ]
    assert Role.OTHER_ROD in [one.role for one in found.imported.solids]
    assert found.bores[0].width == pytest.approx(WIDTH)


def test_rods_with_the_same_bores_and_other_shanks_must_be_chosen(tmp_path):
    def draw(occ):
        rod(occ)
        before = occ.getEntities(3)
        rod(occ, z=40)
        other = [solid for solid in occ.getEntities(3) if solid not in before]
        occ.cut(other, [(3, occ.addBox(50, -20, 40, 60, 40, 20))])

    path = written(tmp_path / "alike.step", draw)
    refused(path, r"several solids .* could be the rod: .* mm³")
    assert imported(path, solids=("part 2",)).imported.solids[1].role is Role.ROD


def test_parts_that_do_not_touch_are_refused(tmp_path):
    path = written(tmp_path / "gap.step", lambda occ: rod(occ, cap="split", gap=0.05))
    refused(path, r"do not touch \(gap 0\.05 mm\), so they cannot be bonded")


@pytest.mark.parametrize(
    ("shape", "why"),
    [
        (lambda occ: ellipse(occ, BIG, 0.01), r"diameter 50 mm .* circle by 0\.25 mm, 1 % of its radius"),
        (lambda occ: polygon(occ, BIG, 36), r"diameter 49\.\d* mm .* circle by 0\.06\d* mm"),
        (lambda occ: cone(occ, BIG), r"whose wall is not a cylinder"),
    ],
)
def test_a_bore_that_is_no_cylinder_is_refused_with_its_deviation(tmp_path, shape, why):
    path = written(tmp_path / "odd.step", lambda occ: rod(occ, bores=[shape(occ), bore(occ, LENGTH, SMALL)]))
    refused(path, f"no two parallel bores were found.*{why}")

    def with_a_hole(occ):  # 75 mm from the small end: an oil drilling, or a pair of bores to someone careless
        rod(occ, bores=[shape(occ), bore(occ, LENGTH, SMALL), bore(occ, LENGTH / 2, 3)])

    refused(written(tmp_path / "hole.step", with_a_hole), f"a larger hole is unused.*{why}")


def test_a_hole_between_the_bores_is_not_taken_for_the_larger_bore(tmp_path):
    def draw(occ):
        occ.cut([(3, occ.addBox(-40, -40, -10, 230, 80, 20))], [bore(occ, x, r) for x, r in HOLES])

    path = written(tmp_path / "link.step", draw)
    refused(path, "more than one pair of holes could be the bores")
    assert imported(path, big_end_bore=50.0, small_end_bore=22.0).bores[1].x == pytest.approx(LENGTH)


def test_a_rod_with_a_hole_in_its_shank_is_found_among_other_parts(tmp_path):
    def draw(occ):
        holes = [bore(occ, x, r) for x, r in ((0, BIG), (LENGTH / 2, SMALL + 1), (LENGTH, SMALL))]
        occ.cut([(3, occ.addBox(-40, -40, -10, 230, 80, 20))], holes)
        bore(occ, LENGTH, SMALL)
        bore(occ, 0, BIG)

    path = written(tmp_path / "lightened.step", draw)
    refused(path, "more than one pair of holes could be the bores")
    found = imported(path, big_end_bore=2 * BIG, small_end_bore=2 * SMALL)
    assert [one.role for one in found.imported.solids if one.kept] == [Role.ROD]


def test_bolt_holes_of_a_cap_alone_are_no_bores(tmp_path):
    def draw(occ):
        occ.cut(
            [(3, occ.addCylinder(0, 0, -WIDTH / 2, 0, 0, WIDTH, BIG + 20))],
            [
                bore(occ, 0, BIG),
                (3, occ.addBox(0, -100, -50, 100, 200, 100)),
                *((3, occ.addCylinder(-60, y, 0, 120, 0, 0, 4)) for y in (-35, 35)),
            ],
        )

    refused(written(tmp_path / "cap.step", draw), "covers only 180°, .*: this is a cap, or another part")


def test_the_end_with_the_cap_is_the_big_end(tmp_path):
    def draw(occ):
        rod(occ, cap="split", bores=[bore(occ, 0, SMALL - 1), bore(occ, LENGTH, SMALL)])

    found = imported(written(tmp_path / "slim.step", draw))
    assert [end.radius for end in found.bores] == pytest.approx([SMALL - 1, SMALL])


def test_solids_of_the_same_name_are_numbered(tmp_path):
    path = written(tmp_path / "twins.step", lambda occ: rod(occ, cap="split"))
    text = re.sub(r"PRODUCT\('[^']*',\s*'[^']*'", r"PRODUCT('Body','\\X2\\00DC\\X0\\ \t1'", path.read_text())
    path.write_text(text)
    found = imported(path)
    assert [one.name for one in found.imported.solids] == ["Ü 1 1", "Ü 1 2"]
    assert len(imported(path, solids=("Ü 1",)).parts) == 2
    refused(path, "half open", solids=("Ü 1 1",))


@pytest.mark.parametrize(
    ("declared", "name"), [(".MICRO.", "µm"), (".DECI.", "dm"), (".KILO.", "km"), (".CENTI.", "cm")]
)
def test_a_unit_that_no_rod_is_drawn_in_is_named(tmp_path, declared, name):
    path = written(tmp_path / "rod.step", rod)
    path.write_text(path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", f"SI_UNIT({declared},.METRE.)"))
    assert declared_unit(path) == name
    found = imported(path)
    assert found.imported.unit == ("cm" if name == "cm" else "mm")
    assert found.bores[1].x == pytest.approx(LENGTH * (10 if name == "cm" else 1))
    assumed = " ".join(found.imported.assumed)
    assert (f"because in {name}, which the file" in assumed) == (name != "cm")


def test_a_length_that_is_unusual_is_told(tmp_path):
    path = written(tmp_path / "model.step", rod, 1 / 6)
    assert 'apart, which is unusual for a rod; with rod.unit = "in"' in " ".join(
        imported(path).imported.assumed
    )
    assert imported(path, unit="mm").imported.assumed == ()


def test_a_byte_order_mark_is_skipped_and_a_cut_file_called_so(tmp_path):
    path = written(tmp_path / "rod.step", rod)
    content = path.read_bytes()
    path.write_bytes(b"\xef\xbb\xbf" + content)
    assert imported(path).bores[1].x == pytest.approx(LENGTH)
    path.write_bytes(content[: len(content) // 2])
    refused(path, "could not read rod.step.* may be damaged or cut short")


def test_few_walls_of_a_large_solid_are_examined(tmp_path, monkeypatch):
    def draw(occ):
        rod(occ)
        holes = [bore(occ, 300 + 20 * place, 4) for place in range(60)]
        occ.cut([(3, occ.addBox(280, -20, -10, 1240, 40, 20))], holes)

    path = written(tmp_path / "plate.step", draw)
    asked, inside = [], gmsh.model.isInside
    monkeypatch.setattr(gmsh.model, "isInside", lambda *given: asked.append(given) or inside(*given))
    assert [one.kept for one in imported(path).imported.solids] == [True, False]
    assert sum(volume == 2 for _, volume, *_ in asked) < 60  # fewer than one for each hole
