"""Fretting under bolt heads: sliding as a whole, and stretching under a rigid head."""

import numpy as np
import pytest

from fea.analysis.bolt_seats import SeatSurface, seats, sliding
from geometry.assembly import BoltAxis
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

SEAT = {"hole_radius": 4.0, "head": 20.0, "grip_end": -20.0, "engaged": 0.0}
SEAT |= {"head_radius": 7.0, "nut_radius": 7.0, "thread_radius": 4.0}
AXIS = BoltAxis(point=(0.0, 30.0, 0.0), direction=(-0.8, 0.6, 0.0), **SEAT)
STIFFNESS = 2e4  # of the bolt against its head's shift, N/mm


def test_a_head_slides_as_a_slider_in_series_with_a_spring():
    """A force k (u − s) that friction limits to μ F: followed step by step until it has settled, 1 %."""
    turn = np.linspace(0, 2 * np.pi, 401)
    shift = 0.01 + 0.03 * np.cos(turn)  # mm, and a mean that sliding takes away
    bears, slid, path = 400.0, 0.0, []
    for at in np.tile(shift, 3):
        slid = np.clip(slid, at - bears / STIFFNESS, at + bears / STIFFNESS)
        path.append(slid)
    path = np.array(path[-len(shift) :])
    paths = np.stack([np.cos(0.3) * shift, np.sin(0.3) * shift])[None]
    reserve, slides = sliding(STIFFNESS * paths, paths, np.array([bears]))
    assert reserve == pytest.approx([bears / (STIFFNESS * 0.03)], rel=0.01)
    assert slides == pytest.approx([np.ptp(path)], rel=0.01)
    _, none = sliding(STIFFNESS * paths, paths, np.array([1.01 * STIFFNESS * 0.03]))
    assert none == pytest.approx([0.0])


def ring():
    """Vertices of the seat under the head, in its plane, with equal areas."""
    angle = 2 * np.pi * np.arange(16) / 16
    in_plane, across = SeatSurface(np.arange(16), np.zeros((16, 3)), np.ones(16), AXIS).tangents
    points = AXIS.at(AXIS.head) + 6.0 * (np.outer(np.cos(angle), in_plane) + np.outer(np.sin(angle), across))
    return SeatSurface(np.arange(16), points, np.ones(16), AXIS), np.outer(np.cos(angle), [1, 0]) * 6.0


def test_a_rigid_motion_of_the_seat_is_no_slip():
    seat, _ = ring()
    turned = np.cross([0.002, -0.001, 0.003], seat.points) + np.array([0.01, 0.02, -0.03])
    assert np.abs(seat.stretched(turned[..., None])).max() < 1e-12


def test_stretching_in_one_direction_slips_by_strain_times_distance():
    seat, from_axis = ring()
    strain = 1e-4
    moved = strain * from_axis[:, :1] * seat.tangents[0]
    np.testing.assert_allclose(seat.stretched(moved[..., None])[..., 0], strain * from_axis, atol=1e-15)


def test_seats_of_one_surface_are_told_apart_by_what_hangs_together():
    """Two squares of two facets each, beside two parallel bolts."""
    square = np.array([[0, 0], [6, 0], [6, 6], [0, 6]], float)
    level = np.full((4, 1), 20.0)
    points = np.concatenate([np.hstack([level, square + np.array([y, -3.0])]) for y in (-36.0, 30.0)])
    facets = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    mesh = TetMesh(points, np.zeros((0, 4), dtype=np.int64), {Surface.BOLT_HEAD: facets})
    bolts = tuple(BoltAxis(point=(0.0, y, 0.0), direction=(1.0, 0.0, 0.0), **SEAT) for y in (33.0, -33.0))
    first, second = seats(mesh, Surface.BOLT_HEAD, bolts)
    assert (first.bolt, second.bolt) == bolts[::-1]
    assert first.area.sum() == pytest.approx(36.0)
    np.testing.assert_array_equal(second.nodes, [4, 5, 6, 7])
