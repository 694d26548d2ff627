"""Where rims of interfaces and bolt seats are left out of peaks: by name, nodes and radius.

Beside a rim the exact stress is infinite, or jumps where a pressure begins abruptly. The radius is a share of
the smallest measure there, so that of a thin bush or shell, or of a narrow seat, what is not beside a rim is
judged: the width of the face that ends there, and the depth of the part behind it.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Ints
from mesh.rims import Rim, rims
from mesh.tetmesh import TetMesh

# Radius of the mask, over the smallest measure.
_SHARE = 0.25


@dataclass(frozen=True)
class RimMask:
    """The rims of one name.

    Attributes
    ----------
    name
        In words.
    nodes
        (n,) on them.
    radius
        Within which stress is left out, mm.
    """

    name: str
    nodes: Ints
    radius: float


def rim_masks(mesh: TetMesh, largest: float) -> tuple[RimMask, ...]:
    """Find what is left out beside the rims of a mesh of separate bodies.

    Parameters
    ----------
    mesh
        The mesh.
    largest
        Radius that is not exceeded, mm.
    """
    found = rims(mesh)
    if not found:
        return ()
    part = np.zeros(len(mesh.points), dtype=np.int64)
    if mesh.part is not None:
        part[mesh.tets] = mesh.part[:, None]
    volume = np.asarray(np.bincount(part[mesh.tets[:, 0]], _volumes(mesh)), dtype=np.float64)
    masks: dict[str, RimMask] = {}
    for rim in found:
        radius = min(largest, _SHARE * _measure(mesh, rim, found, part, volume))
        known = masks.get(rim.name, RimMask(rim.name, rim.nodes, radius))
        nodes = np.union1d(known.nodes, rim.nodes)
        masks[rim.name] = RimMask(rim.name, nodes, min(known.radius, radius))
    return tuple(masks.values())


def _measure(mesh: TetMesh, rim: Rim, every: tuple[Rim, ...], part: Ints, volume: Floats) -> float:
    """Smallest width of the faces that end at a rim, or depth of the parts behind them, mm."""
    facets = mesh.facets[rim.surface]
    edges = np.concatenate([other.edges for other in every if other.surface is rim.surface])
    measures = []
    for number in np.unique(part[rim.nodes]):
        area = _areas(mesh, facets[part[facets[:, 0]] == number]).sum()
        ends = mesh.points[edges[part[edges[:, 0]] == number]]
        border = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
        measures += [2 * area / border, volume[number] / area]
    return float(min(measures))


def _areas(mesh: TetMesh, facets: Ints) -> Floats:
    a, b, c = mesh.points[facets[:, :3]].transpose(1, 0, 2)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


def _volumes(mesh: TetMesh) -> Floats:
    a, b, c, d = mesh.points[mesh.tets[:, :4]].transpose(1, 0, 2)
    return np.asarray(np.abs(((b - a) * np.cross(c - a, d - a)).sum(axis=1)) / 6)
