"""The signed equivalent stress of a stress history, and its extremes.

Fatigue is assessed with one signed value per crank angle. The equivalent stress used here is the von Mises
stress with the sign of q(θ) · q(θ*), where q is the deviatoric vector and θ* the instant at which it is
longest: positive while the deviator points in the same direction as at θ*, negative while it points in the
opposite direction. The whole history then takes the sign of the mean stress at θ*, so that tension is
positive. For a proportional history, σ(θ) = f(θ) σ₀, this is exactly ±σ_vM with the sign of f. The usual
signs (of the mean stress, or of the principal stress of largest magnitude) fail for alternating torsion: both
give R = 0 instead of R = −1, and half the amplitude.

Rainflow counting of a repeated history: the cycles that close in its second period.

They are those of ASTM E1049 begun at the largest peak. A range between two that are not smaller is closed,
wherever it stands (the four-point rule), so that all such ranges of a history are taken out at once.
"""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from fea.judge.verdict import CAP
from geometry.arrays import Floats, Ints, Reals


def cycle_ends(history: Floats) -> Ints:
    """Return where in a period (n,) each cycle begins and ends: numbers (2, n_cycles) of its values."""
    start = int(np.argmax(history))
    order = np.append(np.roll(np.arange(len(history)), -start), start)
    rising = np.diff(history[order])
    order = order[np.append(True, rising != 0)]
    rising = rising[rising != 0] > 0
    order = order[np.concatenate([[True], rising[1:] != rising[:-1], [True]])] if rising.size else order[:0]
    ends = [np.empty((2, 0), dtype=np.int64)]
    while len(order) > 1:
        size = np.abs(np.diff(history[order]))
        closed = (size <= np.append(np.inf, size[:-1])) & (size <= np.append(size[1:], -np.inf))
        # Of equal ranges side by side, every other one.
        number = np.arange(len(size))
        closed &= (number - np.maximum.accumulate(np.where(closed, -1, number))) % 2 == 1
        at = np.flatnonzero(closed)
        if not at.size:
            raise ValueError("a history must be finite")
        ends.append(np.stack([order[at], order[at + 1]]))
        order = np.delete(order, np.concatenate([at, at + 1]))
    return np.concatenate(ends, axis=1)


def rainflow(history: Floats) -> tuple[Floats, Floats]:
    """Means and amplitudes of the cycles of a period (n,), each counted whole, wherever the period begins."""
    ends = history[cycle_ends(history)]
    return ends.mean(axis=0), np.ptp(ends, axis=0) / 2


Real = TypeVar("Real", bound=np.floating[Any])

_ROOT = 3**0.5
# Rows q₁…q₅ and σ_m, columns XX YY ZZ XY YZ XZ.
FROM_TENSOR = np.array(
    [
        [1, -1 / 2, -1 / 2, 0, 0, 0],
        [0, _ROOT / 2, -_ROOT / 2, 0, 0, 0],
        [0, 0, 0, _ROOT, 0, 0],
        [0, 0, 0, 0, _ROOT, 0],
        [0, 0, 0, 0, 0, _ROOT],
        [1 / 3, 1 / 3, 1 / 3, 0, 0, 0],
    ]
)
TO_TENSOR = np.linalg.inv(FROM_TENSOR)


def deviatoric(history: Floats) -> Floats:
    """Return q and σ_m (…, 6, n) of stress (…, 6, n), components XX YY ZZ XY YZ XZ."""
    return np.asarray(FROM_TENSOR.astype(history.dtype) @ history)


def tensor(components: Floats) -> Floats:
    """Return stress (…, 6, n) of q and σ_m (…, 6, n)."""
    return np.asarray(TO_TENSOR @ components)


def deviator_norm(components: npt.NDArray[Real]) -> npt.NDArray[Real]:
    """Return the von Mises stress (n, n_instants) of q and σ_m (n, 6, n_instants)."""
    q = components[:, :5]
    return np.asarray(np.sqrt(np.einsum("nct,nct->nt", q, q)))


