"""A rod whose unit solutions span every instant of its crank cycles."""

from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.basis import Basis
from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.pins.model import UnitLoads, Weights
from fea.rod.meshed_rod import MeshedRod
from fea.rod.surface_regions import SurfaceRegions
from geometry.arrays import Floats, Mask
from loads.crank_cycle import CrankCycle


@dataclass(frozen=True)
class SpannedRod:
    """What is superposed, and what its stress is judged by."""

    mesh: MeshedRod
    materials: tuple[Material, ...]  #: one per part
    basis: Basis  #: what is superposed
    fatigue: Fatigue  #: the mean-stress correction
    masked: Mask  #: nodes of the cell near stress singularities, which do not count
    regions: SurfaceRegions  #: of the surface of the cell

    @property
    def loads(self) -> UnitLoads:
        """The unit loads that span every instant."""
        return self.basis.loads

    @property
    def units(self) -> UnitSolutions:
        """The unit solutions that are superposed."""
        return self.basis.units

    @property
    def counts(self) -> Mask:
        """Nodes of the cell that count; all nodes if none would be left."""
        return counting(self.masked)

    def weights(self, cycle: CrankCycle, angles: Floats) -> Weights:
        """Weights of the unit solutions at crank angles (n_instants,), rad."""
        return self.basis.weights(cycle.at(angles), cycle)


def counting(masked: Mask) -> Mask:
    """Nodes that count: those that are not masked; all nodes if none would be left."""
    return np.ones_like(masked) if masked.all() else ~masked
