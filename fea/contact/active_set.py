"""The small dense problem of frictionless contact.

    minimise ½ λᵀCλ + gᵀλ   with λ ≥ 0 and Rᵀλ = F

λ are the pressures, C the compliance of both bodies, g the gap that loads other than λ leave, and F the
resultants along the rigid motions R that are free. The optimality conditions are those of contact: the gap
w = Cλ + g − R d ≥ 0 with the rigid motions d, and w λ = 0 in each place.

`fea.contact.friction_system` with μ = 0 finds the same pressures, to 2e-11, but takes three to four times as
long: its matrices are not symmetric, and it does not keep the factor of the last contact area.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.optimize import nnls
from scipy.sparse.csgraph import connected_components

from fea.solid.errors import ContactError
from geometry.arrays import Floats, Ints, Mask

# Changes of the contact area before single exchanges take over: a near start takes two or three, a distant
# one six to ten.
MOST_CHANGES = 25
# A gap that counts as none, relative to the largest of the parts that it is the difference of.
TOLERANCE = 1e-12
# Largest relative error of the resultants.
BALANCE = 1e-9
# Solved loads whose contact areas are kept.
_KEPT = 1000
_UNSETTLED = (
    "the contact area did not settle, because rounding errors are too large: choose a larger --size or "
    "another --pressure"
)
# Relative: below it, no place in contact is sure to resist a motion.
_RESISTED = 1e-2


@dataclass(frozen=True)
class FrictionlessState:
    """A solution."""

    pressure: Floats  #: λ (n,), not negative, MPa
    motion: Floats  #: d (m,)
    gap: Floats  #: w (n,), the moments of the gap; rounding where the pressure is positive
    changes: int  #: how many contact areas were tried
    #: Largest overlap, or gap under pressure, relative to the largest part that the gap is made of
    residual: float
    imbalance: float  #: largest error of the resultants, relative to them

    @property
    def values(self) -> Floats:
        """λ (n,): the pressures are the only unknowns."""
        return self.pressure


class ContactSystem:
    """Solves for several loads, with C (n, n) and R (n, m), each from contact areas of solved loads like it.

    The primal-dual active set (Hintermüller, Itō & Kunisch 2003) changes all places at once and usually ends
    in a few steps. If it does not, a primal active-set method (Nocedal & Wright 2006, algorithm 16.3) starts
    from pressures that have the resultants and exchanges single places: each step lowers the energy and no
    contact area comes twice, so it ends.
    """

    def __init__(self, compliance: Floats, rigid: Floats) -> None:
        self._C, self._R = compliance, rigid
        scale = np.abs(rigid).max(axis=0, initial=0.0)
        self._scale = np.where(scale > 0, scale, 1.0)
        # Motions and places of each pin; resultants and areas of the loads that were solved last.
        count, pin = connected_components(np.abs(rigid).T @ np.abs(rigid))
        self._pins = [(pin == number, (rigid[:, pin == number] != 0).any(axis=1)) for number in range(count)]
        self._forces = np.zeros((_KEPT, rigid.shape[1]))
        self._areas = np.zeros((_KEPT, len(rigid)), dtype=bool)
        self._solved = 0
        # Places of the last area, its factor, and its answer to the motions: the next load begins with it.
        self._factorised: tuple[Ints, Floats, Floats] | None = None

    def solve(self, gap: Floats, force: Floats) -> FrictionlessState:
        """Solve for gap (n,) and resultants (m,); `ContactError`: no pressure fits."""
        contact = self._primal_dual(gap, force, self._near(force)) if self._solved else None
        contact = contact or self._primal_dual(gap, force, self._R @ force > 0)
        contact = contact or self._exchanged(gap, force)
        place = self._solved % _KEPT
        self._forces[place], self._areas[place] = force, contact.pressure > 0
        self._solved += 1
        return contact

    def _near(self, force: Floats) -> Mask:
        """Return the contact area of each pin under the nearest of its solved resultants, else the last."""
        area: Mask = self._areas[(self._solved - 1) % _KEPT].copy()
        for motions, places in self._pins:
            apart = np.linalg.norm(self._forces[: self._solved, motions] - force[motions], axis=1)
            area[places] = self._areas[apart.argmin(), places]
        return area

    def _primal_dual(self, gap: Floats, force: Floats, active: Mask) -> FrictionlessState | None:
        """Change all places at once; None if that does not settle."""
        tried = set()
        for change in range(1, MOST_CHANGES + 1):
            pressure, motion = self._touching(active, gap, force)
            left = self._gap(pressure, motion, gap)
            better = np.where(active, pressure >= -_little(pressure), left < -_slack(left, gap)).astype(bool)
            if (better == active).all():
                contact = self._contact(pressure, motion, left, gap, force, changes=change)
                return contact if contact.imbalance <= BALANCE else None
            if (key := better.tobytes()) in tried:
                return None
            tried.add(key)
            active = better
        return None

    def _exchanged(self, gap: Floats, force: Floats) -> FrictionlessState:
        """Exchange single places, from pressures that have the resultants."""
        pressure = balanced(self._R / self._scale, force / self._scale)
        active = pressure > 0
        for change in range(MOST_CHANGES + 1, MOST_CHANGES + 1000 + 50 * len(gap)):
            solved, motion = self._touching(active, gap, force)
            sinking = np.flatnonzero(active & (solved < -_little(solved)))
            if sinking.size:  # go as far as no pressure becomes negative, and let that place go
                shares = pressure[sinking] / (pressure[sinking] - solved[sinking])
                pressure = pressure + shares.min() * (solved - pressure)
                first = sinking[shares.argmin()]
                pressure[first], active[first] = 0.0, False
                continue
            # A place may touch without pressure, as one of a pair that only together has no resultant.
            pressure = np.maximum(solved, 0.0)
            left = self._gap(pressure, motion, gap)
            deepest = int(np.where(active, 0.0, left).argmin())
            if active[deepest] or left[deepest] >= -_slack(left, gap):
                return self._contact(pressure, motion, left, gap, force, changes=change)
            active[deepest] = True
        raise ContactError(_UNSETTLED)

    def _touching(self, active: Mask, gap: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Pressures (n,) and motions (m,) that close the gap in the active places and balance the load."""
        touching = np.flatnonzero(active)
        if not touching.size:
            return np.zeros(len(gap)), np.zeros(len(force))
        rigid = self._R[touching]
        known = self._factorised  # another thread may replace it meanwhile
        if known is None or not np.array_equal(known[0], touching):
            # The block is symmetric: its transpose has the order of LAPACK.
            factor, failed = dpotrf(self._C[np.ix_(touching, touching)].T, lower=1, clean=0, overwrite_a=1)
            if failed:
                raise ContactError(_UNSETTLED)
            known = touching, factor, dpotrs(factor, rigid, lower=1)[0]
            self._factorised = known
        _, factor, moved = known
        at_rest = dpotrs(factor, gap[touching], lower=1)[0]
        scale = self._scale
        motion = _balancing((rigid.T @ moved) / np.outer(scale, scale), (force + rigid.T @ at_rest) / scale)
        motion /= scale
        pressure = np.zeros(len(gap))
        pressure[touching] = moved @ motion - at_rest
        return pressure, motion

    def _contact(
        self, pressure: Floats, motion: Floats, left: Floats, *given: Floats, changes: int
    ) -> FrictionlessState:
        """Return a solution with the gap that is left, and how far it misses a gap and resultants `given`."""
        gap, force = given
        pressure, scale = np.maximum(pressure, 0.0), self._scale
        overlap = max(-left.min(), np.abs(left[pressure > 0]).max(initial=0.0))
        size = _slack(left, gap) / TOLERANCE
        missing = np.linalg.norm((self._R.T @ pressure - force) / scale)
        # Without resultants, as of a press fit alone, what the pressures are the balance of.
        total = max(np.linalg.norm(force / scale), np.linalg.norm(np.abs(self._R.T) @ pressure / scale))
        residual = float(overlap / max(size, np.finfo(float).tiny))
        imbalance = float(missing / max(total, np.finfo(float).tiny))
        return FrictionlessState(pressure, motion, left, changes, residual, imbalance)

    def _gap(self, pressure: Floats, motion: Floats, gap: Floats) -> Floats:
        return np.asarray(self._C @ pressure + gap - self._R @ motion)


