"""The dense contact problem: its optimality conditions, and both of its methods against each other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.contact.active_set import ContactSystem
from fea.solid.errors import ContactError


def problem(seed: int, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A bore of `size` places with a random smooth compliance, a random gap and a random force."""
    draw = np.random.default_rng(seed)
    angle = 2 * np.pi * np.arange(size) / size
    apart = np.abs((angle[:, None] - angle + np.pi) % (2 * np.pi) - np.pi)
    compliance = np.exp(-draw.uniform(1, 8) * apart) + 1e-3 * np.eye(size)
    rigid = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    gap = draw.normal() + 0.3 * draw.normal(size=size)
    return compliance, rigid, gap, 10 ** draw.uniform(-2, 2) * draw.normal(size=2)


drawn = given(seed=st.integers(0, 2**31), size=st.integers(5, 60))


@drawn
@settings(max_examples=60, deadline=None)
def test_a_solution_meets_the_conditions_of_contact(seed, size):
    compliance, rigid, gap, force = problem(seed, size)
    found = ContactSystem(compliance, rigid).solve(gap, force)
    left = compliance @ found.pressure + gap - rigid @ found.motion
    scale = np.abs(gap).max() + np.abs(compliance @ found.pressure).max()
    assert (found.pressure >= 0).all()
    assert left.min() >= -1e-11 * scale
    assert np.abs(left[found.pressure > 0]).max(initial=0) <= 1e-11 * scale
    assert rigid.T @ found.pressure == pytest.approx(force, rel=1e-9, abs=1e-9 * np.abs(force).max())
    assert max(found.residual, found.imbalance) < 1e-9


@drawn
@settings(max_examples=40, deadline=None)
def test_single_exchanges_lead_to_the_same_pressures(seed, size):
    compliance, rigid, gap, force = problem(seed, size)
    system = ContactSystem(compliance, rigid)
    at_once, one_by_one = system.solve(gap, force), system._exchanged(gap, force)
    largest = at_once.pressure.max()
    assert one_by_one.pressure == pytest.approx(at_once.pressure, abs=1e-8 * largest)


@drawn
@settings(max_examples=40, deadline=None)
def test_an_earlier_contact_area_changes_nothing(seed, size):
    compliance, rigid, gap, force = problem(seed, size)
    warm = ContactSystem(compliance, rigid)
    warm.solve(gap[::-1].copy(), -force)
    again, cold = warm.solve(gap, force), ContactSystem(compliance, rigid).solve(gap, force)
    assert again.pressure == pytest.approx(cold.pressure, abs=1e-9 * cold.pressure.max())


@drawn
@settings(max_examples=30, deadline=None)
def test_a_neat_fit_is_linear_in_its_force(seed, size):
    # Without clearance the contact area does not depend on the size of the force.
    compliance, rigid, gap, force = problem(seed, size)
    one, thousand = (
        ContactSystem(compliance, rigid).solve(np.zeros_like(gap), factor * force) for factor in (1.0, 1e3)
    )
    assert thousand.pressure == pytest.approx(1e3 * one.pressure, rel=1e-9, abs=1e-9 * one.pressure.max())


def test_no_force_with_clearance_leaves_no_contact():
    compliance, rigid, _, _ = problem(1, 24)
    found = ContactSystem(compliance, rigid).solve(np.full(24, 0.1), np.zeros(2))
    assert (found.pressure == 0).all()
    assert found.gap.min() > 0


def test_half_a_bore_cannot_be_pulled_away():
    compliance, rigid, gap, _ = problem(1, 24)
    half = rigid[:, 0] > 0.01
    system = ContactSystem(compliance[np.ix_(half, half)], rigid[half])
    with pytest.raises(ContactError, match="resultant"):
        system.solve(gap[half], np.array([-1.0, 0.0]))
