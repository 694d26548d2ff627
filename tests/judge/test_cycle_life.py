"""Cycles to failure at one speed: closed forms of the assumed line, of its bands, and where it goes on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fea.base.material import Basquin, Marin, Material
from fea.judge.cycle_life import (
    LONGEST,
    LOW_CYCLE,
    assumed_line,
    cycle_life,
    strength_share,
    varied_pressure,
)

STEEL = Material(
    207e3, 0.3, 7.85e-9, 800.0, ultimate_strength=1000.0, endurance_limit=425.0, marin=Marin(load=0.85)
)
ONE_CYCLE = np.sin(np.linspace(0.0, 2 * np.pi, 721))


def test_the_assumed_line_passes_through_075_of_the_ultimate_strength_and_the_limit():
    """Juvinall (1967): 0.75 S_u at 10³ cycles under axial load; 425 MPa is 0.85 times 500 of specimens."""
    line = assumed_line(STEEL)
    assert 0.85 * line.amplitude(1e3) == pytest.approx(750.0)
    assert 0.85 * line.amplitude(1e6) == pytest.approx(425.0)
    aluminium = replace(STEEL, youngs_modulus=71e3, endurance_cycles=5e8)
    assert 0.85 * assumed_line(aluminium).amplitude(5e8) == pytest.approx(425.0)
    assert assumed_line(replace(STEEL, ultimate_strength=None)) is None
    assert assumed_line(replace(STEEL, endurance_limit=760.0)) is None


@pytest.mark.parametrize("amplitude", [440.0, 500.0, 600.0])
def test_cycles_are_those_of_the_straight_line_between_both_points(amplitude):
    found = cycle_life(amplitude * ONE_CYCLE, STEEL)
    slope = math.log(1e3) / math.log(750.0 / 425.0)
    assert found.cycles == pytest.approx(1e6 * (425.0 / amplitude) ** slope, rel=1e-9)
    assert found.assumed
    assert not found.by_strain
    for strength, cycles in ((0.862, found.low), (1.138, found.high)):
        if amplitude > 600.0 * strength:
            assert cycles == LOW_CYCLE  # by strain, and not more
        elif amplitude > 425.0 * strength:
            assert cycles == pytest.approx(1e6 * (425.0 * strength / amplitude) ** slope, rel=1e-9)
        else:
            assert math.isinf(cycles)


def test_a_known_line_has_the_band_of_its_scatter():
    """Two standard deviations of 8 % (Stulen 1961), and the slope of the given line."""
    known = replace(STEEL, basquin=Basquin(1500.0, -0.09), marin=Marin(), endurance_limit=430.0)
    found = cycle_life(500.0 * ONE_CYCLE, known)
    assert (found.assumed, found.band_percent) == (False, pytest.approx(16.0))
    assert found.cycles == pytest.approx(known.basquin.cycles(500.0), rel=1e-6)


def test_two_equal_cycles_in_a_period_halve_the_life():
    """Palmgren and Miner."""
    twice = np.sin(np.linspace(0.0, 4 * np.pi, 1441))
    one, two = (cycle_life(500.0 * history, STEEL).cycles for history in (ONE_CYCLE, twice))
    assert two == pytest.approx(one / 2, rel=1e-9)


def test_life_is_unlimited_below_the_limit_of_soft_steels_alone():
    soft = cycle_life(300.0 * ONE_CYCLE, STEEL)
    assert math.isinf(soft.low)
    assert soft.unlimited
    hard = cycle_life(300.0 * ONE_CYCLE, replace(STEEL, ultimate_strength=1500.0))
    decades = math.log(300.0 / 425.0) / math.log(0.95)  # Sonsino (2007): 5 % a decade
    assert hard.cycles == pytest.approx(1e6 * 10**decades, rel=1e-9)
    assert hard.cycles > LONGEST
    assert not hard.unlimited
    light = cycle_life(300.0 * ONE_CYCLE, replace(STEEL, youngs_modulus=114e3, endurance_cycles=1e7))
    assert not light.unlimited
    assert 1e7 < light.cycles < math.inf


def test_mean_stress_counts_as_in_the_factor():
    """Goodman: 300 ± 400 MPa does the damage of 400/(1 − 0.3) MPa fully reversed."""
    found = cycle_life(300.0 + 400.0 * ONE_CYCLE, STEEL)
    assert found.cycles == pytest.approx(cycle_life(400.0 / 0.7 * ONE_CYCLE, STEEL).cycles, rel=1e-9)


def test_no_life_without_strengths():
    assert cycle_life(ONE_CYCLE, replace(STEEL, ultimate_strength=None, endurance_limit=None)) is None
    assert cycle_life(ONE_CYCLE, STEEL, surface=1.8) is None  # more than 0.75 of the ultimate strength


def test_a_hard_steel_is_damaged_below_its_limit_by_every_cycle():
    """Two equal cycles a period halve its life, also where nothing exceeds the limit; a soft one lives on."""
    hard = replace(STEEL, ultimate_strength=1500.0)
    twice = 300.0 * np.sin(np.linspace(0.0, 4 * np.pi, 1441))
    one, two = (cycle_life(history, hard).cycles for history in (300.0 * ONE_CYCLE, twice))
    assert two == pytest.approx(one / 2, rel=1e-9)
    assert math.isinf(cycle_life(twice, STEEL).cycles)


@pytest.mark.parametrize("cycles", [2e4, 3e5, 1e6, 1e9])
@pytest.mark.parametrize("surface", [0.7, 1.0])
def test_the_strength_for_a_life_is_that_which_lasts_so_long(cycles, surface):
    """The inverse of the life, of a soft and a hard steel and of titanium; a soft steel has its limit."""
    titanium = replace(STEEL, youngs_modulus=114e3, density=4.4e-9, endurance_cycles=1e7)
    for metal in (STEEL, replace(STEEL, ultimate_strength=1500.0), titanium):
        (share,) = strength_share(metal, np.array([surface]), cycles)
        found = cycle_life(share * 425.0 * ONE_CYCLE * (1 - 1e-12), metal, surface).cycles
        endless = metal is STEEL and cycles >= 1e6
        assert math.isinf(found) if endless else found == pytest.approx(cycles, rel=1e-6)
        assert not endless or share == pytest.approx(surface)


def test_cycles_of_other_pressures_count_by_their_shares_and_severe_ones_end_unlimited_life():
    """Palmgren and Miner: 1/N = Σ share/N_i; nothing but a severe cycle exceeds the limit in the second."""
    weak, strong = (amplitude * ONE_CYCLE for amplitude in (450.0, 550.0))
    each = [cycle_life(history, STEEL).cycles for history in (weak, strong)]
    mixed = cycle_life(weak, STEEL, varied=[(0.7, weak), (0.3, strong)])
    assert mixed.cycles == pytest.approx(1 / (0.7 / each[0] + 0.3 / each[1]), rel=1e-9)
    below = 400.0 * ONE_CYCLE
    assert math.isinf(cycle_life(below, STEEL, varied=[(1.0, below), (0.0, below)]).cycles)
    assert math.isfinite(cycle_life(below, STEEL, varied=[(1.0, below), (0.0, strong)]).cycles)


def test_five_pressures_stand_for_a_normal_distribution():
    """E[(1 + c z)^8] = 1 + 28 c² + 210 c⁴ + 420 c⁶ + 105 c⁸, which five points of Gauss and Hermite meet."""
    c = 0.05
    varied = varied_pressure(c)
    exact = 1 + 28 * c**2 + 210 * c**4 + 420 * c**6 + 105 * c**8
    assert sum(share * (1 + change) ** 8 for share, change in varied) == pytest.approx(exact, rel=1e-12)
    assert [change for share, change in varied if share == 0] == pytest.approx([-3 * c, 3 * c])
    assert varied_pressure(0.0) == [(1.0, 0.0)]
