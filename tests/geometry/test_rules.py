import math
from dataclasses import replace

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from geometry.dimensions import ShankSection, dimensions, options
from geometry.errors import InvalidValue
from geometry.presets import PRESETS
from geometry.rod import Rod, proportioned

LEON_2001 = PRESETS["leon-2001"]

ROD = proportioned(141, 50, 22, big_end_width=30, small_end_width=28)

REFUSED = [
    ("rod.big_end_ring_mm", {"big_end_ring": 0.5}),  # thinner than a fiftieth of the bore
    ("rod.length_mm", {"length": 50}),  # the rings overlap
    ("rod.length_mm", {"big_end_bore": 250}),  # a bore larger than the rod
    ("rod.shank_width_mm", {"shank_width": 29}),  # wider than the small end
    ("rod.shank_width_mm", {"shank_width": 27.8}),  # a sliver of a step
    ("rod.shank_depth_big_end_mm", {"shank_depth_big_end": 70}),  # deeper than the ring
    ("rod.shank_depth_small_end_mm", {"shank_depth_small_end": 34}),
    ("rod.big_end_fillet_mm", {"big_end_fillet": 400}),  # meets the other fillet
    ("rod.small_end_fillet_mm", {"small_end_fillet": 1500}),
    ("rod.ring_step_radius_mm", {"ring_step_radius": 60}),
    ("rod.ring_step_radius_mm", {"ring_step_radius": 25, "shank_width": 4, "length": 95}),
    ("rod.web_thickness_mm", {"web_thickness": 20}),  # thicker than the shank
    ("rod.pocket_floor_radius_mm", {"pocket_floor_radius": 3.5}),  # larger than the corner's
    ("rod.pocket_floor_radius_mm", {"web_thickness": 17.5}),  # larger than the pocket is deep
    ("rod.pocket_setback_mm", {"pocket_setback": 60}),  # no pocket left
    ("rod.flange_thickness_mm", {"flange_thickness": 10}),
    ("rod.pocket_corner_radius_mm", {"pocket_corner_radius": 8}),
    ("rod.web_thickness_mm", {"shank_section": "H", "web_thickness": 19}),  # thicker than the shank is deep
    ("rod.flange_thickness_mm", {"shank_section": "H", "flange_thickness": 10}),  # half of the width
    ("rod.oil_gallery_mm", {"oil_gallery": 6.0}),  # wider than the web allows
    ("rod.shank_bore_mm", {"shank_section": "tubular"}),  # without it
    ("rod.shank_bore_mm", {"shank_bore": 4.0}),  # of an I-section
    ("rod.shank_bore_mm", {"shank_section": "tubular", "shank_bore": 15.0}),  # hardly a wall
    ("rod.shank_bore_mm", {"shank_section": "tubular", "shank_bore": 8.0, "pocket_setback": 90.0}),
    ("rod.oil_gallery_mm", {"shank_section": "tubular", "shank_bore": 5.0, "oil_gallery": 4.8}),
    ("rod.oil_gallery_mm", {"shank_section": "rectangular", "oil_gallery": 12.0}),  # half of the small bore
]


@pytest.mark.parametrize(("key", "change"), REFUSED)
def test_a_rod_that_cannot_be_made_is_refused_by_the_dimension_to_change(key, change):
    with pytest.raises(InvalidValue) as refusal:
        replace(ROD, **change)
    assert refusal.value.name == key
    assert key in str(refusal.value)


@given(
    name=st.sampled_from(dimensions()),
    value=st.one_of(
        st.floats(max_value=0.0999),
        st.floats(min_value=10_001),
        st.just(math.nan),
        st.booleans(),
        st.text(max_size=3),
        st.none(),
    ),
)
def test_a_dimension_that_is_no_length_is_refused_by_name(name, value):
    assume(not (value == 0 and name in options()))
    with pytest.raises(InvalidValue) as refusal:
        replace(ROD, **{name: value})
    assert refusal.value.name == f"rod.{name}_mm"


@given(name=st.sampled_from(dimensions()), factor=st.floats(0.01, 100))
def test_any_single_dimension_is_taken_or_refused_by_a_rule(name, factor):
    try:
        rod = replace(ROD, **{name: factor * getattr(ROD, name)})
    except InvalidValue as refusal:
        assert refusal.name.removeprefix("rod.").removesuffix("_mm") in dimensions()  # noqa: PT017
    else:
        assert getattr(rod, name) == pytest.approx(factor * getattr(ROD, name))


@example(length=20.0, big=0.5, small=1.0, section=ShankSection.I)
@given(
    length=st.floats(20, 1000),
    big=st.floats(0.15, 0.5),
    small=st.floats(0.3, 1),
    section=st.sampled_from(ShankSection),
)
def test_three_dimensions_are_enough_for_a_rod(length, big, small, section):
    rod = proportioned(length, big * length, small * big * length, shank_section=section)
    assert isinstance(rod, Rod)
    assert rod.shank_section is section


def test_an_unknown_section_is_refused_with_the_known_ones():
    with pytest.raises(
        InvalidValue, match=r"rod\.shank_section = 'Z': must be one of I, H, rectangular, tubular"
    ):
        replace(ROD, shank_section="Z")


def test_a_section_may_be_given_by_its_name():
    assert replace(LEON_2001, shank_section="rectangular").shank_section is ShankSection.RECTANGULAR
