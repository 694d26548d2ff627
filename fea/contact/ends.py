"""Blocks of the contact problem that hardly know of each other, as the two ends of a rod, and what they do.

The ends of a rod that hangs in two pins are statically determinate. Once their resultants are given, what
opens, slips and touches at one end changes the other only by what St. Venant's principle leaves of stresses
in equilibrium over the length of the rod: next to nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fea.contact.block import NOTHING, Block
from fea.contact.guess import Offsets
from geometry.arrays import Floats


@dataclass(frozen=True)
class Product:
    """A matrix (n, k), as the product of two that are as narrow as they can be; None where it is nothing."""

    left: Floats | None
    right: Floats | None

    @classmethod
    def of(cls, matrix: Floats, rows: Floats, columns: Floats, basis: Floats) -> "Product":
        """Take a matrix apart.

        Parameters
        ----------
        matrix
            (n, k).
        rows, columns
            (n,), (k,) that scale it to unknowns of unit stiffness.
        basis
            (k, r) orthonormal: it may be all that the scaled rows consist of.
        """
        scaled = rows[:, None] * matrix * columns
        left = scaled @ basis
        if np.abs(scaled - left @ basis.T).max(initial=0.0) > NOTHING:
            return cls(matrix, None)
        if np.abs(left).max(initial=0.0) <= NOTHING:
            return cls(None, None)
        return cls(left / rows[:, None], (basis / columns[:, None]).T)

    @property
    def transposed(self) -> "Product":
        """The transpose (k, n)."""
        if self.left is None or self.right is None:
            return Product(None if self.left is None else np.ascontiguousarray(self.left.T), None)
        return Product(self.right.T, self.left.T)

    def added(self, to: Floats, values: Floats, sign: float = 1.0) -> Floats:
        """Add what it makes of values (k,), or subtract it."""
        if self.left is None:
            return to
        return np.asarray(to + sign * (self.left @ (values if self.right is None else self.right @ values)))


@dataclass(frozen=True)
class Coupling:
    """What pressures and slips of one block do to another.

    Attributes
    ----------
    by
        The number of the other block.
    gap_by_pins, gap_by_slip, stress_by_pins, stress_by_slip
        (n_p, n_p'), (n_p, n_J'), (n_J, n_p'), (n_J, n_J').
    """

    by: int
    gap_by_pins: Product
    gap_by_slip: Product
    stress_by_pins: Product
    stress_by_slip: Product

    @classmethod
    def of(cls, whole: Block, blocks: Sequence[Block], to: int, by: int) -> "Coupling":
        """Between two blocks."""
        own, other, every = blocks[to], blocks[by], whole.effects
        press, unit, its = own.effects.press, own.effects.unit, other.effects
        nothing = np.zeros((len(other.joined), 0))
        slip = Product.of(every.B[np.ix_(other.joined, own.pins)], its.unit, press, own.even)
        return cls(
            by=by,
            gap_by_pins=Product.of(every.A[np.ix_(own.pins, other.pins)], press, its.press, other.even),
            gap_by_slip=slip.transposed,
            stress_by_pins=Product.of(every.B[np.ix_(own.joined, other.pins)], unit, its.press, other.even),
            stress_by_slip=Product.of(every.S[np.ix_(own.joined, other.joined)], unit, its.unit, nothing),
        )

    def shifted(self, offsets: Offsets, pressure: Floats, moved: Floats) -> Offsets:
        """Offsets under pressures and slips of the other block."""
        stress = self.stress_by_pins.added(offsets.stress, pressure, -1.0)
        gap = self.gap_by_slip.added(self.gap_by_pins.added(offsets.pin_gap, pressure), moved)
        return replace(offsets, stress=self.stress_by_slip.added(stress, moved), pin_gap=gap)


@dataclass(frozen=True)
class Ends:
    """A problem in blocks.

    Attributes
    ----------
    blocks
        That hardly know of each other.
    couplings
        For each block, what the others do to it.
    """

    blocks: tuple[Block, ...]
    couplings: tuple[tuple[Coupling, ...], ...]

    @classmethod
    def of(cls, whole: Block) -> "Ends":
        """Divide a problem."""
        blocks = whole.divided()
        count = range(len(blocks))
        couplings = [tuple(Coupling.of(whole, blocks, to, by) for by in count if by != to) for to in count]
        return cls(tuple(blocks), tuple(couplings))

    @cached_property
    def sticking(self) -> "Ends":
        """The same, where all slip is given."""
        return replace(self, blocks=tuple(own.sticking for own in self.blocks))

    def shifted(
        self, number: int, offsets: Offsets, pressure: Sequence[Floats], moved: Sequence[Floats]
    ) -> Offsets:
        """Offsets of a block under pressures and slips of the others."""
        for own in self.couplings[number]:
            offsets = own.shifted(offsets, pressure[own.by], moved[own.by])
        return offsets

    def slipped(self, number: int, gap: Floats) -> tuple[Floats, Floats]:
        """Stresses S y (n_J, n) and gaps Bᵀ y (n_p, n) of a block under gaps y of all unknowns."""
        own = self.blocks[number]
        here = gap[own.joined]
        stress, pin_gap = own.effects.S @ here, own.effects.B.T @ here
        for other in self.couplings[number]:
            there = gap[self.blocks[other.by].joined]
            stress = other.stress_by_slip.added(stress, there)
            pin_gap = other.gap_by_slip.added(pin_gap, there)
        return stress, pin_gap
