"""What acts between separate bodies, as unknowns on the cell: in bores, between mating faces, along bolts.

Mating faces have matching facets, so that the pressures at the vertices of one side act on both, and their
moments are those of the gap between the sides. Friction acts along two tangents of the face. A bolt is one
unknown: its force, which presses under the head and at the other end of the grip.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from fea.contact.assembly_state import BoltBeam
from fea.contact.elastic_pin import HALF_COSINE, ORDERS, Pin, harmonics
from fea.contact.multipliers import Direction, Multipliers, uniform
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_TURN, TetMesh

# Harmonics of an elastic pin's deflection, at least and at most: facets follow none that are finer.
FEWEST, HARMONICS = 16, 64

_Z = np.array([0.0, 0.0, 1.0])


class Interface(ABC):
    """Unknowns of one kind on the cell."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of unknowns."""

    @abstractmethod
    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, size) of a unit of each, N."""

    @property
    def on_y(self) -> Mask:
        """Which unknowns (size,) are at places on y = 0."""
        return np.zeros(self.size, dtype=bool)

    @property
    def across(self) -> Mask:
        """Which unknowns (size,) reverse under reflection about y = 0 where they lie on it."""
        return np.zeros(self.size, dtype=bool)

    @property
    def nodes(self) -> Ints:
        """Node (size,) of the cell at which each unknown acts; −1 where it acts at many."""
        return np.full(self.size, -1)

    def initial(self) -> Floats:
        """Moments (size,) of the gap as made."""
        return np.zeros(self.size)

    def flexibility(self, parity: Parity) -> Floats | float:  # noqa: ARG002
        """Moments (size, size) of what a unit of each moves beside the body; 0 for nothing."""
        return 0.0


@dataclass(frozen=True)
class PinInBore(Interface):
    """A pin in a bore whose axis is parallel to z."""

    multipliers: Multipliers  #: the pressures on the bore
    center: tuple[float, float]  #: (x, z) of the middle of the bore and of the pin, mm
    clearance: float  #: radius of the bore minus that of the pin, mm; negative for a press fit
    pin: Pin | None  #: None for a rigid one
    #: cut_y, cut_z: whether the cell represents its mirror images about y = 0, z = 0
    cut_y: bool
    cut_z: bool
    #: Length and radial depth of the relief at either end of the bore, mm: it widens like a parabola
    relief: tuple[float, float] | None = None
    as_drawn: bool = False  #: whether the bore widens by itself, as its mesh shows
    #: Highest one of an elastic pin's deflection; by default what the facets can follow
    harmonics: int | None = None

    @property
    def size(self) -> int:
        """Number of pressures on the cell."""
        return self.multipliers.size

    @property
    def on_y(self) -> Mask:
        """Which of them (size,) are at places on y = 0."""
        return self.multipliers.on_y

    @property
    def nodes(self) -> Ints:
        """Vertices (size,) of the bore."""
        return self.multipliers.nodes

    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, size) of unit pressures, N."""
        return self.multipliers.forces(n_nodes)

    def flexibility(self, parity: Parity) -> Floats | float:
        """Moments (size, size) of the deflection of an elastic pin under unit pressures."""
        return 0.0 if self.deflection is None else self.deflection.compliance[parity]

    def initial(self) -> Floats:
        """Moments (n,) of the gap around the centred pin, as both are made."""
        gap = np.full_like(self.multipliers.areas, self.clearance)
        if self.relief is not None:
            length, depth = self.relief
            off = np.abs(self.multipliers.places[..., 2] - self.center[1])
            gap += depth * np.maximum(0.0, 1 - (off.max() - off) / length) ** 2
        if self.as_drawn:
            x, y, _ = np.moveaxis(self.multipliers.places, -1, 0)
            radius = np.hypot(x - self.center[0], y)
            gap += radius - radius.min()
        return self.multipliers.moments(gap)

    def harmonic(self, order: int, field: Floats) -> dict[Parity, Floats]:
        """Moments (n, k) of cos nφ and of sin nφ times fields (n_facets n_points, k)."""
        waves = {Parity.SYMMETRIC: np.cos, Parity.ANTISYMMETRIC: np.sin}
        average, turned = self.multipliers.averaging, order * self._angle
        return {parity: average @ (wave(turned)[:, None] * field) for parity, wave in waves.items()}

    def resolved(self) -> int:
        """Number of equilateral facets around the bore: its facets follow no higher harmonics."""
        side = np.sqrt(4 / np.sqrt(3) * self.multipliers.areas.sum(axis=1).mean())
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        radius = float(np.hypot(x - self.center[0], y).mean())
        return int(np.clip(2 * np.pi * radius / side, FEWEST, HARMONICS))

    @cached_property
    def _angle(self) -> Floats:
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        return np.asarray(np.arctan2(y, x - self.center[0]))

    def shifted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit shift of the pin along x, and along y."""
        waves = self.harmonic(1, np.ones((len(self._angle), 1)))
        return waves[Parity.SYMMETRIC][:, 0], waves[Parity.ANTISYMMETRIC][:, 0]

    def tilted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit turn of the rod about x, and about y."""
        waves = self.harmonic(1, self.multipliers.places[..., 2].reshape(-1, 1))
        return -waves[Parity.ANTISYMMETRIC][:, 0], waves[Parity.SYMMETRIC][:, 0]

    @cached_property
    def deflection(self) -> "Deflection | None":
        """How the pin gives way, on the cell; None for a rigid one."""
        return None if self.pin is None else Deflection.of(self, self.pin)


