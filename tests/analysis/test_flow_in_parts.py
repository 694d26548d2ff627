"""Plastic flow of a bolted rod, whose contact is held as in the elastic rod, on large elements."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from assemblies import EVERY, SIMPLE, study

from fea.analysis.flow import with_flow
from fea.analysis.flowing_rod import flowing_under
from fea.analysis.pipeline import prepare, solve_speed
from fea.contact.assembled import TemperatureChange
from fea.plastic.cycling import PlasticAnswer
from fea.solid.parity import Parity
from fea.study.option_tables import MeshTable
from loads.instants import given

pytestmark = pytest.mark.usefixtures("coarse_bores")

BARE = replace(EVERY, bushing_interference_mm=None, shell_thickness_mm=None, shell_interference_mm=None)
STUDY = replace(study(BARE, rod=replace(SIMPLE, bushing=0.0, oil_hole=0.0)), mesh=MeshTable(size_mm=24.0))


@pytest.fixture(scope="module")
def rod():
    return prepare(STUDY)


@pytest.fixture(scope="module")
def parts(rod):
    return rod.assembly_contact.assembly.assembled


def test_a_part_that_is_moved_as_a_whole_fits_again_without_stress(parts):
    even = dict(parts.motions)[Parity.SYMMETRIC]
    share, back = parts.refitted(even, 0 * even)
    assert share < 1e-6
    assert back[Parity.SYMMETRIC].ravel() == pytest.approx(-even, abs=1e-9 * np.abs(even).max())


def test_what_a_displacement_changes_is_what_the_contact_solver_finds_of_a_small_one(rod, parts):
    """The rod shrinks along the bolts by 10⁻⁶: nothing opens or slips, so that contact is linear."""
    shrinks = np.zeros_like(rod.mesh.cell.points)
    shrinks[:, 0] = -1e-6 * rod.mesh.cell.points[:, 0]
    share, _ = parts.refitted(shrinks.ravel(), 0 * shrinks.ravel())
    other = copy(parts)
    other.warming = TemperatureChange(shrinks.ravel(), np.zeros(parts.problem.pulls), (0.0, 0.0))
    other = other.tightened_to(EVERY.bolt_preload_kN * 1e3)
    change = {
        "pressures": (other.start.values - parts.start.values)[parts.vertices.normal],
        "bolts": (other.start.values - parts.start.values)[parts.bolts],
    }
    largest = parts.start.values[parts.vertices.normal].max(), parts.start.values[parts.bolts].max()
    expected = max(np.abs(own).max() / most for own, most in zip(change.values(), largest, strict=True))
    assert share == pytest.approx(expected, rel=1e-3)


def test_bolts_keep_their_preload_at_any_multiple_of_the_loads(rod):
    flowing = flowing_under(rod, given(-30e3).named("pressed")[None])
    nothing, once, twice = (flowing._times(scale)[0] for scale in (0.0, 1.0, 2.0))
    assert nothing == pytest.approx(flowing.displacements[1])  # no load but the bolts
    assert twice - once == pytest.approx(once - nothing)
    assert np.abs(nothing).max() > 0


@pytest.fixture(scope="module")
def weak(rod):
    """The rod with a yield strength of 0.97 of its largest stress, and its load cases."""
    elastic = solve_speed(rod, 6000.0)
    largest = max(case.max_von_mises for case in elastic.cases.values())
    material = replace(STUDY.material, yield_MPa=0.97 * largest, cyclic_yield_MPa=0.97 * largest)
    own = prepare(replace(STUDY, material=material))
    return own, solve_speed(own, 6000.0)


def test_a_bolted_rod_that_yields_shakes_down(weak):
    found = with_flow(*weak)
    assert found.plastic.state == PlasticAnswer.SHAKES_DOWN
    assert found.plastic.collapse_factor > 1
    assert found.flows["plastic"].contact_change < 0.05
    assert all(check.passed for name, check in found.checks.items() if name.startswith("plastic"))
    assert any("contact between the parts as in the elastic rod" in note.text for note in found.notes)


def test_flow_that_would_change_the_contact_is_not_said_to_settle(weak, monkeypatch):
    monkeypatch.setattr("fea.analysis.flow.HELD", -1.0)
    found = with_flow(*weak)
    assert found.plastic.state == PlasticAnswer.UNDECIDED
    assert any("too much to be left out" in note.text for note in found.notes)