def balanced(rigid: Floats, force: Floats) -> Floats:
    """Pressures (n,) with resultants F (m,) along R (n, m), in as few places as there are resultants.

    The columns of R are of size one, and F is in the same units. Raises `ContactError`: there are none.
    """
    pressure, missing = nnls(rigid.T, force)
    if missing > BALANCE * np.linalg.norm(force):
        message = (
            "no contact pressure on the bores has the resultants of the pin forces: a bore is open on "
            "the side that its pin pulls at. Close it, or choose another --pressure"
        )
        raise ContactError(message)
    return np.asarray(pressure)


def _balancing(resistance: Floats, force: Floats) -> Floats:
    """Motions (m,) that balance forces; one that no place in contact resists stays zero."""
    factor, failed = dpotrf(resistance, lower=1, clean=0)
    if not failed and (own := factor.diagonal()).min() > _RESISTED * own.max():
        return np.asarray(dpotrs(factor, force, lower=1)[0])
    return np.asarray(np.linalg.lstsq(resistance, force, rcond=1e-12)[0])


def _little(pressure: Floats) -> float:
    """Pressure that rounding may leave where there is none."""
    return float(TOLERANCE * np.abs(pressure).max(initial=0.0))


def _slack(left: Floats, gap: Floats) -> float:
    """Gap that rounding may leave where there is none."""
    return float(TOLERANCE * (np.abs(left - gap).max() + np.abs(gap).max()))
