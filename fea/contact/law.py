"""The laws of contact and friction where a place is guessed to open or to slip, linear in what is unknown."""

from dataclasses import dataclass

import numpy as np

from fea.contact.block import Block
from fea.contact.guess import Guess
from geometry.arrays import Floats, Ints, Mask

_TWO = np.eye(2)


@dataclass(frozen=True)
class Law:
    """D L λ_J + D K D (Δy / D) = 0 of the gaps that are unknown, scaled by D to unit stiffness.

    Where a place is open, λ = 0. Where it slips, λ_t = μ λ_n d, with the direction d of the shear stress less
    the stiffness times the slip, and the derivative of that direction.

    Attributes
    ----------
    moving, unit
        (n,) positions of these gaps in the block, and the diagonal of D: first of what is open, then of what
        slips.
    stresses, share
        (k, 3) positions of the shear stresses and of the pressure of each place that slips, and D L (k, 2, 3)
        of them; 0 where there is no such stress.
    slipping
        (2 k,) which of the shear stresses there are.
    give
        Rows, columns and values of D K D (n, n) where it is not zero.
    """

    moving: Ints
    unit: Floats
    stresses: Ints
    share: Floats
    slipping: Mask
    give: tuple[Ints, Ints, Floats]

    def of_rows(self, matrix: Floats, columns: Ints, to: Floats) -> None:
        """Put D L M (n, m), of some columns (m,) of a matrix M (n_J, …), into a matrix."""
        n_open = len(self.moving) - int(self.slipping.sum())
        opened = matrix[self.moving[:n_open]][:, columns]
        np.multiply(self.unit[:n_open, None], opened, out=to[:n_open])
        chosen = matrix[self.stresses.ravel()][:, columns].reshape(*self.stresses.shape, len(columns))
        to[n_open:] = (self.share @ chosen).reshape(len(self.slipping), len(columns))[self.slipping]

    def of_values(self, stress: Floats) -> Floats:
        """D L λ_J (n,)."""
        found = np.zeros((len(self.moving), 1))
        self.of_rows(stress[:, None], np.zeros(1, dtype=np.int64), found)
        return found[:, 0]

    def give_way(self, matrix: Floats) -> None:
        """Add D K D to a matrix (n, n)."""
        row, column, value = self.give
        matrix[row, column] += value

    @classmethod
    def of(cls, block: Block, guess: Guess) -> "Law":
        """The law of a guess."""
        places, tangential = block.places, block.places.tangential
        opened, slips = np.flatnonzero(guess.opened), np.flatnonzero(guess.slipping & ~guess.opened)
        free = tangential[opened].ravel()
        slid, along = tangential[slips], guess.direction[slips]
        has = slid >= 0
        moving = np.concatenate([places.normal[opened], free[free >= 0], slid[has]])
        unit = 1 / np.sqrt(block.stiff[moving])
        # The derivative of the direction of slip acts square to it.
        turn = guess.ratio[slips, None, None] * (_TWO - along[:, :, None] * along[:, None, :])
        both = has[:, :, None] & has[:, None, :]
        row = np.full(slid.shape, -1)
        row[has] = len(moving) - int(has.sum()) + np.arange(has.sum())
        scale = np.where(has, unit[row], 0.0)
        pressed = -places.friction[slips, None] * along
        share = np.concatenate([np.where(both, _TWO - turn, 0.0), pressed[..., None]], axis=2)
        one = np.broadcast_to(row[:, :, None], both.shape)[both]
        other = np.broadcast_to(row[:, None, :], both.shape)[both]
        give = (turn * block.against[slips, None, None])[both] * unit[one] * unit[other]
        return cls(
            moving=moving,
            unit=unit,
            stresses=np.concatenate([np.where(has, slid, 0), places.normal[slips, None]], axis=1),
            share=scale[..., None] * share,
            slipping=has.ravel(),
            give=(one, other, give),
        )
