"""Column formulas against closed forms."""

import math

import numpy as np
import pytest

from fea.judge.column import ColumnLoads, Plane, column, euler_load
from geometry.section import CrossSection

E, LENGTH = 207e3, 150.0


def test_a_uniform_column_has_eulers_load():
    x = np.linspace(0, LENGTH, 41)
    stiffness = np.full_like(x, E * 400.0)
    expected = math.pi**2 * E * 400.0 / LENGTH**2
    assert euler_load(x, stiffness, built_in=False) == pytest.approx(expected, rel=1e-6)
    assert euler_load(x, stiffness, built_in=True) == pytest.approx(4 * expected, rel=1e-5)


@pytest.mark.parametrize("growth", [0.5, 2.0])
def test_a_tapered_column_has_its_exact_load(growth):
    # I = I₀(1 + cx/l)² makes EI w″ + P w = 0 an equation of Euler and Cauchy's, w = √s sin(ν ln s) with
    # s = 1 + cx/l: P = EI₀ (c/l)² (1/4 + (π/ln(1 + c))²).
    x = np.linspace(0, LENGTH, 121)
    stiffness = E * 400.0 * (1 + growth * x / LENGTH) ** 2
    exact = E * 400.0 * (growth / LENGTH) ** 2 * (0.25 + (math.pi / math.log(1 + growth)) ** 2)
    assert euler_load(x, stiffness, built_in=False) == pytest.approx(exact, rel=1e-4)


def test_the_weaker_axis_of_each_plane_counts():
    stations = tuple(
        CrossSection(x, area=90.0, inertia_y=3000.0, inertia_z=5000.0) for x in np.linspace(0, LENGTH, 21)
    )
    swing, sideways = (column(plane, stations, stations[1], E, 600.0) for plane in Plane)
    assert swing.slenderness == pytest.approx(150 / math.sqrt(5000 / 90))
    assert sideways.slenderness == pytest.approx(75 / math.sqrt(3000 / 90))
    assert sideways.euler / swing.euler == pytest.approx(4 * 3 / 5, rel=1e-3)


def uniform(slenderness, strength=600.0, area=90.0):
    return ColumnLoads(slenderness, math.pi**2 * E * area / slenderness**2, strength * area)


@pytest.mark.parametrize("slenderness", [20.0, 60.0])
def test_johnson_and_rankine_in_their_usual_form(slenderness):
    found = uniform(slenderness)
    johnson = 600 * 90 * (1 - 600 * slenderness**2 / (4 * math.pi**2 * E))
    rankine = 600 * 90 / (1 + 600 / (math.pi**2 * E) * slenderness**2)
    assert found.johnson == pytest.approx(johnson)
    assert found.rankine == pytest.approx(rankine)
    assert found.least == pytest.approx(rankine)


def test_johnsons_parabola_ends_on_eulers_curve():
    touching = math.pi * math.sqrt(2 * E / 600)
    assert uniform(touching * (1 - 1e-9)).johnson == pytest.approx(600 * 90 / 2)
    assert uniform(2 * touching).johnson == uniform(2 * touching).euler
