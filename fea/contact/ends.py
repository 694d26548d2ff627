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
class Coupling:
    """What pressures and slips of one block do to another.

    Attributes
    ----------
    to, by
        The blocks, by their numbers.
    gap_by_pins, gap_by_slip, stress_by_pins, stress_by_slip
        (n_p, n_p'), (n_p, n_J'), (n_J, n_p'), (n_J, n_J'), or None where it is nothing.
    """

    to: int
    by: int
    gap_by_pins: Floats
    gap_by_slip: Floats
    stress_by_pins: Floats
    stress_by_slip: Floats | None

    @classmethod
    def of(cls, whole: Block, blocks: Sequence[Block], to: int, by: int) -> "Coupling":
        """Between two blocks."""
        own, other = blocks[to], blocks[by]
        slip = whole.B[np.ix_(other.joined, own.pins)]
        stress = whole.S[np.ix_(own.joined, other.joined)]
        none = _little(stress, own.stiff, other.stiff)
        return cls(
            to=to,
            by=by,
            gap_by_pins=whole.A[np.ix_(own.pins, other.pins)],
            gap_by_slip=np.ascontiguousarray(slip.T),
            stress_by_pins=whole.B[np.ix_(own.joined, other.pins)],
            stress_by_slip=None if none else stress,
        )

    def shifted(self, offsets: Offsets, pressure: Floats, moved: Floats) -> Offsets:
        """Offsets under pressures and slips of the other block."""
        stress = offsets.stress - self.stress_by_pins @ pressure
        if self.stress_by_slip is not None:
            stress += self.stress_by_slip @ moved
        gap = offsets.pin_gap + self.gap_by_pins @ pressure + self.gap_by_slip @ moved
        return replace(offsets, stress=stress, pin_gap=gap)


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

    def slipped(self, gap: Floats) -> Floats:
        """Stresses S y (n_J,) of gaps y (n_J,)."""
        found = np.zeros_like(gap)
        for block, others in zip(self.blocks, self.couplings, strict=True):
            found[block.joined] = block.S @ gap[block.joined]
            for own in others:
                if own.stress_by_slip is not None:
                    found[block.joined] += own.stress_by_slip @ gap[self.blocks[own.by].joined]
        return found


def _little(values: Floats, rows: Floats, columns: Floats) -> bool:
    scaled = np.abs(values) / np.sqrt(rows)[:, None] / np.sqrt(columns)
    return bool(scaled.max(initial=0.0) < NOTHING)
