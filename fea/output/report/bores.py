"""The bores as a drawing of the loads on them needs them."""

from typing import NamedTuple

import numpy as np

from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Of the names of the surfaces; the big end's first.
BORES = (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)


class DrawnBore(NamedTuple):
    """A bore: the x of its centre, its radius and its ends along z, mm."""

    x: float
    radius: float
    low: float
    high: float


def drawn_bores(mesh: TetMesh, rod_length: float) -> tuple[DrawnBore, ...]:
    """Measure the bores of a mesh with named surfaces; none if it has no names."""
    if any(surface not in mesh.facets for surface in BORES):
        return ()
    return tuple(_bore(mesh, surface, x) for surface, x in zip(BORES, (0.0, rod_length), strict=True))


def _bore(mesh: TetMesh, surface: Surface, x: float) -> DrawnBore:
    own = mesh.points[np.unique(mesh.facets[surface])]
    radius = float(np.hypot(own[:, 0] - x, own[:, 1]).mean())
    return DrawnBore(x, radius, float(own[:, 2].min()), float(own[:, 2].max()))
