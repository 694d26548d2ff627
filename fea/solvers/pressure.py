"""The pressure field of Taylor–Hood elements: linear in each element, continuous within each part.

Pressure is positive in tension here: σ = 2 μ ε + p I, with p = λ ∇·u on average over the elements of a
vertex.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fea.base.material import Material
from fea.solid.element import gauss_blocks, gauss_places, shape_functions, stiffness_degree
from geometry.arrays import Floats, Ints
from mesh.tetmesh import EDGES, TetMesh

VERTICES = 4


@dataclass(frozen=True)
class PressureSpace:
    """The unknowns of the pressure and their matrices.

    Attributes
    ----------
    parts
        Numbers of the parts that have a pressure.
    tets
        Per such part (n_elements, 10) the nodes of its elements.
    vertex
        Per such part (n,) the node of the mesh that each of its unknowns belongs to; the unknowns of the
        parts are numbered consecutively.
    divergence
        D (n_unknowns, 3 n_nodes): ∫ q ∇·u dV = qᵀ D u, mm².
    mass
        M (n_unknowns, n_unknowns): ∫ q p dV = qᵀ M p, mm³; different parts are not coupled.
    lame_lambda, shear_modulus
        (n_unknowns,) λ and μ of the unknown's part, MPa.
    """

    parts: tuple[int, ...]
    tets: tuple[Ints, ...]
    vertex: tuple[Ints, ...]
    divergence: sparse.csr_array
    mass: sparse.csr_array
    lame_lambda: Floats
    shear_modulus: Floats

    def compressed(self, pressure: Floats) -> Floats:
        """∫ q p / λ dV, (n_unknowns, n_cases), mm³, of pressures (n_unknowns, n_cases)."""
        return np.asarray((self.mass @ pressure) / self.lame_lambda[:, None])

    def nodal(self, pressure: Floats, n_points: int) -> dict[int, Floats]:
        """Pressure (n_points, n_cases) of each part that has one, from unknowns (n_unknowns, n_cases), MPa.

        At mid-edge nodes it is the mean of the ends; at nodes outside the part it is zero.
        """
        bounds = np.cumsum([nodes.size for nodes in self.vertex])[:-1]
        fields = {}
        for number, tets, nodes, values in zip(
            self.parts, self.tets, self.vertex, np.split(pressure, bounds), strict=True
        ):
            field = np.zeros((n_points, pressure.shape[1]))
            field[nodes] = values
            for middle, (a, b) in enumerate(EDGES, start=VERTICES):
                field[tets[:, middle]] = (field[tets[:, a]] + field[tets[:, b]]) / 2
            fields[number] = field
        return fields


def pressure_space(mesh: TetMesh, materials: dict[int, Material]) -> PressureSpace:
    """Number and integrate the pressure of some parts of a mesh of second order.

    Parameters
    ----------
    mesh
        The mesh.
    materials
        By the number of each part that gets a pressure.
    """
    part = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
    parts = tuple(materials)
    elements = [np.flatnonzero(part == number) for number in parts]
    tets = tuple(mesh.tets[own] for own in elements)
    vertex = tuple(np.unique(own[:, :VERTICES]) for own in tets)
    sizes = [nodes.size for nodes in vertex]
    unknowns = np.concatenate(
        [
            first + np.searchsorted(nodes, own[:, :VERTICES])
            for first, nodes, own in zip(np.r_[0, np.cumsum(sizes)], vertex, tets, strict=False)
        ]
    )
    soft = TetMesh(mesh.points, np.concatenate(tets))
    divergence, mass = _matrices(soft, unknowns, sum(sizes))
    constants = [(m.lame_lambda, m.shear_modulus) for m in materials.values()]
    lam, mu = np.repeat(np.array(constants), sizes, axis=0).T
    return PressureSpace(
        parts=parts,
        tets=tets,
        vertex=vertex,
        divergence=divergence,
        mass=mass,
        lame_lambda=lam,
        shear_modulus=mu,
    )


def _matrices(mesh: TetMesh, unknowns: Ints, size: int) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Divergence and mass matrices of elements with `unknowns` (n_elements, 4)."""
    n_elements, n_nodes = mesh.tets.shape
    degree = stiffness_degree(n_nodes)
    values, _ = shape_functions(VERTICES, gauss_places(n_nodes).T)
    squares = values[:, :, None] * values[:, None, :]
    divergence = np.empty((n_elements, VERTICES, 3 * n_nodes))
    mass = np.empty((n_elements, VERTICES, VERTICES))
    for block, gauss in gauss_blocks(mesh, degree):
        weighted = (gauss.gradients * gauss.volumes[:, :, None, None]).reshape(-1, len(values), 3 * n_nodes)
        divergence[block] = values.T @ weighted
        mass[block] = np.tensordot(gauss.volumes, squares, axes=1)
    columns = (3 * mesh.tets[:, :, None] + np.arange(3)).reshape(n_elements, -1)
    return (
        _summed(divergence, unknowns, columns, (size, 3 * len(mesh.points))),
        _summed(mass, unknowns, unknowns, (size, size)),
    )


def _summed(values: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> sparse.csr_array:
    row = np.broadcast_to(rows[:, :, None], values.shape).ravel()
    column = np.broadcast_to(columns[:, None, :], values.shape).ravel()
    return sparse.csr_array(sparse.coo_array((values.ravel(), (row, column)), shape=shape))
