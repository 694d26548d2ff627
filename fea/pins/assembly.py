"""Rods of separate parts: bolts, fits and pins, with friction between the parts.

What acts between the parts is linear in the inertia while everything sticks, so that one kind of unit loads
is that of the joined rod. The state in which the parts were put together is one more. What the pins, opening
and slip add over a cycle is spanned by the largest singular vectors of its states (method of snapshots,
Sirovich 1987, Q. Appl. Math. 45, 561).
"""

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import replace
from operator import itemgetter
from typing import cast

import numpy as np

from fea.contact.assembled import Assembled, FrictionCycle, TemperatureChange
from fea.contact.assembly_state import AssemblySpecification, AssemblyState
from fea.contact.bolts import BoltBending, BoltEnds, BoltPull, BoltStop
from fea.contact.fretting import Rubbing
from fea.contact.friction_system import ContactState, Load
from fea.contact.interfaces import MatingFaces, radial, uniform
from fea.film.functions import FilmPressure
from fea.pins.assembly_states import AssemblyStates, gap_at_nodes
from fea.pins.contact import BoreContact, ContactPins, ContactUnits, acting, of_unit_work
from fea.pins.fits import Fits
from fea.pins.model import (
    SMOOTH,
    Contacts,
    JointBounds,
    PinModelContext,
    Response,
    UnitLoads,
    Weights,
    total,
)
from fea.rod.meshed_rod import Bores
from fea.solid.errors import ContactError
from fea.solid.parity import Parity, ParityPair
from fea.solid.supports import components
from geometry.arrays import Floats, Ints
from geometry.assembly import BoltAxis
from geometry.holes import Axis
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants, assembled, joined
from mesh.tetmesh import TetMesh

# Distance of the forces of the pins, over their size, within which the state of another instant, also solved
# from rest, makes a good first guess.
_ALIKE = 0.5
# Distance from a mirror plane, over the hole's radius, within which a bolt's axis lies on it.
_ON_PLANE = 1e-6


