import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fea.judge.sharp_places import NotchField, VNotch, fitted_notch

# λ₁ and λ₂ by the opening angle, degrees (Williams 1952; figures of Lazzarin & Tovo 1998 to four digits).
EXPONENTS = {
    0: (0.5, 0.5),
    60: (0.5122, 0.7309),
    90: (0.5445, 0.9085),
    120: (0.6157, 1.1489),
    135: (0.6736, 1.3021),
}
openings = st.floats(60.0, 150.0).map(math.radians)


@pytest.mark.parametrize("degrees", EXPONENTS)
def test_the_exponents_are_williams(degrees):
    notch = VNotch(math.radians(degrees))
    assert (notch.opens, notch.slides) == pytest.approx(EXPONENTS[degrees], abs=1e-4)


def test_a_blunt_crack_is_that_of_creager_and_paris():
    """The peak is 2 K/√(πρ), and K/√(2π r) the stress ahead of the sharp crack."""
    assert VNotch(0.0).rounded == pytest.approx(2 * math.sqrt(2), rel=1e-3)


@given(openings, st.floats(-300, 300), st.floats(-100, 100))
def test_a_field_of_the_notch_is_found_again(opening, a, c):
    notch, r = VNotch(opening), np.linspace(1.0, 5.0, 8)
    mean, half = a * r ** (notch.opens - 1), c * r ** (notch.slides - 1)
    field = fitted_notch(notch, r, mean + half, mean - half)
    assert (field.opening, field.sliding) == pytest.approx((a, c), rel=1e-6, abs=1e-6)


@given(openings, st.floats(1.0, 300.0), st.floats(0.0, 30.0), st.floats(1.1, 4.0))
def test_the_radius_for_a_stress_has_that_peak_and_a_larger_one_less(opening, a, c, share):
    field = NotchField(VNotch(opening), a, c, 5.0)
    allowed = share * field.peak(5.0)
    radius = field.radius(allowed)
    assert field.peak(radius) <= allowed * (1 + 1e-9)
    assert field.radius(field.peak(5.0) * 0.99) is None


def test_a_narrow_notch_is_not_judged_by_its_flanks():
    r = np.linspace(1.0, 5.0, 8)
    assert fitted_notch(VNotch(math.radians(30.0)), r, 1 / r, 1 / r) is None
