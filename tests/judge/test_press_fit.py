"""Press fits by Lamé: published figures, equilibrium with a direct solution, and what is said of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fea.judge.press_fit import ROD, Expansions, PressFit, Ring, judge_fit, judge_seat
from fea.study.material_table import LIBRARY, MaterialTable, thermal_expansion
from geometry.errors import InvalidValue

STEEL = MaterialTable(E_GPa=207.0, nu=0.3, density_kg_m3=7850.0, yield_MPa=600.0)
BRONZE = MaterialTable(E_GPa=110.0, nu=0.34, density_kg_m3=8800.0, yield_MPa=250.0)


def bushing(interference):
    inner, outer = BRONZE.material(), STEEL.material()
    return PressFit(Ring(11.0, 12.5, inner), Ring(12.5, 17.5, outer), interference)


def elastic(modulus, ratio):
    return replace(STEEL.material(), youngs_modulus=modulus, poissons_ratio=ratio)


def judged(interference):
    key = "assembly.bushing_interference_mm"
    return judge_fit("bushing", bushing(interference), key=key, given=interference)


def test_a_bronze_bushing_and_a_steel_shell():
    # p of δ_r = 0.02 and 0.03 mm in plane stress, from the compliance of both rings by hand.
    found = bushing(0.04)
    assert found.pressure == pytest.approx(18.88, rel=3e-4)
    assert found.pressure * found.outer.hoop == pytest.approx(58.21, rel=1e-4)
    assert found.inner_hoop == pytest.approx(-167.36, rel=1e-4)
    steel = STEEL.material()
    shell = PressFit(Ring(24.0, 25.5, steel), Ring(25.5, 33.0, steel), 0.06)
    assert shell.pressure == pytest.approx(11.89, rel=4e-4)
    assert shell.pressure * shell.outer.hoop == pytest.approx(47.14, rel=3e-4)


@given(st.floats(5, 40), st.floats(0.05, 1), st.floats(0.1, 2), st.floats(0, 0.45), st.floats(0, 0.45))
def test_the_rings_meet_at_one_radius(a, wall, around, nu_i, nu_o):
    b = a * (1 + wall)
    c = b * (1 + around)
    inner, outer = Ring(a, b, elastic(1e5, nu_i)), Ring(b, c, elastic(2e5, nu_o))
    # u(r) = C₁ r + C₂/r in each, with free bore and outside, equal pressure, and δ/2 between them.
    delta = 1e-3 * b

    def stress(E, nu, r):  # σ_r from C₁ and C₂ in plane stress
        return E / (1 - nu**2) * np.array([1 + nu, -(1 - nu) / r**2])

    system, right = np.zeros((4, 4)), np.array([0.0, 0.0, 0.0, delta / 2])
    system[0, :2], system[1, 2:] = stress(1e5, nu_i, a), stress(2e5, nu_o, c)
    system[2, :2], system[2, 2:] = stress(1e5, nu_i, b), -stress(2e5, nu_o, b)
    system[3] = [-b, -1 / b, b, 1 / b]
    # Equations in MPa and mm: each row is brought to its own size.
    size = abs(system).max(axis=1)
    solution = np.linalg.solve(system / size[:, None], right / size)
    fit = PressFit(inner, outer, delta)
    assert fit.pressure == pytest.approx(-stress(2e5, nu_o, b) @ solution[2:], rel=1e-6)
    # The bore of the inner ring is uniaxial.
    assert fit.inner_hoop / 1e5 == pytest.approx(solution[0] + solution[1] / a**2, rel=1e-6)
    hoop = 2e5 / (1 - nu_o**2) * ((1 + nu_o) * solution[2] + (1 - nu_o) * solution[3] / b**2)
    assert fit.pressure * fit.outer.hoop == pytest.approx(hoop, rel=1e-6)
    assert fit.outer_stress == pytest.approx(
        math.sqrt(hoop**2 + hoop * fit.pressure + fit.pressure**2), rel=1e-6
    )


def test_warming_changes_a_fit():
    # Bronze in steel, 25 mm, 100 K: (18 − 11.5)e-6 · 25 · 100.
    for expansion, interference in ((18e-6, 0.05625), (11.5e-6, 0.04)):
        expansions = Expansions({ROD: 11.5e-6, "bushing": expansion}, 100.0, ())
        assert expansions.interference("bushing", 0.04, 25.0) == pytest.approx(interference)


@pytest.mark.parametrize(
    ("preset", "metal", "expansion"),
    [
        ("leon-2001", "steel", 11.5e-6),
        ("ti-6al-4v", "titanium", 8.6e-6),
        ("al-7075-t6", "aluminium", 23.5e-6),
        ("cusn8p", "copper alloy", 18e-6),
        ("steel-backed-shell", "steel", 11.5e-6),
    ],
)
def test_expansion_follows_from_the_metal(preset, metal, expansion):
    assert thermal_expansion("material", MaterialTable(preset=preset)) == (expansion, metal)


def test_every_preset_is_a_metal_whose_expansion_is_known():
    for preset in LIBRARY:
        assert thermal_expansion("material", MaterialTable(preset=preset))[1] is not None


def test_a_given_expansion_counts_and_an_unknown_metal_is_asked_for_its_own():
    assert thermal_expansion("material", MaterialTable(preset="cusn8p", thermal_expansion_1_K=1.7e-5)) == (
        1.7e-5,
        None,
    )
    odd = MaterialTable(E_GPa=300.0, nu=0.3, density_kg_m3=3000.0, yield_MPa=100.0)
    with pytest.raises(InvalidValue, match=r"material\.bushing\.thermal_expansion_1_K is missing"):
        thermal_expansion("material.bushing", odd)
    with pytest.raises(InvalidValue, match="at most"):
        thermal_expansion("material", MaterialTable(preset="cusn8p", thermal_expansion_1_K=18.0))


def test_what_yields_at_its_bore_is_said_and_what_yields_through_is_refused():
    assert judged(0.04) == ()
    # The bore yields at 250/167.36 of 0.04 mm, the wall at S_y (1 − 11/12.5) = 30 MPa, 0.0636 mm.
    (said,) = judged(0.0610)
    assert "bushing yield at its bore" in str(said)
    assert judged(0.0590) == ()
    with pytest.raises(InvalidValue, match=r"bushing_interference_mm = 0\.065.*below about 0\.064 mm"):
        judged(0.065)


def test_loose_parts_and_loosely_held_shells_are_said():
    assert "clearance of 0.01 mm" in str(judge_seat("bushing", bushing(-0.01))[0])
    assert bushing(-0.01).pressure == 0
    assert judge_seat("bushing", bushing(0.01)) == ()
    assert "MPa on their backs" in str(judge_seat("bearing shells", bushing(0.01))[0])
    assert judge_seat("bearing shells", bushing(0.04)) == ()
