"""A moved mesh is that of the other rod: same volume, on its surface, with sound elements."""

from dataclasses import replace

import numpy as np
import pytest

from fea.analysis.meshing import mesh_study
from fea.rod.discretise import moved
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.surfaces import Surface

STUDY = Flags(size=14.0).applied(load_study("leon-2001"))
CHANGES = {"web_thickness_mm": 5.6, "big_end_ring_mm": 9.5, "shank_width_mm": 11.5, "small_end_ring_mm": 10.5}


@pytest.fixture(scope="module")
def base():
    return mesh_study(STUDY, movable=True)


@pytest.fixture(scope="module")
def other(base):
    return moved(base, STUDY.rod.with_dimensions(CHANGES))


def test_it_has_the_volume_and_the_quality_of_a_mesh_of_its_own(base, other):
    own = mesh_study(STUDY.with_rod(**CHANGES))
    assert other.parts == pytest.approx(own.parts, rel=1e-9)
    volume, expected = (np.linalg.det(span(mesh.whole)).sum() / 6 for mesh in (other, own))
    assert volume == pytest.approx(expected, rel=2e-3)  # straight-sided
    assert other.meshing.quality.least_scaled_jacobian > 0.1
    assert other.meshing.quality.median_shape == pytest.approx(base.meshing.quality.median_shape, rel=0.03)
    assert np.array_equal(other.whole.tets, base.whole.tets)


def span(mesh):
    corners = mesh.points[mesh.tets[:, :4]]
    return corners[:, 1:] - corners[:, :1]


def test_its_nodes_are_on_the_new_surface(base, other):
    points = other.whole.points
    bore = points[np.unique(other.whole.facets[Surface.BIG_END_BORE])]
    assert np.hypot(*bore[:, :2].T) == pytest.approx(STUDY.rod.dimensions.big_end_bore / 2, rel=1e-9)
    ring = STUDY.rod.dimensions.big_end_bore / 2 + CHANGES["big_end_ring_mm"]
    before = np.hypot(*base.whole.points[:, :2].T)
    on_ring = (abs(before - STUDY.rod.dimensions.big_end_radius) < 1e-9) & (base.whole.points[:, 0] < 0)
    assert on_ring.sum() > 100
    assert np.hypot(*points[on_ring, :2].T) == pytest.approx(ring, rel=1e-9)


def test_the_same_dimensions_give_the_same_mesh(base):
    assert moved(base, STUDY.rod).whole.points == pytest.approx(base.whole.points, abs=1e-9)


def test_a_mesh_does_not_follow_another_shape_or_further_than_its_elements_bear(base):
    for section in ("rectangular", "H"):
        assert moved(base, STUDY.rod.with_dimensions({"shank_section": section})) is None
    assert moved(base, STUDY.rod.with_dimensions({"oil_hole_mm": 3.0})) is None
    thin = {"small_end_ring_mm": 2.0, "big_end_ring_mm": 3.0, "shank_depth_big_end_mm": 20.0}
    assert moved(base, STUDY.rod.with_dimensions(thin)) is None
    assert moved(replace(base, movable=None), STUDY.rod) is None
