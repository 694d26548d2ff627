"""Crossland's criterion over a rod.

Every node gets what its factor cannot be below, from a ball that holds its path though it is not the
smallest (`fea.cycle.screened.Reach`); nodes that may be the worst of the rod get the factor itself, by every
degree. So the array is complete, never hopeful, and its least value is the rod's.
"""

from collections.abc import Sequence

import numpy as np

from fea.assess.crossland import crossland_factors
from fea.assess.deviatoric import deviatoric
from fea.cycle.envelope import Envelope
from fea.cycle.spots import Spot, spots
from fea.cycle.unit_loads import Weights
from fea.cycle.unit_solutions import UnitSolutions
from fea.material import Material
from fea.rod.surface_regions import SurfaceRegions
from geometry.arrays import Floats, Mask
from mesh.mirror import MirroredMesh

BLOCK = 64  # places evaluated at a time


def worst_multiaxial(
    found: Envelope,
    units: UnitSolutions,
    weights: Weights,
    whole: MirroredMesh,
    materials: Sequence[Material],
    *,
    counts: Mask,
    regions: SurfaceRegions,
) -> tuple[Spot | None, Floats | None]:
    """Return the place of the smallest Crossland factor, and the factor of every node, or None if unknown.

    They are unknown if no part's endurance limit is known. Nodes are evaluated in the order of their bounds
    until the next bound exceeds the smallest factor found; nodes that do not count (n_nodes,) are left out.
    At an interface the smaller factor of the parts is used. `regions` are those of the whole rod's surface.
    """
    if found.crossland_factor is None:
        return None, None
    factor = found.crossland_factor.copy()
    # An image across z = 0 has the same history.
    image = 2 * whole.source + (whole.sign[:, 1] < 0)
    once = np.flatnonzero(counts & np.isfinite(factor) & (whole.sign[:, 2] > 0))
    order = once[factor[once].argsort()]
    exact = np.full(int(image.max()) + 1, np.nan)
    holds = np.zeros((len(units.parts), int(whole.source.max()) + 1), dtype=bool)
    for part, held in zip(units.parts, holds, strict=True):
        held[part.nodes] = True
    surface = [regions.factors(material) for material in materials]
    worst, best = None, np.inf
    for start in range(0, len(order), BLOCK):
        nodes = order[start : start + BLOCK]
        if factor[nodes[0]] >= best:
            break
        chosen = nodes[factor[nodes] < best]
        numbers, rows = np.nonzero(holds[:, whole.source[chosen]])
        places = list(zip(chosen[rows].tolist(), numbers.tolist(), strict=True))
        for spot in spots(places, units, weights, whole):
            history, skin = deviatoric(spot.stress)[None], float(surface[spot.part][spot.node])
            factors = crossland_factors(history, materials[spot.part], skin)
            if factors is None:
                continue
            exact[image[spot.node]] = np.fmin(exact[image[spot.node]], factors[0])
            if factors[0] < best:
                worst, best = spot, float(factors[0])
    return worst, np.where(np.isnan(exact[image]), factor, exact[image])
