"""Bolts: their force as an unknown of contact, how they bear on their holes, and how they bend.

The force of a bolt presses under its head and at the other end of the grip. For its bending, a bolt is a beam
between its head's seat and the nut's, or the first thread that carries. Its ends follow the mean motion of
these seats, the rigid one that is nearest in the least squares, as they do while friction holds head and nut.
While a bolt is tightened its head slides, so that it has no shear then. The seats move under what acts
between the parts and on them; in turn the bolt's moments turn them back, through the parts as they stick
together where the joint is closed. What they do to bolt force and pressures is left out: it is small as long
as a bolt is slender beside what it clamps.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve

from fea.contact.assembly_state import BoltBeam
from fea.contact.interfaces import ContactInterface, Direction, MatingFaces, Multipliers, uniform
from fea.solid.parity import MirrorUnfolding, Parity
from geometry.arrays import Floats, Ints, Mask, Reals
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

if TYPE_CHECKING:
    from fea.contact.assembled import Assembled
    from fea.contact.friction_system import ContactState

_Z = np.array([0.0, 0.0, 1.0])
# Stiffness, over that of each place alone, that holds parts which nothing else holds.
_HELD = 1e-9


@dataclass(frozen=True)
class BoltPull(ContactInterface):
    """A bolt on the cell, or one of a pair of images about z = 0."""

    nodal_forces: Floats  #: (3 n_nodes,) on the cell, of a bolt force of 1 N
    share: float  #: of the bolt that belongs to the cell: one half if the plane z = 0 cuts it
    stiffness: float  #: of what the mesh does not hold, head, shank and thread, N/mm
    seated: dict[Surface, Floats]  #: traction (n_nodes, 3) on each seat of a bolt force of 1 N, MPa
    area: float = 1.0  #: force over its unknown, mm² where this is a stress

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
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
        return cls(forces, share, stiffness, traction)

    @property
    def kinds(self) -> tuple[tuple[Multipliers, Ints], ...]:
        """None: the one unknown is the force."""
        return ()

    @property
    def size(self) -> int:
        """One unknown: its force."""
        return 1

    @property
    def on_y(self) -> Mask:
        """A bolt's unknown belongs to its side of y = 0."""
        return np.zeros(1, dtype=bool)

    @property
    def nodes(self) -> Ints:
        """Its force acts at many."""
        return np.array([-1])

    def forces(self, n_nodes: int) -> sparse.csr_array:  # noqa: ARG002
        """Nodal forces (3 n_nodes, 1) of a bolt force of 1 N."""
        return sparse.csr_array(self.nodal_forces[:, None])

    def flexibility(self, parity: Parity) -> float:  # noqa: ARG002
        """Elongation of what the mesh does not hold, for the share of the bolt."""
        return self.share / self.stiffness

    def traction(self, values: Floats, points: Floats) -> dict[Surface, Floats]:  # noqa: ARG002
        """Traction (n_nodes, 3, k) on the seats under forces (1, k), MPa."""
        return {surface: unit[..., None] * values for surface, unit in self.seated.items()}

    def pressure(self, values: Floats, n_nodes: int) -> dict[Surface, Floats]:  # noqa: ARG002
        """Pressure (n_nodes,) on the seats under a force (1,), MPa."""
        return {surface: values[0] * np.linalg.norm(unit, axis=1) for surface, unit in self.seated.items()}


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
        (first, _), (second, _) = joint.sides(joint.kinds[-1][0])
        both = first.forces(n_nodes) - second.forces(n_nodes)
        unit, area = np.asarray(both @ around.astype(float)), float(joint.pressing.weights @ around) / share
        one, other = (cls(way * unit, share, beam.lateral, {}, area, beam.play) for way in (1, -1))
        return one, other

    def initial(self) -> Floats:
        """Moment (1,) of the play."""
        return np.array([self.share * self.area * self.play])

    def flexibility(self, parity: Parity) -> float:  # noqa: ARG002
        """Moment of the offset of the parts that a unit bends it by."""
        return self.share * self.area**2 / self.stiffness


def _linear(pull: Floats, across: Floats, origin: Floats, spread: Floats) -> Direction:
    return lambda places: (spread[0] + (places - origin) @ (spread[1:] @ across))[..., None] * pull


