"""Stress over a cycle where parts touch: tension along the surface, and Crossland's criterion below it.

At the surface, the stress of contact changes within an element. Below it the criterion has the mean over the
elements that hold a place, which a finer mesh makes a smaller volume.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from fea.analysis.cycle.rows import SpannedRod
from fea.analysis.cycle.screened import product
from fea.judge.fatigue import crossland_factors
from fea.judge.history import deviatoric
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import TetMesh

_ALONG_Z = np.array([0.0, 0.0, 1.0])
# Mean of a field of a straight element over its volume, from its values at the nodes.
_MEAN = {4: np.full(4, 1 / 4), 10: np.repeat([-1 / 20, 1 / 5], [4, 6])}


@dataclass(frozen=True)
class RubbedStress:
    """Stress at k places of the surface and n instants."""

    part: Ints  #: (k,) number of the part
    tension: Floats  #: (k, n) largest normal stress along the surface, MPa
    factor: Floats  #: (k,) by Crossland's criterion below it; NaN where it was not asked for or is not known
    radius: Floats  #: (k,) of the half ball over whose volume that is averaged, mm


class TouchingPlaces(NamedTuple):
    """Places where parts touch."""

    nodes: Ints  #: (k,) of the cell
    image: Mask  #: (k,) which are their images across y = 0
    normal: Floats  #: (k, 3) of the surface at the nodes, square to z


def surface_stress(rod: SpannedRod, weights: Weights, places: TouchingPlaces, judged: Mask) -> RubbedStress:
    """Return the stress at places; `judged` (k,): where the criterion is evaluated."""
    nodes, image, normal = places
    mesh, (k, n) = rod.mesh.cell, (len(nodes), weights.even.shape[1])
    owner = np.zeros(len(mesh.points), dtype=np.int64)
    owner[mesh.tets] = 0 if mesh.part is None else mesh.part[:, None]
    part, across = owner[nodes], np.cross(_ALONG_Z, normal)
    tension, factor, radius = np.zeros((k, n)), np.full(k, np.nan), np.zeros(k)
    for number, own in enumerate(rod.units.parts):
        rows = np.flatnonzero(part == number)
        if not rows.size:
            continue
        tets = mesh.tets if mesh.part is None else mesh.tets[mesh.part == number]
        unique, at = np.unique(nodes[rows], return_inverse=True)
        side = np.where(image[rows], -1.0, 1.0)[:, None, None]
        mean, radii = _averaging(mesh, tets, unique)
        surface = rod.regions.without_support().at(unique).factors(rod.materials[number])
        radius[rows] = radii[at]
        units = [unit[..., : len(w)] for unit, w in zip((own.even, own.odd), weights, strict=True)]
        here = [
            product(unit[np.searchsorted(own.nodes, unique)], w)
            for unit, w in zip(units, weights, strict=True)
        ]
        tension[rows] = _along(here[0][at] + side * here[1][at], across[rows])
        wanted = np.flatnonzero(judged[rows])
        below = [
            product((mean[:, own.nodes] @ unit.reshape(len(unit), -1)).reshape(len(unique), 6, -1), w)
            for unit, w in zip(units, weights, strict=True)
        ]
        history = below[0][at[wanted]] + side[wanted] * below[1][at[wanted]]
        found = crossland_factors(deviatoric(history), rod.materials[number], surface[at[wanted]])
        if found is not None:
            factor[rows[wanted]] = found
    return RubbedStress(part, tension, factor, radius)


def _along(stress: Floats, across: Floats) -> Floats:
    """Largest normal stress (k, n) in planes of z and directions (k, 3) across it, of stress (k, 6, n)."""
    x, y, _ = across.T[..., None]
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, 1, 0)
    around, shear = x * x * xx + y * y * yy + 2 * x * y * xy, x * xz + y * yz
    return np.asarray((around + zz) / 2 + np.hypot((around - zz) / 2, shear))


def _averaging(mesh: TetMesh, tets: Ints, nodes: Ints) -> tuple[sparse.csr_array, Floats]:
    """Matrix (k, n_nodes) of means over the elements that hold nodes, and radii (k,) of their half balls."""
    corners = mesh.points[tets[:, :4]]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    element = np.arange(len(tets)).repeat(tets.shape[1])
    shape = (len(tets), len(mesh.points))
    holds = sparse.csr_array((volume[element], (element, tets.ravel())), shape=shape)[:, nodes].T.tocsr()
    mean = sparse.csr_array((np.tile(_MEAN[tets.shape[1]], len(tets)), (element, tets.ravel())), shape=shape)
    total = holds.sum(axis=1)
    copies = 2 ** sum(np.isin(nodes, mesh.facets[plane]).astype(int) for plane in mesh.planes)
    averaging = sparse.csr_array(sparse.diags_array(1 / total) @ holds @ mean)
    return averaging, np.cbrt(3 * copies * total / (2 * np.pi))
