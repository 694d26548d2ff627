"""Bending of bolts whose ends follow their seats.

A bolt is a beam between its head's seat and the nut's, or the first thread that carries. Its ends follow the
mean motion of these seats, the rigid one that is nearest in the least squares, as they do while friction
holds head and nut. While a bolt is tightened its head slides, so that it has no shear then. The seats move
under what acts between the parts and on them; in turn the bolt's moments turn them back, through the parts as
they stick together where the joint is closed. What they do to bolt force and pressures is left out: it is
small as long as a bolt is slender beside what it clamps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from fea.contact.assembled import Assembled
from fea.contact.assembly_state import BoltBeam
from fea.contact.friction_system import ContactState
from fea.contact.multipliers import Multipliers, uniform
from fea.solid.parity import MirrorUnfolding, Parity
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

_Z = np.array([0.0, 0.0, 1.0])
# Stiffness, over that of each place alone, that holds parts which nothing else holds.
_HELD = 1e-9


class Body(Protocol):
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
        body: Body,
        assembled: Assembled,
        ends: Sequence[BoltEnds],
        beam: BoltBeam,
        growth: Floats | float = 0.0,
    ) -> None:
        problem = assembled.problem
        self.beam, self._assembled = beam, assembled
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
        of_beams = np.kron(np.diag([end.share for end in ends]), np.kron(np.eye(2), beam.flexibility))
        beams = self._unfolding.compliance(dict.fromkeys(self._unfolding.parities(), of_beams))
        joint = [number for number, own in enumerate(problem.faces) if own.name == Surface.JOINT]
        self._joint = np.flatnonzero(np.isin(assembled.vertices.face, joint))
        self._opened: dict[bytes, Floats] = {}
        self._compliance = beams + self._seats(itself)
        self._stiffness = np.linalg.inv(self._compliance)
        warmed = self._whole({Parity.SYMMETRIC: turning.T @ np.broadcast_to(growth, len(turning))})
        self._made = warmed + self._shifted(self._turns(assembled.tightened))

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
        both = np.kron(np.eye(len(turns) // 2), np.ones((2, 1)))
        sheared = both.T @ self._stiffness
        return np.asarray(-both @ np.linalg.solve(sheared @ both, sheared @ turns))

    def moments(self, state: ContactState) -> Floats:
        """Moments (n_bolts, 2, 2), N mm, in the order of `BoltBeam.bending`; zero for bolts without force."""
        moments = (self._with_open(state) @ (self._turns(state) + self._made)).reshape(-1, 2, 2)
        moments[state.values[self._assembled.bolts] <= 0] = 0.0
        return np.asarray(moments)

    def _with_open(self, state: ContactState) -> Floats:
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
            more = stresses.T @ cho_solve(cho_factor(stiff, overwrite_a=True), stresses)
            self._opened[key] = np.linalg.inv(self._compliance + more)
        return self._opened[key]

    def _turns(self, state: ContactState) -> Floats:
        """Turns (m,) of the ends of all bolts with their seats, as these are without their moments."""
        assembled, load = self._assembled, state.load
        values = assembled.problem.unfolding.parts(state.values)
        turned = {
            parity: turned @ values[parity] + self._loaded[parity] @ load.motion
            for parity, turned in self._turned.items()
        }
        return np.asarray(self._whole(turned) + self._moved @ assembled.system.part_motion(state))
