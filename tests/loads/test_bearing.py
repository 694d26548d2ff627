import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from geometry.errors import InvalidValue
from loads.bearing import PROFILES, BorePressure, PressureArc


@given(st.sampled_from(sorted(PROFILES)), st.floats(2, 180))
def test_resultant_against_quadrature(shape, degrees):
    arc = PressureArc(PROFILES[shape], math.radians(degrees))
    half = arc.angle / 2

    def integral(power, factor=lambda phi: 1.0):
        # Adaptive quadrature (QUADPACK) of the smooth pressure reaches rounding.
        return quad(lambda phi: float(arc(phi)) * math.cos(phi) ** power * factor(phi), -half, half)[0]

    assert arc.moment(1) == pytest.approx(integral(1), rel=1e-11)
    assert arc.moment(2) == pytest.approx(integral(2), rel=1e-11)
    pressed = arc.peak(5000, 12, 20, -3) * 12
    width = integral(1, lambda phi: 20 - 3 * math.cos(phi) + 0.7 * math.sin(phi))
    assert pressed * width == pytest.approx(5000, rel=1e-11)


def test_published_peaks():
    # references.md of this field's practice: P = 21.66 kN, R = 24 mm, b = 18 mm.
    cosine, uniform = (BorePressure.parse(n).tension for n in ("cosine-180", "uniform-120"))
    assert cosine.peak(21660, 24, 18) == pytest.approx(2 * 21660 / (math.pi * 24 * 18), rel=1e-14)
    assert uniform.peak(21660, 24, 18) == pytest.approx(21660 / (math.sqrt(3) * 24 * 18), rel=1e-14)
    assert round(cosine.peak(21660, 24, 18), 1) == 31.9
    assert round(uniform.peak(21660, 24, 18), 1) == 28.9


def test_shape_is_periodic_even_and_zero_outside():
    arc = PressureArc(PROFILES["cosine"], math.radians(120))
    phi = np.array([0, 0.5, -0.5, 2 * math.pi, math.radians(61), math.pi])
    np.testing.assert_allclose(arc(phi), [1, math.cos(0.75), math.cos(0.75), 1, 0, 0], atol=1e-14)


def test_webster_differs_in_tension_and_compression():
    webster = BorePressure.parse("webster")
    assert webster.arc(+1.0) == PressureArc(PROFILES["cosine"], math.pi)
    assert webster.arc(-1.0) == PressureArc(PROFILES["uniform"], math.radians(120))


@pytest.mark.parametrize("name", ["cosine", "cosine-0", "cosine-181", "uniform-x", "hertz", "", "cosine-1e3"])
def test_a_bad_name_is_refused(name):
    with pytest.raises(InvalidValue, match=r"analysis\.pressure"):
        BorePressure.parse(name)


@pytest.mark.parametrize("angle", [0.0, -1.0, math.nan, 4.0])
def test_a_bad_arc_is_refused(angle):
    with pytest.raises(InvalidValue, match=r"analysis\.pressure"):
        PressureArc(PROFILES["cosine"], angle)
