"""Fatigue criteria on histories and parts with published answers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fea.base.choices import Fatigue, Finish, Loading
from fea.base.material import (
    Material,
    estimated_endurance,
    finish_factor,
    reliability_factor,
    roughness_factor,
    size_factor,
)
from fea.judge.fatigue import (
    TORSION_RATIO,
    crossland_bound,
    crossland_factors,
    enclosing_balls,
    fatigue_factor,
    gerber,
    goodman,
)
from fea.judge.history import deviatoric, extremes, tensor
from fea.solid.stress import von_mises
from fea.study.material_table import MaterialTable
from fea.study.tables import read_table
from geometry.errors import InvalidValue

KPSI = 6.894757  # MPa
TURN = np.linspace(0, 2 * math.pi, 721)


def bending_and_torsion(
    bending: float, torsion: float, phase: float = 0.0, mean: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """History (1, 6, 721) of σxx = m + σ sin θ and σxy = m + τ sin(θ − phase)."""
    history = np.zeros((1, 6, TURN.size))
    history[0, 0] = mean[0] + bending * np.sin(TURN)
    history[0, 3] = mean[1] + torsion * np.sin(TURN - phase)
    return history


def test_shigley_example_6_10_a_machined_bar_under_pulsating_tension():
    # Budynas & Nisbett, 9th ed., example 6-10: S_ut = 100 kpsi, machined, axial load (k_c = 0.85), local
    # σ_a = σ_m = 8.38 kpsi; k_a = 0.797, S_e = 33.9 kpsi, n_f = 3.66 by Gerber. Printed with three digits.
    k_a = finish_factor(Finish.MACHINED, 100 * KPSI)
    assert k_a == pytest.approx(0.797, rel=2e-3)
    endurance = k_a * 0.85 * estimated_endurance(100 * KPSI, 207e3) / KPSI
    assert endurance == pytest.approx(33.9, rel=2e-3)
    stress = np.array(8.38)
    assert gerber(stress, stress, endurance, 100.0) == pytest.approx(3.66, rel=5e-3)
    # The lines order themselves so for any tensile mean.
    lines = [goodman(stress, stress, endurance, 84.0), goodman(stress, stress, endurance, 100.0)]
    assert lines[0] < lines[1] < gerber(stress, stress, endurance, 100.0)
    assert lines[1] == pytest.approx(1 / (8.38 / 33.9 + 8.38 / 100), rel=2e-3)


@pytest.mark.parametrize(
    ("line", "strength", "diameter"),
    [(gerber, 100e3, 1.016), (goodman, 80e3, 1.090), (goodman, 100e3, 1.073)],
)
def test_shigley_problem_7_1_a_shaft_in_bending_and_torsion_with_means(line, strength, diameter):
    # Budynas & Nisbett, 8th ed., problem 7-1 and its solution: M = 500 ± 600 and T = 300 ± 400 lbf in,
    # K_f = 2.2, K_fs = 1.8, S_e = 30, S_ut = 100, S_y = 80 kpsi; diameters in inches for a factor of 2. They
    # take the von Mises stress of means and of amplitudes; the history is nearly proportional.
    modulus = math.pi * diameter**3 / 32
    bending, torsion = 2.2 / modulus, 1.8 / (2 * modulus)
    history = bending_and_torsion(600 * bending, 400 * torsion, mean=(500 * bending, 300 * torsion))
    found = extremes(deviatoric(history))
    assert line(found.mean, found.amplitude, 30e3, strength)[0] == pytest.approx(2, rel=5e-3)


@pytest.mark.parametrize(
    ("computed", "printed"),
    [
        (finish_factor(Finish.POLISHED, 520.0), 1.0),
        (finish_factor(Finish.MACHINED, 520.0), 0.860),  # example 6-3
        (finish_factor(Finish.AS_FORGED, 520.0), 0.540),  # the same steel forged
        (size_factor(32.0), 0.858),  # example 6-4
        (reliability_factor(50), 1.0),  # table 6-5
        (reliability_factor(90), 0.897),
        (reliability_factor(99), 0.814),
        (reliability_factor(99.99), 0.702),
    ],
)
def test_marin_factors_are_shigleys(computed, printed):
    assert computed == pytest.approx(printed, rel=1.5e-3)  # printed with three digits


def test_the_roughness_factor_is_that_of_the_guideline():
    # K_R = 1 − 0.22 lg(R_z) lg(2 R_m/400) (FKM guideline, 6th ed. 2012): 0.79 at 600 MPa and 100 µm, as in a
    # worked example (quadco.engineering, Surface Roughness Factor KR); 1 on a polished surface.
    assert roughness_factor(100.0, 600.0) == pytest.approx(0.79, abs=5e-3)
    assert roughness_factor(1.0, 900.0) == roughness_factor(200.0, 200.0) == 1.0
    assert finish_factor(Finish.SHOT_PEENED, 900.0) == pytest.approx(1.1 * roughness_factor(200.0, 900.0))


def test_bores_and_faces_of_a_forging_are_machined_unless_it_is_said_otherwise():
    steel = MaterialTable(preset="forged-steel-2005", surface=Finish.AS_FORGED, reliability_percent=99.0)
    marin = steel.material().marin
    assert [skin.finish for skin in marin.surfaces.values()] == ["machined", "machined", "as-forged"]
    assert [skin.assumed for skin in marin.surfaces.values()] == [True, True, False]
    assert marin.bores.factor == finish_factor(Finish.MACHINED, 938.0)
    said = replace(steel, bore_surface=Finish.GROUND, face_surface=0.5).material().marin
    assert [skin.factor for skin in said.surfaces.values()][:2] == [finish_factor(Finish.GROUND, 938.0), 0.5]
    assert not said.bores.assumed
    # Without any finish, every metal is a cleaned forging, with the factors of steel.
    usual = replace(steel, surface=None, reliability_percent=None).material().marin
    assert [skin.finish for skin in usual.surfaces.values()] == ["machined", "machined", "shot-peened"]
    assert usual.reliability == 1
    assert all(skin.assumed for skin in usual.surfaces.values())
    table = MaterialTable(preset="ti-6al-4v")
    titanium, strength = table.material().marin, table.resolved().ultimate_MPa
    assert titanium.rest.factor == finish_factor(Finish.SHOT_PEENED, strength) < 1
    assert titanium.bores.factor == finish_factor(Finish.MACHINED, strength)
    assert all(skin.of_steel and skin.assumed for skin in titanium.surfaces.values())
    peened = replace(steel, surface=Finish.MACHINED_PEENED).material().marin
    assert peened.rest.factor == pytest.approx(1.1 * finish_factor(Finish.MACHINED, 938.0))
    # The finish of a whole part, or a factor of its own, holds everywhere.
    for surface, factor in ((Finish.MACHINED, 0.735), (0.8, 0.8), (Finish.POLISHED, 1.0)):
        alike = replace(steel, surface=surface).material().marin
        assert alike.bores == alike.faces == alike.rest
        assert alike.rest.factor == pytest.approx(factor, rel=1e-3)
    # The surface is not contained in the limit, everything else is.
    assert steel.material().endurance_limit == pytest.approx(423 * reliability_factor(99))
    axial = replace(steel, loading=Loading.AXIAL, size_mm=32.0, endurance_torsion_MPa=260.0).material()
    assert axial.endurance_limit == pytest.approx(423 * 0.85 * size_factor(32.0) * reliability_factor(99))
    assert axial.torsion_limit == pytest.approx(260 * size_factor(32.0) * reliability_factor(99))


@pytest.mark.parametrize(
    ("keys", "rule"),
    [
        (
            {"surface": Finish.MACHINED, "ultimate_MPa": None},
            "ultimate_MPa is missing: the factor of surface",
        ),
        ({"bore_surface": 0.0}, "bore_surface = 0: must be above 0"),
        ({"face_surface": 2.5}, "face_surface = 2.5: must be above 0 and at most 2"),
        ({"surface": Finish.SHOT_PEENED, "E_GPa": 71.7}, "surface = 'shot-peened': is known of steel only"),
        ({"surface": Finish.MACHINED_PEENED, "E_GPa": 110.0}, "'machined-peened': is known of steel only"),
    ],
)
def test_a_surface_that_nothing_is_known_of_is_refused(keys, rule):
    table = MaterialTable(E_GPa=207.0, nu=0.3, density_kg_m3=7800.0, yield_MPa=600.0, ultimate_MPa=900.0)
    with pytest.raises(InvalidValue, match=rule):
        replace(table, **keys).material()


@pytest.mark.parametrize("value", ["foo", True, [0.7]])
def test_a_surface_is_a_finish_or_a_number(value):
    assert read_table(MaterialTable, "material", {"bore_surface": 1}).bore_surface == 1.0
    with pytest.raises(InvalidValue, match=r"bore_surface = .*Choose from polished, .* or give a number\."):
        read_table(MaterialTable, "material", {"bore_surface": value})


def test_rough_surfaces_reduce_every_factor_as_they_reduce_the_endurance_limit():
    steel = MaterialTable(preset="hard-steel-1945").material()
    half = replace(steel, endurance_limit=steel.endurance_limit / 2, torsion_limit=steel.torsion_limit / 2)
    history = bending_and_torsion(100.0, 50.0, mean=(30.0, 0.0))
    history = deviatoric(np.repeat(history, 3, axis=0))
    surface = np.array([1.0, 0.5, 0.25])
    factors = crossland_factors(history, steel, surface)
    assert factors == pytest.approx(factors[0] * surface, rel=1e-6)
    assert factors[1] == pytest.approx(crossland_factors(history, half)[1], rel=1e-6)
    found = extremes(history)
    for criterion in Fatigue:
        mine = fatigue_factor(criterion, found.mean, found.amplitude, steel, surface)
        whole = fatigue_factor(criterion, found.mean, found.amplitude, half)
        assert mine[1] == pytest.approx(whole[1], rel=1e-12)


def test_only_steels_have_half_their_ultimate_strength():
    assert estimated_endurance(1000.0, 207e3) == 500.0
    assert estimated_endurance(1600.0, 207e3) == 700.0
    assert estimated_endurance(572.0, 71.7e3) is None


@pytest.mark.parametrize(
    "value", [(size_factor, 300.0), (reliability_factor, 100.0), (reliability_factor, 40.0)]
)
def test_factors_refuse_what_was_never_tested(value):
    factor, argument = value
    with pytest.raises(InvalidValue):
        factor(argument)


@pytest.mark.parametrize(("bending", "torsion"), [(100.0, 0.0), (0.0, 100.0), (100.0, 80.0), (-60.0, 100.0)])
def test_a_symmetric_proportional_cycle_has_ratio_minus_one(bending, torsion):
    found = extremes(deviatoric(bending_and_torsion(bending, torsion)))
    assert found.ratio[0] == pytest.approx(-1)
    assert found.amplitude[0] == pytest.approx(math.hypot(bending, math.sqrt(3) * torsion))
    assert found.mean[0] == pytest.approx(0, abs=1e-9)


def test_pulsating_tension_has_ratio_zero_and_pulsating_compression_none():
    pull = extremes(deviatoric(bending_and_torsion(50.0, 0.0, mean=(50.0, 0.0))))
    assert (pull.ratio[0], pull.mean[0], pull.amplitude[0]) == pytest.approx((0, 50, 50), abs=1e-9)
    push = extremes(deviatoric(bending_and_torsion(50.0, 0.0, mean=(-50.0, 0.0))))
    assert (push.mean[0], push.amplitude[0]) == pytest.approx((-50, 50))
    assert goodman(push.mean, push.amplitude, 300.0, 700.0)[0] == pytest.approx(6)  # no benefit, no harm
    assert goodman(pull.mean, pull.amplitude, 300.0, 700.0)[0] == pytest.approx(4.2)


def test_extreme_principal_stresses_are_those_of_every_instant():
    history = np.random.default_rng(3).normal(size=(40, 6, 60))
    found = extremes(deviatoric(history))
    tensors = np.moveaxis(history, 1, -1)
    roots = np.linalg.eigvalsh(tensors[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])
    np.testing.assert_allclose(found.principal_1, roots[..., 2].max(axis=1), rtol=1e-7)
    np.testing.assert_allclose(found.principal_3, roots[..., 0].min(axis=1), rtol=1e-7)
    np.testing.assert_allclose(found.von_mises, von_mises(tensors).max(axis=1), rtol=1e-12)
    np.testing.assert_allclose(tensor(deviatoric(history)), history, atol=1e-14)


def limited(tension, torsion):
    """A steel with these endurance limits."""
    return Material(206e3, 0.29, 7.85e-9, 500.0, 680.0, tension, torsion)


@pytest.mark.parametrize("phase_deg", [0, 30, 60, 90])
@pytest.mark.parametrize(("bending", "torsion"), [(138.1, 167.1), (245.3, 122.6), (100.0, 57.7)])
def test_crossland_in_and_out_of_phase(bending, torsion, phase_deg):
    # Papadopoulos, Davoli, Gorla, Filippini & Bernasconi 1997 (Int. J. Fatigue 19, 219): for bending and
    # torsion out of phase by δ, 2 J₂,a = σ²/3 + τ² + √((σ²/3 + τ²)² − 4/3 σ²τ² sin²δ); σ_H,max = σ/3.
    f, t, delta = 313.9, 196.2, math.radians(phase_deg)
    both = bending**2 / 3 + torsion**2
    root = math.sqrt(both**2 - 4 / 3 * (bending * torsion * math.sin(delta)) ** 2)
    used = math.sqrt((both + root) / 2) + (3 * t / f - math.sqrt(3)) * bending / 3
    history = deviatoric(bending_and_torsion(bending, torsion, delta))
    assert crossland_factors(history, limited(f, t))[0] == pytest.approx(
        t / used, rel=2e-3
    )  # the ball is to 1e-3


@pytest.mark.parametrize(("bending", "torsion"), [(313.9, 0.0), (0.0, 196.2)])
def test_crossland_meets_both_limits_it_was_made_from(bending, torsion):
    history = deviatoric(bending_and_torsion(bending, torsion))
    assert crossland_factors(history, limited(313.9, 196.2))[0] == pytest.approx(1, rel=1.1e-3)


def test_crossland_under_steady_torsion_is_that_of_the_bending_alone():
    # A steady shear moves the path and not its ball (Crossland 1956; Sines 1959 measured as much).
    steel = limited(313.9, 196.2)
    alone, sheared = (
        crossland_factors(deviatoric(bending_and_torsion(200.0, 0.0, mean=(0.0, steady))), steel)
        for steady in (0.0, 120.0)
    )
    assert sheared[0] == pytest.approx(alone[0], rel=1.1e-3)
    # Mean tension counts: σ_H,max = (m + σ)/3.
    pulled = crossland_factors(deviatoric(bending_and_torsion(200.0, 0.0, mean=(200.0, 0.0))), steel)
    used = 200 / math.sqrt(3) + (3 * 196.2 / 313.9 - math.sqrt(3)) * 400 / 3
    assert pulled[0] == pytest.approx(196.2 / used, rel=1.1e-3)


def test_crossland_refuses_a_torsion_limit_that_rewards_tension():
    with pytest.raises(InvalidValue, match="torsion"):
        crossland_factors(deviatoric(bending_and_torsion(100.0, 0.0)), limited(300.0, 150.0))


def test_crossland_without_a_torsion_limit_takes_that_of_wrought_steels():
    steel = Material(206e3, 0.29, 7.85e-9, 500.0, 680.0, 313.9)
    history = deviatoric(bending_and_torsion(0.0, 100.0))
    assert crossland_factors(history, steel)[0] == pytest.approx(TORSION_RATIO * 3.139, rel=1.1e-3)
    assert crossland_factors(history, replace(steel, endurance_limit=None)) is None


def test_no_history_is_worse_than_its_bound():
    steel = Material(206e3, 0.29, 7.85e-9, 500.0, 680.0, 313.9, 196.2)
    history = 100 * np.random.default_rng(7).normal(size=(200, 6, 40))
    q = deviatoric(history)
    found = extremes(q)
    bound = crossland_bound(found.von_mises, found.principal_1, steel)
    assert (bound <= crossland_factors(q, steel)).all()
    assert bound[0] == pytest.approx(crossland_factors(q, steel)[0], rel=0.8)  # and it says something


def test_ball_round_points_on_a_sphere_and_within():
    points = np.random.default_rng(5).normal(size=(5, 300))
    points /= np.linalg.norm(points, axis=0)
    points[:, 150:] *= 0.6
    center = np.arange(5.0)[:, None]
    assert enclosing_balls((7 * points + center)[None])[0][0] == pytest.approx(7, rel=1e-3)
    assert enclosing_balls(np.ones((1, 5, 10)))[0][0] == 0


def test_balls_of_many_paths_are_the_smallest():
    # A simplex of unit edge in d dimensions: R = √(d/(2(d + 1))) (Jung 1901); an obtuse triangle: half its
    # longest side. Between them, points that reach no farther.
    corners = np.pad(np.eye(6) / math.sqrt(2), ((0, 0), (0, 1)))[:, :6]  # in the plane Σx = const. of six
    basis = np.linalg.svd(corners - corners.mean(axis=0))[2][:5]
    simplex = (corners @ basis.T).T
    inside = simplex @ np.random.default_rng(2).dirichlet(np.ones(6), 54).T
    obtuse = np.zeros((5, 60))
    obtuse[:2, :3] = [[0, 10, 4], [0, 0, 1]]
    obtuse[:, 3:] = obtuse[:, [2]]
    radii, _ = enclosing_balls(np.stack([np.hstack([simplex, inside]), obtuse]))
    assert radii == pytest.approx([math.sqrt(5 / 12), 5], rel=1e-3)
    assert (radii >= [math.sqrt(5 / 12) - 1e-9, 5 - 1e-9]).all()
