"""Contact of a rod with its two pins: from a load case to pressures and nodal forces."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from fea.contact.interfaces import BoltPull, MatingFaces, PinInBore
from fea.contact.multipliers import Multipliers, radial
from fea.contact.problem import ContactProblem
from fea.contact.touch import Touch
from fea.machine.threads import one_blas_thread
from fea.pins.case_forces import CaseForces
from fea.pins.fits import Fits
from fea.rod.meshed_rod import Bores
from fea.solid.inertia import EVEN_MOTIONS, ODD_MOTIONS, Inertia
from fea.solid.parity import Parity, Split
from fea.solid.tilt import resultants
from fea.solvers.static import Model
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.instants import Instants

_MOTIONS = (*EVEN_MOTIONS, *ODD_MOTIONS)


class Solved(Protocol):
    """A solution of the contact problem."""

    @property
    def values(self) -> Floats:
        """λ (n,) of all unknowns of `ContactProblem`."""

    @property
    def residual(self) -> float:
        """Largest violation of the laws of contact, relative to what it is the difference of."""

    @property
    def imbalance(self) -> float:
        """Largest error of the resultants, relative to them."""

    @property
    def changes(self) -> int:
        """How many contact areas or states were tried."""


class RodContact:
    """The contact problem of a meshed rod, whose compliance is computed once.

    Parameters
    ----------
    model
        The stiffness of the cell.
    bores
        Dimensions of the bores.
    inertia
        Of the same mesh.
    fits
        The pins.
    faces, bolts
        Where separate parts of the rod touch, and what holds them together (`fea.pins.assembled_rod`).
    """

    def __init__(
        self,
        model: Model,
        bores: Bores,
        inertia: Inertia,
        fits: Fits,
        *,
        faces: Sequence[MatingFaces] = (),
        bolts: Sequence[BoltPull] = (),
    ) -> None:
        mesh = model.mesh
        cut_y, cut_z = Surface.SYMMETRY_Y in mesh.facets, Surface.SYMMETRY_Z in mesh.facets
        self._n_nodes, self._points, self._inertia = len(mesh.points), mesh.points, inertia
        pins = []
        for surface, x, clearance, pin, relief in (
            (Surface.SMALL_END_BORE, bores.rod_length, fits.small_clearance, fits.piston_pin, fits.relief),
            (Surface.BIG_END_BORE, 0.0, fits.big_clearance, fits.crank_pin, None),
        ):
            multipliers = Multipliers.of(mesh, surface, radial(x))
            z = multipliers.places[..., 2]
            middle = 0.0 if cut_z else float(z.min() + z.max()) / 2
            pins.append(PinInBore(multipliers, (x, middle), clearance, pin, cut_y, cut_z, relief))
        unit = [inertia.forces(motion) for motion in _MOTIONS]
        parities = tuple(Parity) if cut_y else (Parity.SYMMETRIC,)
        loads = {
            parity: np.stack([forces.part(parity).ravel() for forces in unit], axis=1) for parity in parities
        }
        # Moments about x and y of the unit motions, on a rod that may tilt.
        self._tilting = (
            None
            if cut_z
            else np.stack([resultants(mesh.points, forces.symmetric)[3:5] for forces in unit], axis=1)
        )
        self.problem = ContactProblem(model, mesh, pins, loads, both_sides=True, faces=faces, bolts=bolts)
        # Place and bore of each unknown.
        nodes = np.concatenate([bore.multipliers.nodes for bore in pins])
        owner = np.repeat(np.arange(len(pins)), [bore.multipliers.size for bore in pins])
        unfolding, cells = self.problem.unfolding, np.arange(len(nodes))
        off = ~unfolding.on_y[cells] if unfolding.both_sides else np.zeros(len(nodes), dtype=bool)
        self._pins = unfolding.with_images(cells)
        images = mesh.points[nodes[off]] * [1.0, -1.0, 1.0]
        self._vertices = np.concatenate([mesh.points[nodes], images])
        self._owner = np.concatenate([owner, owner[off]])

    def solutions(self, instants: Instants) -> Sequence[Solved]:
        """Solve instants one after another.

        Raises
        ------
        ContactError
            No pressure on a bore has the force of its pin.
        """
        with one_blas_thread():
            return [self._solved(*instant) for instant in acting(instants)]

    def _solved(self, pin: Floats, crank: Floats, motion: Floats) -> Solved:
        return self.problem.solve((pin, crank), motion, self._tilted(motion))

    def _tilted(self, motion: Floats) -> Floats | None:
        """Moments (2,) that the pins must have on a rod that may tilt."""
        return None if self._tilting is None else -self._tilting @ motion

    def __call__(self, case: Instants) -> CaseForces:
        """Nodal forces of everything that acts in a case.

        Raises
        ------
        ContactError
            No state of contact carries the load: no pressure on a bore has the force of its pin, or separate
            parts come apart.
        """
        with one_blas_thread():
            found = self._solved(case.pin, case.crank, case.motions)
        return self._forces(case, found)

    def _forces(self, case: Instants, found: Solved) -> CaseForces:
        """Nodal forces of a solution and of the inertia of its case."""
        parts = self.problem.unfolding.parts(found.values)
        forces = {parity: (self.problem.forces @ own).reshape(-1, 3) for parity, own in parts.items()}
        if case.motions.any():
            inertial = self._inertia.forces(case)
            forces = {parity: own + inertial.part(parity) for parity, own in forces.items()}
        traction = {parity: self.traction(own[:, None]) for parity, own in parts.items()}
        odd = Parity.ANTISYMMETRIC
        return CaseForces(
            forces=Split(forces[Parity.SYMMETRIC], forces.get(odd)),
            traction={
                surface: Split(even[..., 0], traction[odd][surface][..., 0] if odd in traction else None)
                for surface, even in traction[Parity.SYMMETRIC].items()
            },
            scale=1.0,
            largest=float(case.largest_force),
            touch=self.touch(found.values),
            checks={"contact_gap": found.residual, "contact_balance": found.imbalance},
        )

    def touch(self, values: Floats) -> dict[Surface, Touch]:
        """Contact of each pin with its bore under the values (n,) of the unknowns."""
        pressure = values[self._pins]
        x, y, z = self._vertices.T
        found = {}
        for number, bore in enumerate(self.problem.bores):
            own = self._owner == number
            angle = np.arctan2(y[own], x[own] - bore.center[0])
            found[bore.multipliers.surface] = Touch.of(pressure[own], angle, z[own])
        return found

    def traction(self, pressure: Floats) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, k) on each surface of unknowns (n_cell, k) on the cell, MPa."""
        found: dict[Surface, Floats] = {}
        for number, bore in enumerate(self.problem.bores):
            own = bore.multipliers
            nodes, values = own.at_nodes(pressure[self.problem.own(number)])
            traction = np.zeros((self._n_nodes, 3, pressure.shape[1]))
            traction[nodes] = values[:, None] * own.direction(self._points[nodes])[..., None]
            found[own.surface] = traction
        first = len(self.problem.bores)
        for number, faces in enumerate(self.problem.faces):
            found |= faces.traction(pressure[self.problem.own(first + number)], self._points)
        for number, bolt in enumerate(self.problem.bolts, first + len(self.problem.faces)):
            for surface, unit in bolt.traction.items():
                own_share = unit[..., None] * pressure[self.problem.own(number)]
                found[surface] = found.get(surface, 0.0) + own_share
        return found


Acting = tuple[Floats, Floats, Floats]


def acting(instants: Instants) -> Iterator[Acting]:
    """Yield the forces (2,) at pin and crank and the weights (4,) of the motion of each instant."""
    return zip(instants.pin.T, instants.crank.T, instants.motions.T, strict=True)


def key(*acting: Floats) -> bytes:
    """What tells whether the same acts."""
    return b"".join(own.tobytes() for own in acting)