class AssemblyContact(BoreContact):
    """The contact problem of a rod of separate parts and its pins.

    Attributes: `assembled`: the parts put together; `sums`: sums up states of them; `growth`: free thermal
    expansion of the rod on the cell, mm. Raises `ContactError`: no contact between the parts carries the bolt
    forces.
    """

    def __init__(self, structure: PinModelContext, fits: Fits, film: FilmPressure | None = None) -> None:
        if structure.assembly is None:
            raise ValueError("a rod of one piece is not an assembly")
        specification = structure.assembly
        mesh, bores, friction = structure.mesh, structure.bores, specification.friction
        faces = []
        for first, second in mesh.interfaces:
            x = bores.rod_length if first is Surface.BUSHING_SEAT else 0.0
            across = uniform(np.array([*specification.normal, 0.0])) if first is Surface.JOINT else radial(x)
            sides, tight = (first, second), specification.interference.get(first, 0.0)
            faces.append(MatingFaces.of(mesh, sides, across, interference=tight, friction=friction > 0))
        axes = _of_cell(mesh, specification.bolts)
        seated = _ends(mesh, axes)
        pulls, stiffness = list[BoltPull](), specification.stiffness
        for bolt, ends in zip(axes, seated, strict=True):
            seats, along, point = dict(ends.seats), np.array(bolt.direction), np.array(bolt.point)
            pulls.append(BoltPull.of(mesh, seats, along, stiffness, share=ends.share, point=point))
        if friction:
            joint = next(face for face in faces if face.name == Surface.JOINT)
            places = mesh.points[joint.pressing.nodes]
            near = np.argmin([np.linalg.norm(places - bolt.point, axis=1) for bolt in axes], axis=0)
            for place, ends in enumerate(seated):
                pulls += BoltStop.pair(joint, near == place, specification.beam, ends.share, len(mesh.points))
        super().__init__(structure, fits, faces=faces, bolts=pulls, film=film)
        body = components(mesh)
        held = body[mesh.tets[0, 0]]  # the first part, to which the others are moved
        parts = [np.flatnonzero(body == number) for number in np.unique(body) if number != held]
        number = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
        numbers = [int(number[np.isin(mesh.tets[:, 0], nodes).argmax()]) for nodes in parts]
        names = [specification.parts[k] if k < len(specification.parts) else "part" for k in numbers]
        preload = np.full(len(axes), specification.preload)
        warming = _warming(mesh, bores, fits, specification)
        self.growth = None if warming is None else ParityPair(warming.displacement.reshape(-1, 3), None)
        self.assembled = Assembled(self.problem, parts, friction, preload, warming, names=names)
        at = np.array([bolt.point for bolt in axes]).reshape(-1, 3)
        growth = 0.0 if warming is None else warming.displacement
        bending = BoltBending(structure.model, self.assembled, seated, specification.beam, growth)
        self.sums = AssemblyStates(self.assembled, friction, at, bending, bores.big_radius)

    def tightened_to(self, preload: float) -> "AssemblyContact":
        """Return the same parts with bolts of another preload, N; errors as of the class."""
        other = copy(self)
        other.assembled = self.assembled.tightened_to(preload)
        other.sums = self.sums.of(other.assembled)
        return other

    def varied(self, friction: float, crush: float) -> "AssemblyContact":
        """Return the parts with another friction and so many times their interferences; errors as of it."""
        other = copy(self)
        other.assembled = self.assembled.varied(friction, crush)
        return other

    def loads(self, instants: Instants, film: Floats | None = None) -> list[Load]:
        """What acts between the parts at instants; `film`: its weights (n_functions, n); 0: the pin acts."""
        pressed = np.zeros((len(self.unit_loads) - 4, len(instants))) if film is None else film
        loads = []
        for (pin, crank, motion), own in zip(acting(instants), pressed.T, strict=True):
            weights = np.append(motion, own)
            forces = pin, np.where(own.any(), 0.0, crank)
            loads.append(self.assembled.load(forces, weights, self.tilted(weights)))
        return loads

    def respond(self, instant: Instants, state: ContactState) -> Response:
        """Return what a state and the inertia of its instant do to the rod."""
        forces, (pressure, gap) = self.response(instant, state), self.sums.vertices(state)
        summed = self.sums(state, pressure, gap)
        moved, values = self.assembled.displacement(state), state.values.copy()
        normal = self.assembled.vertices.normal
        values[normal] = pressure  # exactly zero where parts have parted
        pressures = self.pressure(values)
        if self.film is not None:
            pressed, presses = self.film.pressed(state.load.motion[len(instant.motions) :])
            bore, traction = Surface.BIG_END_BORE, dict(forces.traction)
            traction[bore] = total([traction[bore], pressed.traction])
            pressures[bore] = total([pressures[bore], presses])
            forces = replace(forces, forces=total([forces.forces, pressed.forces]), traction=traction)
        return replace(
            forces,
            touch=forces.touch if instant.pin.any() or instant.crank.any() else {},
            shift=ParityPair(moved[Parity.SYMMETRIC], moved.get(Parity.ANTISYMMETRIC)),
            growth=self.growth,
            largest=max(forces.largest, summed.bolt_force),
            assembly=summed,
            pressure=pressures,
            gap=gap_at_nodes(self.problem, normal, gap),
        )


