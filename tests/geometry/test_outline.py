import math
from itertools import pairwise

import numpy as np
import pytest

from geometry.outline import Outline, web_pocket
from geometry.presets import PRESETS
from geometry.segments import Arc, Line

LEON_2001 = PRESETS["leon-2001"]

OUTLINE = Outline(LEON_2001)


def directions(piece):
    """Unit tangents at start and end."""
    if isinstance(piece, Line):
        along = np.subtract(piece.end, piece.start) / piece.length
        return along, along
    turn = math.copysign(1, piece.sweep)
    angles = np.array([piece.begin, piece.begin + piece.sweep])
    return tuple(turn * np.stack([-np.sin(angles), np.cos(angles)], axis=1))


@pytest.mark.parametrize(
    "chain", [OUTLINE.upper, web_pocket(LEON_2001, OUTLINE.edge).outline()], ids=["outline", "pocket"]
)
def test_pieces_join_tangentially(chain):
    for one, other in pairwise(chain):
        assert math.dist(one.end, other.start) < 1e-12 * LEON_2001.length
        assert directions(one)[1] == pytest.approx(directions(other)[0], abs=1e-12)


def test_the_outline_starts_and_ends_on_the_axis():
    assert OUTLINE.upper[0].start == pytest.approx((-LEON_2001.big_end_radius, 0), abs=1e-12)
    assert OUTLINE.upper[-1].end == pytest.approx((141 + LEON_2001.small_end_radius, 0), abs=1e-12)


def test_heights_follow_the_pieces():
    for piece in OUTLINE.upper:
        x, y = piece.at(0.3) if isinstance(piece, Arc) else np.add(piece.start, piece.end) / 2
        assert float(OUTLINE.height(np.array(x))) == pytest.approx(y, rel=1e-12)


def test_the_shank_has_its_depth_where_the_axis_meets_the_rings():
    assert OUTLINE.edge.height(LEON_2001.big_end_radius) == pytest.approx(LEON_2001.shank_depth_big_end / 2)
    at = LEON_2001.length - LEON_2001.small_end_radius
    assert OUTLINE.edge.height(at) == pytest.approx(LEON_2001.shank_depth_small_end / 2)


def test_flanges_are_as_thick_as_given():
    pocket = web_pocket(LEON_2001, OUTLINE.edge)
    side = pocket.outline()[1]
    assert OUTLINE.edge.distance(side.start) == pytest.approx(LEON_2001.flange_thickness)
    assert OUTLINE.edge.distance(side.end) == pytest.approx(LEON_2001.flange_thickness)
