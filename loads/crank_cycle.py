"""A crank cycle at one speed: its instants, and the increments that divide it where friction remembers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import EngineInstants, cycle
from loads.engine import Engine
from loads.gas import CYCLE, GasModel
from loads.instants import Instants
from loads.slider_crank import cycle_angles

# How many increments; and the crank angle at which they begin, rad: before the dead centre of gas exchange,
# at which the inertia pulls most, so that little is left afterwards of what friction did before.
INCREMENTS, BEGINNING = 80, -np.pi / 3
# Decimal places to which rounding leaves the share of an increment.
_DIGITS = 9


@dataclass(frozen=True)
class CrankCycle:
    """What acts on a rod over a crank cycle."""

    #: engine, rod, gas: the engine, the mass properties of its rod, and what gives its gas pressure
    engine: Engine
    rod: MassProperties
    gas: GasModel
    speed: float  #: of the crank, rad/s

    def at(self, crank_angles: Floats) -> EngineInstants:
        """What acts at crank angles, rad."""
        return cycle(self.engine, self.rod, self.gas, self.speed, crank_angles)

    @cached_property
    def degrees(self) -> EngineInstants:
        """What acts at every degree, both ends included."""
        return self.at(cycle_angles())

    @cached_property
    def increments(self) -> Instants:
        """What acts at the ends of the increments in their order; the first one follows the last.

        Half of what divides the cycle into increments, of whole degrees, is the crank angle; the other half
        is the change of the pins' forces.
        """
        every = self.at(BEGINNING + cycle_angles())
        forces = np.diff(np.concatenate([every.pin, every.crank]), axis=1)
        changed = np.append(0.0, np.cumsum(np.linalg.norm(forces, axis=0)))
        passed = np.linspace(0.0, 1.0, len(every))
        shares = (passed + changed / changed[-1]) / 2 if changed[-1] > 0 else passed
        places = np.interp(np.arange(INCREMENTS) / INCREMENTS, shares, np.arange(len(every)))
        return every[np.unique(np.round(places).astype(int))]

    def places(self, crank_angles: Floats) -> Floats:
        """Numbers (n,) of the increments before crank angles (n,), with the share of the way to the next."""
        first, *_ = angles = self.increments.crank_angle
        ends = np.append(angles, first + CYCLE)
        places = np.interp((crank_angles - first) % CYCLE, ends - first, np.arange(len(ends)))
        return np.asarray(np.round(places, _DIGITS) % len(angles))
