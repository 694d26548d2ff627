import math

import pytest

from geometry.errors import InvalidValue
from loads.engine import Engine

GOOD = {"crank_radius": 47.0, "rod_length": 141.0, "bore": 76.0, "piston_mass": 1.3e-3}


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"crank_radius": 0.0}, "engine.stroke_mm"),
        ({"crank_radius": -47.0}, "engine.stroke_mm"),
        ({"rod_length": math.nan}, "rod.length_mm"),
        ({"bore": math.inf}, "engine.bore_mm"),
        ({"piston_mass": "1"}, "engine.piston_mass_kg"),
        ({"pin_offset": math.nan}, "engine.pin_offset_mm"),
        ({"friction": -0.1}, "engine.friction"),
        ({"cylinders": 0}, "engine.cylinders"),
        ({"cylinders": 2.0}, "engine.cylinders"),
        ({"phase": math.inf}, "engine.phase_deg"),
    ],
)
def test_bad_value_is_named(change, name):
    with pytest.raises(InvalidValue) as caught:
        Engine(**(GOOD | change))
    assert caught.value.name == name


@pytest.mark.parametrize("change", [{"crank_radius": 141.0}, {"crank_radius": 200.0}, {"pin_offset": -94.0}])
def test_a_crank_that_cannot_turn_is_refused_with_lambda(change):
    with pytest.raises(InvalidValue, match=r"or the crank cannot turn \(λ = .* must be below 1\)"):
        Engine(**(GOOD | change))


def test_friction_that_jams_the_piston_is_refused():
    tangent = Engine(**GOOD).largest_rod_tangent
    assert Engine(**GOOD, friction=0.999 / tangent).friction > 0
    with pytest.raises(InvalidValue, match="μ tan β must stay below 1 over the cycle, but reaches 1"):
        Engine(**GOOD, friction=1 / tangent)


def test_stroke_is_twice_the_radius_and_grows_with_offset():
    assert Engine(**GOOD).stroke == pytest.approx(94, rel=1e-14)
    assert Engine(**GOOD, pin_offset=5.0).stroke > 94
