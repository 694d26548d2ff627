"""Parts put together: fits closed, bolts tightened and locked; then loads, step by step, or a crank cycle.

1. The parts are put together without friction, while the bolts have their preload and the pins are absent.
2. The bolts keep their length from then on. Bores are machined in this state, so that pins see them as round,
   and slip is counted from it.
3. From then on there is friction: a uniform change of temperature is a first step.
4. Loads are steps from one state to the next.
5. Over a crank cycle, friction makes a state depend on what came before. Increments follow each other until
   they are those of the cycle before; instants between two of them divide their slip. Each end of the rod
   goes through the cycle by itself (`fea.contact.block`).
"""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np

from fea.contact.active_set import ContactSystem
from fea.contact.block import Guess, Places
from fea.contact.friction_system import ContactState, FrictionSystem, Load, Steps
from fea.contact.problem import CondensedInterface, ContactProblem
from fea.contact.trial import TOLERANCES, Tolerances
from fea.machine.threads import threads
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask


@dataclass(frozen=True)
class TemperatureChange:
    """A uniform change of temperature."""

    displacement: Floats  #: (3 n_nodes,) free expansion of the parts on the cell, mm
    bolts: Floats  #: (n_bolts,) free expansion of each bolt of the cell over its grip, mm
    pins: Sequence[float]  #: radial expansion of each pin, mm


@dataclass(frozen=True)
class InterfaceVertices:
    """The vertices of all mating faces and of their images across y = 0."""

    normal: Ints  #: (k,) unknowns that are their pressures
    shear: Ints  #: (k, 2) unknowns that are their shear stresses; −1 where there is none
    face: Ints  #: (k,) number of the face
    #: node, mate: (k,) nodes of the cell on both sides of which each is a vertex, or the image of one
    node: Ints
    mate: Ints
    image: Mask  #: (k,) which are images
    facets: Ints  #: (m, 3) places of the corners of each facet among the vertices
    place: Floats  #: (k, 3) mm
    area: Floats  #: (k,) that belongs to each on the whole body, mm²

    @classmethod
    def of(cls, problem: ContactProblem) -> "InterfaceVertices":
        """Collect those of a problem."""
        normal, shear, face, node, mate, corners, count = [], [], [], [], [], [], 0
        ones, unfolding = np.zeros(problem.forces.shape[1]), problem.unfolding
        for number, faces in enumerate(problem.faces):
            start, pressing = problem.starts[len(problem.bores) + number], faces.pressing
            normal.append(start + np.arange(pressing.size))
            both = np.stack(faces.tangential, axis=1)
            shear.append(np.where(both >= 0, start + both, -1))
            face.append(np.full(pressing.size, number))
            node.append(pressing.nodes)
            mate.append(faces.mates)
            corners.append(count + pressing.corners)
            count += pressing.size
            ones[normal[-1]] = pressing.weights
        cells, both, face_of = np.concatenate(normal), np.concatenate(shear), np.concatenate(face)
        off = ~unfolding.on_y[cells] if unfolding.both_sides else np.zeros(len(cells), dtype=bool)
        here, there, facets = (np.concatenate(each) for each in (node, mate, corners))
        place, at_image = (
            problem.mesh.points[here],
            np.where(off, count + np.cumsum(off) - 1, np.arange(count)),
        )
        images = np.where(both[off] >= 0, unfolding.images_of(both[off]), -1)
        numbers = np.concatenate([cells, unfolding.images_of(cells[off])])
        return cls(
            normal=numbers,
            shear=np.concatenate([both, images]),
            face=np.concatenate([face_of, face_of[off]]),
            node=np.append(here, here[off]),
            mate=np.append(there, there[off]),
            image=np.arange(len(numbers)) >= count,
            facets=np.concatenate([facets, at_image[facets]]) if off.any() else facets,
            place=np.concatenate([place, place[off] * [1.0, -1.0, 1.0]]),
            area=problem.gaps(ones)[numbers],
        )


