"""One guess of what touches, opens and slips: its linear problem, and how it violates contact or friction."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fea.contact.block import Block
from fea.contact.dense import Factor, solved
from fea.contact.guess import Guess, Offsets
from fea.contact.law import Law
from geometry.arrays import Floats, Ints, Mask

# What rounding leaves, relative to the largest stress.
ROUNDING = 1e-11
# Rows of a matrix are gathered where no more than one out of so many is needed.
_SPARSE = 4


class Exact(NamedTuple):
    """How exactly laws shall hold, relative to the largest stress.

    Attributes
    ----------
    violation
        Of contact and friction.
    direction
        Error of the shear stress where places slip, which Newton's method makes small at once.
    """

    violation: float = ROUNDING
    direction: float = 1e-9


EXACT = Exact()


@dataclass(frozen=True)
class Trial:
    """The solution of a guess.

    Attributes
    ----------
    block, offsets, guess
        What it belongs to.
    pressure
        (n_p,) of the pins, MPa.
    motion
        (m,) of the pins.
    moved
        (n_J,) change of the gaps in the step.
    stress
        λ_J (n_J,).
    pin_gap
        (n_p,) moments of the gaps of the pins.
    unknown, factor
        Which pressures and gaps were unknown, and a factor of their matrix.
    """

    block: Block
    offsets: Offsets
    guess: Guess
    pressure: Floats
    motion: Floats
    moved: Floats
    stress: Floats
    pin_gap: Floats
    unknown: bytes
    factor: Factor | None

    @classmethod
    def of(cls, block: Block, offsets: Offsets, guess: Guess, last: "Trial | None" = None) -> "Trial":
        """Solve for what touches, opens and slips.

        Parameters
        ----------
        block, offsets, guess
            See the class.
        last
            An earlier trial; where only the directions of slip have changed, its factor is of use.
        """
        active = np.flatnonzero(guess.touching)
        law = Law.of(block, guess)
        moving, unit, R = law.moving, law.unit, block.R
        n_a, n_d = len(active), len(moving)
        press = 1 / np.sqrt(block.soft[active])
        pins, gaps, motions = slice(0, n_a), slice(n_a, n_a + n_d), slice(n_a + n_d, None)
        matrix = np.zeros((n_a + n_d + R.shape[1],) * 2)
        np.multiply(press[:, None] * block.A[active][:, active], press, out=matrix[pins, pins])
        np.multiply(press[:, None] * block.B[moving][:, active].T, unit, out=matrix[pins, gaps])
        rigid = press[:, None] * R[active]
        reach = np.linalg.norm(rigid, axis=0)
        reach = 1 / np.where(reach > 0, reach, 1.0)
        matrix[motions, pins] = (rigid * reach).T
        matrix[pins, motions] = -matrix[motions, pins].T
        law.of_rows(block.B, active, matrix[gaps, pins])
        law.of_rows(block.S, moving, matrix[gaps, gaps])
        matrix[gaps, pins] *= -press
        matrix[gaps, gaps] *= unit
        law.give_way(matrix[gaps, gaps])
        side = np.concatenate(
            [-press * offsets.pin_gap[active], -law.of_values(offsets.stress), reach * offsets.forces]
        )
        unknown = active.tobytes() + moving.tobytes()
        known = last.factor if last is not None and last.unknown == unknown else None
        found, factor = solved(matrix, side, known)
        pressure, moved = np.zeros(len(block.pins)), np.zeros(len(block.joined))
        pressure[active], moved[moving] = press * found[pins], unit * found[gaps]
        motion = reach * found[motions]
        return cls(
            block=block,
            offsets=offsets,
            guess=guess,
            pressure=pressure,
            motion=motion,
            moved=moved,
            stress=offsets.stress
            - _combined(block.by_pins, pressure, active)
            + _combined(block.S, moved, moving),
            pin_gap=_combined(block.A, pressure, active)
            + _combined(block.B, moved, moving)
            + offsets.pin_gap
            - R @ motion,
            unknown=unknown,
            factor=factor,
        )

    @property
    def gap(self) -> Floats:
        """y_J (n_J,) at the end of the step; exactly zero where places are closed."""
        found = self.offsets.gap + self.moved
        found[self.block.places.normal[~self.guess.opened]] = 0.0
        return found

    @cached_property
    def _normal(self) -> Floats:
        return np.asarray(self.stress[self.block.places.normal])

    @cached_property
    def _tangential(self) -> tuple[Floats, Floats]:
        """Shear stress (k, 2), and the same less the slip that the stiffness turns into a stress."""
        own, at = self.block.places.tangential >= 0, self.block.places.tangential
        shear, slip = (np.where(own, values[at], 0.0) for values in (self.stress, self.moved))
        return shear, shear - self.block.against[:, None] * slip

    @cached_property
    def size(self) -> float:
        """Largest stress, MPa."""
        pressed = np.abs(self._normal[~self.block.places.bolt]).max(initial=0.0)
        return float(max(pressed, np.abs(self.pressure).max(initial=0.0), self.offsets.least))

    @cached_property
    def _allowed(self) -> Floats:
        return np.asarray(self.block.places.friction * np.maximum(self._normal, 0.0))

    @cached_property
    def violations(self) -> tuple[Floats, Floats, Floats]:
        """By how much pins, normal contact and friction are violated, MPa; 0 where the guess is right."""
        guess, stiff = self.guess, self.block.stiff[self.block.places.normal]
        pins = np.where(guess.touching, -self.pressure, -self.pin_gap / self.block.soft)
        gaps = (self.offsets.gap + self.moved)[self.block.places.normal]
        normal = np.where(guess.opened, -gaps * stiff, -self._normal)
        _, trial = self._tangential
        excess = np.hypot(*trial.T) - self._allowed
        wrong = np.where(guess.slipping, -excess, excess) * (self.block.places.rubbing & ~guess.opened)
        little = ROUNDING * self.size
        return tuple(np.where(values > little, values, 0.0) for values in (pins, normal, wrong))  # type: ignore[return-value]

    @cached_property
    def _turned(self) -> Floats:
        """Error (k,) of the direction of the shear stress where places slip, MPa."""
        shear, trial = self._tangential
        slips = self.guess.slipping & ~self.guess.opened
        off = shear - self._allowed[:, None] * _unit(trial)
        return np.asarray(np.where(slips, np.hypot(*off.T), 0.0))

    @property
    def residual(self) -> float:
        """Largest violation of contact or friction, relative to the largest stress."""
        worst = max(float(values.max(initial=0.0)) for values in (*self.violations, self._turned))
        return worst / self.size

    @cached_property
    def left(self) -> Floats:
        """Resultants (m,) that the pressures of the pins do not have."""
        return np.asarray(self.offsets.forces - self.block.R.T @ self.pressure)

    @cached_property
    def imbalance(self) -> float:
        """Error of the resultants of the pins, relative to them."""
        size = float(np.linalg.norm(self.offsets.forces))
        return float(np.linalg.norm(self.left)) / size if size > 0 else 0.0

    def obeys(self, exact: "Exact") -> bool:
        """Whether every law holds."""
        worst = max(float(values.max(initial=0.0)) for values in self.violations)
        turned = float(self._turned.max(initial=0.0))
        return worst <= exact.violation * self.size and turned <= exact.direction * self.size

    def corrected(self, pins: Mask, normal: Mask, friction: Mask) -> Guess:
        """Return the guess that follows from this one.

        Parameters
        ----------
        pins, normal, friction
            (n_p,), (k,), (k,) where it is wrong about what touches, opens and slips.
        """
        guess = self.guess
        opened = guess.opened ^ normal
        _, trial = self._tangential
        length = np.hypot(*trial.T)
        # Where slip would turn round, there is none.
        turns_round = guess.slipping & ((guess.direction * trial).sum(axis=1) < 0)
        slipping = (guess.slipping ^ friction) & ~opened & ~turns_round
        slipping |= guess.opened & ~opened & self.block.places.rubbing & (length > 0)
        ratio = np.divide(self._allowed, length, out=np.zeros_like(length), where=length > 0)
        return replace(
            guess,
            touching=guess.touching ^ pins,
            opened=opened,
            slipping=slipping,
            direction=np.where(slipping[:, None], _unit(trial), 0.0),
            ratio=np.where(slipping, np.minimum(ratio, 1.0), 0.0),
        )


def _combined(rows: Floats, weights: Floats, which: Ints) -> Floats:
    """Sum (k,) of the rows of a matrix (n, k) with weights (n,), of which only some are not zero."""
    if len(which) * _SPARSE < len(weights):
        return np.asarray(weights[which] @ rows[which])
    return np.asarray(weights @ rows)


def _unit(vectors: Floats) -> Floats:
    length = np.hypot(*vectors.T)[:, None]
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
