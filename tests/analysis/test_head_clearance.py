"""What the gap between piston and head must leave: kinematics, sums, and a hand calculation."""

from types import SimpleNamespace

import numpy as np
import pytest

from fea.analysis.head_clearance import stretch
from fea.apps.result import analyse
from fea.output.tables import head_clearance_tables
from fea.study.study import load_study
from geometry.surfaces import Surface

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def summary():
    return analyse(load_study("leon-2001"), rpm=6000, size=14).summary


def test_a_stretched_rod_moves_its_bores_apart_by_strain_times_what_lies_between_their_far_sides():
    """u = ε x: from the cap's side of the big end to the crown's side of the small end."""
    angle = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    big, small = (
        np.stack([x + r * np.cos(angle), r * np.sin(angle), 0 * angle], axis=1)
        for x, r in ((0, 24), (140, 11))
    )
    facets = {
        Surface.BIG_END_BORE: np.arange(72)[:, None],
        Surface.SMALL_END_BORE: 72 + np.arange(72)[:, None],
    }
    points = np.concatenate([big, small])
    moved = 1e-3 * points * [1, 0, 0]
    case = SimpleNamespace(mesh=SimpleNamespace(points=points, facets=facets), distortion=moved)
    mean = np.cos(np.radians([-15, -10, -5, 0, 5, 10, 15])).mean()
    assert stretch(case, 140.0) == pytest.approx(1e-3 * (140 + (24 + 11) * mean), rel=2e-3)


def test_the_parts_add_up_to_the_sums(summary):
    gap = summary.head_clearance
    assert gap.cold_mm == pytest.approx(
        gap.rod_stretch_mm + gap.clearances_mm + gap.pin_bending_mm + gap.crank_mm
    )
    grown = gap.cold_mm + gap.piston_growth_mm + gap.rod_growth_mm
    assert gap.hot_iron_block_mm == pytest.approx(grown - gap.iron_block_growth_mm)
    assert gap.hot_aluminium_block_mm == pytest.approx(grown - gap.aluminium_block_growth_mm)
    assert gap.most_mm == gap.hot_iron_block_mm
    # α L ΔT by hand: 30.4 mm of piston, 141 mm of rod, 218.4 mm of block.
    assert gap.piston_growth_mm == pytest.approx(30.4 * 21e-6 * 200)
    assert gap.aluminium_block_growth_mm == pytest.approx((47 + summary.rod.length_mm + 30.4) * 23e-6 * 70)


def test_the_stretch_is_that_of_a_bar_and_of_two_rings(summary):
    """The shank alone gives F l/(E A); rings that become oval add about as much."""
    force, area = summary.loads["tension"].pin_axial_N, summary.buckling.column.least_area_mm2
    shank = force * 90.0 / (207e3 * area)
    assert shank < summary.head_clearance.rod_stretch_mm < 4 * shank


def test_the_table_prints_the_sums_and_the_block_with_its_sign(summary):
    [table] = head_clearance_tables(summary)
    cells = dict(table.rows)
    assert cells["sum of the cold engine, mm"] == f"{summary.head_clearance.cold_mm:.2f}"
    assert cells["the same of cast iron, mm"].startswith("−")


def test_no_gap_is_stated_where_clearances_are_not_known():
    forces = analyse(load_study("leon-2001"), rpm=6000, size=16, pressure="cosine-180").summary
    assert forces.head_clearance is None
    assert not list(head_clearance_tables(forces))
