"""The computations that are compared, and their references."""

import math
import shutil
from dataclasses import replace

import pytest
from studies import plain_study

from fea.study.study import load_study
from fea.verify.computations import Computation, compute, extrapolated
from fea.verify.converge import EXACT


def test_richardson_finds_the_limit_of_a_power_law():
    sizes = [4.0, 2.0, 1.0]
    found = extrapolated(sizes, [100 - 3 * size**2 for size in sizes])
    assert found.value == pytest.approx(100)
    # Grid convergence index: 1.25 times the distance from the finest, here 3 of 97.
    assert found.uncertainty_percent == pytest.approx(100 * 1.25 * 3 / 97)


def test_values_that_scatter_are_uncertain_by_their_spread():
    found = extrapolated([4.0, 2.0, 1.0], [99.0, 101.0, 100.0])
    assert found.value == 100.0
    assert found.uncertainty_percent == pytest.approx(2.0)


def test_two_meshes_tell_nothing_of_the_uncertainty():
    assert extrapolated([2.0, 1.0], [99.0, 100.0]).uncertainty_percent == math.inf


@pytest.mark.parametrize("problem", ["lame", "goodier"])
def test_surface_recovery_beats_the_mean_on_exact_problems(problem):
    size = 2.0 if problem == "lame" else 0.25
    truth = EXACT[problem]
    error = {
        tool: abs(compute(Computation(tool, "p2", problem, size), load_study()).value / truth - 1)
        for tool in ("fea", "fea, mean")
    }
    assert error["fea"] < error["fea, mean"] < 0.1


def test_quarter_and_whole_give_the_same_peak():
    study = plain_study()
    quarter, whole = (compute(Computation(tool, "p2", "rod", 14.0), study) for tool in ("fea", "fea, whole"))
    assert quarter.value == pytest.approx(whole.value, rel=1e-6)
    assert quarter.dofs == whole.dofs


def study_in_contact():
    study = plain_study()
    return replace(study, analysis=replace(study.analysis, pressure="contact"))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
@pytest.mark.parametrize("study", [plain_study(), study_in_contact()], ids=["prescribed", "contact"])
def test_calculix_is_given_the_forces_of_the_pins(study):
    # Both solve the same equations of first order; CalculiX prints six digits of the stress.
    ours, theirs = (compute(Computation(tool, "p1", "rod", 8.0), study) for tool in ("fea, mean", "CalculiX"))
    assert theirs.value == pytest.approx(ours.value, rel=1e-4)
    assert ours.bar_percent > 0
    assert theirs.bar_percent is None
