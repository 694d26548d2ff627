"""The worst place of a rod by Crossland's criterion."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fea.assess.crossland import crossland_bound, crossland_factors
from fea.assess.deviatoric import deviatoric
from fea.cycle.envelope import Envelope
from fea.cycle.spots import Spot, spots
from fea.cycle.unit_solutions import UnitSolutions, Weights
from fea.material import Material
from mesh.mirror import MirroredMesh

Floats = npt.NDArray[np.float64]

BLOCK = 64  # places worked out at a time


def worst_multiaxial(
    found: Envelope,
    units: UnitSolutions,
    weights: Weights,
    whole: MirroredMesh,
    materials: Sequence[Material],
) -> Spot | None:
    """Return the place of the least factor by Crossland; None where no part's endurance is known.

    Every node is considered: in the order of what its factor cannot be below (`crossland_bound`), until
    that exceeds the least factor found. Where parts meet, the node is of the one nearer to yielding.
    """
    least = _bounds(found, materials)
    # An image across z = 0 has the same history.
    once = np.flatnonzero(np.isfinite(least) & (whole.sign[:, 2] > 0))
    order = once[least[once].argsort()]
    worst, best = None, np.inf
    for start in range(0, len(order), BLOCK):
        nodes = order[start : start + BLOCK]
        if least[nodes[0]] >= best:
            break
        for spot in spots(nodes[least[nodes] < best].tolist(), units, weights, whole, found):
            factors = crossland_factors(deviatoric(spot.stress)[None], materials[int(found.part[spot.node])])
            if factors is not None and factors[0] < best:
                worst, best = spot, float(factors[0])
    return worst


def _bounds(found: Envelope, materials: Sequence[Material]) -> Floats:
    """Bound (n_nodes,) of the factors; infinite where the endurance is not known."""
    bounds = np.full(len(found.von_mises), np.inf)
    for number, material in enumerate(materials):
        own = found.part == number
        least = crossland_bound(found.von_mises[own], found.principal_1[own], material)
        if least is not None:
            bounds[own] = least
    return bounds
