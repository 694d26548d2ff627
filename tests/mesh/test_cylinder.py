"""Circles and cylinders fitted to exact and to rough points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.holes import basis_across
from geometry.segments import Circle, fitted_circle
from mesh.files.bore_pair import (
    circles_through,
    covered,
    fitted_cylinders,
    straightest,
)

coordinate = st.floats(-50, 50)
radius = st.floats(0.1, 100)
angle = st.floats(0, 6)


@given(coordinate, coordinate, radius, angle)
def test_a_circle_is_found_from_an_arc_of_it(x, y, size, start):
    turn = start + np.linspace(0, 1.0, 9)
    arc = np.column_stack([x + size * np.cos(turn), y + size * np.sin(turn)])
    found = fitted_circle(arc)
    assert found.radius == pytest.approx(size, rel=1e-5)
    np.testing.assert_allclose(found.center, [x, y], atol=1e-5 * (1 + size))
    centers, radii = circles_through(arc[None, [0, 4, 8]])
    assert radii[0] == pytest.approx(size, rel=1e-5)
    np.testing.assert_allclose(centers[0], found.center, atol=1e-5 * (1 + size))


def test_a_line_is_no_circle():
    line = np.column_stack([np.arange(5.0), 2 * np.arange(5.0)])
    assert fitted_circle(line) is None
    assert np.isnan(circles_through(line[None, :3])[1]).all()


def test_the_distance_from_a_circle_counts_both_ways():
    np.testing.assert_allclose(Circle(np.zeros(2), 2.0).distance(np.array([[3.0, 0], [0, 1]])), 1.0)


def wall(axis, center, size, *, noise=0.0, seed=0):
    random = np.random.default_rng(seed)
    one, other = basis_across(axis)
    turn, height = random.uniform(0, 2 * np.pi, 60), random.uniform(-4, 4, 60)
    own = size * (1 + noise * random.normal(size=60))
    arms = np.cos(turn)[:, None] * one + np.sin(turn)[:, None] * other
    return center + own[:, None] * arms + height[:, None] * axis, -arms


@settings(max_examples=25)
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.integers(0, 20))
def test_two_parallel_cylinders_are_found_from_a_guess_some_degrees_off(u, v, seed):
    axis = np.array([u, v, 1.0])
    axis /= np.linalg.norm(axis)
    centers, sizes = np.array([[3.0, 1.0, 0.0], [90.0, -4.0, 2.0]]), (20.0, 7.0)
    walls = [wall(axis, c, r, seed=seed)[0] for c, r in zip(centers, sizes, strict=True)]
    found = fitted_cylinders(walls, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(found.radii, sizes, rtol=1e-7)
    np.testing.assert_allclose(found.direction, axis, atol=1e-7)
    off = found.centers - centers
    np.testing.assert_allclose(off - (off @ axis)[:, None] * axis, 0, atol=1e-6)
    assert found.residual < 1e-7


def test_the_residual_tells_how_rough_a_wall_is():
    axis = np.array([0.0, 0.0, 1.0])
    rough = wall(axis, np.zeros(3), 10.0, noise=0.02)[0]
    fine = wall(axis, np.array([80.0, 0, 0]), 10.0)[0]
    assert fitted_cylinders([rough, fine], axis).residual == pytest.approx(0.02, rel=0.3)


def test_normals_of_a_wall_give_its_direction():
    axis = np.array([0.6, 0.0, 0.8])
    normals = wall(axis, np.zeros(3), 10.0)[1]
    assert abs(straightest(normals, np.ones(len(normals))) @ axis) == pytest.approx(1.0)


@pytest.mark.parametrize(("start", "end"), [(0.0, 1.0), (2.5, 4.5), (-3.3, -2.9), (0.0, 2 * np.pi)])
def test_the_covered_share_of_a_turn_counts_overlaps_once(start, end):
    edges = np.linspace(start, end, 40)
    both = (np.column_stack([edges[:-1], edges[1:]]) + np.pi) % (2 * np.pi) - np.pi
    assert covered(np.vstack([both, both])) == pytest.approx((end - start) / (2 * np.pi), abs=2 / 360)
