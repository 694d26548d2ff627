"""Which surfaces are machined is told by geometry, for parametric rods and for solids from files alike."""

from dataclasses import replace

import numpy as np
import pytest

from fea.base.choices import Element, Region
from fea.base.material import Marin, Material, SurfaceFinish
from fea.machine.clock import Clock
from fea.rod.discretise import MeshRequest, discretise
from fea.rod.places import SurfaceRegions
from fea.study.rod_table import RodTable
from fea.study.study import load_study
from geometry.cad.formats import step_file
from geometry.imports import RodFile
from geometry.session import session
from geometry.surfaces import Surface

STEEL = Material(207e3, 0.3, 7.8e-9, 600.0, 900.0, 400.0)
BORES, FACES, REST = range(3)
PLAIN = {}
# Chamfers, a small end whose faces are slanted, a bushing, a hole through the crown.
FEATURED = {
    "big_end_chamfer_mm": 1.0,
    "small_end_crown_width_mm": 18.0,
    "bushing_mm": 1.5,
    "oil_hole_mm": 3.0,
}
# A flat rod: its shank is level with the faces of the rings.
FLAT = {"shank_section": "rectangular", "shank_width_mm": 30.0}


def of_steel(names):
    return [STEEL for _ in names]


def meshed(rod: RodTable):
    return discretise(rod, of_steel, MeshRequest(size=14.0, order=Element.P1.order), Clock())


def table(**features) -> RodTable:
    return load_study("leon-2001").with_rod(**features).rod


def regions(mesh):
    return SurfaceRegions.of(mesh.whole, mesh.bores)


def areas(mesh) -> np.ndarray:
    """Area (3,) of the facets all of whose nodes lie on each region, the bores' facets included."""
    whole = mesh.whole
    touched = regions(mesh).touched
    found = np.zeros(3)
    for facets in (whole.facets[s] for s in (Surface.FREE, Surface.BIG_END_BORE, Surface.SMALL_END_BORE)):
        corners = whole.points[facets[:, :3]]
        area = np.linalg.norm(np.cross(*(corners[:, 1:] - corners[:, :1]).swapaxes(0, 1)), axis=1) / 2
        # Of the regions that all corners share the first: a narrow chamfer touches the faces as well.
        shared = touched[facets[:, :3]].all(axis=1)
        np.add.at(found, shared.argmax(axis=1), area)
    return found


@pytest.fixture(scope="module", params=[PLAIN, FEATURED], ids=["plain", "featured"])
def rod(request):
    return request.param, meshed(table(**request.param))


def test_every_surface_is_of_a_region_and_nothing_inside_is(rod):
    _, mesh = rod
    whole, touched = mesh.whole, regions(mesh).touched
    skin = np.zeros(len(whole.points), dtype=bool)
    for facets in whole.facets.values():
        skin[facets] = True
    on_interfaces = 0 if whole.part is None else touched[~skin][:, BORES].sum()
    assert touched[skin].any(axis=1).all()
    assert touched[~skin].any(axis=1).sum() == on_interfaces
    assert not touched[~skin][:, [FACES, REST]].any()
    for surface in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE):
        assert touched[np.unique(whole.facets[surface]), BORES].all()


def test_faces_are_the_ends_of_the_rings_and_the_shank_is_the_rest(rod):
    features, mesh = rod
    whole, (bore, face, rest) = mesh.whole, regions(mesh).touched.T
    x, y, z = whole.points.T
    dimensions = table(**features).dimensions
    outer = dimensions.big_end_bore / 2 + dimensions.big_end_ring
    away = np.hypot(x, y)
    at_big_end = away < outer * (1 + 1e-9)
    level = np.isclose(np.abs(z), dimensions.big_end_width / 2)
    skin = bore | face | rest
    np.testing.assert_array_equal(face & at_big_end, level & at_big_end & skin)
    inner = dimensions.big_end_bore / 2 + features.get("big_end_chamfer_mm", 0.0)
    assert away[face & at_big_end].min() == pytest.approx(inner, rel=1e-3)
    # Beyond the fillets of the rings everything is as it was forged, and nothing of it is machined.
    small_end = dimensions.small_end_bore / 2 + dimensions.small_end_ring
    between = (x > outer + 5) & (x < dimensions.length - small_end - 5)
    assert not (bore | face)[between].any()
    assert rest[between].any()
    small = face & (x > dimensions.length)
    if "small_end_crown_width_mm" in features:  # slanted faces are faces, and so is the bushing's end
        assert np.ptp(np.abs(z[small])) > 1
        assert (np.hypot(x - dimensions.length, y)[small].min()) < dimensions.small_end_bore / 2 + 1.5
    assert small.any()


def test_a_shank_that_is_level_with_the_rings_is_not_a_face_of_theirs():
    mesh = meshed(table(**FLAT))
    whole, (_, face, rest) = mesh.whole, regions(mesh).touched.T
    x, _, z = whole.points.T
    dimensions = table(**FLAT).dimensions
    ends = dimensions.big_end_bore / 2 + dimensions.big_end_ring, dimensions.small_end_bore / 2
    shank = (x > ends[0] + 10) & (x < dimensions.length - ends[1] - dimensions.small_end_ring - 10)
    level = np.isclose(np.abs(z), dimensions.big_end_width / 2)
    assert (rest & level & shank).any()
    assert not (face & shank).any()


def test_the_solved_part_has_the_regions_of_the_whole(rod):
    _, mesh = rod
    of_cell = SurfaceRegions.of(mesh.cell, mesh.bores).at(mesh.mirrored.source)
    np.testing.assert_array_equal(of_cell.touched, regions(mesh).touched)


def test_a_solid_from_a_file_has_the_same_regions(tmp_path):
    features = {name: FEATURED[name] for name in ("big_end_chamfer_mm", "small_end_crown_width_mm")}
    path = tmp_path / "rod.step"
    with session():
        path.write_bytes(step_file(table(**features).dimensions))
    found = meshed(replace(table(), dimensions=None, file=RodFile(path)))
    # Meshed anew: equal but for how the facets divide the curved surfaces.
    assert areas(found) == pytest.approx(areas(meshed(table(**features))), rel=0.02)


def test_an_edge_has_the_least_factor_and_the_inside_none():
    touched = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [0, 0, 0]], dtype=bool)
    marin = Marin(bores=SurfaceFinish(0.9), faces=SurfaceFinish(0.7), rest=SurfaceFinish(0.3))
    found, steel = SurfaceRegions(touched), replace(STEEL, marin=marin)
    assert found.factors(steel) == pytest.approx([0.9, 0.7, 0.3, 0.7, 0.3, 1.0])
    named = [found.region(node, steel) for node in range(6)]
    assert named == [Region.BORES, Region.FACES, Region.REST, Region.FACES, Region.REST, None]
