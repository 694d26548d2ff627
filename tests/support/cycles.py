"""Rods whose crank cycle is superposed, and the same instants solved directly."""

from functools import cache

import numpy as np
from studies import plain_study

from fea.analysis.pipeline import prepare
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import Symmetry
from fea.solid.stress import von_mises
from fea.study.flags import Flags
from geometry.surfaces import Surface

SPEEDS = (1000.0, 6000.0, 9000.0)


@cache
def analysis(symmetry: Symmetry, size: float) -> PreparedRod:
    """The default study without pockets on a coarse mesh, its cycle included."""
    flags = Flags(size=size, symmetry=symmetry, cycle=True)
    return prepare(flags.applied(plain_study()))


def direct(rod: PreparedRod, rpm: float, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stress (n_nodes, 6, n) of the whole rod and largest von Mises stress (n,) of instants."""
    stress = rod.fields.stresses(rod.equilibrium(rod.crank_cycle(rpm).at(angles)))[0]
    return stress, von_mises(np.moveaxis(stress, 1, -1)).max(axis=0)


def on_bores(rod: PreparedRod) -> np.ndarray:
    """Whether each node (n_nodes,) of the whole rod lies on a bore."""
    mesh = rod.mesh.whole
    found = np.zeros(len(mesh.points), dtype=bool)
    for surface in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE):
        found[mesh.facets[surface]] = True
    return found


def superposition_errors(rod: PreparedRod, rpm: float, angles: np.ndarray) -> tuple[float, float]:
    """Largest difference of superposed from direct stress on the bores and elsewhere, of the peaks."""
    stress, peaks = direct(rod, rpm, angles)
    cycle = rod.cycle
    weights = cycle.weights(rod.crank_cycle(rpm), angles)
    superposed = cycle.units.tensor(0, weights, rod.mesh.mirrored)
    error = (np.abs(superposed - stress).max(axis=1) / peaks).max(axis=1)
    there = on_bores(rod)
    return float(error[there].max()), float(error[~there].max())
