"""Parts put together: fits closed, bolts tightened and locked; then loads, step by step.

1. The parts are put together without friction, while the bolts have their preload and the pins are absent.
2. The bolts keep their length from then on. Bores are machined in this state, so that pins see them as round,
   and slip is counted from it.
3. From then on there is friction: a uniform change of temperature is a first step.
4. Loads are steps from one state to the next.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.contact.active_set import ContactSystem
from fea.contact.block import Guess, Places
from fea.contact.friction_system import ContactState, FrictionSystem, Load, Steps
from fea.contact.problem import CondensedInterface, ContactProblem
from fea.contact.trial import EXACT, Exact
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints


@dataclass(frozen=True)
class Warming:
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
    place: Floats  #: (k, 3) mm
    area: Floats  #: (k,) that belongs to each on the whole body, mm²

    @classmethod
    def of(cls, problem: ContactProblem) -> "InterfaceVertices":
        """Collect those of a problem."""
        normal, shear, face, node = [], [], [], []
        ones, unfolding = np.zeros(problem.forces.shape[1]), problem.unfolding
        for number, faces in enumerate(problem.faces):
            start, pressing = problem.starts[len(problem.bores) + number], faces.pressing
            normal.append(start + np.arange(pressing.size))
            both = np.stack(faces.tangential, axis=1)
            shear.append(np.where(both >= 0, start + both, -1))
            face.append(np.full(pressing.size, number))
            node.append(pressing.nodes)
            ones[normal[-1]] = pressing.weights
        cells, both, face_of = np.concatenate(normal), np.concatenate(shear), np.concatenate(face)
        off = ~unfolding.on_y[cells] if unfolding.both_sides else np.zeros(len(cells), dtype=bool)
        place = problem.mesh.points[np.concatenate(node)]
        images = np.where(both[off] >= 0, unfolding.images_of(both[off]), -1)
        numbers = np.concatenate([cells, unfolding.images_of(cells[off])])
        return cls(
            normal=numbers,
            shear=np.concatenate([both, images]),
            face=np.concatenate([face_of, face_of[off]]),
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
        warming: Warming | None = None,
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
        of_motion = [
            f"the {name}"
            for name, (of_part, _) in zip(names, moved, strict=False)
            for _ in range(of_part.shape[1])
        ]
        self._made = problem.initial.copy()
        self._condensed = CondensedInterface.of(problem.compliance, self._P, self.pins)
        self.system = FrictionSystem(self._condensed, problem.rigid, self._places(friction), of_motion)
        self.tightened = self.start = self._tightened()
        if warming is not None:
            self._made = self._made + self._expansion(warming)
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
            rubbing=np.asarray((np.concatenate([shear, none]) >= 0).any(axis=1)),
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
            loose=np.zeros(len(self._condensed.free[1])),
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

    def _expansion(self, warming: Warming) -> Floats:
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

    def steps(self, exact: Exact = EXACT, end: int | None = None) -> Steps:
        """Steps of the rod, or of one end while the other sticks: `system.together` joins their states."""
        return Steps(self.system, exact, None if end is None else range(end, end + 1))

    def sticking(self, gap: Floats, resultants: Floats, opened: Ints | None = None) -> tuple[Floats, Floats]:
        """Values (n, m) of the unknowns and motions (k, m) of the parts, without pins, while all sticks.

        `gap` (n, m) moments of the gaps that loads open, `resultants` (k, m) of these loads; `opened` (o,):
        which of `interface` have no stress, but gaps that change freely; none by default.
        """
        condensed, values = self._condensed, np.zeros_like(gap)
        moved = -gap[condensed.interface]
        stress = condensed.V @ resultants + condensed.S @ moved
        if opened is not None and opened.size:
            S = condensed.S[:, opened]
            free = -np.linalg.solve(S[opened], stress[opened])
            stress += S @ free
            moved[opened] += free
        values[condensed.interface] = stress
        none = np.zeros((len(condensed.pins), gap.shape[1]))
        loose = np.zeros((len(condensed.free[1]), gap.shape[1]))
        return values, condensed.motions(moved, none, resultants, loose)

    def opened(self, state: ContactState) -> Ints:
        """Which of `interface` (o,) have no stress where a state is open."""
        places = self.system.places
        numbers = np.concatenate([places.normal[:, None], places.tangential], axis=1)[state.guess.opened]
        return np.unique(numbers[numbers >= 0])

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

    def displacement(self, state: ContactState) -> dict[Parity, Floats]:
        """Displacement (n_nodes, 3) per parity of the parts as rigid bodies, mm."""
        shape = self.problem.mesh.points.shape
        moved = {parity: np.zeros(shape) for parity in self.problem.unfolding.parities()}
        for amount, (parity, motion) in zip(self.system.part_motion(state), self.motions, strict=True):
            moved[parity] += amount * motion.reshape(shape)
        return moved
