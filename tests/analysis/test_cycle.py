"""The crank cycle by superposition against instants solved directly."""

import math
from dataclasses import replace

import meshio
import numpy as np
import pytest
from cycles import SPEEDS, analysis, superposition_errors

from fea.analysis.cycle.envelope import NOT_JUDGED
from fea.analysis.cycle.unit_solutions import distinct
from fea.analysis.pipeline import solve_speed, with_cycle
from fea.base.choices import Symmetry
from fea.output.vtu import write_vtu
from fea.pins.prescribed import TOLERANCE, series
from fea.solid.stress import von_mises
from loads.bearing import BorePressure


@pytest.fixture(
    scope="module", params=[(Symmetry.QUARTER, 8.0), (Symmetry.NONE, 10.0)], ids=["quarter", "whole"]
)
def rod(request):
    return analysis(*request.param)


@pytest.fixture(scope="module")
def quarter():
    return analysis(Symmetry.QUARTER, 8.0)


@pytest.fixture(scope="module")
def at_6000(quarter):
    return with_cycle(quarter, solve_speed(quarter, 6000.0))


@pytest.mark.parametrize("rpm", SPEEDS)
def test_superposed_stress_is_the_directly_solved_one(rod, rpm):
    # What is promised: 0.5 % of the peak where the pressure acts, 1e-4 elsewhere. Measured with the 74 unit
    # solutions of harmonics up to 32: 0.13 % and 7e-5; up to 8 (26 of them), 0.5 % and 1.4e-3.
    angles = np.random.default_rng(int(rpm)).uniform(0, 4 * math.pi, 20)
    on_bore, elsewhere = superposition_errors(rod, rpm, angles)
    assert on_bore < 5e-3
    assert elsewhere < 1e-4


def test_more_harmonics_come_nearer_to_the_half_cosine():
    arc = BorePressure.parse("cosine-180").tension
    errors = [series(arc, highest).error for highest in (8, 16, 32)]
    # The tail Σ 2/(π(n² − 1)) over even n: 3.5, 1.9 and 0.96 % of the peak pressure.
    assert errors == pytest.approx([0.0353, 0.0187, 0.0096], rel=0.05)
    assert list(series(arc).orders[:5]) == [0, 1, 2, 4, 6]


@pytest.mark.parametrize("pressure", ["cosine-180", "cosine-120", "cosine-90"])
def test_the_series_of_a_pressure_that_does_not_jump_meets_its_tolerance(pressure):
    assert series(BorePressure.parse(pressure).tension).error <= TOLERANCE


def test_weights_press_with_exactly_the_force(quarter):
    bore = quarter.cycle.loads.bores[1]
    direction = np.linspace(0, 2 * math.pi, 25)
    force = 3e4 * np.stack([np.cos(direction), np.sin(direction)])
    even, odd = bore.weights(force)
    of_even, of_odd = bore.resultants
    np.testing.assert_allclose(of_even @ even + of_odd @ odd, force, atol=1e-9 * 3e4)


def test_no_force_needs_no_pressure(quarter):
    even, odd = quarter.cycle.loads.bores[0].weights(np.zeros((2, 1)))
    assert not even.any()
    assert not odd.any()


def test_envelope_is_no_less_than_any_peak_case(at_6000):
    envelope = at_6000.cycle.envelope
    for case in at_6000.cases.values():
        assert (envelope.von_mises >= case.von_mises).all()
        assert (envelope.safety_factor <= case.safety_factor).all()
        assert (envelope.principal_1 >= case.principal[:, 0]).all()
        assert (envelope.principal_3 <= case.principal[:, 2]).all()


def test_envelope_is_the_largest_of_the_instants(quarter, at_6000):
    angles = at_6000.cycle.angles[::6]
    cycle = quarter.cycle
    weights = cycle.weights(quarter.crank_cycle(6000), angles)
    tensors = np.moveaxis(cycle.units.tensor(0, weights, quarter.mesh.mirrored), 1, -1)
    envelope, some = at_6000.cycle.envelope, slice(None, None, 50)
    roots = np.linalg.eigvalsh(tensors[some][..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])
    scale = envelope.von_mises.max()
    assert (envelope.von_mises >= von_mises(tensors).max(axis=1) - 1e-6 * scale).all()
    assert (envelope.principal_1[some] >= roots[..., 2].max(axis=1) - 1e-6 * scale).all()
    assert (envelope.principal_3[some] <= roots[..., 0].min(axis=1) + 1e-6 * scale).all()
    # Between two instants six degrees apart stress changes by a few per cent of its largest.
    np.testing.assert_allclose(envelope.principal_1[some], roots[..., 2].max(axis=1), atol=0.06 * scale)