class AssemblyPins(ContactPins):
    """Pins in contact with a rod of separate parts, as [contact] and [assembly] describe them."""

    def __init__(self, structure: PinModelContext) -> None:
        super().__init__(structure)
        self.resting = joined([assembled()])
        # States by what acts: load cases are asked for again where the cycle is checked.
        self._from_rest: dict[bytes, ContactState] = {}
        self._cycles: dict[bytes, tuple[FrictionCycle, dict[bytes, ContactState]]] = {}
        self._spanned: frozenset[bytes] = frozenset()

    @property
    def assembly(self) -> AssemblyContact:
        """The contact problem."""
        return cast("AssemblyContact", self.contact)

    def _problem(self) -> AssemblyContact:
        return AssemblyContact(self.structure, self.fits)

    def datum(self) -> Response:
        """The state in which the bores were made round: bolts tightened, everything as warm as the room."""
        return self.assembly.respond(assembled(), self.assembly.assembled.tightened)

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        states = self.states(instants, cycle)
        return [self.assembly.respond(*each) for each in zip(instants, states, strict=True)]

    def state_under(self, case: Instants, factor: float = 1.0) -> AssemblyState:
        """Sum up the state under a multiple of everything that acts in a case; errors as of `respond`."""
        (state,) = self.states(case.times(factor)[None])
        return self.assembly.sums(state)

    def states(self, instants: Instants, cycle: CrankCycle | None = None) -> list[ContactState]:
        """States at instants of a cycle, or each from the assembled state; see `PinModel.respond`."""
        if cycle is None:
            return [self._state(instant) for instant in instants]
        keys = [_key(*instant) for instant in acting(instants)]
        history, known = self._cycle(cycle)
        left = [number for number, key in enumerate(keys) if key not in known]
        if left:
            some = instants[np.array(left)]
            states = history.at(self.loads(some, cycle), cycle.places(some.crank_angle))
            known.update(zip([keys[number] for number in left], states, strict=True))
        return [known[key] for key in keys]

    def loads(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Load]:  # noqa: ARG002
        """What acts between the parts at instants of a cycle, or each from the assembled state."""
        return self.assembly.loads(instants)

    def rubbing(self, cycle: CrankCycle, changed: tuple[float, float] | None = None) -> Rubbing:
        """What rubs at the increments of a cycle, from the first until that comes again.

        Between increments slip is divided, and shear may exceed what friction can carry. `changed`: another
        friction, and how many times the interferences there are. Errors as of `respond`.
        """
        contact, history, loads = self.assembly, self._cycle(cycle)[0], self.loads(cycle.increments, cycle)
        if changed is not None:
            contact = contact.varied(*changed)
            loads = [contact.assembled.as_here(load, self.assembly.assembled) for load in loads]
            history = FrictionCycle(contact.assembled, loads)
        places = np.arange(len(loads) + 1.0)
        states = history.at(loads, places[:-1])
        return Rubbing.of(contact.assembled, [*states, states[0]], history.continued(places))

    def _state(self, instant: Instants) -> ContactState:
        parts = self.assembly.assembled
        key = _key(instant.pin, instant.crank, instant.motions)
        if not any(key):  # nothing acts
            return parts.start
        if key not in self._from_rest:
            (load,) = self.loads(instant[None])
            like = _alike(load, self._from_rest.values())
            try:
                self._from_rest[key] = parts.steps().step(load, parts.start, like)
            except ContactError as error:
                raise type(error)(f"{instant.name}: {error}" if instant.name else str(error)) from error
        return self._from_rest[key]

    def _cycle(self, cycle: CrankCycle) -> tuple[FrictionCycle, dict[bytes, ContactState]]:
        key = _cycle_key(cycle)
        if key not in self._cycles:
            kept = {other: known for other, known in self._cycles.items() if other in self._spanned}
            steps = self.loads(cycle.increments, cycle)
            self._cycles = kept | {key: (FrictionCycle(self.assembly.assembled, steps), {})}
        return self._cycles[key]

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:
        """Return patterns of what acts between the parts, and inertia."""
        self._spanned = frozenset(map(_cycle_key, cycles))
        return _AssemblyUnits(self, cycles)


def _alike(load: Load, states: Iterable[ContactState]) -> ContactState | None:
    """Return the state with the nearest forces of the pins; None where they are not near."""
    away = [(float(np.linalg.norm(state.load.pins - load.pins)), state) for state in states]
    least, state = min(away, key=itemgetter(0), default=(np.inf, None))
    return state if least < _ALIKE * np.linalg.norm(load.pins) else None


def _key(*acting: Floats) -> bytes:
    return b"".join((0.0 + values).tobytes() for values in acting)


def _cycle_key(cycle: CrankCycle) -> bytes:
    return _key(cycle.increments.pin, cycle.increments.motions)


def _of_cell(mesh: TetMesh, bolts: Sequence[BoltAxis]) -> tuple[BoltAxis, ...]:
    cuts = [(1, Surface.SYMMETRY_Y), (2, Surface.SYMMETRY_Z)]
    return tuple(
        bolt
        for bolt in bolts
        if all(plane not in mesh.facets or bolt.point[axis] > -_on(bolt) for axis, plane in cuts)
    )


def _on(bolt: BoltAxis) -> float:
    return _ON_PLANE * bolt.hole_radius