def _relief(stiffness: Reals, turns: Floats) -> tuple[Floats, Floats]:
    """Sums (m,) of the moments on both ends of beams that turn (2 m,), and turns (m,) that undo them."""
    both = np.repeat(np.eye(len(turns) // 2), 2, axis=0)
    sheared = both.T @ stiffness
    moments = sheared @ turns
    return moments, np.asarray(np.linalg.solve(sheared @ both, moments), np.float64)


class _RestrainedBody(Protocol):
    """What of the parts is needed."""

    def restrained(self, parity: Parity) -> tuple[Mask, Callable[[Floats], Floats]]:
        """Constrained degrees of freedom (n,) of a parity about y = 0, and the solver for (n, k) forces."""


@dataclass(frozen=True)
class BoltEnds:
    """Where a bolt sits on the cell."""

    seats: Mapping[Surface, Ints]  #: its facets of `BOLT_HEAD` and `BOLT_THREAD`
    head: Floats  #: (3,) where its axis meets the head's seat, mm
    thread: Floats  #: (3,) where it meets the nut's seat or the first thread that carries, mm
    share: float  #: of the bolt that belongs to the cell: one half if the plane z = 0 cuts it

    def turning(self, mesh: TetMesh) -> Floats:
        """Nodal vectors (3 n_nodes, 4) whose work on a displacement is how far the beam's ends turn.

        They are those of the ends at head and thread in the plane across z, then in the other one, against
        the line between the ends; zero there for a bolt that is cut at z = 0, which has none.
        """
        along = self.head - self.thread
        length = float(np.linalg.norm(along))
        axis = along / length
        in_plane = np.cross(_Z, axis)
        columns = []
        for across in (in_plane, np.cross(axis, in_plane)):
            head = self._motion(mesh, Surface.BOLT_HEAD, self.head, across, axis)
            thread = self._motion(mesh, Surface.BOLT_THREAD, self.thread, across, axis)
            tilt = (head[0] - thread[0]) / length
            columns += [head[1] - tilt, thread[1] - tilt]
        return self.share * np.stack(columns, axis=1)

    def _motion(
        self, mesh: TetMesh, surface: Surface, origin: Floats, across: Floats, axis: Floats
    ) -> tuple[Floats, Floats]:
        """Nodal vectors (3 n_nodes,) whose work is the shift of a seat at the origin, and its turn."""
        seat = TetMesh(mesh.points, mesh.tets, {surface: mesh.facets[surface][self.seats[surface]]})
        pressed = Multipliers.of(seat, surface, uniform(axis))
        shifts, turns = np.eye(3), np.eye(3)
        if self.share < 1:  # a half moves only as the plane z = 0 lets it
            shifts, turns = shifts[:2], turns[2:]
        if self.share < 1 and abs(across @ _Z) > 0.5:
            return np.zeros(3 * len(mesh.points)), np.zeros(3 * len(mesh.points))

        def fields(places: Floats) -> list[Floats]:
            rigid = [np.broadcast_to(shift, places.shape) for shift in shifts]
            return rigid + [np.cross(turn, places - origin) for turn in turns]

        def nodal(number: int) -> Floats:
            field = replace(pressed, direction=lambda places: fields(places)[number])
            return np.asarray(field.forces(len(mesh.points)).sum(axis=1))

        own = np.stack(fields(pressed.places))
        rows = [nodal(number) for number in range(len(own))]
        gram = np.einsum("ifqd,jfqd,fq->ij", own, own, pressed.areas)
        shift, turn = np.split(np.linalg.solve(gram, np.array(rows)), [len(shifts)])
        return (shifts @ across) @ shift, (turns @ np.cross(axis, across)) @ turn


class BoltBending:
    """Bending of the bolts of parts that are put together.

    `body`: the parts; `growth`: (3 n_nodes,) free thermal expansion of the parts on the cell, mm; 0 for none.
    """

    def __init__(
        self,
        body: _RestrainedBody,
        assembled: "Assembled",
        ends: Sequence[BoltEnds],
        beam: BoltBeam,
        growth: Floats | float = 0.0,
    ) -> None:
        problem = assembled.problem
        self.beam, self._assembled = beam, assembled
        self._shares = np.diag([end.share for end in ends])
        self._lengths = np.array([np.linalg.norm(end.head - end.thread) for end in ends])
        turning = np.hstack([end.turning(problem.mesh) for end in ends])
        both = problem.unfolding.both_sides
        self._unfolding = MirrorUnfolding(np.zeros(turning.shape[1], bool), both, problem.unfolding.images)
        self._turned, self._loaded, itself, motions = {}, {}, {}, []
        for parity in self._unfolding.parities():
            fixed, solve = body.restrained(parity)
            u = solve(np.where(fixed[:, None], 0.0, turning))
            self._turned[parity] = (problem.forces.T @ u).T
            self._loaded[parity] = u.T @ problem.cell_loads[parity]
            itself[parity] = u.T @ turning
        for parity, motion in assembled.motions:
            motions.append(self._whole({parity: turning.T @ motion}))
        self._moved = np.stack(motions, axis=1) if motions else np.zeros((self._unfolding.size, 0))
        joint = [number for number, own in enumerate(problem.faces) if own.name == Surface.JOINT]
        self._joint = np.flatnonzero(np.isin(assembled.vertices.face, joint))
        self._opened: dict[bytes, Floats] = {}
        self._of_seats = self._seats(itself)
        self._warmed = self._whole({Parity.SYMMETRIC: turning.T @ np.broadcast_to(growth, len(turning))})
        self._tighten()

    def of(self, assembled: "Assembled", beam: BoltBeam | None = None) -> "BoltBending":
        """Return the bending of other bolts in the same seats, or of the same ones with another preload."""
        other = copy(self)
        other.beam, other._assembled = beam or self.beam, assembled  # noqa: SLF001 - its own
        other._tighten()  # noqa: SLF001
        return other

    def _tighten(self) -> None:
        of_beams = np.kron(self._shares, np.kron(np.eye(2), self.beam.flexibility))
        beams = self._unfolding.compliance(dict.fromkeys(self._unfolding.parities(), of_beams))
        self._compliance = beams + self._of_seats
        self._stiffness = np.linalg.inv(self._compliance)
        self._made = self._warmed + self._shifted(self._turns(self._assembled.tightened))

    def _whole(self, parts: dict[Parity, Floats]) -> Floats:
        """Turns of all bolts from those of each parity on the cell, zero where a parity is missing."""
        nothing = np.zeros_like(next(iter(parts.values())))
        return self._unfolding.moments({p: parts.get(p, nothing) for p in self._unfolding.parities()})

    def _seats(self, itself: Mapping[Parity, Floats]) -> Floats:
        """Turns (m, m) of the ends that unit moments on the parts cause while these stick together."""
        unit = self._unfolding.parts(np.eye(self._unfolding.size))
        moved = {parity: turned.T @ unit[parity] for parity, turned in self._turned.items()}
        gap = self._assembled.problem.unfolding.moments(moved)
        values, amounts = self._assembled.sticking(gap, self._moved.T)
        self._stresses = values[self._assembled.interface]
        stuck = gap.T @ values + self._moved @ amounts
        turns = self._unfolding.compliance(itself) + stuck
        return np.asarray((turns + turns.T) / 2)

    def _shifted(self, turns: Floats) -> Floats:
        """Turns (m,) by which heads that slide on their seats relieve the bolts of shear."""
        return -np.repeat(_relief(self._stiffness, turns)[1], 2)

    def moments(self, state: "ContactState") -> Floats:
        """Moments (n_bolts, 2, 2), N mm, in the order of `BoltBeam.bending`; zero for bolts without force."""
        moments = (self._with_open(state) @ (self._turns(state) + self._made)).reshape(-1, 2, 2)
        moments[state.values[self._assembled.bolts] <= 0] = 0.0
        return np.asarray(moments)

    def held(self, state: "ContactState") -> tuple[Floats, Floats]:
        """Shear (n_bolts, 2) by which friction holds each head in both planes, N, and the shift without it.

        The shift (n_bolts, 2), mm, is how far heads would slide on their seats if nothing held them. Both are
        zero for bolts without force.
        """
        moment, turn = _relief(self._with_open(state), self._turns(state) + self._made)
        count = len(moment) // (2 * len(self._lengths))  # sides of y = 0
        length, share = np.tile([self._lengths, np.diag(self._shares)], count)[..., None]
        pulls = (state.values[self._assembled.bolts] > 0)[:, None]
        shear, shift = moment.reshape(-1, 2) / length, turn.reshape(-1, 2) * length / share
        return np.where(pulls, shear, 0.0), np.where(pulls, shift, 0.0)

    def _with_open(self, state: "ContactState") -> Floats:
        """Moments (m, m) by unit turns, where the parts may move freely at places of the joint that are open.

        By unit moments these places have stresses V while all sticks, which their gaps undo: Vᵀ S⁻¹ V more
        compliance.
        """
        opened = self._joint[state.guess.opened[self._joint]]
        key = opened.tobytes()
        if key not in self._opened:
            places, S = self._assembled.system.places, self._assembled.system.condensed.S
            free = np.concatenate([places.normal[opened], places.tangential[opened].ravel()])
            free = free[free >= 0]
            unit = 1 / np.sqrt(np.diag(S)[free])
            stiff = unit[:, None] * S[np.ix_(free, free)] * unit + _HELD * np.eye(len(free))
            stresses = unit[:, None] * self._stresses[free]
            self._opened[key] = stresses.T @ cho_solve(cho_factor(stiff, overwrite_a=True), stresses)
        return np.asarray(np.linalg.inv(self._compliance + self._opened[key]))

    def _turns(self, state: "ContactState") -> Floats:
        """Turns (m,) of the ends of all bolts with their seats, as these are without their moments."""
        assembled, load = self._assembled, state.load
        values = assembled.problem.unfolding.parts(state.values)
        turned = {
            parity: turned @ values[parity] + self._loaded[parity] @ load.motion
            for parity, turned in self._turned.items()
        }
        return np.asarray(self._whole(turned) + self._moved @ assembled.system.part_motion(state))
