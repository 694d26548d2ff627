"""The unknowns of a contact problem: places, loads and guesses, in blocks that are hardly coupled."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fea.contact.problem import CondensedInterface
from geometry.arrays import Floats, Ints, Mask


@dataclass(frozen=True)
class Places:
    """Where parts touch, by the positions of its unknowns in `CondensedInterface.interface`."""

    normal: Ints  #: (k,) of the pressure, or of a bolt's force
    tangential: Ints  #: (k, 2) of the shear stresses; −1 where there is none
    friction: Floats  #: (k,) coefficient μ
    bolt: Mask  #: (k,) which are bolts
    #: (k,) where friction decides on slip; elsewhere slip is given or there is no shear stress
    frictional: Mask

    def of(self, sites: Ints) -> "Places":
        """Some of the places."""
        return Places(*(values[sites] for values in astuple(self)))


@dataclass(frozen=True)
class Guess:
    """What touches, opens and slips."""

    touching: Mask  #: (n_p,) which pressures of the pins act
    #: opened, slipping: (k,) which places are open; which slip
    opened: Mask
    slipping: Mask
    direction: Floats  #: (k, 2) of the shear stress where they slip
    ratio: Floats  #: (k,) friction over the length that `direction` was found from, at most 1

    def of(self, pins: Ints, sites: Ints) -> "Guess":
        """Return what it says of some pressures of the pins and some places."""
        opened, slipping = self.opened[sites], self.slipping[sites]
        return Guess(self.touching[pins], opened, slipping, self.direction[sites], self.ratio[sites])

    def equals(self, other: "Guess") -> bool:
        """Whether both say the same."""
        masks, others = ((guess.touching, guess.opened, guess.slipping) for guess in (self, other))
        if not all(map(np.array_equal, masks, others)):
            return False
        slips, of_slip = self.slipping, ((self.direction, other.direction), (self.ratio, other.ratio))
        return all(np.array_equal(one[slips], two[slips]) for one, two in of_slip)

    @classmethod
    def together(cls, n_pins: int, n_places: int, parts: Sequence[tuple[Ints, Ints, "Guess"]]) -> "Guess":
        """Put guesses of some pressures of the pins and some places together."""
        whole = cls.closed(n_pins, n_places)
        for pins, sites, part in parts:
            whole.touching[pins] = part.touching
            whole.opened[sites], whole.slipping[sites] = part.opened, part.slipping
            whole.direction[sites], whole.ratio[sites] = part.direction, part.ratio
        return whole

    @classmethod
    def closed(cls, n_pins: int, n_places: int) -> "Guess":
        """Return the state in which everything sticks and no pin touches."""
        opened, slipping = np.zeros((2, n_places), dtype=bool)
        return cls(np.zeros(n_pins, bool), opened, slipping, np.zeros((n_places, 2)), np.zeros(n_places))


@dataclass(frozen=True)
class StickingState:
    """The sticking state under a load, without any pressure of the pins."""

    stress: Floats  #: λ_J (n_J,)
    pin_gap: Floats  #: (n_p,) moments of the gaps of the pins
    forces: Floats  #: (m,) resultants along the motions that only the pins resist
    gap: Floats  #: y_J (n_J,) at the beginning of the step
    least: float = 1e-300  #: size of the stresses elsewhere, MPa: what is little beside them is nothing

    def of(self, pins: Ints, interface: Ints, motions: Ints) -> "StickingState":
        """That of some of the unknowns and motions."""
        stress, gap = self.stress[interface], self.gap[interface]
        return StickingState(stress, self.pin_gap[pins], self.forces[motions], gap, self.least)


# Couplings, in terms of unknowns of unit stiffness, up to which unknowns may be in different blocks: the
# least one that divides the problem. The larger ones, still little beside the exactness of a cycle, are for
# rods whose shank is shorter than their ends. And the coupling that rounding leaves.
_WEAK, NOTHING = (1e-6, 1e-5, 1e-4), 1e-11


@dataclass(frozen=True)
class _Effects:
    """What pressures of the pins and slips do to gaps and stresses."""

    #: A, B, S: (n_p, n_p), (n_J, n_p), (n_J, n_J), as in `fea.contact.problem`
    A: Floats
    B: Floats
    S: Floats

    @cached_property
    def stiff(self) -> Floats:
        """Diagonal (n_J,) of S."""
        return np.diag(self.S).copy()

    @cached_property
    def soft(self) -> Floats:
        """Diagonal (n_p,) of A."""
        return np.diag(self.A).copy()

    @cached_property
    def press(self) -> Floats:
        """Pressures (n_p,) of the pins that are one in terms of unknowns of unit stiffness."""
        return np.asarray(1 / np.sqrt(self.soft))

    @cached_property
    def unit(self) -> Floats:
        """Gaps (n_J,) that are one in terms of unknowns of unit stiffness."""
        return np.asarray(1 / np.sqrt(self.stiff))

    def of_unit_stiffness(self) -> "_Effects":
        """The same in terms of unknowns of unit stiffness."""
        press, unit = self.press, self.unit
        A, S = press[:, None] * self.A * press, unit[:, None] * self.S * unit
        return _Effects(A, unit[:, None] * self.B * press, S)

    @cached_property
    def scaled(self) -> "_Effects":
        """The same in terms of unknowns of unit stiffness, where that is needed again and again."""
        return self.of_unit_stiffness()

    @cached_property
    def of_pins(self) -> Floats:
        """The transpose (n_p, n_J) of B, row by row."""
        return np.ascontiguousarray(self.B.T)

    def part(self, interface: Ints, pins: Ints) -> "_Effects":
        """Those of some unknowns."""
        matrices = (self.A, pins, pins), (self.B, interface, pins), (self.S, interface, interface)
        return _Effects(*(np.ascontiguousarray(of[np.ix_(rows, columns)]) for of, rows, columns in matrices))


@dataclass(frozen=True)
class ContactBlock:
    """Some of the unknowns, by their numbers in the whole problem, and what is between them."""

    #: pins, interface, motions, sites: (n_p,) of the pins' pressures; (n_J,) of stresses between parts and
    #: bolt forces; (m,) of the motions that only the pins resist; (k,) of the places
    pins: Ints
    interface: Ints
    motions: Ints
    sites: Ints
    effects: _Effects  #: of these pressures and slips
    R: Floats  #: (n_p, m) moments of the motions
    places: Places  #: where parts touch, by positions in `interface`

    @classmethod
    def whole(cls, condensed: CondensedInterface, R: Floats, places: Places) -> "ContactBlock":
        """Everything."""
        sizes = *condensed.B.shape[::-1], R.shape[1], len(places.normal)
        pins, interface, motions, sites = map(np.arange, sizes)
        return cls(
            pins, interface, motions, sites, _Effects(condensed.A, condensed.B, condensed.S), R, places
        )

    @cached_property
    def has_friction(self) -> bool:
        """Whether friction decides on slip anywhere."""
        return bool(self.places.frictional.any())

    @cached_property
    def against(self) -> Floats:
        """Stiffness (k,) of each place against slip in either direction."""
        at = self.places.tangential
        return np.asarray(np.where(at >= 0, self.effects.stiff[at], 0.0).max(axis=1))

    def part(self, pins: Ints, interface: Ints, motions: Ints) -> "ContactBlock":
        """Some of the unknowns; no place may be divided."""
        position = np.full(len(self.interface) + 1, -1)  # the last one stands for none
        position[interface] = np.arange(len(interface))
        sites = np.flatnonzero(position[self.places.normal] >= 0)
        every = self.places.of(sites)
        places = replace(every, normal=position[every.normal], tangential=position[every.tangential])
        effects, R = self.effects.part(interface, pins), self.R[np.ix_(pins, motions)]
        return ContactBlock(pins, interface, motions, sites, effects, R, places)

    def divided(self) -> list["ContactBlock"]:
        """Blocks that are hardly coupled."""
        n_p, n_J = len(self.pins), len(self.interface)
        for weak in _WEAK:
            pins, interface, motions = kinds = np.split(self._labels(weak), [n_p, n_p + n_J])
            numbers = np.unique(np.concatenate([pins, interface]))
            if len(numbers) > 1:
                break
        else:
            return [self]
        # A motion that nothing resists goes to any of the blocks, where it is found not to be in balance.
        motions[~np.isin(motions, numbers)] = numbers[0]
        return [self.part(*(np.flatnonzero(kind == each) for kind in kinds)) for each in numbers]

    def _labels(self, weak: float) -> Ints:
        """Number (n_p + n_J + m,) of the block of every unknown and every motion."""
        even, scaled = self.even, self.effects.of_unit_stiffness()
        n_p, n_J, m = len(self.pins), len(self.interface), self.R.shape[1]
        interface = np.arange(n_p, n_p + n_J)
        linked = np.zeros((n_p + n_J + m,) * 2, dtype=bool)
        A, B = scaled.A - even @ (even.T @ scaled.A), scaled.B
        linked[:n_p, :n_p] = np.abs(A - (A @ even) @ even.T) > weak
        linked[n_p : n_p + n_J, :n_p] = np.abs(B - (B @ even) @ even.T) > weak
        linked[n_p : n_p + n_J, n_p : n_p + n_J] = np.abs(scaled.S) > weak
        linked[n_p + n_J :, :n_p] = np.abs(self.R.T) > NOTHING
        normal, shear = np.broadcast_arrays(self.places.normal[:, None], self.places.tangential)
        linked[interface[normal[shear >= 0]], interface[shear[shear >= 0]]] = True
        _, label = connected_components(sparse.csr_array(linked), directed=False)
        return np.asarray(label, dtype=np.int64)

    @cached_property
    def even(self) -> Floats:
        """Orthonormal rigid motions (n_p, m) of the pins, in terms of unknowns of unit stiffness."""
        R = self.R[:, np.abs(self.R).max(axis=0, initial=0.0) > NOTHING] * self.effects.press[:, None]
        return np.asarray(np.linalg.qr(R)[0]) if R.size else R

    def carrying(self, touching: Mask, forces: Floats) -> Floats:
        """Least pressures (n_p,) of the pins that touch, of either sign, with the resultants (m,)."""
        pressure = np.zeros(len(self.pins))
        if touching.any():
            pressure[touching] = np.linalg.lstsq(self.R[touching].T, forces, rcond=None)[0]
        return pressure

    def change(self, one: StickingState, other: StickingState) -> float:
        """Largest change of a stress from one load to another while nothing moves but the pins, MPa."""
        gap = (one.pin_gap - other.pin_gap) * self.effects.press
        gap = (gap - self.even @ (self.even.T @ gap)) * self.effects.press
        return float(max(np.abs(stress).max(initial=0.0) for stress in (one.stress - other.stress, gap)))


@dataclass(frozen=True)
class Product:
    """A matrix (n, k), as the product of two that are as narrow as they can be; None where it is nothing."""

    left: Floats | None
    right: Floats | None

    @classmethod
    def of(cls, matrix: Floats, rows: Floats, columns: Floats, basis: Floats) -> "Product":
        """Take a matrix (n, k) apart.

        `rows` (n,) and `columns` (k,) scale it to unknowns of unit stiffness. The basis (k, r) is
        orthonormal: it may be all that the scaled rows consist of.
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
class _Coupling:
    """What pressures and slips of one block do to another."""

    by: int  #: the number of the other block
    #: gap_by_pins, gap_by_slip, stress_by_pins, stress_by_slip: (n_p, n_p'), (n_p, n_J'), (n_J, n_p'), (n_J,
    #: n_J')
    gap_by_pins: Product
    gap_by_slip: Product
    stress_by_pins: Product
    stress_by_slip: Product

    @classmethod
    def of(cls, whole: ContactBlock, blocks: Sequence[ContactBlock], to: int, by: int) -> "_Coupling":
        """Between two blocks."""
        here, other, every = blocks[to], blocks[by], whole.effects
        own, there = here.interface, other.interface
        press, unit, its = here.effects.press, here.effects.unit, other.effects
        nothing = np.zeros((len(there), 0))
        slip = Product.of(every.B[np.ix_(there, here.pins)], its.unit, press, here.even)
        return cls(
            by=by,
            gap_by_pins=Product.of(every.A[np.ix_(here.pins, other.pins)], press, its.press, other.even),
            gap_by_slip=slip.transposed,
            stress_by_pins=Product.of(every.B[np.ix_(own, other.pins)], unit, its.press, other.even),
            stress_by_slip=Product.of(every.S[np.ix_(own, there)], unit, its.unit, nothing),
        )

    def shifted(self, offsets: StickingState, pressure: Floats, moved: Floats) -> StickingState:
        """The sticking state under pressures and slips of the other block."""
        stress = self.stress_by_pins.added(offsets.stress, pressure, -1.0)
        gap = self.gap_by_slip.added(self.gap_by_pins.added(offsets.pin_gap, pressure), moved)
        return replace(offsets, stress=self.stress_by_slip.added(stress, moved), pin_gap=gap)


