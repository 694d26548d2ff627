"""Nodal forces of a traction on a surface, of a force per volume and of a temperature rise."""

from collections.abc import Callable

import numpy as np

from fea.base.material import Material
from fea.solid.assembly import VOLUME_DEGREE, gauss_blocks, jacobians, tabulate, volume_points
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# From places (n, 3) and unit outward normals (n, 3) to tractions (n, 3), MPa.
Traction = Callable[[Floats, Floats], Floats]

TRACTION_DEGREE = 6


def traction_forces(mesh: TetMesh, surface: Surface, traction: Traction) -> Floats:
    """Nodal forces ∫ N_a t dA, (n_nodes, 3), N, of a traction on a surface."""
    nodes = mesh.facets[surface]
    table = tabulate(nodes.shape[1], TRACTION_DEGREE)
    corners = mesh.points[nodes]
    tangents = jacobians(corners, table.gradients)
    areas = np.cross(tangents[..., 0], tangents[..., 1])
    size = np.linalg.norm(areas, axis=-1, keepdims=True)
    places, normals = (array.reshape(-1, 3) for array in (table.values @ corners, areas / size))
    pulled = traction(places, normals).reshape(areas.shape) * size * table.weights[:, None]
    return scattered(nodes, table.values.T @ pulled, len(mesh.points))


def scattered(nodes: Ints, forces: Floats, n_nodes: int) -> Floats:
    """Sum forces (n_elements, n_local, 3) at the nodes (n_elements, n_local) they act on: (n_nodes, 3)."""
    of_axes = (forces[..., axis].ravel() for axis in range(3))
    return np.stack([np.bincount(nodes.ravel(), each, minlength=n_nodes) for each in of_axes], axis=1)


def nodal_traction(mesh: TetMesh, surface: Surface, traction: Callable[[Floats], Floats]) -> Floats:
    """Traction (n_nodes, 3, 1) on a surface from places (n, 3), else 0, as `fea.solid.recovery` needs."""
    nodes = np.unique(mesh.facets[surface])
    values = np.zeros((len(mesh.points), 3, 1))
    values[nodes, :, 0] = traction(mesh.points[nodes])
    return values


def thermal_modulus(material: Material, expansion: float) -> float:
    """Return β = (3λ + 2μ) α, MPa/K, for an expansion coefficient α in 1/K."""
    return (3 * material.lame_lambda + 2 * material.shear_modulus) * expansion


def thermal_forces(
    mesh: TetMesh, material: Material, expansion: float, temperature: Callable[[Floats], Floats]
) -> Floats:
    """Nodal forces ∫ β ΔT ∇N_a dV, (n_nodes, 3), N, of a temperature rise ΔT (n,) at places (n, 3), K."""
    places, volumes = volume_points(mesh)
    stress = thermal_modulus(material, expansion) * temperature(places.reshape(-1, 3)).reshape(volumes.shape)
    blocks = gauss_blocks(mesh, VOLUME_DEGREE)
    forces = [
        np.einsum("ep,epax->eax", stress[part] * volumes[part], gauss.gradients) for part, gauss in blocks
    ]
    return scattered(mesh.tets, np.concatenate(forces), len(mesh.points))


def body_forces(mesh: TetMesh, field: Callable[[Floats], Floats]) -> Floats:
    """Nodal forces ∫ N_a b dV, (n_nodes, 3), N, of a force per volume b (n, 3) at places (n, 3), N/mm³."""
    places, volumes = volume_points(mesh)
    forces = field(places.reshape(-1, 3)).reshape(places.shape) * volumes[..., None]
    values = tabulate(mesh.tets.shape[1], VOLUME_DEGREE).values
    return scattered(mesh.tets, values.T @ forces, len(mesh.points))