@dataclass(frozen=True)
class Deflection:
    """Inward displacement of an elastic pin, as moments on the cell."""

    compliance: dict[Parity, Floats]  #: per parity (n, n), of pressures on the bore
    #: Per parity (n, n_orders), of pressures of 1 MPa times cos nφ or sin nφ on the supports
    carried: dict[Parity, Floats]

    @classmethod
    def of(cls, bore: PinInBore, pin: Pin) -> "Deflection":
        """Add up the harmonics."""
        size = bore.multipliers.size
        compliance = {parity: np.zeros((size, size)) for parity in Parity}
        carried = {parity: np.zeros((size, len(ORDERS))) for parity in Parity}
        z = bore.multipliers.places[..., 2].ravel() - bore.center[1]
        highest = bore.harmonics or bore.resolved()
        share = (2 if bore.cut_y else 1) * (1 if bore.cut_z else 0.5)
        for mirrored in (True,) if bore.cut_z else (True, False):
            stations, answers = harmonics(pin, highest, mirrored=mirrored)
            along = _between(stations, np.abs(z)) * (1.0 if mirrored else np.sign(z)[:, None])
            for answer in answers:
                for parity, moments in bore.harmonic(answer.order, along).items():
                    compliance[parity] += share * moments @ answer.compliance @ moments.T
                    if mirrored and answer.order in ORDERS:
                        column = list(ORDERS).index(answer.order)
                        carried[parity][:, column] = moments @ answer.carried
        if not bore.cut_y:
            compliance = {Parity.SYMMETRIC: sum(compliance.values(), np.zeros((size, size)))}
        return cls(compliance, carried)

    def pressed(self, pin: Pin, force: Floats) -> dict[Parity, Floats]:
        """Moments (n, …) of the deflection by the supports, for forces (2, …) of the pin on the whole rod, N.

        They press with half a cosine around the side opposite to the force, constant along their length.
        """
        near, far = pin.carried or (0.0, np.inf)
        peak = 2 * np.hypot(*force) / (np.pi * pin.radius * 2 * (far - near))
        share = np.multiply.outer(HALF_COSINE, peak)
        turned = np.multiply.outer(ORDERS, np.arctan2(force[1], force[0]) + np.pi)
        waves = {Parity.SYMMETRIC: np.cos(turned), Parity.ANTISYMMETRIC: np.sin(turned)}
        return {parity: self.carried[parity] @ (share * wave) for parity, wave in waves.items()}


def _between(stations: Floats, z: Floats) -> Floats:
    """Values (n, n_stations) at places z of the quadratic functions: every other station ends an element."""
    ends = stations[::2]
    element = np.clip(np.searchsorted(ends, z, side="right") - 1, 0, len(ends) - 2)
    s = np.clip((z - ends[element]) / (ends[element + 1] - ends[element]), 0.0, 1.0)
    values = np.zeros((len(z), len(stations)))
    rows = np.arange(len(z))
    for place, value in enumerate(((1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1))):
        values[rows, 2 * element + place] = value
    return values


