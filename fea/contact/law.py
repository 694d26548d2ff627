"""The laws of contact and friction where a place is guessed to open or to slip, linear in what is unknown."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fea.contact.block import Block
from fea.contact.guess import Guess
from geometry.arrays import Floats, Ints

_TWO = np.eye(2)


@dataclass(frozen=True)
class Law:
    """D L λ_J + D K D (Δy / D) = 0 of the gaps that are unknown, scaled by D to unit stiffness.

    Where a place is open, λ = 0. Where it slips, λ_t = μ λ_n d, with the direction d of the shear stress less
    the stiffness times the slip, and the derivative of that direction.

    Attributes
    ----------
    moving, unit
        (n,) positions of these gaps in the block, and the diagonal of D.
    rows, share
        (l,) positions of the stresses in the law, and D L (n, l); None for D where nothing slips.
    give
        Rows, columns and values of D K D (n, n) where it is not zero.
    """

    moving: Ints
    unit: Floats
    rows: Ints
    share: sparse.csr_array | None
    give: tuple[Ints, Ints, Floats]

    def of_rows(self, matrix: Floats, columns: Ints) -> Floats:
        """D L M (n, k), of some columns of a matrix M (n_J, …)."""
        chosen = matrix[self.rows][:, columns]
        return np.asarray(self.unit[:, None] * chosen if self.share is None else self.share @ chosen)

    def of_values(self, stress: Floats) -> Floats:
        """D L λ_J (n,)."""
        chosen = stress[self.rows]
        return np.asarray(self.unit * chosen if self.share is None else self.share @ chosen)

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
        unloaded = np.concatenate([places.normal[opened], free[free >= 0]])
        if not len(slips):
            none = np.zeros(0, dtype=np.int64)
            unit = 1 / np.sqrt(block.stiff[unloaded])
            return cls(unloaded, unit, unloaded, None, (none, none, np.zeros(0)))
        slid, along = tangential[slips], guess.direction[slips]
        has = slid >= 0
        moving = np.concatenate([unloaded, slid[has]])
        row = np.full(slid.shape, -1)
        row[has] = len(unloaded) + np.arange(has.sum())
        normal = np.broadcast_to(len(moving) + np.arange(len(slips))[:, None], slid.shape)
        # The derivative of the direction of slip acts square to it.
        turn = guess.ratio[slips, None, None] * (_TWO - along[:, :, None] * along[:, None, :])
        both = has[:, :, None] & has[:, None, :]
        one = np.broadcast_to(row[:, :, None], both.shape)[both]
        other = np.broadcast_to(row[:, None, :], both.shape)[both]
        alone = np.arange(len(unloaded))
        unit = 1 / np.sqrt(block.stiff[moving])
        rows = np.concatenate([alone, row[has], one])
        entries = np.concatenate(
            [
                np.ones(len(alone)),
                (-places.friction[slips, None] * along)[has],
                (_TWO - turn)[both],
            ]
        )
        share = sparse.csr_array(
            (unit[rows] * entries, (rows, np.concatenate([alone, normal[has], other]))),
            shape=(len(moving), len(moving) + len(slips)),
        )
        give = (turn * block.against[slips, None, None])[both] * unit[one] * unit[other]
        return cls(
            moving=moving,
            unit=unit,
            rows=np.concatenate([moving, places.normal[slips]]),
            share=share,
            give=(one, other, give),
        )
