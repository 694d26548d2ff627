"""A rod of separate parts: from its bolts, fits and pins to the nodal forces of a load case."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.contact.assembled import Assembled, Warming
from fea.contact.friction_cycle import FrictionCycle
from fea.contact.friction_system import ContactState, Load
from fea.contact.interfaces import BoltPull, MatingFaces
from fea.contact.multipliers import Direction, radial
from fea.machine.threads import one_blas_thread
from fea.pins.assembly_states import AssemblyStates, gap_at_nodes, pressure_at_nodes
from fea.pins.case_forces import CaseForces
from fea.pins.fits import Fits
from fea.pins.rod_contact import RodContact, Solved, acting, key
from fea.rod.meshed_rod import Bores
from fea.solid.errors import ContactError
from fea.solid.inertia import Inertia
from fea.solid.parity import Parity, Split
from fea.solid.supports import components
from fea.solvers.static import Model
from geometry.arrays import Floats, Ints
from geometry.assembly import BoltAxis
from geometry.surfaces import Surface
from loads.cases import ASSEMBLY, assembled
from loads.instants import Instants
from mesh.tetmesh import TetMesh

# Distance from a mirror plane, over the hole's radius, within which a bolt's axis lies on it.
_ON_PLANE = 1e-6


@dataclass(frozen=True, kw_only=True)
class Expansion:
    """A uniform change of temperature, K, and linear expansions, 1/K, of parts, bolts and both pins."""

    rise: float
    parts: tuple[float, ...]
    bolt: float
    piston_pin: float
    crank_pin: float


@dataclass(frozen=True, kw_only=True)
class Putting:
    """How the parts are put together.

    Attributes
    ----------
    normal
        (x, y) of the joint plane, from the cap towards the rod.
    bolts
        Axes of all bolts of the whole rod.
    preload, stiffness
        Of each bolt after tightening, N, and of what of it the mesh does not hold, N/mm.
    friction
        Coefficient μ between the parts.
    interference
        Radial, mm, by the first surface of an interface.
    expansion
        None where the engine is as warm as the room in which the parts were put together.
    parts
        Names of the parts in the order of their numbers.
    """

    normal: tuple[float, float]
    bolts: tuple[BoltAxis, ...]
    preload: float
    stiffness: float
    friction: float
    interference: Mapping[Surface, float]
    expansion: Expansion | None = None
    parts: tuple[str, ...] = ()


class AssembledRod(RodContact):
    """The contact problem of a meshed rod of separate parts.

    Parameters
    ----------
    model, bores, inertia, fits
        As for `RodContact`.
    putting
        How the parts are put together.

    Attributes
    ----------
    assembled
        The parts put together.
    states
        Sums up steps of them.

    Raises
    ------
    ContactError
        No contact between the parts carries the bolt forces.
    """

    def __init__(self, model: Model, bores: Bores, inertia: Inertia, fits: Fits, putting: Putting) -> None:
        mesh = model.mesh
        faces = [
            MatingFaces.of(
                mesh,
                sides,
                _direction(sides[0], bores, putting.normal),
                interference=putting.interference.get(sides[0], 0.0),
                friction=putting.friction > 0,
            )
            for sides in mesh.interfaces
        ]
        self.bolt_axes = _of_cell(mesh, putting.bolts)
        self._known: dict[
            bytes, ContactState
        ] = {}  # load cases are asked for again where the cycle is checked
        bolts = _pulls(mesh, self.bolt_axes, putting.stiffness)
        super().__init__(model, bores, inertia, fits, faces=faces, bolts=bolts)
        body = components(mesh)
        held = body[mesh.tets[0, 0]]  # the first part, to which the others are moved
        parts = [np.flatnonzero(body == number) for number in np.unique(body) if number != held]
        names = [_part_name(mesh, nodes, putting.parts) for nodes in parts]
        preload = np.full(len(self.bolt_axes), putting.preload)
        warming = _warming(mesh, bores, fits, putting)
        self._growth = None if warming is None else Split(warming.displacement.reshape(-1, 3), None)
        self.assembled = Assembled(self.problem, parts, putting.friction, preload, warming, names=names)
        at = np.array([bolt.point for bolt in self.bolt_axes]).reshape(-1, 3)
        self.states = AssemblyStates(self.assembled, putting.friction, at, bores.big_radius)

    def _solved(self, pin: Floats, crank: Floats, motion: Floats) -> ContactState:
        asked = key(pin, crank, motion)
        if asked not in self._known:
            self._known[asked] = self.assembled.step(self._load(pin, crank, motion), self.assembled.start)
        return self._known[asked]

    def solutions(self, instants: Instants) -> list[ContactState]:
        """States at instants, each of them from that in which the parts were put together.

        Errors are those of `RodContact.solutions`.
        """
        with one_blas_thread():
            return [self._solved(*instant) for instant in acting(instants)]

    def cycle(self, increments: Instants) -> FrictionCycle:
        """A cycle with increments."""
        return FrictionCycle(self.assembled, self.loads(increments))

    def loads(self, instants: Instants) -> list[Load]:
        """What acts between the parts at instants."""
        return [self._load(*instant) for instant in acting(instants)]

    def _load(self, pin: Floats, crank: Floats, motion: Floats) -> Load:
        return self.assembled.load((pin, crank), motion, self._tilted(motion))

    def __call__(self, case: Instants) -> CaseForces:
        """Nodal forces of everything that acts in a case; see `RodContact`."""
        try:
            return self.assembly() if case.name == ASSEMBLY else super().__call__(case)
        except ContactError as error:
            raise type(error)(f"{case.name}: {error}") from error

    def under(self, case: Instants, state: ContactState) -> CaseForces:
        """Nodal forces of everything that acts in a case whose state is known."""
        return self._forces(case, state)

    def scaled(self, case: Instants, factor: float) -> ContactState:
        """Find the state under a multiple of everything that acts in a case.

        Raises
        ------
        ContactError
            No state of contact carries it.
        """
        pin, crank, motion = (factor * own for own in (case.pin, case.crank, case.motions))
        with one_blas_thread():
            return self._solved(pin, crank, motion)

    def assembly(self, *, warm: bool = True) -> CaseForces:
        """Nodal forces of bolts and fits alone.

        Parameters
        ----------
        warm
            Whether at the engine's temperature, or where the parts were put together and their bores made.
        """
        found = self.assembled.start if warm else self.assembled.tightened
        return replace(self._forces(assembled(), found), touch={})

    def _pressing(self, found: ContactState) -> Floats:
        """Unknowns (n,) with pressures of exactly zero where parts have parted."""
        values = found.values.copy()
        values[self.assembled.vertices.normal] = self.states.pressure(found)
        return values

    def _forces(self, case: Instants, found: Solved) -> CaseForces:
        forces = super()._forces(case, found)
        if not isinstance(found, ContactState):
            raise TypeError("the parts of an assembly are solved step by step")
        state, moved = self.states(found), self.assembled.displacement(found)
        shift = Split(moved[Parity.SYMMETRIC], moved.get(Parity.ANTISYMMETRIC))
        return replace(
            forces,
            shift=shift,
            growth=self._growth,
            largest=max(float(case.largest_force), state.bolt_force),
            assembly=state,
            pressure=pressure_at_nodes(self.problem, self._pressing(found)),
            gap=gap_at_nodes(self.problem, self.assembled.vertices.normal, self.states.gap(found)),
        )


def _direction(surface: Surface, bores: Bores, normal: tuple[float, float]) -> Direction:
    """In which pressure on an interface pushes its first side."""
    if surface is Surface.JOINT:
        across = np.array([*normal, 0.0])
        return lambda places: np.broadcast_to(across, places.shape)
    return radial(bores.rod_length if surface is Surface.BUSHING_SEAT else 0.0)


def _part_name(mesh: TetMesh, nodes: Ints, names: Sequence[str]) -> str:
    """Name of the part that nodes belong to."""
    number = 0 if mesh.part is None else mesh.part[np.isin(mesh.tets[:, 0], nodes).argmax()]
    return names[number] if number < len(names) else "part"


def _of_cell(mesh: TetMesh, bolts: Sequence[BoltAxis]) -> tuple[BoltAxis, ...]:
    """Bolts that the cell holds, or holds a half of."""
    cuts = [(1, Surface.SYMMETRY_Y), (2, Surface.SYMMETRY_Z)]
    return tuple(
        bolt
        for bolt in bolts
        if all(plane not in mesh.facets or bolt.point[axis] > -_on(bolt) for axis, plane in cuts)
    )


def _on(bolt: BoltAxis) -> float:
    return _ON_PLANE * bolt.hole_radius


def _pulls(mesh: TetMesh, bolts: Sequence[BoltAxis], stiffness: float) -> list[BoltPull]:
    """The bolts of the cell with the facets that they press on."""
    owner = {surface: _owner(mesh, surface, bolts) for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    halved = Surface.SYMMETRY_Z in mesh.facets
    return [
        BoltPull.of(
            mesh,
            f"bolt {number + 1}",
            {surface: np.flatnonzero(own == number) for surface, own in owner.items()},
            np.array(bolt.direction),
            stiffness,
            share=0.5 if halved and abs(bolt.point[2]) <= _on(bolt) else 1.0,
            point=np.array(bolt.point),
        )
        for number, bolt in enumerate(bolts)
    ]


def _owner(mesh: TetMesh, surface: Surface, bolts: Sequence[BoltAxis]) -> Ints:
    """Number of the bolt whose axis is nearest to each facet."""
    middle = mesh.points[mesh.facets[surface][:, :3]].mean(axis=1)
    away = []
    for bolt in bolts:
        off, along = middle - np.array(bolt.point), np.array(bolt.direction)
        away.append(np.linalg.norm(off - (off @ along)[:, None] * along, axis=1))
    return np.asarray(np.stack(away).argmin(axis=0))


def _warming(mesh: TetMesh, bores: Bores, fits: Fits, putting: Putting) -> Warming | None:
    """Free expansion of the parts about the big end's centre, of the bolts and of the pins."""
    own = putting.expansion
    if own is None or own.rise == 0:
        return None
    rate = np.zeros(len(mesh.points))
    parts = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
    for number, alpha in enumerate(own.parts):
        rate[mesh.tets[parts == number]] = alpha
    bolts = _of_cell(mesh, putting.bolts)
    pins = (
        (own.piston_pin, bores.small_radius - fits.small_clearance),
        (own.crank_pin, bores.big_radius - fits.big_clearance),
    )
    return Warming(
        displacement=(own.rise * rate[:, None] * mesh.points).ravel(),
        bolts=np.array([own.rise * own.bolt * bolt.grip for bolt in bolts]),
        pins=[own.rise * alpha * radius for alpha, radius in pins],
    )
