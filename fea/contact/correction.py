"""From a guess that violates contact or friction to the next one."""

import numpy as np

from fea.contact.guess import Guess
from fea.contact.trial import Exact, Trial
from geometry.arrays import Mask

# Guesses in the beginning that change everything at once.
_EAGER = 40
# Share of the largest violation from which on only the worst place is changed.
_SINGLE = 0.8


class Correction:
    """Corrects guesses until one obeys every law.

    A semismooth Newton method changes all places that are wrong. If that does not settle, pins come first and
    friction comes last, because what the parts do under a wrong load of the pins says nothing about friction.
    Where the method returns to a guess, it runs in a circle: from then on, only the worst places of that kind
    are changed, fewer each time, down to single ones.

    Parameters
    ----------
    exact
        How exactly the laws shall hold.
    """

    def __init__(self, exact: Exact) -> None:
        self._exact = exact
        self._seen = set[bytes]()
        self._least = np.zeros(3)
        self._eager = _EAGER
        self._round = False

    def of(self, trial: Trial) -> Guess | None:
        """Return the next guess, or None if this one obeys every law."""
        if trial.obeys(self._exact):
            return None
        eager = self._eager > 0
        self._eager -= 1
        pins, normal, friction = trial.violations
        kind = 2 if eager else 0 if pins.any() else 1 if normal.any() else 2
        wrong = [
            (own > 0) & (own >= least * own.max(initial=0.0)) if number <= kind else np.zeros_like(own, bool)
            for number, (own, least) in enumerate(zip((pins, normal, friction), self._least, strict=True))
        ]
        found = trial.corrected(*wrong)
        if any(own.any() for own in wrong):
            self._remember(found, kind)
        return found

    def hopeless(self, trial: Trial) -> bool:
        """Whether no correction leads on: a place is wrong when it is open, and also when it is closed.

        This is so where slip is given that friction does not allow: single changes run in a circle.
        """
        return self._round and not trial.block.rubs

    def _remember(self, guess: Guess, kind: int) -> None:
        key = _key(guess.touching, guess.opened, guess.slipping)
        if key not in self._seen:
            self._seen.add(key)
            return
        self._seen = {key}
        if self._eager > 0:
            self._eager = 0
            return
        self._round = self._round or bool(self._least[kind] == 1)
        halfway = (1 + self._least[kind]) / 2
        self._least[kind] = halfway if halfway < _SINGLE else 1.0


def _key(*masks: Mask) -> bytes:
    return np.packbits(np.concatenate(masks)).tobytes()
