"""Estimated contact pressures, and an upper bound of their error that needs no solution.

The pressures λ minimise ½ λᵀCλ + gᵀλ with λ ≥ 0 and Rᵀλ = F (`fea.contact.active_set`). Let λ̂ be others that
are not negative and have the same resultants, and w = Cλ̂ + g − R d their gap with any motions d. As λ is the
minimum, the error e = λ̂ − λ fulfils

    ‖e‖² = eᵀC e ≤ wᵀe.

Split the gap into w = u + v with v ≥ 0. Then vᵀe ≤ vᵀλ̂ =: b, as λ ≥ 0, and uᵀe ≤ a ‖e‖ with
a² = min_y (u − R y)ᵀ C⁻¹ (u − R y), as Rᵀe = 0. So ‖e‖² ≤ a ‖e‖ + b, and

    ‖e‖ ≤ (a + √(a² + 4 b)) / 2.

v is the part of w that is open where λ̂ presses little, u is the rest: λ̂ = λ gives u = 0 and b = 0.
"""

import numpy as np
from scipy.linalg import solve_triangular

from fea.contact.active_set import BALANCE
from geometry.arrays import Floats, Ints

# Pressures that are little, relative to the largest of an instant.
_LITTLE = 0.01
# Relative: no pressure resists a motion with less than this.
_UNRESISTED = 1e-10


def interpolated(values: Floats, knots: Ints, places: Ints) -> Floats:
    """Interpolate values (n, n_knots) at rising knots by cubic polynomials through the four nearest."""
    order = min(4, len(knots))
    first = np.clip(np.searchsorted(knots, places, side="right") - order // 2, 0, len(knots) - order)
    near = knots[first + np.arange(order)[:, None]].astype(float)  # (order, n_places)
    result = np.zeros((len(values), len(places)))
    for k in range(order):
        others = np.delete(near, k, axis=0)
        result += values[:, first + k] * np.prod((places - others) / (near[k] - others), axis=0)
    return result


class PressureEstimator:
    """Makes guesses of pressures admissible, and bounds their error, with C (n, n) and R (n, m)."""

    def __init__(self, compliance: Floats, rigid: Floats) -> None:
        self._C, self._scale = compliance, np.abs(rigid).max(axis=0, initial=0.0)
        self._R = rigid / np.where(self._scale > 0, self._scale, 1.0)
        self._root = np.linalg.cholesky(compliance)  # C = L Lᵀ
        self._free = np.linalg.qr(solve_triangular(self._root, self._R, lower=True))[0]
        self._pairs = (self._R[:, :, None] * self._R[:, None]).reshape(len(rigid), -1)

    def estimate(self, guess: Floats, gap: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Return admissible pressures (n, k) near guesses, and bounds (k,) of their errors ‖e‖, (N mm)^½.

        `gap` (n, k) and `force` (m, k) are those of the problems. The bound is infinite where the guess has
        no such pressures near.
        """
        pressure = np.maximum(guess, 0.0)
        force = force / np.where(self._scale > 0, self._scale, 1.0)[:, None]
        pressure *= 1 + self._R @ self._least(pressure, force - self._R.T @ pressure)
        missing = np.abs(self._R.T @ np.maximum(pressure, 0.0) - force).max(axis=0, initial=0.0)
        largest = np.abs(self._R.T @ np.abs(pressure)).max(axis=0, initial=0.0)
        admissible = (pressure.min(axis=0) >= 0) & (missing <= BALANCE * largest)
        pressure = np.maximum(pressure, 0.0)
        left = self._C @ pressure + gap
        left -= self._R @ self._least(pressure, self._R.T @ (pressure * left))
        opened = np.where(pressure <= _LITTLE * pressure.max(axis=0), np.maximum(left, 0.0), 0.0)
        rest = solve_triangular(self._root, left - opened, lower=True, check_finite=False)
        rest -= self._free @ (self._free.T @ rest)
        a, b = np.linalg.norm(rest, axis=0), np.einsum("ik,ik->k", opened, pressure)
        return pressure, np.where(admissible, (a + np.sqrt(a**2 + 4 * b)) / 2, np.inf)

    def _least(self, weight: Floats, side: Floats) -> Floats:
        """Motions y (m, k) with Rᵀ diag(weight) R y = side, the least ones where there are several."""
        m = len(side)
        matrices = (self._pairs.T @ weight).T.reshape(-1, m, m)
        inverse = np.linalg.pinv(matrices, rcond=_UNRESISTED, hermitian=True)
        return np.asarray((inverse @ side.T[..., None])[..., 0].T)
