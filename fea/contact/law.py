"""The laws of contact and friction where a place is guessed to open or to slip, linear in what is unknown."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fea.contact.block import Block
from fea.contact.guess import Guess
from geometry.arrays import Floats, Ints

_TWO = np.eye(2)
_NOWHERE = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)


@dataclass(frozen=True)
class Law:
    """D L λ_J + D K D (Δy / D) = 0 of the gaps that are unknown, with D that scales them to unit stiffness.

    Where a place is open, λ = 0. Where it slips, λ_t = μ λ_n d, with the direction d of the shear stress less
    the stiffness times the slip, and the derivative of that direction.

    Attributes
    ----------
    moving
        (n,) positions of these gaps in the block: first of what is open, then of what slips.
    weights
        D L D⁻¹ (n, n_J); None where nothing slips, so that it selects `moving`.
    give
        Rows, columns and values of D K D (n, n) where it is not zero.
    """

    moving: Ints
    weights: sparse.csr_array | None
    give: tuple[Ints, Ints, Floats]

    def of_rows(self, values: Floats) -> Floats:
        """D L D⁻¹ times values (n_J, …)."""
        return np.asarray(values[self.moving] if self.weights is None else self.weights @ values)

    def give_way(self, matrix: Floats) -> None:
        """Add D K D to a matrix (n, n)."""
        row, column, value = self.give
        matrix[row, column] += value

    @classmethod
    def of(cls, block: Block, guess: Guess) -> "Law":
        """The law of a guess."""
        places, tangential, unit = block.places, block.places.tangential, block.effects.unit
        opened, slips = np.flatnonzero(guess.opened), np.flatnonzero(guess.slipping & ~guess.opened)
        free = tangential[opened].ravel()
        if not len(slips):
            return cls(np.concatenate([places.normal[opened], free[free >= 0]]), None, _NOWHERE)
        slid, pressed, along = tangential[slips], places.normal[slips], guess.direction[slips]
        has = slid >= 0
        moving = np.concatenate([places.normal[opened], free[free >= 0], slid[has]])
        n_slid = int(has.sum())
        n_open = len(moving) - n_slid
        # The derivative of the direction of slip acts square to it.
        turn = guess.ratio[slips, None, None] * (_TWO - along[:, :, None] * along[:, None, :])
        both = has[:, :, None] & has[:, None, :]
        row = np.full(slid.shape, -1)
        row[has] = n_open + np.arange(n_slid)
        one = np.broadcast_to(row[:, :, None], both.shape)[both]
        other = np.broadcast_to(row[:, None, :], both.shape)[both]
        give = (turn * block.against[slips, None, None])[both] * unit[moving[one]] * unit[moving[other]]
        # Of each shear stress of a place that slips: both of its shear stresses, where it has them, and its
        # pressure.
        share = -places.friction[slips, None] * along
        share = np.concatenate([np.where(both, _TWO - turn, 0.0), share[..., None]], axis=2)
        stresses = np.concatenate([np.where(has, slid, pressed[:, None]), pressed[:, None]], axis=1)
        share = (unit[slid][..., None] * share / unit[stresses][:, None, :])[has]
        stresses = np.broadcast_to(stresses[:, None, :], (*slid.shape, 3))[has]
        values = np.concatenate([np.ones(n_open), share.ravel()])
        columns = np.concatenate([moving[:n_open], stresses.ravel()])
        starts = np.concatenate([np.arange(n_open), n_open + 3 * np.arange(n_slid + 1)])
        weights = sparse.csr_array((values, columns, starts), (len(moving), len(block.joined)))
        return cls(moving, weights, (one, other, give))