def _ends(mesh: TetMesh, bolts: Sequence[BoltAxis]) -> list[BoltEnds]:
    owner = {surface: _owner(mesh, surface, bolts) for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    halved = Surface.SYMMETRY_Z in mesh.facets
    return [
        BoltEnds(
            seats={surface: np.flatnonzero(owners == number) for surface, owners in owner.items()},
            head=np.array(bolt.at(bolt.head)),
            thread=np.array(bolt.at(bolt.grip_end)),
            share=0.5 if halved and abs(bolt.point[2]) <= _on(bolt) else 1.0,
        )
        for number, bolt in enumerate(bolts)
    ]


def _owner(mesh: TetMesh, surface: Surface, bolts: Sequence[BoltAxis]) -> Ints:
    """Number of the bolt whose axis is nearest to each facet."""
    middle = mesh.points[mesh.facets[surface][:, :3]].mean(axis=1)
    axes = [Axis(center=np.array(bolt.point), direction=np.array(bolt.direction)) for bolt in bolts]
    return np.asarray(np.argmin([axis.beside(middle) for axis in axes], axis=0))


def _warming(
    mesh: TetMesh, bores: Bores, fits: Fits, specification: AssemblySpecification
) -> TemperatureChange | None:
    """Free expansion of the parts about the big end's centre, of the bolts and of the pins."""
    expansion = specification.expansion
    if expansion is None or expansion.rise == 0:
        return None
    rate = np.zeros(len(mesh.points))
    parts = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
    for number, alpha in enumerate(expansion.parts):
        rate[mesh.tets[parts == number]] = alpha
    bolts = _of_cell(mesh, specification.bolts)
    pins = (
        (expansion.piston_pin, bores.small_radius - fits.small_clearance),
        (expansion.crank_pin, bores.big_radius - fits.big_clearance),
    )
    return TemperatureChange(
        displacement=(expansion.rise * rate[:, None] * mesh.points).ravel(),
        bolts=np.array([expansion.rise * expansion.bolt * bolt.grip for bolt in bolts]),
        pins=[expansion.rise * alpha * radius for alpha, radius in pins],
    )


# Largest error of a pressure, relative to the largest, and of a bolt force likewise, that the patterns may
# leave over a cycle: stresses, which are larger, err less. Of load cases, some of which have little stress,
# it is a tenth. And the least singular values, relative to the largest, with which that is tried.
_ERROR, _OF_CASES = 2e-3, 10
_KEPT = np.geomspace(1e-3, 1e-6, 31)
# Singular values, relative to the largest, that a Gram matrix does not tell from rounding.
_NOISE = 1e-7
_Parts = dict[Parity, Floats]


class _AssemblyUnits(ContactUnits):
    """The unit loads of a rod of separate parts, for instants of cycles and for their peak cases."""

    path_dependent = True

    def __init__(self, pins: AssemblyPins, cycles: Sequence[CrankCycle]) -> None:
        super().__init__(pins, of_assembly=1)
        self._pins, self._assembled = pins, pins.assembly.assembled
        self._unfolding = self.contact.problem.unfolding
        self._sticking = self._assembled.sticking_loads(), self._assembled.sticking_start[:, None]
        over_cycles = [pins.states(cycle.degrees, cycle) for cycle in cycles]
        of_cases = [pins.states(own.peaks.cases) for own in cycles]
        rests = [self._rest(own) for own in over_cycles] + [_OF_CASES * self._rest(own) for own in of_cases]
        largest = np.max([np.abs(state.values) for states in over_cycles for state in states], axis=0)
        parts = self._unfolding.parts(np.hstack(rests))
        self._patterns, self._weighing = self._spanning(parts, largest)
        self._joined, self._start = map(self._unfolding.parts, self._sticking)
        count = {parity: own.shape[1] for parity, own in self._patterns.items()}
        self.joint = JointBounds(*(slice(SMOOTH, count.get(parity, 0)) for parity in Parity))

    def _rest(self, states: Sequence[ContactState]) -> Floats:
        """Unknowns (n, n_instants) less those of the parts put together and of loads on the joined rod."""
        loaded, start = self._sticking
        return np.asarray(_values(states) - start - loaded @ _loads(states))

    def _spanning(self, parts: _Parts, largest: Floats) -> tuple[_Parts, _Parts]:
        """Patterns (n_cell, k) of unit work, and weights (k, n_cell) of what they span, per parity.

        They span states (n_cell, n_states) whose unknowns reach the values `largest` (n,).
        """
        problem, bolts = self.contact.problem, self._assembled.bolts
        pressure, force = np.delete(largest, bolts).max(), largest[bolts].max(initial=0.0)
        scale = np.ones(len(problem.unfolding.on_y))
        if force > 0:  # both count in their own sizes
            first = len(scale) - len(problem.bolts)
            scale[first : first + problem.pulls] = pressure / force
        scaled = {parity: scale[:, None] * own for parity, own in parts.items()}
        patterns, weights = _Parts(), _Parts()
        for parity, basis in _principal(scaled, _ERROR * pressure).items():
            unscaled = basis / scale[:, None]
            smooth, weighing = of_unit_work(unscaled.T @ problem.cell_compliance[parity] @ unscaled)
            nearest = basis.T * scale
            # Exactly the forces of the pins: what is left must not reach beyond the ends of the rod.
            forces, of_patterns = (self.pin_forces(parity, own) for own in (np.eye(len(scale)), unscaled))
            nearest += np.linalg.pinv(of_patterns, rcond=_NOISE) @ (forces - of_patterns @ nearest)
            patterns[parity], weights[parity] = unscaled @ smooth, weighing.T @ nearest
        return patterns, weights

    def patterns(self, parity: Parity) -> Floats:
        """Unknowns in each unit load: pins, opening and slip; the parts put together; inertia and film."""
        numbers = self.contact.of_parity[list(Parity).index(parity)]
        if parity not in self._patterns:  # a cell that is not cut at y = 0 has everything in its even part
            return self._joined[Parity.SYMMETRIC][:, numbers]
        return np.hstack([self._patterns[parity], self._start[parity], self._joined[parity][:, numbers]])

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        states = self._pins.states(instants, cycle)
        rest, loads = self._unfolding.parts(self._rest(states)), _loads(states)
        one = np.ones((1, loads.shape[1]))
        weights = []
        for parity, numbers in zip(Parity, self.contact.of_parity, strict=True):
            known = [self._weighing[parity] @ rest[parity], one] if parity in self._weighing else []
            weights.append(np.concatenate([*known, loads[numbers]]))
        return Weights(*weights)

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Contact of the pins with the bores, bolts and interfaces at each instant."""
        states = self._pins.states(instants, cycle)
        touches = self.contact.touches(_values(states), self._assembled.pins)
        return Contacts(touches, tuple(map(self._pins.assembly.sums, states)))


def _values(states: Sequence[ContactState]) -> Floats:
    return np.stack([state.values for state in states], axis=1)


def _loads(states: Sequence[ContactState]) -> Floats:
    return np.stack([state.load.motion for state in states], axis=1)


def _principal(parts: _Parts, error: float) -> _Parts:
    """Orthonormal patterns (n_cell, k) that span states (n_cell, n_states) up to an error at any place."""
    singular = {parity: _singular(own) for parity, own in parts.items()}
    most = max(float(sizes.max(initial=0.0)) for sizes, _ in singular.values())
    left, count = parts, dict.fromkeys(parts, 0)
    for least in _KEPT:
        for parity, (sizes, vectors) in singular.items():
            before, count[parity] = count[parity], int((sizes > least * most).sum())
            more = vectors[:, before : count[parity]]
            left = left | {parity: left[parity] - more @ (more.T @ left[parity])}
        if np.sum([np.abs(own) for own in left.values()], axis=0).max() <= error:
            break
    return {parity: vectors[:, : count[parity]] for parity, (_, vectors) in singular.items()}


def _singular(states: Floats) -> tuple[Floats, Floats]:
    """Singular values (k,), the largest first, and left vectors (n_cell, k), from the smaller Gram matrix."""
    few = states.shape[1] <= states.shape[0]
    values, vectors = np.linalg.eigh(states.T @ states if few else states @ states.T)
    sizes = np.sqrt(np.maximum(values[::-1], 0.0))
    kept = sizes > _NOISE * sizes.max(initial=0.0)
    sizes, vectors = sizes[kept], vectors[:, ::-1][:, kept]
    return sizes, states @ (vectors / sizes) if few else vectors
