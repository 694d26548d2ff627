"""Lives by local strain: exact points of the line, mean stress, factors, estimated constants."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fea.base.material import Basquin, CoffinManson, Marin, Material
from fea.judge.cycle_life import LOW_CYCLE, StrainLine, cycle_life

LINE, PLASTIC, E = Basquin(1500.0, -0.09), CoffinManson(0.8, -0.6), 207e3
STEEL = Material(E, 0.3, 7.85e-9, 800.0, 1000.0, 430.0, basquin=LINE, coffin_manson=PLASTIC)
ONE_CYCLE = np.sin(np.linspace(0.0, 2 * np.pi, 721))
KNEE = 1e6


def elastic_stress(cycles, line=LINE, plastic=PLASTIC):
    """Neuber's elastic stress, MPa, of the stress and the strain that last so many reversed cycles."""
    stress = line.amplitude(cycles)
    return math.sqrt(stress * E * (stress / E + plastic.coefficient * (2 * cycles) ** plastic.exponent))


def life(strain, mean, amplitude):
    return strain.cycles(np.array([mean]), np.array([amplitude]))


@pytest.mark.parametrize("cycles", [5.0, 200.0, 3e3, 1e5])
def test_a_reversed_cycle_lasts_as_the_strain_line_says(cycles):
    """With σ_max = σ_a, Smith, Watson & Topper's line is Coffin and Manson's times σ_a: exact."""
    strain = StrainLine.of(STEEL, KNEE)
    assert life(strain, 0.0, elastic_stress(cycles)) == pytest.approx(cycles, rel=1e-6)
    assert not strain.assumed


def test_local_stress_is_on_the_cyclic_curve_and_on_neubers_hyperbola():
    strain = StrainLine.of(STEEL, KNEE)
    stress, total = strain.local(900.0)
    assert stress * total == pytest.approx(900.0**2 / E, rel=1e-9)
    # n′ = b/c = 0.15 and K′ = σ_f′/ε_f′^n′, by hand.
    assert total == pytest.approx(stress / E + (stress / (1500.0 / 0.8**0.15)) ** (1 / 0.15), rel=1e-9)
    assert strain.local(1.0)[0] == pytest.approx(1.0, rel=1e-6)


def test_tensile_mean_stress_shortens_and_compressive_does_nothing():
    strain, amplitude = StrainLine.of(STEEL, KNEE), elastic_stress(2e3)
    pushed, reversed_, pulled = (life(strain, mean, amplitude) for mean in (-300.0, 0.0, 300.0))
    assert pushed == reversed_
    # By hand: σ_max of the elastic 300 + amplitude, and the left side grows with it.
    most, stress = strain.local(300.0 + amplitude)[0], LINE.amplitude(2e3)
    left = [value * strain.local(amplitude)[1] for value in (stress, most)]
    right = [1500.0**2 / E * (2 * n) ** -0.18 + 1500.0 * 0.8 * (2 * n) ** -0.69 for n in (reversed_, pulled)]
    assert right == pytest.approx(left, rel=1e-6)
    assert pulled < reversed_


def test_factors_of_the_place_hold_at_the_knee_and_not_at_the_first_reversal():
    rough = StrainLine.of(replace(STEEL, marin=Marin(size=0.9)), KNEE, 0.7)
    assert rough.elastic.amplitude(KNEE) == pytest.approx(0.63 * LINE.amplitude(KNEE), rel=1e-9)
    assert rough.elastic.amplitude(0.5) == pytest.approx(1500.0)
    reliable = StrainLine.of(replace(STEEL, marin=Marin(reliability_percent=99.0)), KNEE)
    assert life(reliable, 0.0, 0.8139 * elastic_stress(1e3)) == pytest.approx(1e3, rel=1e-3)  # 1 − 0.08·2.326


def test_constants_that_are_not_known_are_those_of_the_uniform_material_law():
    """Bäumel & Seeger (1990): ψ = 1.375 − 125·1000/207 000 = 0.7711 of 1000 MPa, 1 of a softer steel."""
    unknown = replace(STEEL, basquin=None, coffin_manson=None)
    strain = StrainLine.of(unknown, KNEE)
    assert strain.assumed
    assert (strain.elastic, strain.plastic.exponent) == (Basquin(1500.0, -0.087), -0.58)
    assert strain.plastic.coefficient == pytest.approx(0.59 * 0.77114, rel=1e-4)
    soft = StrainLine.of(replace(unknown, ultimate_strength=600.0), KNEE)
    assert soft.plastic.coefficient == 0.59
    titanium = replace(unknown, youngs_modulus=114e3, density=4.43e-9)
    assert StrainLine.of(titanium, KNEE).plastic == CoffinManson(0.35, -0.69)
    bronze = replace(unknown, youngs_modulus=115e3, density=8.8e-9)
    assert StrainLine.of(bronze, KNEE) is None
    assert StrainLine.of(replace(unknown, ultimate_strength=2200.0), KNEE) is None  # ψ = 0.05
    assert StrainLine.of(replace(STEEL, coffin_manson=None), KNEE).assumed


def test_below_ten_thousand_cycles_the_life_follows_from_strain():
    found = cycle_life(elastic_stress(2e3) * ONE_CYCLE, STEEL)
    assert found.by_strain
    assert not found.assumed
    assert found.cycles == pytest.approx(2e3, rel=1e-6)
    assert found.low < found.cycles < found.high <= LOW_CYCLE
    # Where the S–N line says fewer than 10⁴ and the strain more, it is 10⁴; never more at a larger stress.
    lives = [cycle_life(stress * ONE_CYCLE, STEEL).cycles for stress in np.arange(450.0, 1500.0, 25.0)]
    assert lives == sorted(lives, reverse=True)
    assert LOW_CYCLE in lives
