"""The elastic pin against closed forms and against a solid mesh."""

import math

import numpy as np
import pytest

from fea.contact.elastic_pin import ElasticPin, Pin

E, NU = 206e3, 0.3


def slice_of(inner: float) -> Pin:
    """A slice of a long pin."""
    return Pin(10.0, inner, 4.0, None, E, NU)


def pressed(pin: Pin, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stations, and inward displacements there under 1 MPa times cos nφ: on the contact, on the supports."""
    half = ElasticPin(pin)
    (found,) = half.harmonics(np.array([order]))
    z = half.stations
    load = np.zeros(len(z))
    for first in range(0, len(z) - 2, 2):  # Simpson's rule along the quadratic elements
        load[first : first + 3] += (z[first + 2] - z[first]) * np.array([1, 4, 1]) / 6
    around = math.pi * (1 + (order == 0))
    return z, found.compliance @ (around * pin.radius * load), found.carried


@pytest.mark.parametrize("order", [0, 2, 3, 5, 9])
def test_a_solid_slice_deflects_as_michell_says(order):
    # Airy's function (A rⁿ + B rⁿ⁺²) cos nφ with the coefficients of a radial traction of −cos nφ and no
    # shear at r = R; plane strain (Michell 1899; Timoshenko & Goodier 1970, article 43).
    n, R, mu = order, 10.0, E / (2 * (1 + NU))
    if n == 0:
        exact = R * (1 + NU) * (1 - 2 * NU) / E
    else:
        rows = [[n * (1 - n), n + 2 - n * n], [n * (n - 1), n * (n + 1)]]
        a, b = np.linalg.solve(rows, [-1.0, 0.0])
        exact = -(-a * n + b * (2 - 4 * NU - n)) * R / (2 * mu)
    # The mesh of the pin: 0.05 % at the ninth harmonic.
    _, inward, _ = pressed(slice_of(0.0), order)
    assert inward == pytest.approx(np.full_like(inward, exact), rel=1e-3)


def test_a_thin_slice_becomes_oval_as_a_ring():
    # Plane strain, inextensible thin ring under p cos 2φ: w = p R⁴ / (E' I (n² − 1)²), E' = E / (1 − ν²),
    # I = t³ / 12 (Timoshenko 1940, article 78). What shear and stretching add to it is of the order (t/R)².
    t, R = 0.2, 10.0
    mean = R - t / 2
    exact = R * mean**3 * (1 - NU**2) / (E * t**3 / 12 * 9)  # the pressure acts outside
    _, inward, _ = pressed(slice_of(R - t), 2)
    assert inward == pytest.approx(np.full_like(inward, exact), rel=1e-2)


@pytest.mark.parametrize("inner", [0.0, 2.0, 3.5])
def test_a_slender_pin_bends_as_timoshenko_s_beam(inner):
    # Uniform load over the bore, carried by short bosses far away: the sag of the middle against the ends of
    # the bore, less the flattening of the section, which is the same all along.
    R, c, span = 5.0, 25.0, 100.0
    pin = Pin(R, inner, c, (span, span + 2.0), E, NU)
    z, inward, carried = pressed(pin, 1)
    force = math.pi * R * c  # on half of the pin, of a pressure cos φ of 1 MPa
    peak = force / (math.pi * R * 2.0)  # the same as a pressure cos φ on the boss
    deflection = inward - peak * carried
    area, inertia = math.pi * (R**2 - inner**2), math.pi / 4 * (R**4 - inner**4)
    q, boss = force / c, span + 1.0
    m = inner / R
    kappa = 6 * (1 + NU) * (1 + m**2) ** 2 / ((7 + 6 * NU) * (1 + m**2) ** 2 + (20 + 12 * NU) * m**2)
    x = z[z <= 0.8 * c]
    moment_at_middle = force * boss - q * c**2 / 2
    bent = (moment_at_middle * x**2 / 2 - q * x**4 / 24) / (E * inertia)
    sheared = q * x**2 / 2 / (kappa * E / (2 * (1 + NU)) * area)
    sag = deflection[0] - deflection[: len(x)]
    assert sag[-1] == pytest.approx((bent + sheared)[-1], rel=1e-2)


@pytest.mark.parametrize("order", [0, 1, 2, 4, 16])
def test_a_finer_mesh_of_the_pin_changes_nothing(order, monkeypatch):
    pin = Pin(11.0, 6.6, 11.0, (12.0, 30.0), E, NU)
    _, inward, carried = pressed(pin, order)
    balanced = inward - 11.0 / 18.0 * carried
    for name, count in (("RADIAL", 10), ("TOUCHING", 24), ("BETWEEN", 8), ("CARRIED", 12)):
        monkeypatch.setattr(f"fea.contact.elastic_pin.{name}", count)
    monkeypatch.setattr("fea.contact.elastic_pin._AXIAL_RATIO", math.sqrt(0.75))
    _, inward, carried = pressed(pin, order)
    finer = inward - 11.0 / 18.0 * carried
    if order == 1:  # a rigid motion is free
        balanced, finer = balanced - balanced[-1], finer - finer[-1]
    assert balanced[0] == pytest.approx(finer[0], rel=5e-3)
    # At the end of the bore, where the pressure jumps.
    assert balanced[-1] == pytest.approx(finer[-1], rel=3e-2, abs=1e-12)


def test_harmonics_between_those_solved_are_as_if_solved():
    half = ElasticPin(Pin(11.0, 6.6, 11.0, (12.0, 30.0), E, NU))
    found = {answer.order: answer.compliance for answer in half.harmonics_up_to(64)}
    assert sorted(found) == list(range(65))
    for exact in half.harmonics(np.array([13, 16, 23, 40, 57, 64])):
        largest = np.abs(exact.compliance).max()
        assert np.abs(found[exact.order] - exact.compliance).max() < 1e-3 * largest