def test_histories_are_those_of_their_places(at_6000):
    envelope = at_6000.cycle.envelope
    for spot in at_6000.cycle.spots:
        # Every degree against every degree and the peaks between them.
        assert np.abs(spot.signed).max() == pytest.approx(envelope.von_mises[spot.node], rel=5e-3)
        largest = envelope.mean[spot.node] + envelope.amplitude[spot.node]
        assert spot.signed.max() <= largest * (1 + 1e-6)  # they are in single precision
        assert spot.signed[0] == pytest.approx(spot.signed[-1], rel=1e-6, abs=1e-6)  # the cycle closes


def test_hottest_places_are_distinct(quarter, at_6000):
    length = quarter.mesh.bores.rod_length
    places = np.array([spot.place for spot in at_6000.cycle.spots])
    assert len(places) == 5
    apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(5, 1)]
    assert apart.min() > 0.1 * length
    assert (places[:, 2] >= 0).all()
    assert at_6000.cycle.spots[0].node == at_6000.cycle.weakest.node  # fatigue governs


def test_without_fatigue_the_place_nearest_to_yielding_stands_first():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [50, 0, 0], [100, 0, 0]])
    factor = np.array([1.0, 2.0, 3.0, 4.0])
    assert distinct(points, factor, 100.0) == [0, 2, 3]
    assert distinct(points, factor, 100.0, [1]) == [1, 2, 3]


def test_images_across_the_plane_of_motion_are_one_place():
    points = np.array([[0.0, 0, 5], [0, 0, -5], [50, 0, 0]])
    assert distinct(points, np.array([1.0, 0.9, 2.0]), 100.0) == [0, 2]


def test_superposition_is_checked_against_the_peak_cases(at_6000):
    assert at_6000.checks["superposition"].passed
    assert 0 < at_6000.cycle.superposition < 5e-3


@pytest.mark.parametrize(
    ("jumps", "superposition", "passed"),
    [(False, 0.004, True), (False, 0.006, False), (True, 0.04, True), (True, 0.14, False)],
)
def test_a_pressure_that_jumps_is_held_to_a_limit_of_its_own(at_6000, jumps, superposition, passed):
    found = replace(at_6000.cycle, jumps=jumps, series_error=0.5, superposition=superposition)
    assert found.checks()["superposition"].passed is passed
    assert any(("jumps" if jumps else "narrow arc") in str(note) for note in found.notes())
    assert not any("bore pressure" in str(note) for note in at_6000.cycle.notes())


def test_a_factor_that_is_not_known_is_no_nan_in_the_file(at_6000):
    envelope = at_6000.cycle.envelope
    unknown = np.full(len(envelope.mean), np.nan)
    data = replace(envelope, fatigue_factor=unknown).point_data()
    assert (data["fatigue_safety_factor"] == NOT_JUDGED).all()
    assert "fatigue_safety_factor" not in replace(envelope, fatigue_factor=None).point_data()


def test_the_file_can_be_read_by_meshio(tmp_path, quarter, at_6000):
    # Nodes in a number of the kind 3k + 2 fill blocks whose base64 text has no padding.
    whole = quarter.mesh.whole
    count = len(whole.points) - (len(whole.points) - 2) % 3
    within = (whole.tets < count).all(axis=1)
    cut = replace(whole, points=whole.points[:count], tets=whole.tets[within], facets={})
    data = {name: values[:count] for name, values in at_6000.cycle.envelope.point_data().items()}
    write_vtu(tmp_path / "envelope.vtu", cut, data)
    read = meshio.read(tmp_path / "envelope.vtu").point_data
    for name, values in data.items():
        np.testing.assert_array_equal(read[name], values)


def test_the_error_of_superposition_is_relative_to_the_largest_stress_of_the_peak_cases(quarter):
    """A cap that is pushed is hardly stressed, but has the error of the pressure beside it all the same."""
    result = with_cycle(quarter, solve_speed(quarter, 4500.0))
    cases = [case for case in result.cases.values() if case.load.in_cycle]
    weights = quarter.cycle.weights(
        quarter.crank_cycle(4500), np.array([case.load.crank_angle for case in cases])
    )
    superposed = von_mises(np.moveaxis(quarter.cycle.units.tensor(0, weights, quarter.mesh.mirrored), 1, -1))
    solved = np.stack([case.von_mises for case in cases], axis=-1)
    apart = np.abs(superposed - solved).max(axis=0)
    assert result.cycle.superposition == pytest.approx(apart.max() / solved.max(), rel=1e-3)
    assert (apart / solved.max(axis=0)).max() > 1.3 * result.cycle.superposition
