"""J2 flow without hardening at the Gauss points of the elements that may flow.

Yield condition of von Mises, associated flow rule, backward Euler by the radial return (Simo & Hughes 1998,
Computational Inelasticity, section 3.3). Flow keeps the volume, which second-order tetrahedra with four
Gauss points cannot do at every point (Nagtegaal, Parks & Rice 1974): loads would rise beyond the limit load,
and the mean stress would alternate from point to point. The volumetric strain is therefore projected to a
field that is linear in each element and continuous (Taylor & Hood 1973). Its mean over each element would do,
too, but has a much larger error in a sphere. All of the strain is projected: if that of the elastic solution
were not, its rest, which grows with the load and which no flow can balance, would let a body collapse early.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fea.base.material import Material, Materials
from fea.solid.assembly import COMPONENTS, gauss_block, stiffness_degree, tabulate
from fea.solid.stress import matrices, von_mises
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Of symmetric tensors (…, 6): products with this weight are double contractions.
_TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])


@dataclass(frozen=True)
class Zone:
    """Elements that may flow, with their Gauss points.

    Of a cell that is cut at y = 0, each half of the body has elements of its own. Both stand on the cell: the
    fields of the second half are mirrored to it.
    """

    nodes: Ints  #: (n_nodes,) nodes of the cell that the elements have
    half: Ints  #: (n_elements,) 0, or 1 for elements of the second half
    element: Ints  #: (n_elements,) of the cell
    corners: Ints  #: (n_elements, n_local) their nodes, as places in `nodes`
    vertices: Ints  #: (n_elements, 4) their vertices, numbered in both halves; those at y = 0 are of both
    gradients: Floats  #: (n_elements, 3 n_points, n_local) of the shape functions, by point and axis, 1/mm
    volumes: Floats  #: (n_elements, n_points), mm³
    #: shear, bulk, strength: (n_elements, 1) moduli μ and κ and the yield strength, MPa
    shear: Floats
    bulk: Floats
    strength: Floats

    @classmethod
    def of(
        cls, mesh: TetMesh, material: Material | Materials, half: Ints, element: Ints, strength: Floats
    ) -> "Zone":
        """Prepare elements (n,) of halves (n,) with their yield strength (n,), MPa."""
        tets = mesh.tets[element]
        nodes, corners = np.unique(tets, return_inverse=True)
        n_local = tets.shape[1]
        gauss = gauss_block(mesh.points[tets], tabulate(n_local, stiffness_degree(n_local)))
        constants = material.of(slice(None))
        lam, mu = (
            np.broadcast_to(value, len(mesh.tets))[element, None]
            for value in (constants.lame_lambda, constants.shear_modulus)
        )
        corners = corners.reshape(tets.shape)
        other = (half[:, None] > 0) & ~np.isin(tets[:, :4], mesh.facets.get(Surface.SYMMETRY_Y, ()))
        vertices = np.unique(tets[:, :4] + other * len(mesh.points), return_inverse=True)[1].reshape(-1, 4)
        gradients = np.ascontiguousarray(gauss.gradients.swapaxes(2, 3).reshape(len(tets), -1, n_local))
        bulk = lam + 2 * mu / 3
        volumes = gauss.volumes
        return cls(nodes, half, element, corners, vertices, gradients, volumes, mu, bulk, strength[:, None])

    @property
    def virgin(self) -> Floats:
        """Plastic strain (n_elements, n_points, 6) before anything has flowed."""
        return np.zeros((*self.volumes.shape, 6))

    def strain(self, u: Floats) -> tuple[Floats, Floats]:
        """Deviatoric strain (n_elements, n_points, 6) and volumetric strain (n_elements, n_points).

        Of displacements (n_halves, n_nodes, 3), mm.
        """
        slope = (self._slopes @ u.reshape(-1, 3)[: self._slopes.shape[1]]).reshape(*self.volumes.shape, 3, 3)
        strain = np.stack([(slope[..., i, j] + slope[..., j, i]) / 2 for i, j in COMPONENTS], axis=-1)
        volumetric = strain[..., :3].sum(axis=-1)
        strain[..., :3] -= volumetric[..., None] / 3
        return strain, volumetric

    def smooth(self, field: Floats) -> Floats:
        """Project a field (n_elements, n_points) to one that is linear in elements and continuous."""
        values, solve = self._linear
        return np.asarray((values @ solve(values.T @ (field * self.volumes).ravel())).reshape(field.shape))

    @cached_property
    def _linear(self) -> tuple[sparse.csr_array, Callable[[Floats], Floats]]:
        """Values of linear fields at all Gauss points, and the solver of their mass matrix."""
        shape = tabulate(4, stiffness_degree(self.corners.shape[1])).values
        columns = np.repeat(self.vertices[:, None], len(shape), axis=1).ravel()
        rows = np.repeat(np.arange(self.volumes.size), 4)
        entries = np.tile(shape.ravel(), len(self.vertices))
        values = sparse.csr_array(sparse.coo_array((entries, (rows, columns))))
        mass = values.T @ sparse.diags_array(self.volumes.ravel()) @ values
        return values, splu(sparse.csc_array(mass)).solve

    def stress(self, elastic: Floats, moved: Floats, plastic: Floats) -> Floats:
        """Stress (n_elements, n_points, 6), MPa.

        Of the displacement of the elastic body under its loads, and of that which plastic strain adds to it,
        both (n_halves, n_nodes, 3).
        """
        deviatoric, volumetric = self.strain(elastic + moved)
        stress = 2 * self.shear[..., None] * (deviatoric - plastic)
        stress[..., :3] += (self.bulk * self.smooth(volumetric))[..., None]
        return stress

    def trial(self, u: Floats, plastic: Floats) -> Floats:
        """Deviatoric stress (n_elements, n_points, 6), MPa, of all displacement and plastic strain."""
        return np.asarray(2 * self.shear[..., None] * (self.strain(u)[0] - plastic))

    def usage(self, u: Floats, plastic: Floats) -> Floats:
        """Von Mises stress over yield strength (n_elements, n_points)."""
        return self.used(self.trial(u, plastic))

    def used(self, deviatoric: Floats) -> Floats:
        """Von Mises stress (n_elements, n_points) of a deviatoric stress, over yield strength."""
        return von_mises(deviatoric) / self.strength

    def returned(self, deviatoric: Floats, plastic: Floats) -> Floats:
        """Plastic strain after the radial return at a deviatoric strain, from that before."""
        trial = 2 * self.shear[..., None] * (deviatoric - plastic)
        beyond = 1 - self.strength / np.maximum(von_mises(trial), self.strength)
        return np.asarray(plastic + beyond[..., None] * trial / (2 * self.shear[..., None]))

    def initial_forces(self, volumetric: Floats, plastic: Floats, n_halves: int) -> Floats:
        """Forces (n_halves, n_nodes, 3), N, that act on the elastic body like the plastic strain.

        They contain what the projection of the volumetric strain takes away.
        """
        initial = 2 * self.shear[..., None] * plastic
        initial[..., :3] += (self.bulk * (volumetric - self.smooth(volumetric)))[..., None]
        return self.forces(initial, n_halves)

    def forces(self, stress: Floats, n_halves: int) -> Floats:
        """Nodal forces (n_halves, n_nodes, 3), N, of a stress (n_elements, n_points, 6): ∫ ∇N · σ dV."""
        tensor = matrices(stress * self.volumes[..., None]).reshape(-1, 3)
        found = np.zeros((n_halves * len(self.nodes), 3))
        found[: self._slopes.shape[1]] = self._slopes.T @ tensor
        return found.reshape(n_halves, -1, 3)

    @cached_property
    def _slopes(self) -> sparse.csr_array:
        """Gradients, by element, point and axis, of fields that are given at the nodes, half by half."""
        place = self.half[:, None, None] * len(self.nodes) + self.corners[:, None]
        columns = np.broadcast_to(place, self.gradients.shape).ravel()
        starts = np.arange(0, columns.size + 1, self.corners.shape[1])
        width = (1 + self.half.max(initial=0)) * len(self.nodes)
        return sparse.csr_array((self.gradients.ravel(), columns, starts), shape=(len(starts) - 1, width))

    def dissipation(self, stress: Floats, flow: Floats) -> float:
        """Work, mJ, of a stress on an increment of plastic strain, both (n_elements, n_points, 6)."""
        return float(((stress * flow * _TWICE).sum(axis=-1) * self.volumes).sum())


def equivalent_strain(plastic: Floats) -> Floats:
    """Equivalent plastic strain √(2/3 ε:ε) (…,) of plastic strain (…, 6)."""
    return np.asarray(np.sqrt(2 / 3 * (plastic**2 * _TWICE).sum(axis=-1)))
