"""The linear problem of a guess of what touches, opens and slips, in terms of unknowns of unit stiffness."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fea.contact.block import Block
from fea.contact.dense import Factor, solved
from fea.contact.guess import Guess, Offsets
from fea.contact.law import Law
from geometry.arrays import Floats, Ints


class Solution(NamedTuple):
    """What solves it.

    Attributes
    ----------
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
    """

    pressure: Floats
    motion: Floats
    moved: Floats
    stress: Floats
    pin_gap: Floats


@dataclass(frozen=True)
class Linear:
    """The pressures of the pins that touch, the gaps of what opens or slips, and the motions of the pins.

    Attributes
    ----------
    block, guess, law
        What it belongs to, and the law of the gaps.
    active
        (n_a,) which pressures of the pins act.
    matrix
        (n, n).
    by_pins, by_slip
        (n_J, n_a), (n_J, n_d) what pressures and gaps do to the stresses between the parts.
    reach
        (m,) the scale of the motions.
    """

    block: Block
    guess: Guess
    law: Law
    active: Ints
    matrix: Floats
    by_pins: Floats
    by_slip: Floats
    reach: Floats

    @classmethod
    def of(cls, block: Block, guess: Guess) -> "Linear":
        """Set it up."""
        active, law, scaled = np.flatnonzero(guess.touching), Law.of(block, guess), block.effects.scaled
        by_pins, by_slip = np.take(scaled.B, active, axis=1), np.take(scaled.S, law.moving, axis=1)
        rigid = block.effects.press[active, None] * block.R[active]
        reach = np.linalg.norm(rigid, axis=0)
        reach = 1 / np.where(reach > 0, reach, 1.0)
        n_a, n = len(active), len(active) + len(law.moving)
        pins, gaps, motions = slice(0, n_a), slice(n_a, n), slice(n, None)
        matrix = np.zeros((n + len(reach),) * 2)
        matrix[pins, pins] = scaled.A[active][:, active]
        matrix[pins, gaps] = by_pins[law.moving].T
        matrix[gaps, pins] = -law.of_rows(by_pins)
        matrix[gaps, gaps] = law.of_rows(by_slip)
        law.give_way(matrix[gaps, gaps])
        matrix[motions, pins] = (rigid * reach).T
        matrix[pins, motions] = -matrix[motions, pins].T
        return cls(block, guess, law, active, matrix, by_pins, by_slip, reach)

    def belongs_to(self, block: Block, guess: Guess) -> bool:
        """Whether it is the problem of a guess."""
        return self.block is block and self.guess.equals(guess)

    def resembles(self, other: "Linear") -> bool:
        """Whether its unknowns are those of another, so that at most directions of slip differ."""
        return (
            self.block is other.block
            and np.array_equal(self.active, other.active)
            and np.array_equal(self.law.moving, other.law.moving)
        )

    def solve(self, offsets: Offsets, near: Factor | None) -> tuple[Solution, Factor | None]:
        """Solve it, with the factor of one that it resembles if there is any."""
        block, scaled, active, moving = self.block, self.block.effects.scaled, self.active, self.law.moving
        press, unit = block.effects.press, block.effects.unit
        acting = -press[active] * offsets.pin_gap[active], -self.law.of_rows(unit * offsets.stress)
        found, factor = solved(self.matrix, np.concatenate([*acting, self.reach * offsets.forces]), near)
        pressed, slid, motion = np.split(found, [len(active), len(active) + len(moving)])
        pressure, moved = np.zeros(len(block.pins)), np.zeros(len(block.joined))
        pressure[active], moved[moving] = press[active] * pressed, unit[moving] * slid
        motion = self.reach * motion
        stress = self.by_slip @ slid - self.by_pins @ pressed
        pin_gap = pressed @ scaled.A[active] + slid @ scaled.B[moving]
        solution = Solution(
            pressure=pressure,
            motion=motion,
            moved=moved,
            stress=offsets.stress + stress / unit,
            pin_gap=offsets.pin_gap + pin_gap / press - block.R @ motion,
        )
        return solution, factor
