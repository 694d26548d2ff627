"""The relative gradient of the stress amplitude at the surface, by which a notch supports its own surface.

G = −(∂σ_a/∂s)/σ_a along the inward normal, with the amplitude of the signed equivalent stress over the cycle.
None is taken on the bores, where the pins press, nor where stress is singular.
"""

import numpy as np

from fea.analysis.cycle.rows import SpannedRod
from fea.analysis.cycle.screened import superposed
from fea.analysis.cycle.unit_solutions import PartStress
from fea.base.choices import Region
from fea.judge.history import deviatoric, signed_equivalent
from fea.machine.threads import side_by_side
from fea.pins.model import Weights
from fea.solid.assembly import blocks, reference_nodes
from fea.solid.recovery import ElementStress
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.creases import SurfaceMesh
from mesh.tetmesh import TetMesh


def inward_derivative(mesh: TetMesh, facets: Ints, values: Floats) -> Floats:
    """Derivative (n_nodes, k), per mm, of nodal values (n_nodes, k) along the inward normal of `facets`.

    At a node it is the mean of those in the elements there, whose interpolation is differentiated; 0 at nodes
    that are not on the facets.
    """
    flat, normal = SurfaceMesh(mesh.points, facets[:, :3]), np.zeros_like(mesh.points)
    for corner in facets.T:
        np.add.at(normal, corner, flat.vectors)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    near = mesh.tets[(normal != 0).any(axis=1)[mesh.tets].any(axis=1)]
    places, total = reference_nodes(mesh.tets.shape[1]), np.zeros((len(mesh.points), values.shape[1]))
    for some in blocks(len(near)):
        tets = near[some]
        slopes = ElementStress(TetMesh(mesh.points, tets), places).slopes()  # (e, place, 3, node)
        gradient = slopes @ values[tets][:, None]
        np.add.at(total, tets, -np.einsum("epik,epi->epk", gradient, normal[tets]))
    count = np.bincount(near.ravel(), minlength=len(total))
    return np.asarray(total / np.maximum(count, 1)[:, None])


# Of the degrees of a cycle, one in so many suffices for the ratio of amplitudes.
EVERY = 10
_BLOCK = 500  # nodes evaluated at once
_TINY = 1e-12


def relative_gradients(rod: SpannedRod, weights: Weights) -> Floats:
    """G (n_nodes,) of the cell, 1/mm, of a cycle of instants; the smaller one of a node and its image.

    It is 0 where stress does not decrease inwards, inside the solid, and where no support is taken.
    """
    mesh, found = rod.mesh.cell, np.zeros(len(rod.mesh.cell.points))
    free = mesh.facets.get(Surface.FREE)
    if free is None:
        return found
    for number, part in enumerate(rod.units.parts):
        tets = mesh.tets if mesh.part is None else mesh.tets[mesh.part == number]
        own = np.zeros(len(mesh.points), dtype=bool)
        own[part.nodes] = True
        amplitude = np.zeros((len(mesh.points), len(rod.units.sides)))
        amplitude[part.nodes] = _amplitudes(part, rod.units.sides, weights)
        facets = free[own[free].all(axis=1)]
        inward = inward_derivative(TetMesh(mesh.points, tets), facets, amplitude)
        found = np.maximum(found, (-inward / np.maximum(amplitude, _TINY)).min(axis=1))
    found[rod.masked | rod.regions.touched[:, list(Region).index(Region.BORES)]] = 0.0
    return found


def _amplitudes(part: PartStress, sides: tuple[int, ...], weights: Weights) -> Floats:
    """Amplitudes (n, n_sides), MPa, of the nodes of a part and of their images."""

    def block(start: int) -> Floats:
        even, odd = (
            unit[start : start + _BLOCK, :, : len(weight)]
            for unit, weight in zip((part.even, part.odd), weights, strict=True)
        )
        stress = superposed(even, odd, sides, weights)
        signed = signed_equivalent(deviatoric(np.asarray(stress, np.float64)))
        return np.asarray(np.ptp(signed, axis=1) / 2).reshape(len(sides), -1).T

    return np.concatenate(list(side_by_side(block, range(0, len(part.nodes), _BLOCK))))