@dataclass(frozen=True)
class CoupledBlocks:
    """A problem in blocks."""

    blocks: tuple[ContactBlock, ...]  #: hardly coupled
    couplings: tuple[tuple[_Coupling, ...], ...]  #: for each block, what the others do to it

    @classmethod
    def of(cls, whole: ContactBlock) -> "CoupledBlocks":
        """Divide a problem."""
        blocks = whole.divided()
        count = range(len(blocks))
        couplings = [tuple(_Coupling.of(whole, blocks, to, by) for by in count if by != to) for to in count]
        return cls(tuple(blocks), tuple(couplings))

    @cached_property
    def sticking(self) -> "CoupledBlocks":
        """The same, where all slip is given."""
        given = [
            replace(block.places, frictional=np.zeros_like(block.places.frictional)) for block in self.blocks
        ]
        blocks = [replace(block, places=places) for block, places in zip(self.blocks, given, strict=True)]
        return replace(self, blocks=tuple(blocks))

    def shifted(
        self, number: int, offsets: StickingState, pressure: Sequence[Floats], moved: Sequence[Floats]
    ) -> StickingState:
        """The sticking state of a block under pressures and slips of the others."""
        for coupling in self.couplings[number]:
            offsets = coupling.shifted(offsets, pressure[coupling.by], moved[coupling.by])
        return offsets

    def slipped(self, number: int, gap: Floats) -> tuple[Floats, Floats]:
        """Stresses S y (n_J, n) and gaps Bᵀ y (n_p, n) of a block under gaps y of all unknowns."""
        block = self.blocks[number]
        here = gap[block.interface]
        stress, pin_gap = block.effects.S @ here, block.effects.B.T @ here
        for other in self.couplings[number]:
            there = gap[self.blocks[other.by].interface]
            stress = other.stress_by_slip.added(stress, there)
            pin_gap = other.gap_by_slip.added(pin_gap, there)
        return stress, pin_gap