@dataclass(frozen=True)
class MatingFaces(Interface):
    """The two sides of an interface on the cell.

    The unknowns are the pressures at the vertices, then, with friction, the shear stresses along the first
    tangent and along the second one. Positive, they push the first side along the direction and the second
    side against it.
    """

    name: str  #: of the interface
    #: Pressures on the first side, then shear stresses along z and along the tangent square to it, which
    #: reverses under reflection about y = 0; each with the vertices (m,) that have it
    kinds: tuple[tuple[Multipliers, Ints], ...]
    #: The surface of the second side, and (n_facets, n_facet_nodes) its facets in the order of the first
    opposite: tuple[Surface, Ints]
    #: By how much the parts overlap before they are put together, normal to the face, mm
    interference: float = 0.0

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        sides: tuple[Surface, Surface],
        direction: Direction,
        *,
        interference: float = 0.0,
        friction: bool = True,
    ) -> "MatingFaces":
        """Set up an interface between two surfaces of a cell, as `mesh.tetmesh.separated` leaves them.

        A pressure pushes the first side in the `direction`, which is square to z.
        """
        first, second = sides
        pressing, facets = Multipliers.of(mesh, first, direction), mesh.facets[second]
        every = np.arange(pressing.size)
        rubbing = every if friction else every[:0]
        # The shear stress along z of a field that is symmetric about z = 0 vanishes there.
        free = ~np.isin(pressing.nodes, mesh.facets.get(Surface.SYMMETRY_Z, ()))
        kinds = (
            (pressing, every),
            (replace(pressing, direction=uniform(_Z)), rubbing[free[rubbing]]),
            (replace(pressing, direction=lambda places: np.cross(_Z, direction(places))), rubbing),
        )
        return cls(str(first), kinds, (second, facets[:, FACET_TURN[facets.shape[1]]]), interference)

    @property
    def pressing(self) -> Multipliers:
        """The pressures on the first side."""
        return self.kinds[0][0]

    @property
    def size(self) -> int:
        """Number of unknowns on the cell."""
        return sum(len(vertices) for _, vertices in self.kinds)

    @property
    def on_y(self) -> Mask:
        """Which unknowns (size,) are at places on y = 0."""
        return np.concatenate([self.pressing.on_y[vertices] for _, vertices in self.kinds])

    @property
    def nodes(self) -> Ints:
        """Vertices (size,) of the first side."""
        return np.concatenate([self.pressing.nodes[vertices] for _, vertices in self.kinds])

    @property
    def across(self) -> Mask:
        """Which unknowns (size,) reverse under reflection about y = 0 where they lie on it."""
        return np.arange(self.size) >= self.size - len(self.kinds[-1][1])

    @property
    def tangential(self) -> tuple[Ints, Ints]:
        """Per vertex (m,) the numbers of its shear stresses among the unknowns; −1 where it has none."""
        numbers, start = np.full((2, self.pressing.size), -1), self.pressing.size
        for number, (_, vertices) in zip(numbers, self.kinds[1:], strict=True):
            number[vertices] = start + np.arange(len(vertices))
            start += len(vertices)
        return numbers[0], numbers[1]

    @cached_property
    def sides(self) -> tuple[Multipliers, Multipliers]:
        """The pressures on the first and on the second side."""
        surface, facets = self.opposite
        return self.pressing, replace(self.pressing, surface=surface, facets=facets)

    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, size) of unit stresses, N."""
        columns = [
            (stress.forces(n_nodes) - replace(stress, facets=self.opposite[1]).forces(n_nodes))[:, vertices]
            for stress, vertices in self.kinds
        ]
        return sparse.csr_array(sparse.hstack(columns))

    def initial(self) -> Floats:
        """Moments (size,) of the gap between the parts as made."""
        return np.pad(-self.interference * self.pressing.weights, (0, self.size - self.pressing.size))

    def traction(self, values: Floats, points: Floats) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, k) on each side of stresses (size, k), MPa."""
        ends = np.cumsum([len(vertices) for _, vertices in self.kinds])
        tractions = {}
        for side, sign in zip(self.sides, (1.0, -1.0), strict=True):
            traction = np.zeros((len(points), 3, values.shape[1]))
            for (kind, vertices), stress in zip(self.kinds, np.split(values, ends[:-1]), strict=True):
                every = np.zeros((side.size, values.shape[1]))
                every[vertices] = stress
                nodes, nodal = side.at_nodes(every)
                traction[nodes] += sign * nodal[:, None] * kind.direction(points[nodes])[..., None]
            tractions[side.surface] = traction
        return tractions