def extreme_principals(components: Reals, equivalent: Reals) -> tuple[Reals, Reals]:
    """Largest and least principal stress (…, n) of q and σ_m (…, 6, n) with their von Mises stress (…, n).

    σ₁ = σ_m + ⅔ σ_vM cos θ and σ₃ = σ_m − ⅔ σ_vM cos(60° − θ) with the Lode angle θ in 0…60°: cos 3θ is
    the determinant of the deviator over its largest at that von Mises stress (Smith 1961).
    """
    q1, q2, xy, yz, xz, mean = np.moveaxis(components, -2, 0)
    first = q1 / _ROOT
    b, c = q2 - first, -q2 - first
    determinant = 2 * first * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    cube = 2 / _ROOT**3 * equivalent**3
    cosine = np.divide(determinant, cube, out=np.ones_like(cube), where=cube > 0)
    theta = np.arccos(np.clip(cosine, -1, 1)) / 3
    radius = 2 / 3 * equivalent
    return mean + radius * np.cos(theta), mean - radius * np.cos(np.pi / 3 - theta)


# A mean stress below this fraction of the von Mises stress has no sign: pure shear counts as tension.
NO_SIGN = 1e-9


@dataclass(frozen=True)
class Extremes:
    """Extremes of stress histories, each (n,)."""

    von_mises: Floats  #: largest von Mises stress, MPa
    instant: Ints  #: number of the instant of the largest von Mises stress
    #: principal_1, principal_3: largest and least principal stress, MPa
    principal_1: Floats
    principal_3: Floats
    #: highest, lowest: of the signed equivalent stress, MPa
    highest: Floats
    lowest: Floats

    @property
    def mean(self) -> Floats:
        """Mean of the signed equivalent's extremes, MPa."""
        return (self.highest + self.lowest) / 2

    @property
    def amplitude(self) -> Floats:
        """Half the range of the signed equivalent, MPa."""
        return (self.highest - self.lowest) / 2

    @property
    def ratio(self) -> Floats:
        """R, least over largest of the signed equivalent; capped if the largest is zero."""
        least = np.abs(self.lowest) / CAP
        below = np.where(np.abs(self.highest) > least, self.highest, np.copysign(least, self.highest))
        return np.divide(self.lowest, below, out=np.zeros_like(below), where=below != 0)


def signed_equivalent(history: Floats) -> Floats:
    """Signed von Mises stress (n, n_instants), MPa, of histories as `deviatoric` gives them."""
    squares, *_ = _signed_squares(history)
    return np.asarray(_signed_root(squares))


def mean_shift(history: Floats, constant: Floats) -> Floats:
    """By how much (n,), MPa, a constant stress (n, 6) moves the signed stress of histories (n, 6, n).

    It is the part of its deviator along their longest one. Components are as `deviatoric` gives them.
    """
    _, square, _, worst = _signed_squares(history)
    length = np.maximum(np.sqrt(square.max(axis=1)), 1e-300)
    return np.asarray((worst * constant[:, :5]).sum(axis=1) / length)


def _signed_squares(history: Floats) -> tuple[Floats, Floats, Ints, Floats]:
    """Signed square and square of the von Mises stress (n, n_instants), instant and q of the largest."""
    q, mean = history[:, :5], history[:, 5]
    square = np.einsum("nct,nct->nt", q, q)
    instant = square.argmax(axis=1)
    rows = np.arange(len(q))
    worst = q[rows, :, instant]
    compressed = mean[rows, instant] < -NO_SIGN * np.sqrt(square[rows, instant])
    worst = np.where(compressed[:, None], -worst, worst)
    along = (worst[:, None] @ q)[:, 0]
    return np.copysign(square, along), square, instant, worst


def _signed_root(square: Floats) -> Floats:
    return np.copysign(np.sqrt(np.abs(square)), square)


def extremes(history: Floats) -> Extremes:
    """Find the extremes of histories (n, 6, n_instants), MPa, as `deviatoric` gives them."""
    signed, square, instant, _ = _signed_squares(history)
    equivalent = np.sqrt(square)
    largest, least = extreme_principals(history, equivalent)
    return Extremes(
        equivalent[np.arange(len(history)), instant],
        instant,
        np.asarray(largest.max(axis=1), np.float64),
        np.asarray(least.min(axis=1), np.float64),
        _signed_root(signed.max(axis=1)),
        _signed_root(signed.min(axis=1)),
    )
