"""The state of one block of unknowns: guesses of what touches, opens and slips, until one obeys every law."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from fea.contact.active_set import BALANCE, balanced
from fea.contact.block import Block
from fea.contact.guess import Guess, Offsets
from fea.contact.trial import Exact, Trial
from fea.solid.errors import ContactError, UnsettledError
from geometry.arrays import Floats, Mask

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
    """

    def __init__(self, exact: Exact) -> None:
        self._exact = exact
        self._seen = set[bytes]()
        self._least = np.zeros(3)
        self._eager = _EAGER
        self.in_circle = False  #: whether single changes, too, return to a guess

    def of(self, trial: Trial) -> Guess | None:
        """Return the next guess, or None if this one obeys every law."""
        if trial.obeys(self._exact):
            return None
        eager = self._eager > 0
        self._eager -= 1
        pins, normal, _ = trial.violations
        kind = 2 if eager else 0 if pins.any() else 1 if normal.any() else 2
        wrong = []
        for number, (violation, least) in enumerate(zip(trial.violations, self._least, strict=True)):
            worst = (violation > 0) & (violation >= least * violation.max(initial=0.0))
            wrong.append(worst if number <= kind else np.zeros_like(worst))
        better = trial.corrected(*wrong)
        if any(violation.any() for violation in wrong):
            key = np.packbits(np.concatenate([better.touching, better.opened, better.slipping])).tobytes()
            returned = key in self._seen
            self._seen = {key} if returned else self._seen | {key}
            if returned and self._eager > 0:
                self._eager = 0
            elif returned:
                self.in_circle = self.in_circle or bool(self._least[kind] == 1)
                halfway = (1 + self._least[kind]) / 2
                self._least[kind] = halfway if halfway < _SINGLE else 1.0
        return better


# States that are tried at most.
_MOST = 300
UNSETTLED = (
    "contact and friction between the parts did not settle: choose a larger --size or another "
    "assembly.joint_friction"
)


class BlockSearch:
    """Searches the state of a block.

    `loose` (m, k) is the share of the motions that only the pins resist in those of the parts; they are the
    last of all `motions` of the pins. `names` (k,) are those of the parts that these motions move, with their
    articles.
    """

    def __init__(self, loose: Floats, motions: int, names: Sequence[str] = ()) -> None:
        self._loose, self._motions, self._names = loose, motions, names

    def __call__(self, problem: tuple[Block, Offsets, Guess, Exact, Trial | None]) -> tuple[Trial, int]:
        """Find the solution of a block, and how many states were tried.

        Parameters
        ----------
        problem
            A block, its sticking state, the first guess, the exactness of the laws, an earlier solution.

        Raises `ContactError`: no pressure of the pins has their forces; `UnsettledError`: no state was found
        that obeys contact and friction.
        """
        block, offsets, guess, exact, trial = problem
        correction = Correction(exact)
        for change in range(1, _MOST + 1):
            trial = Trial.of(block, offsets, guess, trial)
            better = correction.of(trial)
            # Without pins, nothing balances what rounding leaves of loads that balance.
            balance = trial.imbalance <= BALANCE or not block.R.size
            if better is None and balance:
                return trial, change
            # Where slip is given that friction does not allow, a place is wrong whether open or closed.
            if correction.in_circle and not trial.block.rubs:
                break
            guess = better or guess
            if not balance and change == 1:
                # Too few places of the pins touch for their forces.
                guess = replace(guess, touching=guess.touching | self._balancing(block, offsets.forces))
            elif better is None:
                guess = replace(guess, touching=guess.touching | self._stopping(trial))
        if trial is None or trial.imbalance <= BALANCE:
            raise UnsettledError(UNSETTLED)
        raise self._unresisted(trial)

    def _balancing(self, block: Block, forces: Floats) -> Mask:
        """Which pressures (n_p,) of the pins can have the resultants along R together."""
        try:
            return balanced(block.R, forces) > 0
        except ContactError as error:
            if not len(self._loose):
                raise
            left = forces - block.R.T @ nnls(block.R.T, forces)[0]
            raise ContactError(self._slides(block, left)) from error

    def _stopping(self, trial: Trial) -> Mask:
        """Which pressures (n_p,) of the pins stop a motion that those that touch do not resist."""
        closing = np.where(trial.guess.touching, 0.0, trial.block.R @ trial.left)
        ahead = closing > BALANCE * np.abs(closing).max(initial=0.0)
        if not ahead.any():
            raise self._unresisted(trial)
        way = np.divide(trial.solution.pin_gap, closing, out=np.full(len(closing), np.inf), where=ahead)
        return np.asarray(way <= way.min())

    def _unresisted(self, trial: Trial) -> UnsettledError:
        """Return the error of a motion of the pins or of a part that nothing resists."""
        return UnsettledError(self._slides(trial.block, trial.left) if len(self._loose) else UNSETTLED)

    def _slides(self, block: Block, resultants: Floats) -> str:
        """Say which part slides away: that on which most of the resultants (m,) is left."""
        left = np.zeros(self._motions)
        left[block.motions] = resultants
        moved = np.abs(left[-len(self._loose) :] @ self._loose)
        name = self._names[int(moved.argmax())] if len(self._names) else "a part"
        return (
            f"{name} slides away, because nothing but friction holds it: give assembly.joint_friction, or "
            "shells that centre the cap"
        )