@dataclass(frozen=True)
class BoltPull(Interface):
    """A bolt on the cell, or one of a pair of images about z = 0."""

    name: str
    nodal_forces: Floats  #: (3 n_nodes,) on the cell, of a bolt force of 1 N
    share: float  #: of the bolt that belongs to the cell: one half if the plane z = 0 cuts it
    stiffness: float  #: of what the mesh does not hold, head, shank and thread, N/mm
    traction: dict[Surface, Floats]  #: per surface (n_nodes, 3) of a bolt force of 1 N, MPa
    area: float = 1.0  #: force over its unknown, mm² where this is a stress

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        name: str,
        seats: dict[Surface, Ints],
        axis: Floats,
        stiffness: float,
        *,
        share: float,
        point: Floats | None = None,
    ) -> "BoltPull":
        """Spread the force of a bolt over its seats, as a traction along its axis.

        The axis (3,) leads from the thread to the head. The traction is uniform but for a small linear part,
        which leads its resultant through a point (3,) on the axis, mm, where that is given: the centroids of
        meshed annuli lie beside it, on either end by another distance, and a pair of forces that do not
        oppose each other would be a moment. `seats` are the facets of `BOLT_HEAD` and `BOLT_THREAD` that
        belong to this bolt.
        """
        n_nodes = len(mesh.points)
        forces, traction = np.zeros(3 * n_nodes), {}
        # Axes across the bolt's in which the cell holds the whole seat: not z if z = 0 halves it.
        in_plane = np.cross(_Z, axis)
        across = np.array([in_plane] if share < 1 else [in_plane, np.cross(axis, in_plane)])
        across, origin = (across[:0], np.zeros(3)) if point is None else (across, point)
        for surface, sign in ((Surface.BOLT_HEAD, -1.0), (Surface.BOLT_THREAD, 1.0)):
            facets = mesh.facets[surface][seats[surface]]
            seat = TetMesh(mesh.points, mesh.tets, {surface: facets})
            pull = sign * axis
            pressed = Multipliers.of(seat, surface, uniform(pull))
            # Coefficients of the traction 1, (x − origin) · across of resultant 1 through the origin.
            levers = np.einsum("nk,fqk->nfq", across, pressed.places - origin)
            basis = np.concatenate([np.ones((1, *pressed.areas.shape)), levers])
            moments = np.einsum("ifq,jfq,fq->ij", basis, basis, pressed.areas)
            spread = share * np.linalg.solve(moments, np.eye(len(basis))[0])
            led = replace(pressed, direction=_linear(pull, across, origin, spread))
            forces += np.asarray(led.forces(n_nodes).sum(axis=1)).ravel()
            nodes = np.unique(facets)
            traction[surface] = np.zeros((n_nodes, 3))
            traction[surface][nodes] = led.direction(mesh.points[nodes])
        return cls(name, forces, share, stiffness, traction)

    @property
    def size(self) -> int:
        """One unknown: its force."""
        return 1

    def forces(self, n_nodes: int) -> sparse.csr_array:  # noqa: ARG002
        """Nodal forces (3 n_nodes, 1) of a bolt force of 1 N."""
        return sparse.csr_array(self.nodal_forces[:, None])

    def flexibility(self, parity: Parity) -> float:  # noqa: ARG002
        """Elongation of what the mesh does not hold, for the share of the bolt."""
        return self.share / self.stiffness


@dataclass(frozen=True)
class BoltStop(BoltPull):
    """A bolt that bears on its hole as the joint slips one way: its unknown is its force over `area`, MPa.

    Its force acts on the joint around it, along the tangent in the plane of motion, on either part.
    """

    play: float = 0.0  #: slip from which on it bears, mm

    @classmethod
    def pair(
        cls, joint: MatingFaces, around: Mask, beam: BoltBeam, share: float, n_nodes: int
    ) -> tuple["BoltStop", "BoltStop"]:
        """The stops either way of a bolt with these vertices (n,) of the joint around it."""
        tangent, _ = joint.kinds[-1]
        both = tangent.forces(n_nodes) - replace(tangent, facets=joint.opposite[1]).forces(n_nodes)
        unit, area = np.asarray(both @ around.astype(float)), float(joint.pressing.weights @ around) / share
        one, other = (cls("stop", way * unit, share, beam.lateral, {}, area, beam.play) for way in (1, -1))
        return one, other

    def initial(self) -> Floats:
        """Moment (1,) of the play."""
        return np.array([self.share * self.area * self.play])

    def flexibility(self, parity: Parity) -> float:  # noqa: ARG002
        """Moment of the offset of the parts that a unit bends it by."""
        return self.share * self.area**2 / self.stiffness


def _linear(pull: Floats, across: Floats, origin: Floats, spread: Floats) -> Direction:
    return lambda places: (spread[0] + (places - origin) @ (spread[1:] @ across))[..., None] * pull
