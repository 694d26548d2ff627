"""Rims of the places where parts touch and bolts press: the exact stress may be infinite there.

Where a body ends on another one, or a pressure begins abruptly, the elastic stress beside the rim grows with
every refinement, as at the end of a clamped surface.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Ints
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import FACET_EDGES, TetMesh

_JOINT = (Surface.JOINT, Surface.JOINT_CAP)
# In words, by the surface that ends there.
_NAMES = {
    Surface.JOINT: "outline of the joint",
    Surface.JOINT_CAP: "outline of the joint",
    Surface.BUSHING_SEAT: "rim of the bushing's seat",
    Surface.BUSHING_BACK: "rim of the bushing's seat",
    Surface.SHELL_SEAT: "rim of the shells' seat",
    Surface.SHELL_BACK: "rim of the shells' seat",
    Surface.BOLT_HEAD: "rim of the bolt head's seat",
    Surface.BOLT_THREAD: "rim of the nut's seat or run-out of the thread",
}
_AT_BORE = "rim of the joint at the bore"


@dataclass(frozen=True)
class Rim:
    """The rim of an interface or of a bolt's seat, on one of the bodies that meet there.

    Attributes
    ----------
    name
        In words; the same on both bodies.
    surface
        The surface that ends there.
    edges
        (n, 2) vertices at the ends of the mesh's edges on it.
    nodes
        (n_nodes,) all nodes on it, with those amid its edges.
    """

    name: str
    surface: Surface
    edges: Ints
    nodes: Ints


def rims(mesh: TetMesh) -> tuple[Rim, ...]:
    """Find the rims on a mesh of separate bodies (`mesh.separate`); none lies across a mirror plane."""
    cut = [_sides(mesh.facets[plane])[0] for plane in PLANE_AXIS if plane in mesh.facets]
    bore = _sides(mesh.facets.get(Surface.BIG_END_BORE, np.zeros((0, 3), dtype=np.int64)))[0]
    found = []
    for surface, name in _NAMES.items():
        if surface not in mesh.facets:
            continue
        ends, middle = _border(mesh.facets[surface])
        free = ~_within(ends, cut)
        ends, middle = ends[free], middle[free]
        inner = _within(ends, [bore]) if surface in _JOINT else np.zeros(len(ends), dtype=bool)
        for what, chosen in ((_AT_BORE, inner), (name, ~inner)):
            if chosen.any():
                nodes = np.unique(np.concatenate([ends[chosen].ravel(), middle[chosen].ravel()]))
                found.append(Rim(what, surface, ends[chosen], nodes))
    return tuple(found)


def _sides(facets: Ints) -> tuple[Ints, Ints]:
    """Ends (n, 2), the lower number first, and middles (n, 0 or 1) of the sides of facets."""
    ends = np.sort(facets[:, FACET_EDGES].reshape(-1, 2), axis=1)
    return ends, facets[:, 3:].reshape(len(ends), (facets.shape[1] - 3) // 3)


def _border(facets: Ints) -> tuple[Ints, Ints]:
    """Ends and middles of the sides that only one facet has."""
    ends, middle = _sides(facets)
    _, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
    return ends[first[count == 1]], middle[first[count == 1]]


def _within(ends: Ints, sets: list[Ints]) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether each edge (n, 2) is among those of any of some sets (m, 2)."""
    if not sets or not len(ends):
        return np.zeros(len(ends), dtype=bool)
    every = np.concatenate(sets)
    most = int(max(every.max(initial=0), ends.max())) + 1
    return np.isin(ends @ [most, 1], every @ [most, 1])
