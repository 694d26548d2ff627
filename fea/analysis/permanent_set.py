"""What flow leaves of a rod without load, as a builder measures it: length, bend, twist, round bores."""

from collections.abc import Mapping

import numpy as np

from fea.analysis.overload_figures import SetFigures
from fea.base.units import DEG, UM
from fea.solid.bore import bore_shape
from fea.solid.supports import SLIDE_X, SLIDE_Y, TURN_X, TURN_Y, mean_motions
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# A mandrel in each bore shows bend and twist over this length, mm.
_MANDREL = 100.0
# Slices between the bores by which the shank's bow is measured.
_SLICES = 24


def permanent_set(mesh: TetMesh, rod_length: float, moved: Floats) -> dict[str, float]:
    """Return what a displacement (n_nodes, 3), mm, that is left without load means at the bench.

    ``length``: by how much the bores are further apart (negative: closer); ``bend``: by how much their axes
    are out of parallel over 100 mm, seen from the side of the rod; ``bow``: departure of the shank from a
    straight line in the plane of motion; ``big_end``, ``small_end``: out of round, all in µm; ``twist_deg``.
    """
    big, small = (
        np.einsum("mni,ni->m", mean_motions(mesh, bore, x), moved)
        for bore, x in ((Surface.BIG_END_BORE, 0.0), (Surface.SMALL_END_BORE, rod_length))
    )
    x = mesh.points[:, 0]
    share = np.clip(x / rod_length, 0, 1)
    sideways = moved[:, 1] - (1 - share) * big[SLIDE_Y] - share * small[SLIDE_Y]
    number = np.minimum((share * _SLICES).astype(int), _SLICES - 1)
    sums, counts = np.bincount(number, sideways, _SLICES), np.bincount(number, minlength=_SLICES)
    between = slice(_SLICES // 4, _SLICES - _SLICES // 4)  # clear of the rings, which are deformed themselves
    return {
        "length": float(small[SLIDE_X] - big[SLIDE_X]) / UM,
        "bend": float(abs(small[TURN_Y] - big[TURN_Y])) * _MANDREL / UM,
        "twist_deg": float(abs(small[TURN_X] - big[TURN_X])) / DEG,
        "bow": float(np.abs(sums[between] / np.maximum(counts[between], 1)).max()) / UM,
        "big_end": bore_shape(mesh, Surface.BIG_END_BORE, 0.0, moved).ovality / UM,
        "small_end": bore_shape(mesh, Surface.SMALL_END_BORE, rod_length, moved).ovality / UM,
    }


def judged(left: Mapping[str, float], limits: Mapping[str, float]) -> SetFigures:
    """Compare what is left with its limits, both by the names of `permanent_set`."""
    ratios = {name: limit / abs(left[name]) for name, limit in limits.items() if left.get(name)}
    exceeded = tuple(name for name in sorted(ratios, key=ratios.__getitem__) if ratios[name] < 1)
    return SetFigures(limits=limits, exceeded=exceeded, least_factor=min(ratios.values(), default=None))
