"""A single overload of the shipped rod with elements far larger than usual, and the set that it leaves."""

from dataclasses import replace

import numpy as np
import pytest

from fea import load_study
from fea.analysis.buckling import columns
from fea.analysis.collapse import bent_columns
from fea.analysis.meshing import adaptive_mesh
from fea.analysis.overload import with_overload
from fea.analysis.permanent_set import judged, permanent_set
from fea.analysis.pipeline import prepare, refined_rod, solve_speed
from fea.analysis.result import run_result
from fea.analysis.survival import factors, survival
from fea.judge.column import Plane
from fea.machine.clock import Clock
from fea.output.flow_statements import overload_in_full
from fea.output.flow_statements import permanent_set as set_in_words
from fea.plastic.increment import NoEquilibriumError
from fea.solid.assembly import mean_at_nodes, stiffness_degree, tabulate
from fea.solid.supports import rigid_motions
from fea.study.overload_table import OverloadTable
from mesh.tetmesh import EDGES

RPM = 6000.0
STUDY = load_study("leon-2001")
STUDY = replace(
    STUDY,
    mesh=replace(STUDY.mesh, size_mm=14.0),
    engine=replace(STUDY.engine, compression_ratio=10.0),
    material=replace(STUDY.material, yield_MPa=600.0, cyclic_yield_MPa=600.0),
)


@pytest.fixture(scope="module")
def mesh():
    return adaptive_mesh(STUDY, Clock())


@pytest.fixture(scope="module")
def rod(mesh):
    return prepare(STUDY, mesh=mesh)


@pytest.fixture(scope="module")
def solved(rod):
    return solve_speed(rod, RPM)


@pytest.fixture(scope="module")
def limit(rod):
    """Force, N, at which the shank bends."""
    return min(column.limit for column in bent_columns(rod, 600.0).values())


def under(rod, solved, **keys):
    return with_overload(replace(rod, study=replace(STUDY, overload=OverloadTable(**keys))), solved)


def test_the_shank_bends_between_first_yield_and_squash(rod):
    for plane, found in bent_columns(rod, 600.0).items():
        formulas = columns(rod)[plane]
        # Sections of a mesh of such elements against those of the dimensions.
        assert found.euler == pytest.approx(formulas.euler, rel=0.05)
        assert found.squash == pytest.approx(formulas.squash, rel=0.05)
        assert found.perry <= found.limit <= min(found.euler, found.squash)
    assert set(bent_columns(rod, 600.0)) == set(Plane)


def test_a_small_overload_leaves_nothing(rod, solved):
    found = under(rod, solved, force_N=15e3).overload
    assert found.state == "elastic"
    assert not any(found.set_um.values())
    assert found.set_judged.exceeded == ()


@pytest.fixture(scope="module")
def flowed(rod, solved, limit):
    return under(rod, solved, force_N=0.97 * limit)


def test_an_overload_near_the_limit_shortens_the_rod(flowed):
    found = flowed.overload
    assert found.state == "flows"
    assert found.safety_factor == pytest.approx(1 / 0.97)
    assert found.max_plastic_strain > 1e-4
    assert found.set_um["length"] < -0.01
    # The load is symmetric about both mirror planes of the rod.
    assert abs(found.set_um["bend"]) + abs(found.set_um["twist_deg"]) + abs(found.set_um["bow"]) < 1e-6
    assert all(check.passed for check in flowed.checks.values())


def test_liquid_bends_the_shank_until_it_has_room(rod, solved, limit):
    volume = np.pi * 76**2 / 4 * STUDY.engine.stroke_mm / 9 / 1e3  # of the chamber, ml
    assert under(rod, solved, liquid_ml=0.3 * volume).overload.state == "elastic"
    some, most = (
        under(rod, solved, liquid_ml=0.99 * 418, energy_J=energy).overload for energy in (60.0, 80.0)
    )
    assert some.state == most.state == "bends"
    assert some.bending.force_N > limit
    assert 0 < some.set_um["bow"] < most.set_um["bow"]
    assert most.set_um["length"] < some.set_um["length"] < 0
    assert under(rod, solved, liquid_ml=volume, energy_J=1.0).overload.bending.force_N < limit


def test_a_force_that_lasts_bends_without_end(rod, solved, limit):
    found = under(rod, solved, force_N=1.1 * limit).overload
    assert (found.state, found.set_um, found.set_judged) == ("bends", None, None)


def test_what_gives_way_has_at_least_the_factor_of_first_yield(rod, solved, limit, monkeypatch):
    """It was 0, and so below that of a larger force."""

    def without_equilibrium(*_):
        raise NoEquilibriumError

    monkeypatch.setattr("fea.plastic.cycling.increment", without_equilibrium)
    found = under(rod, solved, force_N=0.97 * limit).overload
    assert found.state == "collapses"
    assert 0.5 < found.safety_factor == found.safety_factor.low < found.safety_factor.high < 1.0
    verdict = survival([found.safety_factor])
    assert (verdict.answer, verdict.text.split(",")[0]) == ("fails", "gives way under the overload")


