from dataclasses import replace

import numpy as np
import pytest

from geometry.presets import LEON_2001
from geometry.rod import proportioned
from geometry.section import HeightField
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

RODS = {
    "leon": LEON_2001,
    "flush": proportioned(141, 50, 22, big_end_width=25, small_end_width=25, shank_width=25),
    "rectangular": replace(LEON_2001, shank_section="rectangular"),
    "unequal widths": proportioned(150, 52, 22, big_end_width=28, small_end_width=24, shank_width=18),
    "narrow big end": proportioned(150, 52, 22, big_end_width=22, small_end_width=26, shank_width=18),
    "steep steps": replace(LEON_2001, ring_step_radius=2.0),
    "one end flush": proportioned(150, 52, 22, big_end_width=28, small_end_width=20, shank_width=20),
}


@pytest.mark.parametrize("name", RODS)
def test_the_drawn_solid_is_what_the_dimensions_say(name):
    # Quadrature over the plan shares no code with the kernel's drawing of steps, pockets and radii.
    # Its own error, and the kernel's, are about 2e-7.
    rod = RODS[name]
    with session():
        drawn = build(rod, Mirror.QUARTER).mass
    computed = HeightField(rod).mass()
    assert computed.mass == pytest.approx(drawn.mass, rel=1e-6)
    assert computed.center[0] == pytest.approx(drawn.center[0], rel=1e-6)
    for i in range(3):
        assert computed.inertia[i][i] == pytest.approx(drawn.inertia[i][i], rel=1e-6)


def test_a_rectangular_shank_has_the_section_of_a_rectangle():
    rod = replace(LEON_2001, shank_section="rectangular", shank_depth_big_end=14, shank_depth_small_end=14)
    section = HeightField(rod).section(80.0)
    b, h = rod.shank_width, 14.0
    assert section.area == pytest.approx(b * h, rel=1e-12)
    assert section.inertia_z == pytest.approx(b * h**3 / 12, rel=1e-10)
    assert section.inertia_y == pytest.approx(h * b**3 / 12, rel=1e-10)


def test_an_i_section_is_a_rectangle_less_two_rounded_pockets():
    rod = replace(LEON_2001, shank_depth_big_end=14, shank_depth_small_end=14)
    b, h, r = rod.shank_width, 14.0, rod.pocket_floor_radius
    width, depth = h - 2 * rod.flange_thickness, (b - rod.web_thickness) / 2
    pockets = 2 * (width * depth - 2 * (1 - np.pi / 4) * r**2)
    assert HeightField(rod).section(80.0).area == pytest.approx(b * h - pockets, rel=1e-9)
