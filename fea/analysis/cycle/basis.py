"""Unit loads with their solutions: what spans the crank cycles of a rod.

Where pins are in contact, few sums of the unit loads stand for all of them. The pressures of every instant
are known before any stress is, as the solution of the contact problems alone. A small basis contains the
inertia, the forces of the pins, and the principal patterns of these pressures in the norm of their work
(method of snapshots, Sirovich 1987, Q. Appl. Math. 45, 561), where instants that are represented badly count
more. So what it leaves out of the pressures is known at every place and instant. That part is balanced on
each bore and changes sign over short distances: it acts in its neighbourhood alone, and the stress that it
causes is of its own size.

How large this stress is is measured: what is left out at the worst instants is solved directly. The largest
stress per pressure found there, times the pressures that are still left out elsewhere, is the error that is
stated. It is an estimate from a sample and no bound, which would need the very solutions that are saved.
Singular places do not count, neither the pressure that is left out there, nor its stress, unless the peak
cases, solved directly, show too large an error: then every place counts, with the stress per pressure found.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.judge.history import deviator_norm
from fea.pins.model import SMOOTH, Contacts, JointBounds, UnitLoadFields, UnitLoads, Weights
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

if TYPE_CHECKING:
    from fea.pins.contact import ContactUnits

# Solves even and odd unit loads and recovers their stress.
Solve = Callable[[tuple[UnitLoadFields, UnitLoadFields]], UnitSolutions]


class Basis(ABC):
    """Unit loads and their solutions.

    Attributes: `loads`: the unit loads that span every instant; `units`: solutions of these, or of those of
    their sums that make up the basis; `error`: estimated error of the stress at any place and instant,
    relative to the largest of the cycle.
    """

    loads: UnitLoads
    units: UnitSolutions
    error: float = 0.0

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of `units` at n instants; `cycle` as for `fea.pins.model.PinModel.respond`."""
        return self.projected(self.full(instants, cycle))

    def projected(self, full: Weights) -> Weights:
        """Weights of `units`, from those of `loads`."""
        return full

    @abstractmethod
    def exact_at(self, full: Weights) -> None:
        """Make instants exact at every node, given weights of `loads`."""

    @abstractmethod
    def fields(self) -> tuple[UnitLoadFields, UnitLoadFields]:
        """Return the even and the odd loads of `units`."""

    def full(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of `loads` at n instants; `cycle` as above."""
        return self.loads.weights(instants, cycle)

    def contacts(self, cycle: CrankCycle) -> Contacts:
        """Contact at every degree of a cycle."""
        return self.loads.contacts(self.full(cycle.degrees, cycle), cycle.degrees, cycle)


class FullBasis(Basis):
    """Every unit load by itself."""

    def __init__(self, loads: UnitLoads, solve: Solve) -> None:
        self.loads = loads
        self.units = solve(loads.fields()).bounded(loads.joint)

    def exact_at(self, full: Weights) -> None:
        """Every instant is exact: see `Basis.exact_at`."""

    def fields(self) -> tuple[UnitLoadFields, UnitLoadFields]:
        """Return the even and the odd unit loads."""
        return self.loads.fields()


# Largest error at any place and instant, relative to the largest stress of the cycle.
ACCURACY = 5e-3
# Stress per pressure that is left out, at least, as a few instants do not show the largest: of pins alone,
# and where parts rub against each other too.
_PRESSED, _RUBBED = 0.75, 1.0
# Patterns of either parity with which the largest stress is worked out, and those that are added at a time.
_FIRST, _MORE = 16, 4
# The largest stress is looked for at every so many instants.
_EVERY = 15
# At how many instants the error is measured, and how many instants lie between them at least.
_MEASURED, _APART = 4, 15
# What is nothing beside the largest weights, and how often a subspace is iterated.
_NOTHING, _ITERATIONS = 1e-9, 3
# Cycles whose states are remembered.
_REMEMBERED = 5


def spanned(loads: UnitLoads, solve: Solve, counts: Mask, cycles: Sequence[CrankCycle]) -> Basis:
    """Return a small basis where pins are in contact, and else all unit loads; see `SmallBasis`."""
    from fea.pins.contact import ContactUnits  # noqa: PLC0415 - prescribed pressures do without

    if isinstance(loads, ContactUnits):
        return SmallBasis(loads, solve, counts, cycles)
    return FullBasis(loads, solve)


class _States(NamedTuple):
    """Weights of the full unit loads over a cycle, and its largest von Mises stress, MPa."""

    degrees: Weights  #: at every degree
    every: Weights  #: and in its peak cases
    largest: float


class SmallBasis(Basis):
    """Sums of the unit loads of pins in contact.

    It grows where another cycle is asked for, or where instants shall be exact. New sums follow those before
    them, so that earlier weights remain valid. `solve`: solves unit loads and recovers their stress;
    `counts`: (n,) nodes of the cell that count: those away from singular places; `cycles`: the cycles that
    are spanned from the beginning, one at least.

    Attributes: `sensitivity`: per part, (2, n_sides, n): the largest von Mises and mean stress found per
    pressure that was left out.
    """

    loads: "ContactUnits"

    def __init__(
        self, loads: "ContactUnits", solve: Solve, counts: Mask, cycles: Sequence[CrankCycle]
    ) -> None:
        self.loads, self._solve, self._counts = loads, solve, counts
        self._full = loads.fields()
        self._pressing = loads.contact.pressing(counts)[:, None]
        self._stress = _RUBBED if loads.path_dependent else _PRESSED
        self._kept = [min(kept, of.count) for kept, of in zip(loads.kept, self._full, strict=True)]
        self._pressed = np.unique(loads.contact.problem.forces.nonzero()[0] // 3)
        self._remembered: dict[bytes, _States] = {}
        self._columns = [self._exact(parity) for parity in Parity]
        states = [self._states(cycle) for cycle in cycles]
        every = joined(*(state.every for state in states))
        first = [_leading(rest, _FIRST, self._nothing(every)) for rest in self.left(every)]
        self._columns = [np.hstack(pair) for pair in zip(self._columns, first, strict=True)]
        self.units = solve(self.fields())
        self.sensitivity = [np.zeros((2, len(self.units.sides), len(of.nodes))) for of in self.units.parts]
        for cycle, state in zip(cycles, states, strict=True):
            self._span(cycle, state)

    def _exact(self, parity: Parity) -> Floats:
        """Columns (n, k) of what is exact at every instant: the loads kept, and the forces of the pins."""
        number = list(Parity).index(parity)
        fields, kept = self._full[number], self._kept[number]
        forces = self.loads.pin_forces(parity, fields.patterns).T
        forces[fields.count - kept :] = 0.0
        nothing = _NOTHING * float(np.linalg.norm(forces, axis=0).max(initial=0.0))
        alone = np.eye(fields.count)[:, fields.count - kept :]
        return np.hstack([alone, _orthonormal(forces, alone, nothing)])

    def projected(self, full: Weights) -> Weights:
        """Weights of the sums: see `Basis.projected`."""
        return Weights(*(columns.T @ w for columns, w in zip(self._columns, full, strict=True)))

    def fields(self) -> tuple[UnitLoadFields, UnitLoadFields]:
        """Return the even and the odd sums."""
        return self._combined(self._columns)

    def full(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the full unit loads; the basis grows until it spans the cycle that is given."""
        if cycle is None:
            return self.loads.weights(instants)
        key = _key(cycle.degrees)
        if key not in self._remembered:
            self._span(cycle, self._states(cycle))
        known, count = self._remembered[key].degrees, len(cycle.degrees)
        if _key(instants[:count]) != key:
            return self.loads.weights(instants, cycle)
        if len(instants) == count:
            return known
        return joined(known, self.loads.weights(instants[count:], cycle))

    def left(self, full: Weights) -> Weights:
        """What the basis leaves out, as weights of the full unit loads; exactly zero where it is rounding."""
        left = [w - c @ (c.T @ w) for c, w in zip(self._columns, full, strict=True)]
        some = np.linalg.norm(np.vstack(left), axis=0) > self._nothing(full)
        return Weights(left[0] * some, left[1] * some)

    def _nothing(self, full: Weights) -> float:
        """Length of weights that is nothing beside those of the patterns at any instant."""
        patterns = np.vstack([rows[: len(rows) - kept] for rows, kept in zip(full, self._kept, strict=True)])
        return _NOTHING * float(np.linalg.norm(patterns, axis=0).max(initial=0.0))

    def pressure(self, full: Weights) -> Floats:
        """Largest pressure (n_instants,) at places that count, MPa, of weights of the full unit loads."""
        even, odd = (np.abs(of.patterns @ w) for of, w in zip(self._full, full, strict=True))
        return np.asarray((self._pressing * (even + odd)).max(axis=0))

    def largest(self, cycle: CrankCycle) -> float:
        """Largest von Mises stress of a cycle, MPa, to a few per cent."""
        self.full(cycle.degrees, cycle)
        return self._remembered[_key(cycle.degrees)].largest

    def influence(self, number: int, rows: Ints) -> Floats:
        """Stress per pressure left out, at some nodes of a part: (n_sides, 2, n), von Mises and mean.

        It is twice the largest that was found at the node; where pins or parts press, at least the largest
        of any node.
        """
        ratio = self.sensitivity[number]
        most = ratio.max(axis=(1, 2), keepdims=True)
        pressed = np.isin(self.units.parts[number].nodes[rows], self._pressed)
        return np.moveaxis(np.maximum(2 * ratio[..., rows], np.where(pressed, most, 0.0)), 0, 1)

    def exact_at(self, full: Weights) -> None:
        """Make instants exact at every node: what is left out of them is solved and joins the basis."""
        self._extend([columns[:, :0] for columns in self._columns], self.left(full), self._nothing(full))

    def corrected(self, cycle: CrankCycle, full: Weights, apart: Floats) -> bool:
        """Grow if direct solutions show too large an error, also at singular places; whether it grew.

        `full`: weights of the full unit loads in n peak cases; `apart` (n,): their largest errors, MPa.
        """
        count = self.units.count
        if apart.max(initial=0.0) > ACCURACY * self.largest(cycle):
            self._pressing = self.loads.contact.pressing(np.ones_like(self._counts))[:, None]
            pressure = self.pressure(self.left(full))
            found = apart[pressure > 0] / pressure[pressure > 0]
            self._stress = float(found.max(initial=self._stress))
            self._span(cycle, self._remembered.pop(_key(cycle.degrees)))
        return self.units.count > count

    def _states(self, cycle: CrankCycle) -> _States:
        cases = cycle.peaks.cases
        degrees, peaks = self.loads.weights(cycle.degrees, cycle), self.loads.weights(cases)
        more = [self.loads.weights(cases[cases.in_cycle], cycle)] if self.loads.path_dependent else []
        return _States(degrees, joined(degrees, peaks, *more), np.nan)

    def _span(self, cycle: CrankCycle, states: _States) -> None:
        every, largest = states.every, self._largest(states.every)
        stress, error = self._stress, np.inf
        while error > ACCURACY * largest:
            grown, left = self._grown(every, ACCURACY * largest / stress)
            self._extend(grown, left.at(_worst(self.pressure(left))), self._nothing(every))
            stress = max(stress, *(float(ratio[0].max(initial=0.0)) for ratio in self.sensitivity))
            error = stress * float(self.pressure(self.left(every)).max())
        self.error = max(self.error, error / max(largest, np.finfo(float).tiny))
        if len(self._remembered) == _REMEMBERED:
            del self._remembered[next(iter(self._remembered))]
        self._remembered[_key(cycle.degrees)] = states._replace(largest=largest)

    def _largest(self, full: Weights) -> float:
        """Largest von Mises stress (MPa) of the nodes that count at some of the instants."""
        some, largest = self.projected(full.at(slice(None, None, _EVERY))), 0.0
        for part in self.units.parts:
            rows = np.flatnonzero(self._counts[part.nodes])
            for history in part.histories(some, self.units.sides, rows):
                largest = max(largest, float(deviator_norm(history).max(initial=0.0)))
        return largest

    def _grown(self, full: Weights, allowed: float) -> tuple[list[Floats], Weights]:
        """Patterns with which no more than a pressure is left out, and what is left out then."""
        left, grown, nothing = self.left(full), [c[:, :0] for c in self._columns], self._nothing(full)
        while (pressure := self.pressure(left)).max() > allowed:
            worse = (pressure / pressure.max()) ** 3  # of the powers tried, it needs the fewest
            more = [_leading(part * worse, _MORE, nothing) for part in left]
            if not any(columns.shape[1] for columns in more):
                break
            grown = [np.hstack(pair) for pair in zip(grown, more, strict=True)]
            left = Weights(*(w - c @ (c.T @ w) for c, w in zip(more, left, strict=True)))
        return grown, left

    def _extend(self, grown: list[Floats], left: Weights, nothing: float) -> None:
        """Solve more sums, and what is left out at some instants beside them: see how much stress it is."""
        pressure = self.pressure(left)
        left, pressure = left.at(pressure > 0), pressure[pressure > 0]
        known = [np.hstack(pair) for pair in zip(self._columns, grown, strict=True)]
        rest = [_orthonormal(*pair, nothing) for pair in zip(left, known, strict=True)]
        more = [np.hstack(pair) for pair in zip(grown, rest, strict=True)]
        if not any(columns.shape[1] for columns in more):
            return
        units = self._solve(self._combined(more))
        self._columns = [np.hstack(pair) for pair in zip(self._columns, more, strict=True)]
        causing = Weights(*(columns.T @ w for columns, w in zip(more, left, strict=True)))
        for stress, part in zip(self.sensitivity, units.parts, strict=True):
            for side, history in enumerate(part.histories(causing, units.sides, slice(None))):
                found = np.stack([deviator_norm(history), np.abs(history[:, 5])]) / pressure
                most = np.where(self._counts[part.nodes], found.max(axis=2, initial=0.0), 0.0)
                stress[:, side] = np.fmax(stress[:, side], most)
        ends = (columns.shape[1] for columns in self._columns)
        joint = (slice(n + SMOOTH, max(end, n + SMOOTH)) for n, end in zip(self._kept, ends, strict=True))
        self.units = self.units.followed_by(units).bounded(JointBounds(*joint))

    def _combined(self, columns: list[Floats]) -> tuple[UnitLoadFields, UnitLoadFields]:
        even, odd = (of.combined(some) for of, some in zip(self._full, columns, strict=True))
        return even, odd


def joined(*weights: Weights) -> Weights:
    """Weights at all of these instants."""
    return Weights(*map(np.hstack, zip(*weights, strict=True)))


def _key(instants: Instants) -> bytes:
    return b"".join((0.0 + acting).tobytes() for acting in (instants.pin, instants.crank, instants.motions))


def _worst(pressure: Floats) -> Ints:
    """Numbers of the instants at which most is left out, some way from each other."""
    chosen, left = list[int](), pressure.copy()
    while len(chosen) < _MEASURED and left.max() > 0:
        chosen.append(int(left.argmax()))
        left[max(chosen[-1] - _APART, 0) : chosen[-1] + _APART + 1] = 0.0
    return np.array(chosen, dtype=np.int64)


def _leading(states: Floats, count: int, nothing: float) -> Floats:
    """Left singular vectors (n, k) of the largest singular values of states (n, n_states), if not `nothing`.

    By iteration of a random subspace: Halko, Martinsson & Tropp 2011, SIAM Review 53, 217, algorithm 4.4.
    """
    start = np.random.default_rng(0).normal(size=(states.shape[1], min(2 * count, *states.shape)))
    basis = np.linalg.qr(states @ start)[0]
    for _ in range(_ITERATIONS):
        basis = np.linalg.qr(states @ np.linalg.qr(states.T @ basis)[0])[0]
    vectors, sizes, _ = np.linalg.svd(basis.T @ states, full_matrices=False)
    return np.asarray(basis @ vectors[:, :count][:, sizes[:count] > nothing])


def _orthonormal(states: Floats, known: Floats, nothing: float) -> Floats:
    """Orthonormal vectors (n, k) that span states (n, n_states) together with known ones (n, m)."""
    found = known
    for state in states.T:
        rest = state - found @ (found.T @ state)
        if np.linalg.norm(rest) > nothing:
            rest /= np.linalg.norm(rest)
            rest -= found @ (found.T @ rest)
            found = np.column_stack([found, rest / np.linalg.norm(rest)])
    return found[:, known.shape[1] :]
