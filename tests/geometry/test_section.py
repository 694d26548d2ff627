from dataclasses import replace

import numpy as np
import pytest

from geometry.presets import PRESETS
from geometry.rod import proportioned
from geometry.section import HeightField
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

LEON_2001 = PRESETS["leon-2001"]

RODS = {
    "leon": LEON_2001,
    "flush": proportioned(141, 50, 22, big_end_width=25, small_end_width=25, shank_width=25),
    "rectangular": replace(LEON_2001, shank_section="rectangular"),
    "unequal widths": proportioned(150, 52, 22, big_end_width=28, small_end_width=24, shank_width=18),
    "narrow big end": proportioned(150, 52, 22, big_end_width=22, small_end_width=26, shank_width=18),
    "steep steps": replace(LEON_2001, ring_step_radius=2.0),
    "one end flush": proportioned(150, 52, 22, big_end_width=28, small_end_width=20, shank_width=20),
    "H": proportioned(150, 52, 22, shank_section="H"),
    "H, slanted": proportioned(150, 52, 22, shank_section="H", small_end_crown_width=12.0, bushing=1.5),
    "H, drilled": proportioned(150, 52, 22, shank_section="H", cap_bolt=9.0, oil_gallery=3.0),
    "I, drilled": proportioned(150, 52, 22, oil_gallery=3.0),
    "tubular": proportioned(150, 52, 22, shank_section="tubular", small_end_chamfer=0.5),
    "tubular, drilled": proportioned(150, 52, 22, shank_section="tubular", oil_gallery=3.0),
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


def test_an_h_section_is_an_i_section_turned_by_a_quarter():
    depth = {"shank_depth_big_end": 16.0, "shank_depth_small_end": 16.0, "shank_width": 16.0}
    upright = proportioned(150, 52, 22, **depth)
    one, other = (HeightField(rod).section(80.0) for rod in (upright, replace(upright, shank_section="H")))
    assert other.area == pytest.approx(one.area, rel=1e-9)
    assert other.inertia_y == pytest.approx(one.inertia_z, rel=1e-9)
    assert other.inertia_z == pytest.approx(one.inertia_y, rel=1e-9)
    assert one.inertia_z > 1.5 * one.inertia_y


def test_a_tubular_shank_is_a_rectangle_less_its_bore():
    given = {
        "shank_depth_big_end": 18.0,
        "shank_depth_small_end": 18.0,
        "shank_width": 16.0,
        "shank_bore": 9.0,
    }
    section = HeightField(proportioned(150, 52, 22, shank_section="tubular", **given)).section(80.0)
    assert section.area == pytest.approx(18 * 16 - np.pi * 4.5**2, rel=1e-9)
    assert section.inertia_z == pytest.approx(16 * 18**3 / 12 - np.pi * 4.5**4 / 4, rel=1e-9)
