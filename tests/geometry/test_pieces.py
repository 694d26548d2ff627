"""A rod that is drawn in touching pieces is one rod; what is left out though it touches is doubted."""

import math

import gmsh
import pytest

from geometry.cad.imported import import_cad
from geometry.errors import GeometryError
from geometry.imports import RodFile
from geometry.session import session

LENGTH, WIDTH = 120.0, 20.0


def rod(occ):
    """Two rings and a bar."""
    ring = occ.addCylinder(0, 0, -WIDTH / 2, 0, 0, WIDTH, 34)
    eye = occ.addCylinder(LENGTH, 0, -WIDTH / 2, 0, 0, WIDTH, 18)
    body, _ = occ.fuse([(3, ring)], [(3, eye), (3, occ.addBox(0, -9, -6, LENGTH, 18, 12))])
    bores = [(3, occ.addCylinder(x, 0, -20, 0, 0, 40, radius)) for x, radius in ((0, 25), (LENGTH, 11))]
    return occ.cut(body, bores)[0]


def divided(occ, planes):
    """Cut the rod by large rectangles: a point, and a turn about the x or z axis each."""
    tools = []
    for point, axis, angle in planes:
        plane = (2, occ.addRectangle(-300, -300, 0, 600, 600))
        occ.rotate([plane], 0, 0, 0, *axis, angle)
        occ.translate([plane], *point)
        tools.append(plane)
    solids = rod(occ)
    occ.fragment(solids, tools)
    occ.synchronize()
    for face in gmsh.model.getEntities(2):
        if not len(gmsh.model.getAdjacencies(*face)[0]):
            occ.remove([face], recursive=True)


ACROSS_X, ACROSS_Y, ACROSS_Z = ((0, 1, 0), math.pi / 2), ((1, 0, 0), math.pi / 2), ((1, 0, 0), 0.0)
WAYS = {
    "halves": [((0, 0, 0), *ACROSS_Z)],
    "layers": [((0, 0, -4), *ACROSS_Z), ((0, 0, 3), *ACROSS_Z)],
    "along": [((0, 0, 0), *ACROSS_Y)],
    "shank": [((60, 0, 0), *ACROSS_X)],
    "quarters": [((0, 0, 0), *ACROSS_Y), ((0, 0, 0), *ACROSS_Z)],
    "through the small end": [((LENGTH, 0, 0), *ACROSS_X)],
}


def found(folder, draw, **more):
    with session():
        gmsh.model.add("drawn")
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(folder / "rod.step"))
    with session():
        return import_cad(RodFile(folder / "rod.step", **more))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return found(tmp_path_factory.mktemp("whole"), rod).mass


@pytest.mark.parametrize("way", WAYS)
def test_touching_pieces_are_one_rod(tmp_path, whole, way):
    one = found(tmp_path, lambda occ: divided(occ, WAYS[way]))
    assert one.mass.mass == pytest.approx(whole.mass, rel=1e-6)
    assert one.mass.inertia_z == pytest.approx(whole.inertia_z, rel=1e-6)
    assert all(solid.kept for solid in one.imported.solids)


def test_a_duplicate_counts_once(tmp_path, whole):
    def twice(occ):
        occ.copy(rod(occ))

    assert found(tmp_path, twice).mass.mass == pytest.approx(whole.mass, rel=1e-9)


def test_a_mirrored_half_with_a_small_gap_is_joined(tmp_path, whole):
    def halves(occ):
        occ.cut(rod(occ), [(3, occ.addBox(-200, -200, -100, 600, 400, 100))])
        upper = occ.getEntities(3)
        lower = occ.copy(upper)
        occ.rotate(lower, 0, 0, 0, 1, 0, 0, math.pi)
        occ.translate(lower, 0, 0, -1e-3)

    assert found(tmp_path, halves).mass.mass == pytest.approx(whole.mass, rel=1e-3)


def test_solids_that_overlap_are_refused_with_the_remedy(tmp_path):
    def overlapping(occ):
        rod(occ)
        occ.addBox(50, -9, -6, 30, 18, 12)  # a piece of the shank, drawn once more

    with pytest.raises(GeometryError, match=r"overlap, .* Join them .*rod\.solids"):
        found(tmp_path, overlapping)


def test_a_solid_that_touches_and_is_left_out_is_doubted(tmp_path):
    def with_block(occ):
        rod(occ)
        occ.addBox(50, 9, -6, 20, 10, 12)  # lies on the shank

    read = found(tmp_path, with_block).imported
    joined = all(solid.kept for solid in read.solids)
    assert joined or any("left out, though touching the rod" in doubt for doubt in read.doubts)


def test_a_master_rod_is_told_from_its_knuckle_pins(tmp_path):
    def master(occ):
        ring = [(3, occ.addCylinder(0, 0, -WIDTH / 2, 0, 0, WIDTH, 60))]
        body, _ = occ.fuse(rod(occ), ring)
        tools = [(3, occ.addCylinder(0, 0, -50, 0, 0, 100, 25))]
        for k in range(4):
            angle = math.pi / 2 + k * math.pi / 3
            tools.append((3, occ.addCylinder(45 * math.cos(angle), 45 * math.sin(angle), -50, 0, 0, 100, 7)))
        occ.cut(body, tools)

    carried = found(tmp_path, master).imported.carried
    assert "4 holes of 14 mm beside the big end: this is a master rod" in carried
    assert "forces of the rods that hang on it are not analysed" in carried
