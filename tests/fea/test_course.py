"""When a cycle with friction has settled: states of a made-up rod that comes to rest at a given rate."""

from types import SimpleNamespace

import numpy as np

from fea.contact.friction_cycle import MOST_CYCLES, ON_END, increments

INCREMENTS = 24


class Settling:
    """Its bolt force and a pressure approach those of a cycle by a factor per increment each."""

    def __init__(self, bolt, place):
        self.factors, self.steps = np.array([bolt, place, 0.0]), 0
        self.start, self.bolts = None, np.array([0])
        self.touching = SimpleNamespace(normal=np.array([1, 2]))

    def step(self, load, state, like=None, exact=None):
        number, self.steps = self.steps, self.steps + 1
        ideal = 100.0 + np.cos(2 * np.pi * number / INCREMENTS)
        off = self.factors**number
        return SimpleNamespace(values=ideal * (1 + off), number=number)

    def cycle(self):
        return increments(self, [None] * INCREMENTS)


def test_it_ends_when_states_are_those_of_the_cycle_before():
    rod = Settling(0.5, 0.5)
    states = rod.cycle()
    assert INCREMENTS + ON_END <= rod.steps < 2 * INCREMENTS
    assert [state.number % INCREMENTS for state in states] == list(range(INCREMENTS))
    assert max(state.number for state in states) == rod.steps - 1


def test_one_place_that_has_not_settled_is_enough_to_go_on():
    calm, slow = Settling(0.6, 0.6), Settling(0.6, 0.92)
    calm.cycle()
    slow.cycle()
    assert calm.steps < slow.steps


def test_what_does_not_settle_ends_as_well():
    rod = Settling(0.95, 0.0)
    assert len(rod.cycle()) == INCREMENTS
    assert rod.steps == MOST_CYCLES * INCREMENTS
