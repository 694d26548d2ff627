"""Corrections of guesses that come back to where they were."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from fea.contact.block import Guess
from fea.contact.friction_system import GuessCorrection
from fea.contact.trial import TOLERANCES


@dataclass(frozen=True)
class Circling:
    """Two pressures of pins of which exactly one acts; both are wrong whenever they are the same."""

    guess: Guess

    def obeys(self, exact):
        return bool(self.guess.touching[0] != self.guess.touching[1])

    @property
    def violations(self):
        return np.array([1.0, 0.5]), np.zeros(1), np.zeros(1)

    def corrected(self, pins, normal, friction):
        return replace(self.guess, touching=self.guess.touching ^ pins)


def test_where_all_places_circle_single_ones_are_changed():
    guess, correction = Guess.closed(2, 1), GuessCorrection(TOLERANCES)
    for _ in range(40):
        better = correction.of(Circling(guess))
        if better is None:
            break
        guess = better
    assert Circling(guess).obeys(TOLERANCES)


class Turning(Circling):
    """Both are always wrong, and a place slips along a direction that turns by a share of the last turn."""

    share = 0.5

    def obeys(self, exact):
        return False

    @property
    def violations(self):
        return np.array([1.0, 1.0]), np.zeros(1), np.zeros(1)

    def corrected(self, pins, normal, friction):
        guess = super().corrected(pins, normal, friction)
        return replace(guess, direction=1 + self.share * (guess.direction - 1))


class TurningOn(Turning):
    share = 1.5


@pytest.mark.parametrize(("kind", "settles"), [(Turning, True), (TurningOn, False)])
def test_a_circle_is_one_where_the_slip_keeps_its_direction(kind, settles):
    guess, correction = Guess.closed(2, 1), GuessCorrection(TOLERANCES)
    for _ in range(60):
        guess = correction.of(kind(guess))
        if correction.in_circle:
            break
    assert correction.in_circle == settles
