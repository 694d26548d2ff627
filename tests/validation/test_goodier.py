"""Spherical cavity of radius 1 in an infinite body under tension S (Goodier 1933, Trans. ASME 55, 39-44).

At the equator S (27 − 15ν) / (2(7 − 5ν)) along the tension, at the pole −S (3 + 15ν) / (2(7 − 5ν)) around
it. A quarter of a ball of radius 4 is meshed, cut at y = 0 and z = 0; its outer surface carries the exact
displacement. The tension is along x.
"""

import numpy as np
import pytest
from exact_bodies import MATERIAL, PROBLEMS, rate, solved

NU = MATERIAL.poissons_ratio
EQUATOR = (27 - 15 * NU) / (2 * (7 - 5 * NU))
POLE = -(3 + 15 * NU) / (2 * (7 - 5 * NU))
SIZES = (0.5, 0.35, 0.25, 0.18, 0.13)


def test_the_field_compared_with_is_goodiers():
    at_equator, at_pole = PROBLEMS["goodier"].stress(np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]]))
    assert at_equator[0] == pytest.approx(EQUATOR, rel=1e-12)
    np.testing.assert_allclose(at_pole, [0, POLE, POLE, 0, 0, 0], atol=1e-12)


# The coarsest mesh has five elements around a quarter of the equator. Twice the error seen in the
# largest stress (0.1, 0.0, 0.4, 0.4, 0.7 %), which is where the scatter of many nodes shows.
@pytest.mark.parametrize("size", SIZES)
def test_the_largest_stress_is_the_equators(size):
    body = solved("goodier", size)
    nodes = body.inner()
    hottest = nodes[body.stress[nodes, 0].argmax()]
    assert body.stress[hottest, 0] == pytest.approx(EQUATOR, rel=0.014)
    assert abs(body.mesh.points[hottest, 0]) < 0.3


# In percent of the equator's stress, somewhat above what is seen (2.7, 1.1, 0.6, 0.2, 0.1 and at the
# pole 0.1, 0.2, 0.3, 0.5, 0.6).
@pytest.mark.parametrize(("size", "percent"), list(zip(SIZES, (4.0, 2.0, 1.0, 0.5, 0.3), strict=True)))
def test_equator_and_pole(size, percent):
    body = solved("goodier", size)
    nodes = body.inner()
    points = body.mesh.points[nodes]
    hot = nodes[abs(points[:, 0]) < 0.3]
    assert abs(body.error[hot, 0].mean()) < percent / 100 * EQUATOR
    pole = nodes[np.linalg.norm(points - [1, 0, 0], axis=1).argmin()]
    np.testing.assert_allclose(body.stress[pole], [0, POLE, POLE, 0, 0, 0], atol=0.015 * EQUATOR)


def test_stress_converges_with_the_square_of_the_element_length():
    bodies = [solved("goodier", size) for size in SIZES]
    # Stress of second-order elements is exact to O(h²); irregular meshes scatter by some tenths.
    assert 1.6 < rate([body.rms() for body in bodies], [body.length for body in bodies]) < 2.6


@pytest.mark.parametrize("size", SIZES)
def test_recovery_earns_its_place_against_the_mean_over_elements(size):
    assert solved("goodier", size).rms() < 0.4 * solved("goodier", size, by_mean=True).rms()


def test_a_hole_in_plane_strain():
    # Kirsch 1898: 3 S beside the hole, −S at its crown; 0.5 % and 1.1 % seen.
    body = solved("kirsch", 0.15)
    nodes = body.inner()
    assert body.stress[nodes, 0].max() == pytest.approx(3.0, rel=0.01)
    assert body.stress[nodes, 1].min() == pytest.approx(-1.0, rel=0.025)
