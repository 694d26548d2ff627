"""Small dense problems of parts, friction and pins, against their laws and the solver for pins alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.contact.active_set import ContactSystem
from fea.contact.block import Guess, Places
from fea.contact.friction_system import FrictionSystem, Load, Steps
from fea.contact.problem import CondensedInterface
from fea.contact.trial import Linear
from fea.solid.errors import ContactError

PINS, PLACES = 14, 9
SEEDS = st.integers(0, 10**6)


class Problem:
    """Pins that press on parts which touch at places with two shear stresses each, or none."""

    def __init__(self, seed, friction):
        self.rng = np.random.default_rng(seed)
        shears = 2 * PLACES if friction else 0
        self.n = PINS + PLACES + shears
        root = self.rng.normal(size=(self.n, 2 * self.n))
        self.C = root @ root.T / self.n + np.eye(self.n)
        self.pins, self.normal = np.arange(PINS), np.arange(PINS, PINS + PLACES)
        self.R = np.zeros((self.n, 2))
        self.R[:PINS] = self.rng.normal(size=(PINS, 2))
        self.P = self.rng.normal(size=(self.n, 3))
        self.mu = np.full(PLACES, friction)
        shear = PLACES + np.arange(2 * PLACES).reshape(PLACES, 2)
        self.places = Places(
            normal=np.arange(PLACES),
            tangential=shear if friction else np.full((PLACES, 2), -1),
            friction=self.mu,
            bolt=np.zeros(PLACES, dtype=bool),
            frictional=np.full(PLACES, bool(friction)),
        )
        self.condensed = CondensedInterface.of(self.C, self.P, self.pins)
        self.system = FrictionSystem(self.condensed, self.R, self.places)
        self.gap = self.rng.normal(size=self.n)
        self.gap[self.normal] -= 5.0  # a press fit

    def load(self, size=0.3):
        """Forces that some pressures of the pins and stresses between the parts have."""
        inner = np.abs(self.rng.normal(size=self.n))
        return Load(
            self.gap + size * self.rng.normal(size=self.n),
            size * self.R.T @ np.where(np.arange(self.n) < PINS, inner, 0.0),
            size * self.P.T @ inner,
        )

    def start(self):
        return np.zeros(self.n - PINS), Guess.closed(PINS, PLACES)


def obeys(problem, load, before, found):
    """Compare with the laws, from the problem as it was before anything was condensed."""
    gap, friction = found.gap, problem.mu[0]
    values, size = found.values, np.abs(found.values).max()
    open_gap = problem.C @ values + load.gap - problem.P @ problem.system.part_motion(found)
    np.testing.assert_allclose(open_gap[PINS:], gap, atol=1e-8 * np.abs(open_gap).max())
    np.testing.assert_allclose(problem.P.T @ values, load.parts, atol=1e-8 * size)
    np.testing.assert_allclose(problem.R.T @ values, load.pins, atol=1e-8 * size)
    pressure, opened = values[problem.normal], gap[:PLACES]
    assert pressure.min() >= -1e-9 * size
    assert opened.min() >= -1e-9 * np.abs(open_gap).max()
    assert np.abs(pressure * opened).max() < 1e-9 * size * np.abs(open_gap).max()
    shear = values[problem.places.tangential + PINS]
    slip = (gap - before)[problem.places.tangential]
    limit = friction * np.maximum(pressure, 0.0)
    assert (np.hypot(*shear.T) <= limit + 1e-8 * size).all()
    slides = (np.hypot(*slip.T) > 1e-4 * np.abs(gap).max()) & (opened <= 0)
    against = -limit[slides, None] * slip[slides] / np.hypot(*slip[slides].T)[:, None]
    np.testing.assert_allclose(shear[slides], against, atol=1e-5 * size)


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_without_friction_it_is_the_problem_of_pins(seed):
    problem = Problem(seed, 0.0)
    load = problem.load()
    found = Steps(problem.system).at_once(load, *problem.start())
    every = ContactSystem(problem.C, np.hstack([problem.R, problem.P]))
    direct = every.solve(load.gap, np.concatenate([load.pins, load.parts]))
    np.testing.assert_allclose(found.values, direct.pressure, atol=1e-8 * np.abs(direct.pressure).max())
    moved = problem.system.part_motion(found)
    np.testing.assert_allclose(moved, direct.motion[2:], atol=1e-8 * np.abs(direct.motion).max())


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(0.05, 1.0))
def test_every_law_holds_along_a_path(seed, friction):
    problem = Problem(seed, friction)
    gap, guess = problem.start()
    for _ in range(4):
        load, before = problem.load(), gap
        found = Steps(problem.system).at_once(load, gap, guess)
        gap, guess = found.gap, found.guess
        obeys(problem, load, before, found)


def test_a_part_that_only_friction_would_hold_is_named():
    problem = Problem(5, 0.0)
    alone = problem.P.copy()
    alone[PINS:, 2] = 0.0  # nothing between the parts resists this motion, and no pin does
    alone[:PINS, 2] = 0.0
    condensed = CondensedInterface.of(problem.C, alone, problem.pins)
    system = FrictionSystem(condensed, problem.R, problem.places, ["the cap", "the cap", "the bushing"])
    with pytest.raises(ContactError, match="the bushing slides away"):
        Steps(system).at_once(problem.load(), *problem.start())


def test_without_friction_the_path_does_not_matter():
    problem = Problem(7, 0.0)
    loads = [problem.load() for _ in range(3)]
    gap, guess = problem.start()
    for load in loads:
        found = Steps(problem.system).at_once(load, gap, guess)
        gap, guess = found.gap, found.guess
    alone = Steps(problem.system).at_once(loads[-1], *problem.start())
    np.testing.assert_allclose(found.values, alone.values, atol=1e-10 * np.abs(alone.values).max())


def test_with_friction_it_does():
    problem = Problem(7, 0.3)
    loads = [problem.load(1.0) for _ in range(3)]
    gap, guess = problem.start()
    for load in loads:
        found = Steps(problem.system).at_once(load, gap, guess)
        gap, guess = found.gap, found.guess
    alone = Steps(problem.system).at_once(loads[-1], *problem.start())
    assert np.abs(found.values - alone.values).max() > 1e-3 * np.abs(alone.values).max()


@pytest.mark.parametrize("name", ["touching", "opened", "slipping", "direction", "ratio"])
def test_guesses_are_the_same_where_they_say_the_same(name):
    guess = Guess.closed(PINS, PLACES)
    guess.slipping[:3] = True
    guess.direction[:3], guess.ratio[:3] = [1.0, 0.0], 0.5
    other = replace(guess, **{name: getattr(guess, name).copy()})
    assert guess.equals(other)
    changed = getattr(other, name)
    changed[1] = ~changed[1] if changed.dtype == bool else 0.9 * changed[1]
    assert not guess.equals(other)
    silent = replace(guess, direction=guess.direction + (~guess.slipping)[:, None])
    assert guess.equals(silent)  # of what does not slip there is no direction


@pytest.mark.parametrize("frictional", [True, False])
def test_what_an_earlier_step_left_changes_nothing(frictional, monkeypatch):
    set_up, of = [], Linear.of
    monkeypatch.setattr(Linear, "of", lambda *given: set_up.append(given) or of(*given))
    problem = Problem(11, 0.3)
    remembering = Steps(problem.system)
    gap, guess = problem.start()
    for number in range(4):
        load = problem.load(0.05)
        fresh = Steps(problem.system).at_once(load, gap, guess, frictional=frictional)
        set_up.clear()
        found = remembering.at_once(load, gap, guess, frictional=frictional)
        assert len(set_up) == found.changes - (number > 0)  # what is begun with was solved for before
        np.testing.assert_allclose(found.values, fresh.values, atol=1e-11 * np.abs(fresh.values).max())
        gap, guess = found.gap, found.guess


def test_given_slip_is_kept():
    problem = Problem(3, 0.2)
    gap, guess = problem.start()
    gap[problem.places.tangential] = problem.rng.normal(size=(PLACES, 2))
    found = Steps(problem.system).at_once(problem.load(), gap, guess, frictional=False)
    closed = ~found.guess.opened
    assert closed.any()
    given_slip = gap[problem.places.tangential[closed]]
    assert found.gap[problem.places.tangential[closed]] == pytest.approx(given_slip)
