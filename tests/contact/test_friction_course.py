"""The course of a cycle: its increments, when friction has settled, and which instants are between which."""

from types import SimpleNamespace

import numpy as np
import pytest
from engines import LEON

from fea.base.units import DEG, RPM
from fea.contact.assembled import MOST_CYCLES, ON_END, FrictionCycle, increments
from geometry.mass import MassProperties
from loads.crank_cycle import BEGINNING, CrankCycle
from loads.crank_cycle import INCREMENTS as OF_CYCLE
from loads.gas import NoGas

INCREMENTS = 24


class Settling:
    """Its bolt force and a pressure approach those of a cycle by a factor per increment each."""

    def __init__(self, bolt, place):
        self.factors, self.number = np.array([bolt, place, 0.0]), 0
        self.start, self.bolts = SimpleNamespace(values=np.zeros(3)), np.array([0])
        self.vertices = SimpleNamespace(normal=np.array([1, 2]))

    def step(self, load, state, like=None):
        number, self.number = self.number, self.number + 1
        ideal = 100.0 + np.cos(2 * np.pi * number / INCREMENTS)
        off = self.factors**number
        return SimpleNamespace(values=ideal * (1 + off), number=number)

    def cycle(self):
        return list(increments(self, self, [None] * INCREMENTS))


def test_it_ends_when_states_are_those_of_the_cycle_before():
    rod = Settling(0.5, 0.5)
    states = rod.cycle()
    assert INCREMENTS + ON_END <= len(states) < 2 * INCREMENTS
    assert [state.number for state in states] == list(range(len(states)))


def test_one_place_that_has_not_settled_is_enough_to_go_on():
    calm, slow = Settling(0.6, 0.6), Settling(0.6, 0.92)
    assert len(calm.cycle()) < len(slow.cycle())


def test_what_does_not_settle_ends_as_well():
    assert len(Settling(0.95, 0.0).cycle()) == MOST_CYCLES * INCREMENTS


ROD = MassProperties(0.6e-3, (40.0, 0.0, 0.0), ((0.2, 0.0, 0.0), (0.0, 1.6, 0.0), (0.0, 0.0, 1.5)))


class TwoEnds(Settling):
    """Two ends that settle at different rates; their states tell which increments they are between."""

    def __init__(self):
        super().__init__(0.5, 0.5)
        self.of_ends, self.every = [Between(0.5, 0.5), Between(0.6, 0.92)], range(2)
        self.system = self

    def steps(self, exact, end):
        return self.of_ends[end]

    def together(self, states):
        return states


class Between(Settling):
    """Its instants are the numbers of both increments, and the share."""

    def between(self, loads, ends, shares):
        one, other = (state.number for state in ends)
        return [(load, one, other, share) for load, share in zip(loads, shares, strict=True)]


@pytest.mark.parametrize("threads", [1, 3])
def test_instants_are_between_increments_of_the_last_cycle(threads, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", str(threads))
    rod, places = TwoEnds(), np.random.default_rng(3).permutation(np.arange(0, INCREMENTS, 0.25))
    cycle = FrictionCycle(rod, [None] * INCREMENTS)
    for _ in range(2):  # the second time, the increments are known
        of_ends = zip(*cycle.at(list(range(len(places))), places), strict=True)
        for end, found in zip(rod.of_ends, of_ends, strict=True):
            last = end.number - 1
            for number, (place, state) in enumerate(zip(places, found, strict=True)):
                if place % 1 == 0:
                    one = state.number
                else:
                    load, one, other, share = state
                    assert (load, other, share) == (number, one + 1, place % 1)
                assert one % INCREMENTS == int(place)
                assert last - INCREMENTS <= one < last


def test_increments_are_shorter_where_the_forces_change():
    cycle = CrankCycle(LEON, ROD, NoGas(), 6000 * RPM)
    instants, degrees = cycle.degrees, cycle.increments.crank_angle / DEG
    np.testing.assert_allclose(degrees, np.round(degrees), atol=1e-9)
    assert len(degrees) == OF_CYCLE
    assert degrees[0] == pytest.approx(BEGINNING / DEG)
    lengths = np.diff(np.append(degrees, degrees[0] + 720))
    assert lengths.min() >= 1
    assert lengths.max() <= 2 * 720 / OF_CYCLE + 1
    change = np.linalg.norm(np.diff(np.concatenate([instants.pin, instants.crank]), axis=1), axis=0)
    at = np.round(degrees[:-1]).astype(int) % 720
    assert np.corrcoef(change[at], lengths[:-1])[0, 1] < -0.8


def test_places_tell_the_increments_around_an_instant():
    angles = np.arange(-360.0, 1081.0) * DEG
    cycle = CrankCycle(LEON, ROD, NoGas(), 6000 * RPM)
    places, steps = cycle.places(angles), cycle.increments.crank_angle
    ends = np.append(steps, steps[0] + 720 * DEG)
    before, share = np.floor(places).astype(int), places % 1
    back = (1 - share) * ends[before] + share * ends[before + 1]
    np.testing.assert_allclose(np.cos((back - angles) / 2), 1.0, atol=1e-12)
    for rounding in (-1e-13, 0.0, 1e-13):
        np.testing.assert_array_equal(cycle.places(steps + rounding), np.arange(OF_CYCLE))
