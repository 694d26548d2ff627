"""The elastic pin against closed forms, finer meshes and harmonics solved directly."""

import math

import numpy as np
import pytest

from fea.contact.elastic_pin import ElasticPin, Pin, bending
from fea.verify.cases.contact import NU, SLICE, E, pressed_pin, solid_slice


@pytest.mark.parametrize("order", [2, 3, 5, 9])
def test_a_solid_slice_deflects_as_michell_says(order):
    _, inward, _ = pressed_pin(Pin(SLICE, 0.0, 4.0, None, E, NU), order)
    # The mesh of the pin: 0.05 % at the ninth harmonic.
    assert inward == pytest.approx(np.full_like(inward, solid_slice(order)), rel=1e-3)


def test_a_squeezed_slice_shrinks_as_lame_says():
    _, inward, _ = pressed_pin(Pin(SLICE, 0.0, 4.0, None, E, NU), 0)
    exact = SLICE * (1 + NU) * (1 - 2 * NU) / E
    assert inward == pytest.approx(np.full_like(inward, exact), rel=1e-9)


@pytest.mark.parametrize("order", [0, 1, 2, 4, 16])
def test_a_finer_mesh_of_the_pin_changes_nothing(order, monkeypatch):
    pin = Pin(11.0, 6.6, 11.0, (12.0, 30.0), E, NU)
    _, inward, carried = pressed_pin(pin, order)
    balanced = inward - 11.0 / 18.0 * carried
    for name, count in (("RADIAL", 10), ("TOUCHING", 24), ("BETWEEN", 8), ("CARRIED", 12)):
        monkeypatch.setattr(f"fea.contact.elastic_pin.{name}", count)
    monkeypatch.setattr("fea.contact.elastic_pin._AXIAL_RATIO", math.sqrt(0.75))
    _, inward, carried = pressed_pin(pin, order)
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


def test_a_slender_pin_bends_as_a_beam():
    # Euler-Bernoulli: q on 2h, carried evenly from `near` to `far`; M = q h (c - s) - q (h - s)²/2 with the
    # middle c of a support, so that ∫ (h - s) M ds / (E I) = q h³ ((c - h/3) / 2 - h/8) / (E I).
    # Shear and the flattening of the section are below 1 % at forty radii.
    radius, half, near, far, modulus, force = 1.0, 40.0, 42.0, 60.0, 206e3, 100.0
    load, middle, second = force / (2 * half), (near + far) / 2, math.pi * radius**4 / 4
    pin, lever = Pin(radius, 0.0, half, (near, far), modulus, 0.3), (middle - half / 3) / 2
    beam = load * half**3 * (lever - half / 8) / (modulus * second)
    assert bending(pin, force) == pytest.approx(beam, rel=0.01)
    # With 3/2 q (1 - s²/h²), 19/240 takes the place of 1/8.
    beam = load * half**3 * (lever - 19 * half / 240) / (modulus * second)
    assert bending(pin, force, evenly=False) == pytest.approx(beam, rel=0.01)
    assert bending(pin, 2 * force, evenly=False) == pytest.approx(2 * beam, rel=0.01)
