"""One guess of what touches, opens and slips: its solution, and how that violates contact or friction.

Where a place is guessed to open or to slip, the laws of contact and friction are linear in what is unknown.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import get_lapack_funcs, lapack

from fea.contact.block import ContactBlock, Guess, StickingState
from geometry.arrays import Floats, Ints, Mask, Reals

# Reciprocal condition number, of a scaled matrix, below which a motion counts as free; smallest over largest
# pivot above which the condition need not be known, in double and in single precision.
_SINGULAR, _SAFE, _SAFE_SINGLE = 1e-12, 1e-8, 1e-3
# Steps of iterative refinement with the factor of another matrix, what they must leave of the residual, and
# by how much each must reduce it.
_STEPS, _EXACT, _ENOUGH = 8, 1e-14, 0.1


@cache
def _lapack(name: str, precision: np.dtype[Any]) -> Callable[..., Any]:
    return get_lapack_funcs(name, dtype=precision)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class _Factor:
    """Triangular factors of the transpose of a matrix (n, n) and their pivots (n,), as LAPACK has them.

    Single precision takes little more than half the time; iterative refinement makes up for it.
    """

    triangles: Reals
    pivots: Ints

    @classmethod
    def of(cls, matrix: Reals, *, overwrite: bool = False) -> "_Factor | None":
        """Factorise, in the precision of the matrix, which may be overwritten; None if a pivot is zero."""
        triangles, pivots, broken = _lapack("getrf", matrix.dtype)(matrix.T, overwrite_a=overwrite)
        return cls(triangles, pivots) if broken == 0 else None

    @property
    def least_pivot(self) -> float:
        """Smallest pivot over the largest."""
        pivot = np.abs(np.diag(self.triangles))
        return float(pivot.min() / pivot.max())

    def solve(self, side: Floats) -> Floats:
        """Solve for one right-hand side (n,)."""
        solve = _lapack("getrs", self.triangles.dtype)
        return np.asarray(solve(self.triangles, self.pivots, side, trans=1)[0], float)

    def refined(self, matrix: Floats, side: Floats) -> Floats | None:
        """Solve with another matrix that is nearly the same; None if that takes too long."""
        solution, given = self.solve(side), np.abs(side).max()
        before = np.inf
        for _ in range(_STEPS):
            left = side - matrix @ solution
            size = float(np.abs(left).max())
            if size <= _EXACT * given or size <= _EXACT * np.abs(solution).max():
                return solution
            if size > _ENOUGH * before:
                return None
            solution, before = solution + self.solve(left), size
        return None


def solved(matrix: Floats, side: Floats, near: _Factor | None = None) -> tuple[Floats, _Factor | None]:
    """Solve a matrix (n, n) with a diagonal near one; a motion that nothing resists stays zero.

    `near` factorises a matrix that may be nearly the same. Also returned is a factor of use for the next such
    matrix, unless this one is singular, as where a part has come off.
    """
    if not len(side):
        return side, None
    if near is not None and (solution := near.refined(matrix, side)) is not None:
        return solution, near
    single = _Factor.of(matrix.astype(np.float32), overwrite=True)
    if single is not None and single.least_pivot > _SAFE_SINGLE:
        solution = single.refined(matrix, side)
        if solution is not None:
            return solution, single
    factor = _Factor.of(matrix)
    if factor is not None:
        norm = np.abs(matrix).sum(axis=1).max()
        if factor.least_pivot > _SAFE or lapack.dgecon(factor.triangles, norm)[0] > _SINGULAR:
            return factor.solve(side), factor
    return np.asarray(np.linalg.lstsq(matrix, side, rcond=_SINGULAR)[0]), None


_TWO = np.eye(2)
_NOWHERE = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)


@dataclass(frozen=True)
class _Law:
    """D L λ_J + D K D (Δy / D) = 0 of the gaps that are unknown, with D that scales them to unit stiffness.

    Where a place is open, λ = 0. Where it slips, λ_t = μ λ_n d, with the direction d of the shear stress less
    the stiffness times the slip, and the derivative of that direction.
    """

    moving: Ints  #: (n,) positions of these gaps in the block: first of what is open, then of what slips
    #: (k,) positions of the stresses that the law knows: those of `moving`, then the pressures where it slips
    stressed: Ints
    #: the columns (n, k) of D L D⁻¹ that are not zero; None where nothing slips, so that it is the identity
    weights: sparse.csr_array | None
    give: tuple[Ints, Ints, Floats]  #: rows, columns and values of D K D (n, n) where it is not zero

    def of(self, stresses: Floats) -> Floats:
        """D L D⁻¹ times values (k, …) at `stressed`."""
        return stresses if self.weights is None else np.asarray(self.weights @ stresses)

    @classmethod
    def under(cls, block: ContactBlock, guess: Guess) -> "_Law":
        """The law of a guess."""
        places, tangential, unit = block.places, block.places.tangential, block.effects.unit
        opened, slips = np.flatnonzero(guess.opened), np.flatnonzero(guess.slipping & ~guess.opened)
        free = tangential[opened].ravel()
        if not len(slips):
            moving = np.concatenate([places.normal[opened], free[free >= 0]])
            return cls(moving, moving, None, _NOWHERE)
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
        stressed, last = np.concatenate([moving, pressed]), len(moving) + np.arange(len(slips))[:, None]
        at = np.concatenate([np.where(has, row, last), last], axis=1)
        share = (unit[slid][..., None] * share / unit[stressed[at]][:, None, :])[has]
        values = np.concatenate([np.ones(n_open), share.ravel()])
        columns = np.concatenate(
            [np.arange(n_open), np.broadcast_to(at[:, None], (*both.shape[:2], 3))[has].ravel()]
        )
        starts = np.concatenate([np.arange(n_open), n_open + 3 * np.arange(n_slid + 1)])
        weights = sparse.csr_array((values, columns, starts), (len(moving), len(stressed)))
        return cls(moving, stressed, weights, (one, other, give))


class _Solution(NamedTuple):
    """What solves it."""

    pressure: Floats  #: (n_p,) of the pins, MPa
    motion: Floats  #: (m,) of the pins
    moved: Floats  #: (n_J,) change of the gaps in the step
    stress: Floats  #: λ_J (n_J,)
    pin_gap: Floats  #: (n_p,) moments of the gaps of the pins


@dataclass(frozen=True)
class Linear:
    """The pressures of the pins that touch, the gaps of what opens or slips, and the motions of the pins."""

    #: block, guess, law: what it belongs to, and the law of the gaps
    block: ContactBlock
    guess: Guess
    law: _Law
    active: Ints  #: (n_a,) which pressures of the pins act
    matrix: Floats  #: (n, n)
    #: by_pins, by_slip: (n_a, n_J), (n_d, n_J) what pressures and gaps do to the stresses between the parts
    by_pins: Floats
    by_slip: Floats
    reach: Floats  #: (m,) the scale of the motions

    @classmethod
    def of(cls, block: ContactBlock, guess: Guess) -> "Linear":
        """Set it up."""
        active, law, scaled = np.flatnonzero(guess.touching), _Law.under(block, guess), block.effects.scaled
        # Rows, which lie together in memory, of matrices of which one is symmetric.
        by_pins, by_stress = scaled.of_pins[active], scaled.S[law.stressed]
        rigid = block.effects.press[active, None] * block.R[active]
        reach = np.linalg.norm(rigid, axis=0)
        reach = 1 / np.where(reach > 0, reach, 1.0)
        n_a, n = len(active), len(active) + len(law.moving)
        pins, gaps, motions = slice(0, n_a), slice(n_a, n), slice(n, None)
        matrix = np.zeros((n + len(reach),) * 2)
        matrix[pins, pins] = scaled.A[active][:, active]
        matrix[pins, gaps] = by_pins[:, law.moving]
        matrix[gaps, pins] = -law.of(by_pins[:, law.stressed].T)
        matrix[gaps, gaps] = law.of(np.take(by_stress, law.moving, axis=1))
        row, column, value = law.give
        matrix[n_a + row, n_a + column] += value
        matrix[motions, pins] = (rigid * reach).T
        matrix[pins, motions] = -matrix[motions, pins].T
        return cls(block, guess, law, active, matrix, by_pins, by_stress[: len(law.moving)], reach)

    def solve(self, offsets: StickingState, near: _Factor | None) -> tuple[_Solution, _Factor | None]:
        """Solve it, with the factor of one that it resembles if there is any."""
        block, scaled, active, moving = self.block, self.block.effects.scaled, self.active, self.law.moving
        press, unit = block.effects.press, block.effects.unit
        acting = (
            -press[active] * offsets.pin_gap[active],
            -self.law.of((unit * offsets.stress)[self.law.stressed]),
        )
        unknowns, factor = solved(self.matrix, np.concatenate([*acting, self.reach * offsets.forces]), near)
        pressed, slid, motion = np.split(unknowns, [len(active), len(active) + len(moving)])
        pressure, moved = np.zeros(len(block.pins)), np.zeros(len(block.interface))
        pressure[active], moved[moving] = pressed, slid
        stress = offsets.stress + (slid @ self.by_slip - pressed @ self.by_pins) / unit
        pin_gap = (scaled.A @ pressure + scaled.of_pins @ moved) / press
        pressure, moved, motion = press * pressure, unit * moved, self.reach * motion
        pin_gap = offsets.pin_gap + pin_gap - block.R @ motion
        return _Solution(pressure, motion, moved, stress, pin_gap), factor


# What rounding leaves, relative to the largest stress.
ROUNDING = 1e-11


class Tolerances(NamedTuple):
    """How exactly laws shall hold, relative to the largest stress."""

    violation: float = ROUNDING  #: of contact and friction
    #: Error of the shear stress where places slip, which Newton's method makes small at once
    direction: float = 1e-9
    #: Pressure between parts that are not solved for, MPa: what is nothing beside it is nothing at all
    elsewhere: float = 0.0


TOLERANCES = Tolerances()


@dataclass(frozen=True)
class Trial:
    """The solution of a guess."""

    #: linear, offsets: the problem that is solved, and under what load
    linear: Linear
    offsets: StickingState
    solution: _Solution  #: what solves it
    factor: _Factor | None  #: of its matrix, or of one nearby

    @classmethod
    def of(
        cls, block: ContactBlock, offsets: StickingState, guess: Guess, last: "Trial | None" = None
    ) -> "Trial":
        """Solve for what touches, opens and slips.

        An earlier trial, `last`, may have solved the same problem under another load, or one in which only
        directions of slip were others.
        """
        if last is None or last.block is not block:
            linear, near = Linear.of(block, guess), None
        elif last.guess.equals(guess):
            linear, near = last.linear, last.factor
        else:
            linear, before = Linear.of(block, guess), last.linear
            pairs = (linear.active, before.active), (linear.law.moving, before.law.moving)
            near = last.factor if all(np.array_equal(*pair) for pair in pairs) else None
        return cls(linear, offsets, *linear.solve(offsets, near))

    @property
    def block(self) -> ContactBlock:
        """The unknowns."""
        return self.linear.block

    @property
    def guess(self) -> Guess:
        """What is solved for."""
        return self.linear.guess

    @property
    def gap(self) -> Floats:
        """y_J (n_J,) at the end of the step; exactly zero where places are closed."""
        gap = self.offsets.gap + self.solution.moved
        gap[self.block.places.normal[~self.guess.opened]] = 0.0
        return gap

    @cached_property
    def _normal(self) -> Floats:
        return np.asarray(self.solution.stress[self.block.places.normal])

    @cached_property
    def _tangential(self) -> tuple[Floats, Floats]:
        """Shear stress (k, 2), and the same less the slip that the stiffness turns into a stress."""
        at, found = self.block.places.tangential, self.solution
        shear, slip = (np.where(at >= 0, values[at], 0.0) for values in (found.stress, found.moved))
        return shear, shear - self.block.against[:, None] * slip

    @cached_property
    def size(self) -> float:
        """Largest stress, MPa."""
        pressed = np.abs(self._normal[~self.block.places.bolt]).max(initial=0.0)
        return float(max(pressed, np.abs(self.solution.pressure).max(initial=0.0), self.offsets.least))

    @cached_property
    def _allowed(self) -> Floats:
        return np.asarray(self.block.places.friction * np.maximum(self._normal, 0.0))

    @cached_property
    def violations(self) -> tuple[Floats, Floats, Floats]:
        """Violation, MPa, of pins, normal contact and friction (unless all slip is given); 0 where right."""
        guess, found, effects, at = self.guess, self.solution, self.block.effects, self.block.places.normal
        pins = np.where(guess.touching, -found.pressure, -found.pin_gap / effects.soft)
        gaps = (self.offsets.gap + found.moved)[at]
        normal = np.where(guess.opened, -gaps * effects.stiff[at], -self._normal)
        wrong = np.zeros(0)
        if self.block.has_friction:
            excess = np.hypot(*self._tangential[1].T) - self._allowed
            wrong = np.where(guess.slipping, -excess, excess) * (self.block.places.frictional & ~guess.opened)
        little = ROUNDING * self.size
        return tuple(np.where(values > little, values, 0.0) for values in (pins, normal, wrong))  # type: ignore[return-value]

    @cached_property
    def _turned(self) -> Floats:
        """Error (k,) of the direction of the shear stress where places slip, MPa."""
        if not self.block.has_friction:
            return np.zeros(0)
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
        return np.asarray(self.offsets.forces - self.block.R.T @ self.solution.pressure)

    @cached_property
    def imbalance(self) -> float:
        """Error of the resultants of the pins, relative to them."""
        size = float(np.linalg.norm(self.offsets.forces))
        return float(np.linalg.norm(self.left)) / size if size > 0 else 0.0

    def obeys(self, exact: "Tolerances") -> bool:
        """Whether every law holds."""
        worst = max(float(values.max(initial=0.0)) for values in self.violations)
        turned = float(self._turned.max(initial=0.0))
        return worst <= exact.violation * self.size and turned <= exact.direction * self.size

    def corrected(self, pins: Mask, normal: Mask, friction: Mask) -> Guess:
        """Return the guess that follows where this one is wrong about pins, openings and slips."""
        guess = self.guess
        touching, opened = guess.touching ^ pins, guess.opened ^ normal
        if not self.block.has_friction:
            return replace(guess, touching=touching, opened=opened)
        _, trial = self._tangential
        length = np.hypot(*trial.T)
        # Where slip would turn round, there is none.
        turns_round = guess.slipping & ((guess.direction * trial).sum(axis=1) < 0)
        slipping = (guess.slipping ^ friction) & ~opened & ~turns_round
        slipping |= guess.opened & ~opened & self.block.places.frictional & (length > 0)
        ratio = np.divide(self._allowed, length, out=np.zeros_like(length), where=length > 0)
        return replace(
            guess,
            touching=touching,
            opened=opened,
            slipping=slipping,
            direction=np.where(slipping[:, None], _unit(trial), 0.0),
            ratio=np.where(slipping, np.minimum(ratio, 1.0), 0.0),
        )


def _unit(vectors: Floats) -> Floats:
    length = np.hypot(*vectors.T)[:, None]
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
