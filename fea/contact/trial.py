"""One guess of what touches, opens and slips: its linear problem, and how it violates contact or friction."""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import lapack

from fea.contact.block import Block
from fea.contact.guess import Guess, Offsets
from fea.machine.threads import every_blas_thread
from geometry.arrays import Floats, Ints, Mask

# What rounding leaves, relative to the largest stress; the error of the directions of slip at the end.
ROUNDING, DIRECTION = 1e-11, 1e-9
# Reciprocal condition number, of a scaled matrix, below which a motion counts as free.
_SINGULAR = 1e-12
# Smallest over largest pivot above which the condition need not be known.
_SAFE = 1e-8
# Unknowns above which several threads factorise faster than one.
_LARGE = 400
_TWO = np.eye(2)


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
    """

    block: Block
    offsets: Offsets
    guess: Guess
    pressure: Floats
    motion: Floats
    moved: Floats
    stress: Floats
    pin_gap: Floats

    @classmethod
    def of(cls, block: Block, offsets: Offsets, guess: Guess) -> "Trial":
        """Solve for what touches, opens and slips."""
        active = np.flatnonzero(guess.touching)
        law = _Law.of(block, guess)
        moving, R = law.moving, block.R
        n_a, n_d, m = len(active), len(moving), R.shape[1]
        unit = 1 / np.sqrt(block.stiff[moving])
        press = 1 / np.sqrt(block.soft[active])
        matrix = np.zeros((n_a + n_d + m,) * 2, order="F")
        matrix[:n_a, :n_a] = press[:, None] * block.A[np.ix_(active, active)] * press
        matrix[:n_a, n_a : n_a + n_d] = press[:, None] * block.B[np.ix_(moving, active)].T * unit
        matrix[:n_a, n_a + n_d :] = -press[:, None] * R[active]
        matrix[n_a : n_a + n_d, :n_a] = -unit[:, None] * law.of_rows(block.B, active) * press
        matrix[n_a : n_a + n_d, n_a : n_a + n_d] = (
            unit[:, None] * (law.of_rows(block.S, moving) + law.give) * unit
        )
        matrix[n_a + n_d :, :n_a] = (press[:, None] * R[active]).T
        side = np.concatenate(
            [-press * offsets.pin_gap[active], -unit * law.of_values(offsets.stress), offsets.forces]
        )
        found = _solved(matrix, side)
        pressure, moved = np.zeros(len(block.pins)), np.zeros(len(block.joined))
        pressure[active], moved[moving] = press * found[:n_a], unit * found[n_a : n_a + n_d]
        motion = found[n_a + n_d :]
        return cls(
            block=block,
            offsets=offsets,
            guess=guess,
            pressure=pressure,
            motion=motion,
            moved=moved,
            stress=offsets.stress - block.B @ pressure + block.S @ moved,
            pin_gap=block.A @ pressure + moved @ block.B + offsets.pin_gap - R @ motion,
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
    def imbalance(self) -> float:
        """Error of the resultants of the pins, relative to them."""
        forces = self.offsets.forces
        size = float(np.linalg.norm(forces))
        return float(np.linalg.norm(self.block.R.T @ self.pressure - forces)) / size if size > 0 else 0.0

    @property
    def obeys(self) -> bool:
        """Whether every law holds."""
        wrong = any(values.any() for values in self.violations)
        return not wrong and bool(self._turned.max(initial=0.0) <= DIRECTION * self.size)

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


@dataclass(frozen=True)
class _Law:
    """The law L λ_J + K Δy = 0 of the gaps that are unknown.

    Attributes
    ----------
    moving
        (n,) positions of these gaps in the block.
    rows, share
        (l,) positions of the stresses in the law, and L (n, l).
    give
        K (n, n).
    """

    moving: Ints
    rows: Ints
    share: sparse.csr_array
    give: Floats

    def of_rows(self, matrix: Floats, columns: Ints) -> Floats:
        """L M (n, k), of some columns of a matrix M (n_J, …)."""
        return np.asarray(self.share @ matrix[np.ix_(self.rows, columns)])

    def of_values(self, stress: Floats) -> Floats:
        """L λ_J (n,)."""
        return np.asarray(self.share @ stress[self.rows])

    @classmethod
    def of(cls, block: Block, guess: Guess) -> "_Law":
        """The law of a guess."""
        places, tangential = block.places, block.places.tangential
        opened, slips = np.flatnonzero(guess.opened), np.flatnonzero(guess.slipping & ~guess.opened)
        free = tangential[opened].ravel()
        unloaded = np.concatenate([places.normal[opened], free[free >= 0]])
        slid = tangential[slips]
        has = slid >= 0
        moving = np.concatenate([unloaded, slid[has]])
        row = np.full(slid.shape, -1)
        row[has] = len(unloaded) + np.arange(has.sum())
        along = guess.direction[slips]
        # The derivative of the direction of slip acts square to it.
        turn = guess.ratio[slips, None, None] * (_TWO - along[:, :, None] * along[:, None, :])
        rows, columns, values = (
            [np.arange(len(unloaded))],
            [np.arange(len(unloaded))],
            [np.ones(len(unloaded))],
        )
        give = np.zeros((len(moving),) * 2)
        for one in range(2):
            own = has[:, one]
            rows.append(row[own, one])
            columns.append(len(moving) + np.flatnonzero(own))
            values.append(-places.friction[slips[own]] * along[own, one])
            for other in range(2):
                both = own & has[:, other]
                rows.append(row[both, one])
                columns.append(row[both, other])
                values.append(_TWO[one, other] - turn[both, one, other])
                give[row[both, one], row[both, other]] = turn[both, one, other] * block.against[slips[both]]
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        stresses = np.concatenate([moving, places.normal[slips]])
        share = sparse.csr_array(entries, shape=(len(moving), len(stresses)))
        return cls(moving, stresses, share, give)


def _unit(vectors: Floats) -> Floats:
    length = np.hypot(*vectors.T)[:, None]
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))


def _solved(matrix: Floats, side: Floats) -> Floats:
    """Solve; a motion that nothing resists, as that of a part that has come off, stays zero."""
    if not len(side):
        return side
    with every_blas_thread() if len(side) > _LARGE else nullcontext():
        factor, pivots, broken = lapack.dgetrf(matrix)
    pivot = np.abs(np.diag(factor))
    if broken == 0 and pivot.min() > _SAFE * pivot.max():
        well = 1.0
    else:
        well, _ = lapack.dgecon(factor, np.abs(matrix).sum(axis=0).max()) if broken == 0 else (0.0, 0)
    if well > _SINGULAR:
        return np.asarray(lapack.dgetrs(factor, pivots, side)[0])
    return np.asarray(np.linalg.lstsq(matrix, side, rcond=_SINGULAR)[0])