class Assembled:
    """Parts that are held together by bolts and fits: `tightened`, and at the `start` as warm as the engine.

    `parts`: nodes of each part that nothing else holds; `friction`: coefficient μ between all mating faces;
    `preload`: (n_bolts,) force of each bolt of the cell when it is tightened, N; `warming`: from the
    temperature at which the parts were put together to that of the engine; `names`: of the parts, for
    messages.

    Attributes: `bolts`, `stops`: unknowns of the forces of bolts, and two of each that may bear on its hole,
    one either way; `motions`: the rigid motions of the parts: parity and displacement (3 n_nodes,);
    `warming`.
    Raises `ContactError`: no contact between the parts carries the bolt forces.
    """

    def __init__(
        self,
        problem: ContactProblem,
        parts: Sequence[Ints],
        friction: float,
        preload: Floats,
        warming: TemperatureChange | None = None,
        *,
        names: Sequence[str] = (),
    ) -> None:
        self.problem, self.warming = problem, warming
        self.motions = [motion for nodes in parts for motion in problem.motions(nodes)]
        moved = [problem.moved(nodes) for nodes in parts]
        n, n_loads = problem.loaded.shape
        self._P = np.hstack([columns for columns, _ in moved]) if moved else np.zeros((n, 0))
        self._resultants = np.concatenate([np.zeros((0, n_loads)), *(of_part for _, of_part in moved)])
        bores, faces = len(problem.bores), len(problem.faces)
        self.pins = self._numbers(range(bores))
        first, last = bores + faces + problem.pulls, bores + faces + len(problem.bolts)
        self.bolts, self.stops = self._numbers(range(bores + faces, first)), self._numbers(range(first, last))
        self.vertices = InterfaceVertices.of(problem)
        self._preload = np.tile(preload, len(self.bolts) // max(len(preload), 1))
        self._names = [
            f"the {name}"
            for name, (of_part, _) in zip(names, moved, strict=False)
            for _ in range(of_part.shape[1])
        ]
        self._condensed = CondensedInterface.of(problem.compliance, self._P, self.pins)
        self.system = FrictionSystem(self._condensed, problem.rigid, self._places(friction), self._names)
        self._put_together()

    def tightened_to(self, preload: float) -> "Assembled":
        """Return the same parts with another force of every bolt when it is tightened, N; it takes moments.

        Errors as of the class.
        """
        other = copy(self)
        other._preload = np.full_like(self._preload, preload)  # noqa: SLF001 - its own
        other._put_together()  # noqa: SLF001
        return other

    def varied(self, friction: float, crush: float) -> "Assembled":
        """Return the same parts with another friction, and so many times their interferences.

        Errors as of the class.
        """
        other = copy(self)
        other.problem = self.problem.crushed(crush)
        places = self._places(friction)
        other.system = FrictionSystem(self._condensed, self.problem.rigid, places, self._names)
        other._put_together()  # noqa: SLF001 - its own
        return other

    def _put_together(self) -> None:
        self._made = self.problem.initial.copy()
        self.tightened = self.start = self._tightened()
        if self.warming is not None:
            self._made = self._made + self._expansion(self.warming)
            warm = self.steps().step(self._idle, self.tightened)
            absent = np.zeros_like(warm.guess.touching)  # the pins of the next step are elsewhere
            self.start = replace(warm, guess=replace(warm.guess, touching=absent))

    def _numbers(self, items: Iterable[int]) -> Ints:
        """Unknowns of bores, faces and bolts, by their place among all of these."""
        cells = [np.arange(*self.problem.starts[[item, item + 1]]) for item in items]
        return self.problem.unfolding.with_images(np.concatenate([*cells, np.zeros(0, dtype=np.int64)]))

    def _places(self, friction: float) -> Places:
        position = np.full(self.problem.unfolding.size + 1, -1)  # the last one stands for none
        position[self._condensed.interface] = np.arange(len(self._condensed.interface))
        normal, shear = self.vertices.normal, self.vertices.shear
        single = np.concatenate([self.bolts, self.stops])
        none = np.full((len(single), 2), -1)
        return Places(
            normal=position[np.concatenate([normal, single])],
            tangential=position[np.concatenate([shear, none])],
            friction=np.full(len(normal) + len(single), friction),
            bolt=np.arange(len(normal) + len(single)) >= len(normal),
            frictional=np.asarray((np.concatenate([shear, none]) >= 0).any(axis=1)),
        )

    def _tightened(self) -> ContactState:
        """Close the fits under the preload of the bolts, lock these, and take the bores as round."""
        C, normal, bolts = self.problem.compliance, self.vertices.normal, self.bolts
        pulled = C[:, bolts] @ self._preload
        system = ContactSystem(C[np.ix_(normal, normal)], self._P[normal])
        contact = system.solve((self._made + pulled)[normal], -self._P[bolts].T @ self._preload)
        values = np.zeros(len(C))
        values[normal], values[bolts] = contact.pressure, self._preload
        gap = C @ values + self._made - self._P @ contact.motion
        locked = np.concatenate([bolts, self.pins])
        self._made[bolts] -= gap[bolts]
        centred = np.concatenate([self.pins, self.stops])  # whatever tightening did
        self._made[centred] -= gap[centred] - self.problem.initial[centred]
        gap[locked], gap[self.stops] = 0.0, self.problem.initial[self.stops]
        places = np.concatenate([normal, bolts, self.stops])
        opened = values[places] <= 0
        gap[places[~opened]] = 0.0
        return ContactState(
            load=self._idle,
            values=values,
            gap=gap[self._condensed.interface],
            guess=replace(Guess.closed(len(self.pins), len(places)), opened=opened),
            pin_held=np.zeros(len(self._condensed.free[1])),
            residual=contact.residual,
            imbalance=contact.imbalance,
            changes=contact.changes,
        )

    @property
    def interface(self) -> Ints:
        """The unknowns (n_J,) that gaps `ContactState.gap` belong to."""
        return self._condensed.interface

    @property
    def _idle(self) -> Load:
        idle = np.zeros(self.problem.loaded.shape[1])
        return Load(self._made, np.zeros(self.problem.rigid.shape[1]), np.zeros(self._P.shape[1]), idle)

    def _expansion(self, warming: TemperatureChange) -> Floats:
        """Moments (n,) of the gaps that free expansion opens."""
        problem = self.problem
        even = problem.forces.T @ warming.displacement
        for number, (bore, growth) in enumerate(zip(problem.bores, warming.pins, strict=True)):
            even[problem.own(number)] -= growth * bore.multipliers.weights
        if problem.bolts:
            pulls, first = problem.bolts[: problem.pulls], len(even) - len(problem.bolts)
            longer = [bolt.share * growth for bolt, growth in zip(pulls, warming.bolts, strict=True)]
            even[first : first + problem.pulls] += longer
        return problem.gaps(even)

    def steps(self, exact: Tolerances = TOLERANCES, end: int | None = None) -> Steps:
        """Steps of the rod, or of one end while the other sticks: `system.together` joins their states."""
        return Steps(self.system, exact, None if end is None else range(end, end + 1))

    def sticking(self, gap: Floats, resultants: Floats) -> tuple[Floats, Floats]:
        """Values (n, m) of the unknowns and motions (k, m) of the parts, without pins, while all sticks.

        `gap` (n, m) moments of the gaps that loads open, `resultants` (k, m) of these loads.
        """
        condensed, values = self._condensed, np.zeros_like(gap)
        moved = -gap[condensed.interface]
        values[condensed.interface] = condensed.V @ resultants + condensed.S @ moved
        none = np.zeros((len(condensed.pins), gap.shape[1]))
        pin_held = np.zeros((len(condensed.free[1]), gap.shape[1]))
        return values, condensed.motions(moved, none, resultants, pin_held)

    def refitted(self, even: Floats, odd: Floats) -> tuple[float, dict[Parity, Floats]]:
        """What a small displacement of the parts, each by itself, does to faces and bolts if all sticks.

        Its parts (3 n_nodes,) on the cell are even and odd about y = 0, mm. Returns the largest change of a
        pressure or bolt force over the largest one at the start, and the motion (n_nodes, 3) of the parts as
        rigid bodies per parity, mm, by which they fit again.
        """
        problem, normal, bolts = self.problem, self.vertices.normal, self.bolts
        gap = problem.gaps(problem.forces.T @ even, problem.forces.T @ odd)
        values, amounts = self.sticking(gap[:, None], np.zeros((self._P.shape[1], 1)))
        changed = [
            float(
                np.abs(values[which]).max(initial=0.0) / np.abs(self.start.values[which]).max(initial=1e-12)
            )
            for which in (normal, bolts)
        ]
        return max(changed), self._moved_by(amounts[:, 0])

    def opened(self, state: ContactState) -> Ints:
        """Which of `interface` (o,) have no stress where a state is open."""
        places = self.system.places
        numbers = np.concatenate([places.normal[:, None], places.tangential], axis=1)[state.guess.opened]
        return np.unique(numbers[numbers >= 0])

    def slipped(self, gap: Floats) -> Floats:
        """Mean slip (k, 2) about `vertices` along their tangents, mm, of gaps `ContactState.gap` (n_J,)."""
        shear, interface = self.vertices.shear, self.interface
        moments = gap[np.searchsorted(interface, np.maximum(shear, interface[0]))]
        return np.where(shear >= 0, moments, 0.0) / self.vertices.area[:, None]

    def sticking_loads(self) -> Floats:
        """Values (n, n_loads) of the unknowns under unit loads, without pins, while everything sticks."""
        return self.sticking(self.problem.loaded, self._resultants)[0]

    @property
    def sticking_start(self) -> Floats:
        """Values (n,) of the unknowns at the engine's temperature without pins."""
        values, interface = np.zeros(self.problem.unfolding.size), self._condensed.interface
        values[interface] = self._condensed.S @ (self.start.gap - self._made[interface])
        return values

    def load(self, forces: Sequence[Floats], weights: Floats, moments: Floats | None = None) -> Load:
        """What acts in a step; parameters as for `ContactProblem.gap` and `ContactProblem.sums`."""
        problem = self.problem
        gap = self._made + problem.loaded @ weights + problem.bent(forces)
        return Load(gap, problem.sums(forces, moments), self._resultants @ weights, np.asarray(weights))

    def as_here(self, load: Load, elsewhere: "Assembled") -> Load:
        """Return a load on the same parts, put together in another way, as one on these."""
        return replace(load, gap=load.gap + self._made - elsewhere._made)  # noqa: SLF001

    def displacement(self, state: ContactState) -> dict[Parity, Floats]:
        """Displacement (n_nodes, 3) per parity of the parts as rigid bodies, mm."""
        return self._moved_by(self.system.part_motion(state))

    def _moved_by(self, amounts: Floats) -> dict[Parity, Floats]:
        shape = self.problem.mesh.points.shape
        moved = {parity: np.zeros(shape) for parity in self.problem.unfolding.parities()}
        for amount, (parity, motion) in zip(amounts, self.motions, strict=True):
            moved[parity] += amount * motion.reshape(shape)
        return moved


# Cycles after which a course ends at the latest; over as many increments on end, bolt forces and the pressure
# of every place may differ from the cycle before by so much, relative to the largest, when it ends. (What a
# pressure at the edge of contact owes to the size of the increments is three times as much.)
MOST_CYCLES, ON_END, SETTLED, SETTLED_PLACES = 3, 10, 1e-3, 2e-2
# How exactly the laws shall hold at the instants of a cycle: to a tenth of what the cycle may change by.
OF_COURSE = Tolerances(violation=1e-4, direction=1e-3)


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

    def continued(self, places: Floats) -> Floats:
        """What (n_J, n) makes gaps `ContactState.gap` at places go on from the first increment to the end.

        The last cycle of each end of the rod begins at an increment of its own; what it leaves of slip lies
        between there and the end. The number of increments is the place of the end. Errors as of `at`.
        """
        self.at([], np.zeros(0))
        left = [np.outer(end.left, places >= end.beginning) for end in self._ends]
        return np.asarray(np.sum(left, axis=0))


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
    def __init__(self, assembled: Assembled, loads: Sequence[Load], exact: Tolerances, end: int) -> None:
        self._assembled, self._loads, self._steps = assembled, loads, partial(assembled.steps, exact, end)
        self._settled: list[ContactState] | None = None

    @property
    def beginning(self) -> int:
        """Number of the increment at which the last cycle begins, from 1 to their number."""
        return (len(self._settled or ()) - 2) % len(self._loads) + 1

    @property
    def left(self) -> Floats:
        """What the last cycle left of slip, in gaps (n_J,); those of the other end stay as they are."""
        last, first = ((self._settled or [])[-number] for number in (1, 1 + len(self._loads)))
        return np.asarray(last.gap - first.gap)

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
