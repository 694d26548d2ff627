"""The worst places of a rod, each with its stress over the cycle."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fea.judge.history import signed_equivalent, tensor
from fea.pins.model import Weights
from fea.run.cycle.unit_solutions import UnitSolutions
from geometry.arrays import Floats
from mesh.mirror import MirroredMesh

COUNT = 5
# Places closer to each other than this fraction of the rod's length count as one.
APART = 0.1


@dataclass(frozen=True)
class Spot:
    """One of the worst places."""

    # node, part: node on the whole rod; number of the part that the stress belongs to
    node: int
    part: int
    place: Floats  # (3,) mm
    stress: Floats  # (6, n_instants), MPa, components XX YY ZZ XY YZ XZ
    signed: Floats  # (n_instants,) signed von Mises stress, MPa


def distinct(points: Floats, factor: Floats, length: float) -> list[int]:
    """Nodes of the smallest factors that are not close to each other, at most `COUNT`.

    `points` (n_nodes, 3), mm; images across z = 0 count as one place; `factor` (n_nodes,); `length`: of the
    rod, mm.
    """
    folded = np.abs(points * [0, 0, 1]) + points * [1, 1, 0]
    open_ = points[:, 2] >= -1e-9 * length
    chosen: list[int] = []
    while len(chosen) < COUNT and open_.any():
        node = int(np.where(open_, factor, np.inf).argmin())
        chosen.append(node)
        open_ &= np.linalg.norm(folded - folded[node], axis=1) > APART * length
    return chosen


def spots(
    places: Iterable[tuple[int, int]], units: UnitSolutions, weights: Weights, whole: MirroredMesh
) -> tuple[Spot, ...]:
    """Return the histories of some nodes of the whole rod, each given with the number of its part."""
    return tuple(_spot(node, units, weights, whole, part) for node, part in places)


def _spot(node: int, units: UnitSolutions, weights: Weights, whole: MirroredMesh, number: int) -> Spot:
    part = units.parts[number]
    row = np.searchsorted(part.nodes, whole.source[node])[None]
    x, y, z = whole.sign[node]
    side = int(y) if len(units.sides) > 1 else 1
    (history,) = part.histories(weights, (side,), row)
    stress = tensor(history[0]) * np.array([1, 1, 1, x * y, y * z, x * z])[:, None]
    signed = signed_equivalent(history)[0]
    return Spot(node, number, whole.mesh.points[node], stress, signed)
