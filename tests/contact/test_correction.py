"""Corrections of guesses that come back to where they were."""

from dataclasses import dataclass, replace

import numpy as np

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
