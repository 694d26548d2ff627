import math

import gmsh
import numpy as np
import pytest

from geometry.bodies import Prism, Revolution, Side, SideBySide, block, draw
from geometry.segments import Arc, EllipticArc, Line
from geometry.session import session
from geometry.surfaces import Surface

QUARTER = math.pi / 2
PIPE = (
    Side(Line((1.0, 0.0), (3.0, 0.0)), Surface.SYMMETRY_Y),
    Side(Arc((0.0, 0.0), 3.0, 0.0, QUARTER), Surface.OUTER),
    Side(Line((0.0, 3.0), (0.0, 1.0)), Surface.SYMMETRY_X),
    Side(Arc((0.0, 0.0), 1.0, QUARTER, -QUARTER), Surface.INNER),
)
SHELL = (
    Side(Line((1.0, 0.0), (3.0, 0.0)), Surface.SYMMETRY_Z),
    Side(Arc((0.0, 0.0), 3.0, 0.0, QUARTER), Surface.OUTER),
    Side(Line((0.0, 3.0), (0.0, 1.0)), Surface.FREE),
    Side(Arc((0.0, 0.0), 1.0, QUARTER, -QUARTER), Surface.INNER),
)
RING = 2 * math.pi  # area of a quarter between radii 1 and 3


def areas(body):
    with session():
        faces = draw(body)
        return {name: sum(gmsh.model.occ.getMass(2, tag) for tag in tags) for name, tags in faces.items()}


@pytest.mark.parametrize("levels", [(0.0, 2.0), (-1.0, 0.5, 1.0)])
def test_a_prism_names_its_faces(levels):
    # Two planes of a split body still make one surface a side.
    found = areas(Prism(PIPE, levels, bottom=Surface.CLAMPED, top=Surface.LOADED))
    expected = {
        Surface.SYMMETRY_Y: 4.0,
        Surface.OUTER: 3 * math.pi,
        Surface.SYMMETRY_X: 4.0,
        Surface.INNER: math.pi,
        Surface.CLAMPED: RING,
        Surface.LOADED: RING,
    }
    assert found == pytest.approx(expected, rel=1e-9)


def test_bodies_side_by_side_share_a_face_that_has_no_name():
    def box(first, last, height, end):
        low, high = (first, 0.0), (last, 1.0)
        corners = (low, (last, 0.0), high, (first, 1.0))
        names = (Surface.SYMMETRY_Y, end, Surface.FREE, Surface.LOADED)
        return Prism(
            tuple(
                Side(Line(a, b), name)
                for a, b, name in zip(corners, corners[1:] + corners[:1], names, strict=True)
            ),
            height,
            top=Surface.OUTER,
        )

    found = areas(
        SideBySide(
            (box(0.0, 2.0, (0.0, 1.0), Surface.INNER), box(2.0, 5.0, (0.0, 1.0, 3.0), Surface.CLAMPED))
        )
    )
    # Above the first box, the side of the higher one that it does not touch.
    expected = {
        Surface.SYMMETRY_Y: 2.0 + 9.0,
        Surface.CLAMPED: 3.0,
        Surface.FREE: 2.0 + 9.0,
        Surface.LOADED: 1.0 + 2.0,
        Surface.SYMMETRY_Z: 5.0,
        Surface.OUTER: 5.0,
    }
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_revolution_names_its_faces_and_sweeps_none_on_the_axis():
    found = areas(Revolution(SHELL))
    expected = {
        Surface.SYMMETRY_X: RING,
        Surface.SYMMETRY_Y: RING,
        Surface.SYMMETRY_Z: RING,
        Surface.OUTER: 9 * math.pi / 2,
        Surface.INNER: math.pi / 2,
    }
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("axes", [(2.0, 1.0), (1.0, 2.0)])
def test_an_ellipse_may_lie_either_way(axes):
    sides = (
        Side(Line((0.0, 0.0), (axes[0], 0.0)), Surface.FREE),
        Side(EllipticArc(axes, 0.0, QUARTER), Surface.OUTER),
        Side(Line((0.0, axes[1]), (0.0, 0.0)), Surface.FREE),
    )
    found = areas(Prism(sides, (0.0, 1.0), bottom=Surface.LOADED))
    assert found[Surface.LOADED] == pytest.approx(math.pi / 2, rel=1e-9)


def test_a_block_is_one_surface():
    assert areas(block(1.0, 2.0, 3.0)) == pytest.approx({Surface.FREE: 22.0})


@pytest.mark.parametrize("body", [Prism(PIPE, (0.0, 2.0)), Revolution(SHELL)])
def test_facets_point_outwards(body):
    from mesh.generate import mesh_body

    mesh = mesh_body(body, 0.8)
    a, b, c = mesh.points[np.concatenate(list(mesh.facets.values()))[:, :3]].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    # A closed surface has no resultant area, and ∫ x · n dA is three times the volume.
    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-12)
    corners = mesh.points[mesh.tets[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
    assert (normals * (a + b + c) / 3).sum() / 3 == pytest.approx(volume, rel=1e-9)
