"""The relative gradient of the stress amplitude at the surface, by which a notch supports its own surface.

G = −(∂σ_a/∂s)/σ_a along the inward normal, with the amplitude of the signed equivalent stress over the cycle.
None is taken on the bores, where the pins press, nor where stress is singular.
"""

import numpy as np

from fea.analysis.cycle.rows import SpannedRod
from fea.analysis.cycle.screened import superposed
from fea.analysis.cycle.unit_solutions import PartStress
from fea.judge.history import deviatoric, signed_equivalent
from fea.machine.threads import side_by_side
from fea.pins.model import Weights
from fea.solid.surface_gradient import relative_gradient
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Of the degrees of a cycle, one in so many suffices for the ratio of amplitudes.
EVERY = 10
_BLOCK = 500  # nodes evaluated at once


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
        found = np.maximum(found, relative_gradient(TetMesh(mesh.points, tets), facets, amplitude))
    return np.where(rod.masked | rod.regions.on_bores, 0.0, found)


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
