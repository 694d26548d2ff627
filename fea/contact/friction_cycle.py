"""States of an assembled rod over a crank cycle, which friction makes depend on what came before.

Increments follow each other until they are those of the cycle before; instants between two of them divide
their slip. Each end of the rod goes through the cycle by itself (`fea.contact.block`).
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from fea.contact.assembled import Assembled
from fea.contact.friction_system import ContactState, Load, Trials
from fea.contact.trial import Exact
from fea.machine.threads import one_blas_thread, threads
from geometry.arrays import Floats, Ints

# Cycles after which a course ends at the latest; over as many increments on end, bolt forces and the pressure
# of every place may differ from the cycle before by so much, relative to the largest, when it ends. (What a
# pressure at the edge of contact owes to the size of the increments is six times as much.)
MOST_CYCLES, ON_END, SETTLED, SETTLED_PLACES = 3, 10, 1e-3, 1e-2
# How exactly the laws shall hold at the instants of a cycle: to a tenth of what the cycle may change by.
OF_COURSE = Exact(violation=1e-5, direction=1e-3)


class FrictionCycle:
    """A crank cycle of an assembled rod, whose increments are solved when they are first needed.

    The loads at the increments, `steps`, divide the cycle evenly; the first follows the last.
    """

    def __init__(self, assembled: Assembled, steps: Sequence[Load]) -> None:
        self._assembled = assembled
        self._ends = [_CycleOfEnd(end, steps) for end in assembled.ends]

    def at(self, loads: Sequence[Load], places: Floats) -> list[ContactState]:
        """States under loads at n instants.

        `places` (n,) are the numbers of the increments before them, with the share of the way to the next.

        Raises
        ------
        ContactError
            No state of contact between the parts carries a load.
        """
        instants = _Instants(loads, places)
        with one_blas_thread(), ThreadPoolExecutor(threads()) as pool:
            try:
                begun = [pool.submit(end.go_through, instants, pool) for end in self._ends]
                found = [_together(each.result()) for each in begun]
            finally:
                pool.shutdown(cancel_futures=True)
        return [self._assembled.together([own[k] for own in found]) for k in range(len(loads))]


class _Instants:
    """Instants of a cycle, by the number of the increment before them."""

    def __init__(self, loads: Sequence[Load], places: Floats) -> None:
        self.loads, self._before, self.share = loads, np.floor(places).astype(int), places % 1
        self._order = np.argsort(places, kind="stable")

    def after(self, increment: int) -> Ints:
        """Numbers of those between an increment and the next, in their order."""
        return np.asarray(self._order[self._before[self._order] == increment])


_Found = Future[dict[int, ContactState]]


class _CycleOfEnd:
    """A crank cycle of one end of the rod."""

    def __init__(self, end: Assembled, steps: Sequence[Load]) -> None:
        self._end, self._steps = end, steps
        self._exact = _exact(end)
        self._settled: list[ContactState] | None = None

    def go_through(self, instants: _Instants, pool: ThreadPoolExecutor) -> list[_Found]:
        """Go through the cycle until friction has settled, and leave the instants to a pool.

        Those of the first cycle are begun with from its end, since its beginning is likely to be replaced.
        """
        count, states = len(self._steps), self._settled or []
        begun = dict[int, _Found]()

        def begin(first: int) -> None:
            if first not in begun:
                begun[first] = pool.submit(self._between, states, first, instants)

        for state in () if states else increments(self._end, self._steps, self._exact):
            states.append(state)
            last = len(states) - 1
            if last == count:
                for first in reversed(range(count)):
                    begin(first)
            elif last > count:
                begun.pop(last - 1 - count).cancel()
                begin(last - 1)
        self._settled = states
        cycle = range(len(states) - 1 - count, len(states) - 1)
        for first in cycle:
            begin(first)
        return [begun[first] for first in cycle]

    def _between(
        self, states: Sequence[ContactState], first: int, instants: _Instants
    ) -> dict[int, ContactState]:
        """States, by the numbers of the instants, from an increment up to the next."""
        ends, own = (states[first], states[first + 1]), instants.after(first % len(self._steps))
        at, way = own[instants.share[own] == 0], own[instants.share[own] > 0]
        found = dict.fromkeys(at.tolist(), ends[0])
        if len(way):
            loads, shares = [instants.loads[number] for number in way], instants.share[way].tolist()
            found |= zip(way.tolist(), self._end.between(loads, ends, shares, self._exact), strict=True)
        return found


def increments(end: Assembled, loads: Sequence[Load], exact: Exact = OF_COURSE) -> Iterator[ContactState]:
    """States of one end of the rod at the increments of one cycle after the other, till friction settles."""
    state, states, last = end.start, list[ContactState](), Trials()
    for load in loads:
        state = end.step(load, state, exact=exact, last=last)
        states.append(state)
        yield state
    largest, alike = _largest(end, states), 0
    for number in range(len(loads), MOST_CYCLES * len(loads)):
        before = states[number - len(loads)]
        state = end.step(loads[number % len(loads)], state, before, exact, last)
        states.append(state)
        yield state
        alike = alike + 1 if _alike(end, before, state, largest) else 0
        if alike == ON_END:  # from here on, it would do again what it did in the cycle before
            return


def _exact(end: Assembled) -> Exact:
    """How exactly the laws shall hold at one end; the other presses as when the parts were put together."""
    return OF_COURSE._replace(elsewhere=float(end.start.values[end.vertices.normal].max(initial=0.0)))


def _largest(end: Assembled, states: Sequence[ContactState]) -> tuple[float, float]:
    """Largest bolt force, N, and largest pressure, MPa."""
    values = np.abs([state.values for state in states])
    bolts, pressures = values[:, end.bolts], values[:, end.vertices.normal]
    return float(bolts.max(initial=0.0)), float(pressures.max(initial=0.0))


def _alike(end: Assembled, before: ContactState, after: ContactState, largest: tuple[float, float]) -> bool:
    """Whether a state is that of the cycle before."""
    change = np.abs(after.values - before.values)
    kinds = (end.bolts, SETTLED), (end.vertices.normal, SETTLED_PLACES)
    return all(
        change[which].max(initial=0.0) <= share * size
        for (which, share), size in zip(kinds, largest, strict=True)
    )


def _together(parts: Sequence[_Found]) -> dict[int, ContactState]:
    """All instants of one end."""
    return {number: state for part in parts for number, state in part.result().items()}
