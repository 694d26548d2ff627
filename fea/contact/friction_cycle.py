"""States of an assembled rod over a crank cycle, which friction makes depend on what came before.

Increments follow each other until they are those of the cycle before; instants between two of them divide
their slip. Each end of the rod goes through the cycle by itself (`fea.contact.ends`).
"""

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed

import numpy as np

from fea.contact.assembled import Assembled
from fea.contact.joined_system import Joined, Load
from fea.contact.trial import Exact
from fea.machine.threads import one_blas_thread, threads
from geometry.arrays import Floats, Ints

# Cycles after which a course ends at the latest; over as many increments on end, bolt forces and the pressure
# of every place may differ from the cycle before by so much, relative to the largest, when it ends. (What a
# pressure at the edge of contact owes to the size of the increments is four times as much.)
MOST_CYCLES, ON_END, SETTLED, SETTLED_PLACES = 3, 10, 1e-3, 1e-2
# Runs into which instants are divided, whatever the number of threads: some take longer than others.
RUNS = 6
# How exactly the laws shall hold at the instants of a cycle: to a tenth of what the cycle may change by.
OF_COURSE = Exact(violation=1e-5, direction=1e-3)


class FrictionCycle:
    """A crank cycle of an assembled rod, whose increments are solved when they are first needed.

    Parameters
    ----------
    assembled
        The parts put together.
    steps
        Loads at the increments, from the beginning of the cycle to its end.
    """

    def __init__(self, assembled: Assembled, steps: Sequence[Load]) -> None:
        self._assembled, self._steps = assembled, steps
        self._known: dict[int, list[Joined]] = {}

    def at(self, loads: Sequence[Load], places: Floats) -> list[Joined]:
        """States at instants of the cycle.

        Parameters
        ----------
        loads
            At n instants.
        places
            (n,) numbers of the increments, with the share of the way to the next.

        Raises
        ------
        ContactError
            No state of contact between the parts carries a load.
        """
        order = np.argsort(places, kind="stable")
        runs = np.array_split(order, min(RUNS, max(len(order), 1)))
        ends = self._assembled.ends
        jobs: list[list[Future[list[Joined]]]] = [[] for _ in ends]
        with one_blas_thread(), ThreadPoolExecutor(threads()) as pool:
            solved = {pool.submit(self._increments, number, end): number for number, end in enumerate(ends)}
            for done in as_completed(solved):
                number, states = solved[done], done.result()
                jobs[number] = [pool.submit(_run, ends[number], run, loads, states, places) for run in runs]
        of_ends = [[state for job in own for state in job.result()] for own in jobs]
        found = map(self._assembled.together, zip(*of_ends, strict=True))
        by_number = dict(zip(order.tolist(), found, strict=True))
        return [by_number[number] for number in range(len(order))]

    def _increments(self, number: int, end: Assembled) -> list[Joined]:
        if number not in self._known:
            self._known[number] = increments(end, self._steps)
        return self._known[number]


def increments(end: Assembled, loads: Sequence[Load]) -> list[Joined]:
    """States of one end of the rod at the increments of a cycle, once friction has settled."""
    state, states = end.start, list[Joined]()
    for load in loads:
        state = end.step(load, state, exact=OF_COURSE)
        states.append(state)
    largest, alike = _largest(end, states), 0
    for number in range(len(loads), MOST_CYCLES * len(loads)):
        before = states[number - len(loads)]
        state = end.step(loads[number % len(loads)], state, before, OF_COURSE)
        states.append(state)
        alike = alike + 1 if _alike(end, before, state, largest) else 0
        if alike == ON_END:  # from here on, it would do again what it did in the cycle before
            break
    last = len(states) - 1
    return [states[last - (last - number) % len(loads)] for number in range(len(loads))]


def _largest(end: Assembled, states: Sequence[Joined]) -> tuple[float, float]:
    """Largest bolt force, N, and largest pressure, MPa."""
    values = np.abs([state.values for state in states])
    bolts, pressures = values[:, end.bolts], values[:, end.touching.normal]
    return float(bolts.max(initial=0.0)), float(pressures.max(initial=0.0))


def _alike(end: Assembled, before: Joined, after: Joined, largest: tuple[float, float]) -> bool:
    """Whether a state is that of the cycle before."""
    change = np.abs(after.values - before.values)
    kinds = (end.bolts, SETTLED), (end.touching.normal, SETTLED_PLACES)
    return all(
        change[which].max(initial=0.0) <= share * size
        for (which, share), size in zip(kinds, largest, strict=True)
    )


def _run(
    end: Assembled, run: Ints, loads: Sequence[Load], states: Sequence[Joined], places: Floats
) -> list[Joined]:
    """States of one end of the rod at some of the instants in their order; see `FrictionCycle.at`."""
    found, near, last = list[Joined](), states[0], -1
    for number in run:
        before = min(int(places[number]), len(states) - 2)
        share = float(places[number]) - before
        if share in {0.0, 1.0}:
            near = states[before + int(share)]
        else:
            like = near if before == last else states[before]
            near = end.between(loads[number], (states[before], states[before + 1]), share, like, OF_COURSE)
        last = before
        found.append(near)
    return found
