"""The contact of a body with its pins: from the body's stiffness to the pressures under any load."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from scipy import sparse

from fea.contact.active_set import Contact, ContactSystem
from fea.contact.fold import Fold
from fea.contact.interface import PinInBore
from fea.solid.parity import Parity
from geometry.arrays import Floats


class Body(Protocol):
    """What of a body the contact needs."""

    def compliance(self, parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work (k, k) of forces (3 n_nodes, k) of one parity about y = 0 on what they cause."""


class ContactProblem:
    """Pins in the bores of a body.

    Parameters
    ----------
    body
        Gives the work of forces on the cell.
    n_nodes
        Of the cell.
    bores
        With their pins.
    loads
        Per parity (3 n_nodes, n_loads) forces on the cell beside the contact pressures, whose weights
        `solve` is given.
    both_sides
        Whether loads and pressures have both parities about y = 0; the symmetric one alone otherwise.

    Attributes
    ----------
    forces
        (3 n_nodes, n) nodal forces of a pressure of 1 MPa at each vertex of the cell, bore after bore.
    fold
        Leads from these pressures to the unknowns.
    cell_compliance
        Per parity (n_cell, n_cell) moments of the displacements of these pressures.
    compliance, clearance, rigid
        C (n, n), the moments (n,) of the clearance and R (n, m) of `fea.contact.active_set`.
    """

    def __init__(
        self,
        body: Body,
        n_nodes: int,
        bores: Sequence[PinInBore],
        loads: Mapping[Parity, Floats],
        *,
        both_sides: bool,
    ) -> None:
        self.bores = tuple(bores)
        first = self.bores[0]
        images = (2 if first.cut_y else 1) * (2 if first.cut_z else 1)
        on_y = np.concatenate([bore.multipliers.on_y for bore in self.bores])
        self.fold = Fold(on_y, both_sides and first.cut_y, images)
        self.forces = sparse.csr_array(
            sparse.hstack([bore.multipliers.forces(n_nodes) for bore in self.bores])
        )
        self._starts = np.cumsum([0, *(bore.multipliers.size for bore in self.bores)])
        found, loaded = {}, {}
        for parity in self.fold.parities():
            found[parity], loaded[parity] = self._compliance(body, parity, loads[parity])
        self._loads = self.fold.moments(loaded)
        self.cell_compliance, self.compliance = found, self._folded(found)
        self.clearance = self._both([bore.initial() for bore in self.bores])
        self.rigid = self._rigid()
        self.system = ContactSystem(self.compliance, self.rigid)

    def _compliance(self, body: Body, parity: Parity, loads: Floats) -> tuple[Floats, Floats]:
        """Moments on the cell of unit pressures (n_cell, n_cell) and of the other loads (n_cell, n_loads)."""
        n_cell = self.forces.shape[1]
        every = sparse.hstack([self.forces, dense_columns(loads)], format="csc")
        work = body.compliance(parity, every)
        found = (work[:n_cell, :n_cell] + work[:n_cell, :n_cell].T) / 2
        for bore, start, end in zip(self.bores, self._starts, self._starts[1:], strict=False):
            if bore.deflection is not None:
                found[start:end, start:end] += bore.deflection.compliance[parity]
        return found, work[:n_cell, n_cell:]

    def _folded(self, of_cell: Mapping[Parity, Floats]) -> Floats:
        """Compliance (n, n) of the unknowns."""
        unit = self.fold.parts(np.eye(self.fold.size))
        return self.fold.moments({parity: own @ unit[parity] for parity, own in of_cell.items()})

    def _both(self, even: Sequence[Floats], odd: Sequence[Floats] | None = None) -> Floats:
        """Moments (n,) over the whole body of fields with an even and an odd part on the cell."""
        parts = {Parity.SYMMETRIC: np.concatenate(even)}
        if self.fold.both_sides:
            none = np.zeros_like(parts[Parity.SYMMETRIC])
            parts[Parity.ANTISYMMETRIC] = none if odd is None else np.concatenate(odd)
        return self.fold.moments(parts)

    def _rigid(self) -> Floats:
        """Moments (n, m) of the free motions: of each pin along x and y, and of a body that may tilt."""
        columns, none = [], [np.zeros(bore.multipliers.size) for bore in self.bores]
        for number, bore in enumerate(self.bores):
            along_x, along_y = ([*none[:number], shift, *none[number + 1 :]] for shift in bore.shifted())
            columns.append(self._both(along_x))
            if self.fold.both_sides:
                columns.append(self._both(none, along_y))
            elif not bore.cut_y:
                columns.append(self._both(along_y))
        if not self.bores[0].cut_z:
            columns += [
                self._both(turned) for turned in zip(*(bore.tilted() for bore in self.bores), strict=True)
            ]
        return np.stack(columns, axis=1)

    def gap(self, forces: Sequence[Floats], weights: Floats) -> Floats:
        """Moments (n,) of the gap that everything but the pressures leaves.

        Parameters
        ----------
        forces
            (2,) of each pin on the whole body, N.
        weights
            (n_loads,) of the other loads.
        """
        found = self.clearance + self._loads @ weights
        for number, (bore, force) in enumerate(zip(self.bores, forces, strict=True)):
            if bore.deflection is None or bore.pin is None:
                continue
            even, odd = ([np.zeros(other.multipliers.size) for other in self.bores] for _ in Parity)
            pressed = bore.deflection.pressed(bore.pin, force)
            if bore.cut_y:
                even[number], odd[number] = pressed[Parity.SYMMETRIC], pressed[Parity.ANTISYMMETRIC]
            else:
                even[number] = pressed[Parity.SYMMETRIC] + pressed[Parity.ANTISYMMETRIC]
            found = found + self._both(even, odd)
        return found

    def solve(self, forces: Sequence[Floats], weights: Floats, moments: Floats | None = None) -> Contact:
        """Pressures under a load.

        Parameters
        ----------
        forces, weights
            As for `gap`.
        moments
            (2,) about x and y that the pressures must have on a body that may tilt, N·mm; none by default.

        Raises
        ------
        ContactError
            No pressure on a bore has the force of its pin.
        """
        axes = 2 if self.fold.both_sides or not self.bores[0].cut_y else 1
        sums = [force[:axes] for force in forces]
        if not self.bores[0].cut_z:
            sums.append(np.zeros(2) if moments is None else moments)
        return self.system.solve(self.gap(forces, weights), np.concatenate(sums))

    def of_bore(self, number: int, of_cell: Floats) -> Floats:
        """Rows of one bore of pressures (n_cell, …) on the cell."""
        return of_cell[self._starts[number] : self._starts[number + 1]]


def dense_columns(loads: Floats) -> sparse.csc_array:
    """Columns (n, k) with all their zeros, so that those of both parities have the same sparsity."""
    rows, count = loads.shape
    indices = np.tile(np.arange(rows, dtype=np.int32), count)
    starts = rows * np.arange(count + 1, dtype=np.int32)
    return sparse.csc_array((loads.T.ravel(), indices, starts), shape=loads.shape)
