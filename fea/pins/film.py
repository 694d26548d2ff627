"""The film at a rod's big end: how its bore yields, and what acts on its journal."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import ElasticBore
from fea.pins.bonded import BondedBore
from fea.pins.model import Structure, inertial_fields
from fea.solid.bore import BoreFacets, bore_facets, radial_forces
from fea.solid.parity import Parity, Split
from fea.solvers.static import Model
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.instants import Instants


@dataclass(frozen=True)
class YieldingBore:
    """The displacement of the big end's bore under pressures on it and all else that acts on the rod."""

    functions: BoreFunctions
    #: (n, n), mm³/N, between weights of the functions, without rigid translations: those are the journal's
    compliance: Floats
    #: (n, 6) weights of the displacement of unit forces of the piston pin along x and y and unit motions
    loaded: Floats

    @classmethod
    def of(cls, structure: Structure) -> "YieldingBore":
        """Solve for unit pressures on the bore, unit forces of the piston pin and unit motions.

        The sum of what acts at an instant balances; each unit alone does not, and is held by the restraints.
        """
        mesh, bores = structure.mesh, structure.bores
        functions, n_nodes = BoreFunctions(bores.big_radius, bores.big_width), len(mesh.points)
        facets = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
        pin = BondedBore.of(bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length), n_nodes)
        even, odd = (
            np.stack([*pressed, force, *motions])
            for pressed, force, motions in zip(
                unit_forces(functions, facets, n_nodes),
                pin.forces,
                inertial_fields(structure.inertia),
                strict=True,
            )
        )
        moments = works(structure.model, facets, even, odd)
        # Of each parity, the last three are the force of the piston pin and the two motions.
        rest = np.concatenate([len(even) - 3 + np.arange(3), len(even) + len(odd) - 3 + np.arange(3)])
        own = np.setdiff1d(np.arange(len(moments)), rest)
        compliance, loaded = moments[np.ix_(own, own)], moments[np.ix_(own, rest[[0, 3, 1, 2, 4, 5]])]
        compliance = (compliance + compliance.T) / 2
        compliance[functions.translations] = loaded[functions.translations] = 0.0
        return cls(functions, compliance, loaded)

    def on(self, grid: FilmGrid) -> ElasticBore:
        """The bore for a film on a grid."""
        return ElasticBore(self.functions.means(grid), self.compliance)

    def caused(self, instants: Instants) -> Floats:
        """Weights (n_instants, n) of the displacement by all but the film: g of `ElasticBore`."""
        return np.concatenate([instants.pin, instants.motions]).T @ self.loaded.T


def unit_forces(functions: BoreFunctions, facets: BoreFacets, n_nodes: int) -> tuple[Floats, Floats]:
    """Nodal forces (n, n_nodes, 3) on the cell of pressures of 1 MPa·mm times each even and odd function."""
    z = facets.corners[..., 2] @ facets.shape_values.T
    even, odd = (
        np.stack([radial_forces(facets, n_nodes, each) for each in pressures])
        for pressures in functions.at(facets.angle, z)
    )
    return even, odd


def works(model: Model, facets: BoreFacets, even: Floats, odd: Floats) -> Floats:
    """Work (n, n) in the whole body of forces of both parities, (n_own, n_nodes, 3), on what they cause.

    There are at least as many even ones as odd ones.
    """
    images = (2 if facets.cut_y else 1) * (2 if facets.cut_z else 1)
    if not facets.cut_y:
        every = np.concatenate([even, odd])
        u = model.solve([Split(forces, None) for forces in every]).displacement[Parity.SYMMETRIC]
        return np.asarray(images * np.tensordot(every, u, axes=2))
    none = np.zeros((len(even) - len(odd), *even.shape[1:]))
    pairs = zip(even, np.concatenate([odd, none]), strict=True)
    u_of = model.solve([Split(*pair) for pair in pairs]).displacement
    of_parities = [
        np.tensordot(own, u_of[parity], axes=2)[:, : len(own)]
        for parity, own in ((Parity.SYMMETRIC, even), (Parity.ANTISYMMETRIC, odd))
    ]
    return np.asarray(images * block_diag(*of_parities))
