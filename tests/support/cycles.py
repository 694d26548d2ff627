"""Rods whose crank cycle is superposed, and the same instants solved directly."""

from functools import cache

import numpy as np

from fea.analysis.pipeline import Analysis
from fea.choices import Symmetry
from fea.machine.clock import Clock
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.units import RPM
from geometry.surfaces import Surface
from loads.peaks import load_case

SPEEDS = (1000.0, 6000.0, 9000.0)


@cache
def analysis(symmetry: Symmetry, size: float) -> Analysis:
    """The default study on a coarse mesh, its cycle included."""
    flags = Flags(size=size, symmetry=symmetry, cycle=True)
    return Analysis(flags.applied(load_study("leon-2001")), Clock())


def direct(rod: Analysis, rpm: float, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stress (n_nodes, 6, n) of the whole rod and largest von Mises stress (n,) of instants."""
    cases = tuple(load_case(rod.engine, rod.rod, rod.gas, rpm * RPM, angle, name="any") for angle in angles)
    forces = [rod.case_loads(case) for case in cases]
    solution = rod.model.solve([case.forces for case in forces])
    results = list(rod._judged(cases, forces, solution))
    peaks = np.array([result.von_mises.max() for result in results])
    return np.stack([result.stress for result in results], axis=-1), peaks


def on_bores(rod: Analysis) -> np.ndarray:
    """Whether each node (n_nodes,) of the whole rod lies on a bore."""
    mesh = rod.mesh.whole.mesh
    found = np.zeros(len(mesh.points), dtype=bool)
    for surface in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE):
        found[mesh.facets[surface]] = True
    return found


def superposition_errors(rod: Analysis, rpm: float, angles: np.ndarray) -> tuple[float, float]:
    """Largest difference of superposed from direct stress on the bores and elsewhere, of the peaks."""
    stress, peaks = direct(rod, rpm, angles)
    cycle = rod.cycle_analysis
    weights = cycle.weights(rod.engine, rod.gas, rpm * RPM, angles)
    superposed = cycle.units.tensor(0, weights, rod.mesh.whole)
    error = (np.abs(superposed - stress).max(axis=1) / peaks).max(axis=1)
    there = on_bores(rod)
    return float(error[there].max()), float(error[~there].max())
