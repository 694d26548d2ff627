import itertools

import numpy as np
import pytest

from fea.output.pictures.scale import Bands, band_limits, exaggeration, round_down, round_up
from fea.output.pictures.strokes import View, choose_view
from fea.output.pictures.surface import DrawnSurface, refined_line
from mesh.tetmesh import EDGES

OUTER = [(1, 3, 5), (3, 2, 5), (2, 4, 5), (4, 1, 5), (3, 1, 6), (2, 3, 6), (4, 2, 6), (1, 4, 6)]
OCTANTS = [(0, *outer) for outer in OUTER]


def ball(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Eight tetrahedra around the origin; with order 2 their outer edges lie on the unit sphere."""
    points = [np.zeros(3), *(sign * axis for axis in np.eye(3) for sign in (1.0, -1.0))]
    tets = []
    for number, octant in enumerate(OCTANTS):
        # every face of a tetrahedron is an outer one somewhere: even permutations keep it outside out
        tet = [octant[k] for k in [(0, 1, 2, 3), (1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0)][number % 4]]
        nodes = list(tet)
        if order == 2:
            for i, j in EDGES:
                middle = (points[tet[i]] + points[tet[j]]) / 2
                if tet[i] and tet[j]:
                    middle = middle / np.linalg.norm(middle)
                nodes.append(len(points))
                points.append(middle)
        tets.append(nodes)
    points, number = np.unique(np.round(points, 12), axis=0, return_inverse=True)
    return points, number.reshape(-1)[np.array(tets)]


def area_and_volume(skin: DrawnSurface) -> tuple[float, float]:
    corners = skin.refined(skin.points)[skin.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(cross, axis=1).sum() / 2, np.einsum("ij,ij->", corners[:, 0], cross) / 6


@pytest.mark.parametrize(
    ("order", "area", "volume"),
    [(1, 4 * np.sqrt(3), 4 / 3), (2, 4 * np.pi, 4 / 3 * np.pi)],
)
def test_the_skin_is_closed_outward_and_curved(order, area, volume):
    skin = DrawnSurface.of(*ball(order))
    assert skin.facets.shape == (8, 3 if order == 1 else 6)
    found_area, found_volume = area_and_volume(skin)
    # eight facets of parabolas and flat pieces miss the sphere by a tenth; straight ones by half
    tolerance = 1e-12 if order == 1 else 0.2
    assert found_area == pytest.approx(area, rel=tolerance)
    assert found_volume == pytest.approx(volume, rel=tolerance)


def test_normals_point_outwards_and_are_one_across_smooth_edges():
    skin = DrawnSurface.of(*ball(2))
    corners = skin.points[skin.facets[:, :3]]
    np.testing.assert_allclose(skin.normals[:, :3], corners, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(skin.refined_normals, axis=1), 1, rtol=1e-12)
    assert not skin.sides[1].any()


def test_an_octahedron_has_twelve_edges_and_flat_faces():
    skin = DrawnSurface.of(*ball(1))
    sides, sharp = skin.sides
    assert len(sides) == 12
    assert sharp.all()
    np.testing.assert_allclose(abs(skin.normals), 1 / np.sqrt(3), rtol=1e-12)


def test_a_refined_edge_runs_through_its_middle_node():
    points = np.array([[0.0, 0, 0], [2.0, 0, 0], [1.0, 1, 0]])
    line = refined_line(points, np.array([[0, 1, 2]]))
    np.testing.assert_allclose(line[0, [0, 2, 4]], points[[0, 2, 1]], atol=1e-15)
    np.testing.assert_allclose(line[0, 1], [0.5, 0.75, 0])  # y = x(2 − x)


def test_quadratic_values_are_refined_exactly():
    points, tets = ball(1)
    ends = [sorted(pair) for tet in tets for pair in itertools.combinations(tet, 2)]
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    order = [list(itertools.combinations(range(4), 2)).index(tuple(edge)) for edge in EDGES.tolist()]
    middles = len(points) + number.reshape(-1, 6)[:, order]
    points = np.vstack([points, points[edges].mean(axis=1)])
    skin = DrawnSurface.of(points, np.hstack([tets, middles]))
    x, y, _ = points.T
    fine = skin.refined(points)
    np.testing.assert_allclose(
        skin.refined(x * y + x**2), fine[:, 0] * fine[:, 1] + fine[:, 0] ** 2, atol=1e-14
    )


def test_a_place_is_hidden_by_what_stands_before_it():
    skin = DrawnSurface.of(*ball(1))
    up = np.array([0.0, 0, 1])
    place = np.array([0.1, 0.2, 0.75])
    assert not skin.hides(place, up)
    assert skin.hides(place, -up)
    assert skin.hides(place - up / 2, up)
    assert not skin.hides(np.array([2.0, 0, 0]), up)


@pytest.mark.parametrize("normal", [*np.eye(3), *-np.eye(3), np.array([0.6, 0, -0.8])])
def test_the_view_faces_the_place_with_the_rod_across(normal):
    view = choose_view(normal, lambda _: True, closeness=2.5)
    assert view.towards @ normal > 0.3
    assert view.right[0] > 0.75  # the rod's length
    np.testing.assert_allclose(np.cross(view.right, view.up), view.towards, atol=1e-12)


def test_a_place_on_the_far_side_is_faced_however_unusual_that_is():
    assert choose_view(np.array([0.0, 0, -1]), lambda _: True, closeness=0).towards[2] < -0.1


def test_the_view_avoids_what_hides_the_place():
    view = choose_view(np.array([0.0, 0, 1]), lambda towards: towards[1] < 0, closeness=1)
    assert view.towards[1] < 0


def test_the_usual_view_has_the_face_of_the_rod_upright():
    view = View.along(np.array([0.0, 0, 1]))
    np.testing.assert_allclose(view.across(np.array([[3.0, 4.0, 5.0]])), [[3.0, 4.0]])


@pytest.mark.parametrize("maximum", [0.0123, 1.0, 99.9, 100.0, 261.5, 619.0, 12345.0])
def test_the_legend_covers_the_maximum_with_round_bands(maximum):
    limits = band_limits(maximum)
    assert limits[0] == 0
    assert limits[-2] < maximum <= limits[-1] * (1 + 1e-9)
    assert 6 <= len(limits) <= 11
    assert [float(f"{limit:.3g}") for limit in limits] == pytest.approx(limits, rel=1e-12)


@pytest.mark.parametrize(
    ("least", "largest"), [(-120.0, 230.0), (-639.5, 0.0), (0.0, 3.3), (-3.0, 0.2), (10.0, 20.0)]
)
def test_bands_of_either_sign_have_zero_for_a_limit_and_as_deep_colours_as_they_are_far_from_it(
    least, largest
):
    bands = Bands.around_zero(least, largest)
    limits = np.array(bands.limits)
    assert 0.0 in limits
    assert limits[0] <= min(least, 0) * (1 - 1e-9)
    assert limits[1] > min(least, 0)
    assert limits[-2] < largest <= limits[-1] * (1 + 1e-9)
    warm = bands.colours[:, 0].astype(int) - bands.colours[:, 2]
    middles = (limits[:-1] + limits[1:]) / 2
    far = np.abs(middles) > 0.25 * np.abs(limits).max()
    np.testing.assert_array_equal(np.sign(warm[far]), np.sign(middles[far]))


@pytest.mark.parametrize("maximum", [0.0, -1.0, np.nan, np.inf])
def test_a_legend_of_nothing_is_still_one(maximum):
    assert band_limits(maximum) == [0.0, 1.0]


def test_round_numbers_and_exaggeration():
    assert [round_up(value) for value in (0.11, 1.0, 2.1, 2.6, 9.0)] == pytest.approx([0.15, 1, 2.5, 3, 10])
    assert [round_down(value) for value in (0.19, 1.0, 2.4, 2.6, 9.9)] == pytest.approx([0.15, 1, 2, 2.5, 8])
    assert exaggeration(200.0, 0.1) == 80
    assert exaggeration(200.0, 100.0) == 1
    assert exaggeration(200.0, 0.0) == 1
    assert exaggeration(200.0, np.nan) == 1
