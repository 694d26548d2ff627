import math
from dataclasses import replace

import gmsh
import numpy as np
import pytest

from geometry.assembly import Assembly
from geometry.errors import InvalidValue
from geometry.faces import FeatureKind
from geometry.outline import Outline
from geometry.rod import proportioned
from geometry.section import HeightField
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror, Surface

pytestmark = pytest.mark.slow

PLAIN = {"length": 150, "big_end_bore": 52, "small_end_bore": 22, "small_end_ring": 6.5, "big_end_width": 25}
OPTIONS = {
    "oil hole": {"oil_hole": 4.0},
    "bushing": {"bushing": 2.0},
    "slanted": {"small_end_crown_width": 14.0},
    "cap bolts": {"cap_bolt": 9.0},
    "chamfers": {"big_end_chamfer": 1.5, "small_end_chamfer": 0.8},
    "chamfered bushing": {"oil_hole": 4.0, "bushing": 2.0, "small_end_chamfer": 0.9, "cap_bolt": 9.0},
    "rounded bosses": {"cap_bolt": 9.0, "cap_boss_round": 6.0},
    "thick crown": {"cap_bolt": 9.0, "cap_rib": 5.0, "cap_rib_width": 25.0},
    "rib": {"cap_bolt": 9.0, "cap_rib": 5.0, "cap_rib_width": 12.0},
    "two ribs": {
        "cap_bolt": 9.0,
        "cap_boss_round": 6.0,
        "cap_rib": 4.0,
        "cap_rib_width": 17.0,
        "cap_rib_groove": 7.0,
    },
    "everything": {"oil_hole": 4.0, "bushing": 2.0, "small_end_crown_width": 14.0, "cap_bolt": 9.0},
}


@pytest.mark.parametrize("mirror", [Mirror.NONE, Mirror.QUARTER])
@pytest.mark.parametrize("name", OPTIONS)
def test_the_drawn_solid_is_what_the_dimensions_say(name, mirror):
    # Quadrature against the kernel: both are right to a few millionths where slants and holes cross steps.
    rod = proportioned(**PLAIN, **OPTIONS[name])
    with session() as log:
        drawn = build(rod, mirror).mass
    computed = HeightField(rod).mass()
    assert log.warnings() == ()
    assert computed.mass == pytest.approx(drawn.mass, rel=1e-5)
    assert computed.center[0] == pytest.approx(drawn.center[0], rel=1e-5)
    for i in range(3):
        assert computed.inertia[i][i] == pytest.approx(drawn.inertia[i][i], rel=1e-5)


def test_ribs_turn_with_the_joint():
    # The kernel's volume of the turned rod is that of the straight one: a joint turns what the rod is not.
    cap = {"cap_boss_length": 28.0, "cap_boss_fillet": 3.0, "big_end_fillet": 8.0}
    rod = proportioned(**PLAIN, **(OPTIONS["two ribs"] | cap))
    expected = HeightField(rod).mass()
    for mirror in (Mirror.NONE, Mirror.HALF):
        with session():
            solid = build(rod, mirror, Assembly(split=25.0))
        cap = next(part.mass for part in solid.parts if part.name == "cap")
        assert solid.mass.mass == pytest.approx(expected.mass, rel=1e-6)
        assert math.degrees(math.atan2(-cap.center[1], -cap.center[0])) == pytest.approx(25.0, abs=1e-3)


def test_a_rib_adds_what_it_should():
    # By hand: between two circles that cross at the ring's height, a rib as wide as the big end.
    plain = proportioned(**PLAIN, cap_bolt=9.0)
    crowned = replace(plain, cap_rib=5.0, cap_rib_width=25.0)
    x = np.linspace(-plain.big_end_radius - 5.0, 0.0, 200_001)
    heights = [Outline(rod).height(x) for rod in (plain, crowned)]
    more = 2 * 25.0 * float(np.trapezoid(heights[1] - heights[0], x))
    assert HeightField(crowned).mass().mass - HeightField(plain).mass().mass == pytest.approx(more, rel=1e-5)
    back = Outline(crowned).rib.crown
    assert back.start == pytest.approx((-plain.big_end_radius - 5.0, 0.0), abs=1e-9)


