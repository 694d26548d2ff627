"""States of an assembled rod over a crank cycle, which friction makes depend on what came before.

Increments follow each other until they are those of the cycle before; instants between two of them divide
their slip. Each end of the rod goes through the cycle by itself (`fea.contact.block`).
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from itertools import chain

import numpy as np

from fea.contact.assembled import Assembled
from fea.contact.friction_system import ContactState, Load, Steps
from fea.contact.trial import Exact
from fea.machine.threads import threads
from geometry.arrays import Floats, Ints

# Cycles after which a course ends at the latest; over as many increments on end, bolt forces and the pressure
# of every place may differ from the cycle before by so much, relative to the largest, when it ends. (What a
# pressure at the edge of contact owes to the size of the increments is three times as much.)
MOST_CYCLES, ON_END, SETTLED, SETTLED_PLACES = 3, 10, 1e-3, 2e-2
# How exactly the laws shall hold at the instants of a cycle: to a tenth of what the cycle may change by.
OF_COURSE = Exact(violation=1e-4, direction=1e-3)


class FrictionCycle:
    """A crank cycle of an assembled rod in even increments, solved when first needed."""

    def __init__(self, assembled: Assembled, loads: Sequence[Load]) -> None:
        self._assembled = assembled
        # What is nothing beside the pressures when the parts were put together is nothing at either end.
        pressures = assembled.start.values[assembled.vertices.normal]
        exact = OF_COURSE._replace(elsewhere=float(pressures.max(initial=0.0)))
        self._ends = [_CycleOfEnd(assembled, loads, exact, end) for end in assembled.system.every]

    def at(self, loads: Sequence[Load], places: Floats) -> list[ContactState]:
        """States under loads at n instants.

        `places` (n,) are the numbers of the increments before them, with the share of the way to the next.
        Raises `ContactError`: no state of contact between the parts carries a load.
        """
        instants = _Instants(loads, places)
        with ThreadPoolExecutor(threads()) as pool:
            try:
                begun = [pool.submit(end.go_through, instants, pool) for end in self._ends]
                states = [dict(chain(*(part.result().items() for part in end.result()))) for end in begun]
            finally:
                pool.shutdown(cancel_futures=True)
        return [self._assembled.system.together([of_end[k] for of_end in states]) for k in range(len(loads))]


class _Instants:
    """Instants of a cycle, by the number of the increment before them."""

    def __init__(self, loads: Sequence[Load], places: Floats) -> None:
        self.loads, self._before, self.share = loads, np.floor(places).astype(int), places % 1
        self._order = np.argsort(places, kind="stable")

    def after(self, increment: int) -> Ints:
        """Numbers of those between an increment and the next, in their order."""
        return np.asarray(self._order[self._before[self._order] == increment])


_Part = dict[int, ContactState]  # by the numbers of the instants


class _CycleOfEnd:
    def __init__(self, assembled: Assembled, loads: Sequence[Load], exact: Exact, end: int) -> None:
        self._assembled, self._loads, self._steps = assembled, loads, partial(assembled.steps, exact, end)
        self._settled: list[ContactState] | None = None

    def go_through(self, instants: _Instants, pool: ThreadPoolExecutor) -> list[Future[_Part]]:
        """Go through the cycle until friction has settled, and leave the instants to a pool.

        Those of the first cycle are begun with from its end, since its beginning is likely to be replaced.
        """
        count, states = len(self._loads), self._settled or []
        begun = dict[int, Future[_Part]]()

        def begin(first: int) -> None:
            if first not in begun:
                begun[first] = pool.submit(self._between, states, first, instants)

        for state in () if states else increments(self._steps(), self._assembled, self._loads):
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

    def _between(self, states: Sequence[ContactState], first: int, instants: _Instants) -> _Part:
        """States from an increment up to the next."""
        ends, numbers = (states[first], states[first + 1]), instants.after(first % len(self._loads))
        at, way = numbers[instants.share[numbers] == 0], numbers[instants.share[numbers] > 0]
        between = dict.fromkeys(at.tolist(), ends[0])
        if len(way):
            loads, shares = [instants.loads[number] for number in way], instants.share[way].tolist()
            between |= zip(way.tolist(), self._steps().between(loads, ends, shares), strict=True)
        return between


def increments(steps: Steps, assembled: Assembled, loads: Sequence[Load]) -> Iterator[ContactState]:
    """States of one end of the rod at the increments of one cycle after the other, till friction settles."""
    state, states, count, alike = assembled.start, list[ContactState](), len(loads), 0
    compared = (assembled.bolts, SETTLED), (assembled.vertices.normal, SETTLED_PLACES)
    limits = list[float]()
    for number in range(MOST_CYCLES * count):
        if number == count:
            values = np.abs([each.values for each in states])
            limits = [share * values[:, which].max(initial=0.0) for which, share in compared]
        before = states[number - count] if number >= count else None
        state = steps.step(loads[number % count], state, before)
        states.append(state)
        yield state
        if before is None:
            continue
        change = np.abs(state.values - before.values)
        sizes = [change[which].max(initial=0.0) for which, _ in compared]
        alike = alike + 1 if np.less_equal(sizes, limits).all() else 0
        if alike == ON_END:  # from here on, it would do again what it did in the cycle before
            return