def test_the_answer_names_the_overload(rod, solved, mesh, limit):
    study = replace(STUDY, overload=OverloadTable(force_N=0.97 * limit, most_shortening_um=0.0))
    adapted = refined_rod(study, (RPM,), Clock(), None, mesh)
    found = run_result(study, adapted, adapted.at(RPM)).summary
    assert "is left deformed beyond its limits" in found.survival.text
    assert "beyond the limit: distance of the bores (0 µm)" in next(iter(overload_in_full(found)))
    bent = under(rod, solved, force_N=1.25 * limit).overload
    lines = list(overload_in_full(replace(found, overload=bent)))
    assert lines[0].startswith(f"Overload, {1.25 * limit / 1e3:.1f} kN on the rod: it bends ")
    assert "0.80 times the overload; its first fibre yields at " in lines[-1]
    kept = factors(found.results, found.buckling, None, overload=bent)
    assert "gives way under the overload, safety factor 0.80" in survival(kept).text


def test_a_permanent_set_is_what_a_builder_measures(rod):
    mesh, length = rod.mesh.whole, rod.mesh.bores.rod_length
    x, y, _ = mesh.points.T
    shift, turn = np.zeros((2, *mesh.points.shape))
    turn[:] = rigid_motions(mesh.points, np.array([length, 0.0, 0.0]))[4] * 5e-4  # about y
    turn += rigid_motions(mesh.points, np.array([length, 0.0, 0.0]))[3] * 1e-3  # about x
    small = x > length / 2
    shift[small] = turn[small] + [-0.04, 0.0, 0.0]
    found = permanent_set(mesh, length, shift)
    assert found["length"] == pytest.approx(-40.0)
    assert found["bend"] == pytest.approx(50.0)
    assert found["twist_deg"] == pytest.approx(np.degrees(1e-3))
    bowed = np.zeros(mesh.points.shape)
    low, high = rod.mesh.bores.between
    bowed[:, 1] = 0.1 * np.sin(np.pi * np.clip((x - low) / (high - low), 0, 1))
    assert permanent_set(mesh, length, bowed)["bow"] == pytest.approx(100.0, rel=0.02)
    oval = np.zeros(mesh.points.shape)
    oval[~small, :2] = 1e-4 * np.column_stack([x, -y])[~small]
    # r = e x cos φ − e y sin φ = e R cos 2φ: the diameter changes by ±2 e R.
    expected = 4e-4 * rod.mesh.bores.big_radius * 1e3
    assert permanent_set(mesh, length, oval)["big_end"] == pytest.approx(expected, rel=1e-3)
    assert found["small_end"] < 0.1


def test_limits_are_compared_with_what_is_left():
    left = {"length": -60.0, "bend": 10.0, "twist_deg": 0.0, "bow": 3.0, "big_end": 11.0, "small_end": 0.0}
    found = judged(left, OverloadTable().limits)
    assert found.exceeded == ("length", "big_end")
    assert found.least_factor == pytest.approx(40 / 60)
    text = set_in_words(left, found)
    assert text.startswith("60 µm shorter between the bores, the shank bowed by 3 µm")
    assert text.endswith(
        "beyond the limit: distance of the bores (40 µm), big end's bore out of round (10 µm)"
    )


def test_what_is_left_is_a_field_of_the_whole_rod(rod, flowed):
    followed = flowed.flows["overload"]
    fields = followed.left
    count = len(rod.mesh.whole.points)
    assert fields["permanent_displacement"].shape == (count, 3)
    assert fields["stress"].shape == (count, 6)
    # The nodes of an element extrapolate from its Gauss points; the largest of these lies inside.
    largest = flowed.overload.max_plastic_strain
    assert largest / 2 < fields["plastic_strain_percent"].max() / 100 < 2 * largest
    assert fields["plastic_strain_percent"].min() == 0
    # Without load, the mean of the residual stress over the rod vanishes (∫ σ dV = 0, as no force acts).
    every, moved = followed.rod.every, followed.moved
    plastic = every.virgin
    plastic[followed.zone.element] = followed.flow.state.plastic
    stress = every.stress(0 * moved, moved, plastic)
    weight = every.volumes[..., None]
    mean, size = (stress * weight).sum(axis=(0, 1)), (np.abs(stress) * weight).sum(axis=(0, 1))
    assert abs(mean[0]) < 0.02 * size[0]


def test_a_linear_field_is_extrapolated_exactly(rod):
    cell = rod.mesh.cell
    corners = cell.points[cell.tets]
    places = tabulate(10, stiffness_degree(10)).values @ corners
    straight = np.abs(corners[:, 4:] - corners[:, EDGES].mean(axis=2)).max(axis=(1, 2)) < 1e-9
    inner = np.setdiff1d(cell.tets[straight], cell.tets[~straight])
    found = mean_at_nodes(cell, places @ np.array([[2.0], [-1.0], [0.5]]))
    assert len(inner)
    assert found[inner, 0] == pytest.approx(cell.points[inner] @ [2.0, -1.0, 0.5])


def test_the_shortening_is_the_work_of_a_unit_load_on_the_plastic_strain(rod, flowed):
    # Maysel 1941: the work of the load's stress on the plastic strain, ∫ σ:ε_p dV, is that of its force on
    # what is left, as far as the bores, over which the force is spread, move as rigid bodies.
    followed = flowed.flows["overload"]
    zone, u = followed.zone, followed.rod.displacements[0][:, followed.zone.nodes]
    stress = zone.stress(u, 0 * u, zone.virgin)
    copies = rod.mesh.symmetry.copies // len(u)
    work = copies * zone.dissipation(stress, followed.flow.state.plastic)
    expected = -work / flowed.overload.bending.force_N * 1e3
    assert flowed.overload.set_um["length"] == pytest.approx(expected, rel=0.03)