def test_an_option_takes_what_it_should():
    # By hand: two bolt holes through bosses; an oil hole through a ring, flat to first order.
    plain = HeightField(proportioned(**PLAIN)).mass().mass
    drilled = HeightField(proportioned(**PLAIN, oil_hole=2.0)).mass().mass
    assert plain - drilled == pytest.approx(math.pi * 1.0**2 * 6.5, rel=5e-3)
    rod = proportioned(**PLAIN, cap_bolt=9.0)
    field = HeightField(rod)
    without = 4 * (field.outline.height(0.0 * field.section(0.0).area) - 26.0) * 12.5
    assert field.section(0.0).area == pytest.approx(without - 2 * math.pi * 4.5**2, rel=1e-6)


def test_the_bushing_is_a_part_that_shares_its_faces_with_the_rod():
    rod = proportioned(**PLAIN, bushing=2.0)
    with session():
        solid = build(rod)
        names = [part.name for part in solid.parts]
        sides = [
            {tag for _, tag in gmsh.model.getBoundary([(3, tag) for tag in part.volumes], oriented=False)}
            for part in solid.parts
        ]
        shared = sum(gmsh.model.occ.getMass(2, tag) for tag in sides[0] & sides[1])
        assert set(solid.faces[Surface.SMALL_END_BORE]) <= sides[1]
    assert names == ["rod", "bushing"]
    assert shared == pytest.approx(2 * math.pi * 13 * 25 / 4, rel=1e-9)
    assert solid.parts[1].mass.mass == pytest.approx(math.pi * (13**2 - 11**2) * 25, rel=1e-9)


def test_the_bosses_are_blended_into_the_ring():
    rod = proportioned(**PLAIN, cap_bolt=9.0)
    with session():
        solid = build(rod)
        drawn = sum(
            4 * gmsh.model.occ.getMass(2, face)
            for feature in solid.features
            if feature.kind is FeatureKind.BOSS_FILLET
            for face in feature.faces
        )
    arcs = Outline(rod).bosses.fillets()
    assert drawn == pytest.approx(2 * rod.big_end_width * sum(arc.length for arc in arcs), rel=1e-6)


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("rod.small_end_crown_width_mm", {"small_end_crown_width": 25.0}),
        ("rod.small_end_crown_width_mm", {"small_end_crown_width": 3.0}),
        ("rod.bushing_mm", {"bushing": 6.0}),
        ("rod.oil_hole_mm", {"oil_hole": 12.0}),
        ("rod.oil_hole_mm", {"oil_hole": -1.0}),
        ("rod.big_end_chamfer_mm", {"big_end_chamfer": 5.1}),
        ("rod.small_end_chamfer_mm", {"small_end_chamfer": 1.1, "bushing": 2.0}),
        ("rod.small_end_chamfer_mm", {"small_end_chamfer": 1.0, "small_end_crown_width": 14.0}),
        ("rod.cap_bolt_mm", {"cap_bolt": 24.0, "cap_bolt_spacing": 90.0}),
        ("rod.cap_bolt_spacing_mm", {"cap_bolt_spacing": 55.0}),
        ("rod.cap_bolt_spacing_mm", {"cap_bolt_spacing": 0.0}),
        ("rod.cap_boss_length_mm", {"cap_boss_length": 68.0}),
        ("rod.cap_boss_length_mm", {"cap_boss_length": 56.0, "big_end_fillet": 40.0}),
        ("rod.big_end_width_mm", {"small_end_width": 27.0}),
        ("rod.cap_boss_round_mm", {"cap_boss_round": 12.0}),
        ("rod.cap_rib_mm", {"cap_rib": 1.0, "cap_rib_width": 12.0}),
        ("rod.cap_rib_mm", {"cap_rib": 30.0, "cap_rib_width": 12.0}),
        ("rod.cap_rib_width_mm", {"cap_rib": 5.0, "cap_rib_width": 24.0}),
        ("rod.cap_rib_width_mm", {"cap_rib": 5.0}),
        ("rod.cap_rib_width_mm", {"cap_rib_width": 5.0}),
        ("rod.cap_rib_groove_mm", {"cap_rib": 5.0, "cap_rib_width": 14.0, "cap_rib_groove": 5.0}),
        ("rod.cap_rib_mm", {"cap_bolt": 0.0, "cap_rib": 5.0, "cap_rib_width": 12.0}),
        ("rod.cap_boss_round_mm", {"cap_bolt": 0.0, "cap_boss_round": 5.0}),
    ],
)
def test_an_option_that_does_not_fit_is_refused_by_name(key, change):
    with pytest.raises(InvalidValue) as refusal:
        replace(proportioned(**PLAIN, cap_bolt=9.0), **change)
    assert refusal.value.name == key
