"""From the stiffness of the parts to a dense problem for what acts between them, and its condensed form.

Interfaces are condensed in the state in which they are closed and stick: the parts then move as one body.
With the stresses λ_J between the parts and the bolt forces as unknowns that keep their gaps y_J, what is left
is the compliance of the joined body for its pins:

    w_p = A λ_p + Bᵀ (y_J − g_J) + G f + g_p − R d
    λ_J = S (y_J − g_J) − B λ_p + V f

This is a principal pivot transform of the contact problem (Cottle, Pang & Stone 1992, section 2.3), in which
the rigid motions of the parts have gone as well. Only what opens or slips is an unknown beside the pins.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve, lapack

from fea.contact.active_set import ContactSystem
from fea.contact.bolts import BoltPull, BoltStop
from fea.contact.interfaces import ContactInterface, MatingFaces, PinInBore
from fea.solid.parity import MirrorUnfolding, Parity
from fea.solid.supports import motions_with, rigid_motions
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh


class _ElasticBody(Protocol):
    """What of a body the contact needs."""

    def compliance(self, parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work (k, k) of forces (3 n_nodes, k) of one parity about y = 0 on what they cause."""


class ContactProblem:
    """What acts between separate parts and their pins, as unknowns with their compliance.

    The unknowns are the pressures of the pins in their bores, the stresses between mating faces and the bolt
    forces, in this order on the cell; their images across y = 0 follow, if loads and unknowns have both
    parities about it (`both_sides`). `body`: gives the work of forces on the cell; `loads`: per parity (3
    n_nodes, n_loads) forces on the cell beside the unknowns, with weights of their own.

    Attributes: `forces`: (3 n_nodes, n_cell) nodal forces of a unit of each unknown of the cell;
    `cell_loads`: the loads; `pulls`: how many of the `bolts`, the first ones, are no stops; `nodes`:
    (n_cell,) node of the cell at which each of them acts; −1 for bolts; `unfolding`: leads from the cell to
    all unknowns; `cell_compliance`: per parity (n_cell, n_cell) moments of the displacements of unit
    unknowns; `compliance`, `initial`, `rigid`: C (n, n), the moments (n,) of the gaps as made and those (n,
    m) of the pins' free motions, R in `fea.contact.active_set`; `loaded`: (n, n_loads) moments of the gaps
    that unit loads open.
    """

    def __init__(
        self,
        body: _ElasticBody,
        mesh: TetMesh,
        bores: Sequence[PinInBore],
        loads: Mapping[Parity, Floats],
        *,
        both_sides: bool,
        faces: Sequence[MatingFaces] = (),
        bolts: Sequence[BoltPull] = (),
    ) -> None:
        self.mesh, self.bores, self.faces, self.bolts = mesh, tuple(bores), tuple(faces), tuple(bolts)
        self.cut_y, self.cut_z = (plane in mesh.facets for plane in (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z))
        self.cell_loads, self.pulls = loads, sum(not isinstance(bolt, BoltStop) for bolt in bolts)
        self.interfaces: tuple[ContactInterface, ...] = (*self.bores, *self.faces, *self.bolts)
        self.unfolding = MirrorUnfolding(
            np.concatenate([interface.on_y for interface in self.interfaces]),
            both_sides and self.cut_y,
            (2 if self.cut_y else 1) * (2 if self.cut_z else 1),
            np.concatenate([interface.across for interface in self.interfaces]),
        )
        self.nodes = np.concatenate([interface.nodes for interface in self.interfaces])
        forces = [interface.forces(len(mesh.points)) for interface in self.interfaces]
        self.forces = sparse.csr_array(sparse.hstack(forces))
        self.starts = np.cumsum([0, *(interface.size for interface in self.interfaces)])
        compliance, loaded = {}, {}
        for parity in self.unfolding.parities():
            compliance[parity], loaded[parity] = self._compliance(body, parity, loads[parity])
        self.loaded = self.unfolding.moments(loaded)
        self.cell_compliance, self.compliance = compliance, self.unfolding.compliance(compliance)
        self.initial = self._as_made()
        columns = []
        for number, bore in enumerate(self.bores):
            along_x, along_y = (self._on_cell(number, shift) for shift in bore.shifted())
            columns.append(self.gaps(along_x))
            if self.unfolding.both_sides:
                columns.append(self.gaps(np.zeros_like(along_y), along_y))
            elif not self.cut_y:
                columns.append(self.gaps(along_y))
        if self.bores and not self.cut_z:  # a body that may tilt
            tilts = zip(*(bore.tilted() for bore in self.bores), strict=True)
            columns += [self.gaps(self._on_cell(0, np.concatenate(turned))) for turned in tilts]
        self.rigid = np.stack(columns, axis=1) if columns else np.zeros((self.unfolding.size, 0))

    def _as_made(self) -> Floats:
        return self.gaps(np.concatenate([interface.initial() for interface in self.interfaces]))

    def crushed(self, share: float) -> "ContactProblem":
        """Return the same problem with so many times the interferences between the parts."""
        other = copy(self)
        other.faces = tuple(replace(face, interference=share * face.interference) for face in self.faces)
        other.interfaces = (*self.bores, *other.faces, *self.bolts)
        other.initial = other._as_made()  # noqa: SLF001 - its own
        return other

    @cached_property
    def system(self) -> ContactSystem:
        """The problem of a body of one part and its pins."""
        return ContactSystem(self.compliance, self.rigid)

    def _compliance(self, body: _ElasticBody, parity: Parity, loads: Floats) -> tuple[Floats, Floats]:
        """Moments on the cell of unit pressures (n_cell, n_cell) and of the other loads (n_cell, n_loads)."""
        n_cell = self.forces.shape[1]
        # With the zeros that the other parity has, so that the loads of both have the same sparsity.
        acting = np.logical_or.reduce([own != 0 for own in self.cell_loads.values()])
        column, row = np.nonzero(acting.T)
        starts = np.append(0, np.cumsum(acting.sum(axis=0))).astype(np.int32)
        others = sparse.csc_array((loads[row, column], row.astype(np.int32), starts), shape=loads.shape)
        work = body.compliance(parity, sparse.hstack([self.forces, others], format="csc"))
        compliance = (work[:n_cell, :n_cell] + work[:n_cell, :n_cell].T) / 2
        for number, interface in enumerate(self.interfaces):
            compliance[self.own(number), self.own(number)] += interface.flexibility(parity)
        return compliance, work[:n_cell, n_cell:]

    def gaps(self, even: Floats, odd: Floats | None = None) -> Floats:
        """Moments (n,) over the whole body of gaps with an even and an odd part (n_cell,) on the cell."""
        parts = {Parity.SYMMETRIC: even}
        if self.unfolding.both_sides:
            parts[Parity.ANTISYMMETRIC] = np.zeros_like(even) if odd is None else odd
        return self.unfolding.moments(parts)

    def _on_cell(self, number: int, values: Floats) -> Floats:
        """Values (n_cell, …) of the unknowns of the cell from those of one bore, or of it and the next."""
        cell = np.zeros((self.forces.shape[1], *values.shape[1:]))
        start = self.starts[number]
        cell[start : start + len(values)] = values
        return cell

    def moved(self, nodes: Ints) -> tuple[Floats, Floats]:
        """Moments (n, m) of the free rigid motions of a part, and resultants (m, n_loads) along them."""
        columns, resultants = [], []
        for parity, moves in self.motions(nodes):
            moments = {each: np.zeros(self.forces.shape[1]) for each in self.unfolding.parities()}
            moments[parity] = -(self.forces.T @ moves)
            columns.append(self.unfolding.moments(moments))
            resultants.append(self.unfolding.images * (moves @ self.cell_loads[parity]))
        return np.stack(columns, axis=1), np.stack(resultants)

    def motions(self, nodes: Ints) -> list[tuple[Parity, Floats]]:
        """The rigid motions that the mirror planes leave a part: parity and displacement (3 n_nodes,)."""
        points = self.mesh.points
        unit = rigid_motions(points[nodes], points[nodes].mean(axis=0) * [1.0, 0.0, 0.0])
        free = []
        for parity in self.unfolding.parities():
            for motion in motions_with(self.mesh, parity):
                moves = np.zeros_like(points)
                moves[nodes] = unit[motion]
                free.append((parity, moves.ravel()))
        return free

    def gap(self, forces: Sequence[Floats], weights: Floats) -> Floats:
        """Moments (n, …) of the gap under forces (2, …) of each pin on the whole body, N, and other loads."""
        opened = self.loaded @ weights + self.bent(forces)
        return np.asarray(self.initial.reshape(-1, *(1,) * (opened.ndim - 1)) + opened)

    def bent(self, forces: Sequence[Floats]) -> Floats:
        """Moments (n, …) of the gap that the supports of elastic pins open, for forces (2, …) of the pins."""
        gap = np.zeros((self.unfolding.size, *(forces[0].shape[1:] if len(forces) else ())))
        for number, (bore, force) in enumerate(zip(self.bores, forces, strict=True)):
            if bore.deflection is None or bore.pin is None:
                continue
            pressed = bore.deflection.pressed(bore.pin, force)
            even, odd = (self._on_cell(number, pressed[parity]) for parity in Parity)
            gap += self.gaps(even, odd) if bore.cut_y else self.gaps(even + odd)
        return gap

    def sums(self, forces: Sequence[Floats], moments: Floats | None = None) -> Floats:
        """Resultants (m, …) along the columns of `rigid` of forces (2, …) of each pin on the whole body, N.

        On a body that may tilt, the pressures have moments (2, …) about x and y, N·mm; none by default.
        """
        axes = 2 if self.unfolding.both_sides or not self.cut_y else 1
        sums = [force[:axes] for force in forces]
        if self.bores and not self.cut_z:
            sums.append(np.zeros_like(forces[0]) if moments is None else moments)
        return np.concatenate(sums) if sums else np.zeros(0)

    def own(self, number: int) -> slice:
        """The unknowns of the cell of one bore, then of one pair of faces, then of one bolt."""
        return slice(self.starts[number], self.starts[number + 1])

    def traction(self, values: Floats) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, k) on each surface of unknowns (n_cell, k) on the cell, MPa."""
        return self._on_surfaces(values, lambda interface, own: interface.traction(own, self.mesh.points))

    def pressure(self, values: Floats) -> dict[Surface, Floats]:
        """Pressure (n_nodes,) on each surface of unknowns (n_cell,) on the cell, MPa; 0 beside it."""
        n_nodes = len(self.mesh.points)
        return self._on_surfaces(values, lambda interface, own: interface.pressure(own, n_nodes))

    def _on_surfaces(
        self, values: Floats, field: Callable[[ContactInterface, Floats], dict[Surface, Floats]]
    ) -> dict[Surface, Floats]:
        fields = dict[Surface, Floats]()
        for number, interface in enumerate(self.interfaces):
            for surface, part in field(interface, values[self.own(number)]).items():
                fields[surface] = fields[surface] + part if surface in fields else part
        return fields


# Motions of the parts whose moments are smaller than this part of the largest are resisted by no interface.
_UNRESISTED = 1e-9


@dataclass(frozen=True)
class CondensedInterface:
    """The condensed problem. The private ones are the terms of `motions`."""

    #: pins, interface: (n_p,), (n_J,) numbers of the unknowns: pressures of the pins; stresses between parts
    #: and bolt forces
    pins: Ints
    interface: Ints
    #: A, B, S: (n_p, n_p), (n_J, n_p), (n_J, n_J) as in the module's description
    A: Floats
    B: Floats
    S: Floats
    #: G, V: (n_p, k), (n_J, k) of the forces (k,) of other loads along the motions of the parts
    G: Floats
    V: Floats
    #: (n_p, m) moments of motions that only the pins resist, and (m, k) their share in the motions of the
    #: parts
    free: tuple[Floats, Floats]
    _back: Floats
    _share: Floats
    _reach: Floats
    _moved: Floats

    @classmethod
    def of(cls, compliance: Floats, parts: Floats, pins: Ints) -> "CondensedInterface":
        """Condense C (n, n) to the pins (n_p,), with moments P (n, k) of the parts' free motions."""
        interface = np.setdiff1d(np.arange(len(compliance)), pins)
        P_p, P_J = parts[pins], parts[interface]
        size = np.abs(parts).max(axis=0, initial=0.0)
        size[size == 0] = 1.0
        _, values, rows = np.linalg.svd(P_J / size, full_matrices=len(interface) < len(size))
        values = np.append(values, np.zeros(len(rows) - len(values)))
        resisted = values > _UNRESISTED * values.max(initial=1e-300)
        share = rows.T / size[:, None]
        kept, pin_held = share[:, resisted], share[:, ~resisted]
        # The transpose is stored by columns, so that LAPACK overwrites it.
        factor = cho_factor(compliance[np.ix_(interface, interface)].T, lower=True, overwrite_a=True)
        C_Jp = compliance[np.ix_(interface, pins)]
        moved = cho_solve(factor, P_J @ kept)
        schur = (P_J @ kept).T @ moved
        inverse = np.linalg.inv((schur + schur.T) / 2)
        V = moved @ inverse
        of_pins = P_p @ kept
        # S C_Jp, of which the product would lose several digits to rigid motions.
        solved = cho_solve(factor, C_Jp)
        stiff = solved - V @ ((P_J @ kept).T @ solved)
        B = stiff + V @ of_pins.T
        reach = C_Jp.T @ moved - of_pins
        A = compliance[np.ix_(pins, pins)] - C_Jp.T @ stiff
        inverted, _ = lapack.dpotri(factor[0], lower=1, overwrite_c=1)
        below = np.tril(inverted - V @ moved.T)
        S = below + below.T
        S[np.diag_indices_from(S)] /= 2
        A += of_pins @ inverse @ of_pins.T - C_Jp.T @ V @ of_pins.T - of_pins @ V.T @ C_Jp
        return cls(
            pins=pins,
            interface=interface,
            A=(A + A.T) / 2,
            B=B,
            S=S,
            G=reach @ inverse @ kept.T,
            V=V @ kept.T,
            free=(P_p @ pin_held, pin_held.T),
            _back=kept @ inverse,
            _share=kept,
            _reach=reach,
            _moved=moved,
        )

    def motions(self, open_gap: Floats, pressure: Floats, forces: Floats, pin_held: Floats) -> Floats:
        """Motions (k,) of the parts from y_J − g_J (n_J,), λ_p (n_p,), f (k,) and motions (m,) of `free`."""
        acting = self._share.T @ forces + self._reach.T @ pressure - self._moved.T @ open_gap
        resisted = self._back @ acting
        return np.asarray(resisted + self.free[1].T @ pin_held)
