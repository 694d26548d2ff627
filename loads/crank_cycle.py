"""A crank cycle at one speed: its instants, its peak load cases, and the increments that friction follows."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import EngineInstants, cycle
from loads.engine import Engine
from loads.gas import GasModel
from loads.instants import Instants, joined

# A grid of half a degree finds every peak of the motion, and a trace's own samples find every peak of the
# pressure. A grid a hundred times finer then locates the peak (not a parabola, because a trace has kinks).
_COARSE = math.radians(0.5)
_FINE = _COARSE / 100
# Peaks that differ by less than this (relative) are repetitions of one peak.
_EQUAL = 1e-6
# Forces below this fraction of the largest axial force are rounding errors.
_ROUNDING = 1e-12
# The quantity that is largest in each case; if even its maximum is not positive, the case does not occur.
_PUSHED, _PULLED = (f"the rod is in {state} throughout the cycle" for state in ("compression", "tension"))
_GAS = "gas"
_MEASURES: dict[str, tuple[Callable[[Instants], Floats], str]] = {
    "tension": (lambda c: np.maximum(c.pin_axial, c.crank_axial), _PUSHED),
    "compression": (lambda c: -np.minimum(c.pin_axial, c.crank_axial), _PULLED),
    "side": (lambda c: np.abs(c.wall), "there is no force between piston and wall"),
    "bending": (lambda c: np.abs(c.crank_transverse), "there is no transverse force on the crank end"),
    _GAS: (lambda c: c.gas, "there is no gas force on the piston"),
}
# How many increments a cycle of four strokes has; and the crank angle at which they begin, rad: before the
# dead centre of gas exchange, at which the inertia pulls most (of a two-stroke engine before the firing one,
# at which the gas pushes most), so that little is left afterwards of what friction did before.
INCREMENTS, BEGINNING = 80, -np.pi / 3
# Decimal places to which rounding leaves the share of an increment.
_DIGITS = 9


class Peaks(NamedTuple):
    """The load cases that occur, and the names of the others with the reason why they do not."""

    cases: Instants
    left_out: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class CrankCycle:
    """What acts on a rod over a crank cycle."""

    #: engine, rod, gas: the engine, the mass properties of its rod, and what gives its gas pressure
    engine: Engine
    rod: MassProperties
    gas: GasModel
    speed: float  #: of the crank, rad/s

    def at(self, crank_angles: Floats) -> EngineInstants:
        """Compute what acts at crank angles, rad."""
        return cycle(self.engine, self.rod, self.gas, self.speed, crank_angles)

    @cached_property
    def degrees(self) -> EngineInstants:
        """What acts at every degree, both ends included."""
        return self.at(self.engine.cycle_angles)

    @cached_property
    def peaks(self) -> Peaks:
        """The peak cases of the cycle.

        ``tension`` and ``compression`` have the largest axial force at either end of the rod, ``side`` the
        largest wall force, ``bending`` the largest transverse force at the crank end, each located to 0.005°.
        ``gas`` is the peak gas force alone, on a rod at rest along the cylinder, as at low speed, where
        inertia does not relieve it (Shenoy & Fatemi, SAE 2005-01-0987).
        """
        cycle = self.engine.cycle
        whole = self.at(np.union1d(np.arange(0, cycle - _COARSE / 2, _COARSE), self.gas.samples))
        least = _ROUNDING * max(np.abs(whole.pin_axial).max(), np.abs(whole.crank_axial).max())
        # The fine grids contain the coarse peaks, so that their maxima are never smaller.
        steps = _FINE * np.arange(-100, 101)
        fine = [np.mod(_coarse_peak(of(whole), whole) + steps, cycle) for of, _ in _MEASURES.values()]
        near = self.at(np.concatenate(fine))
        cases, left_out = [], []
        for number, (name, (measure, reason)) in enumerate(_MEASURES.items()):
            values = measure(near)[number * len(steps) : (number + 1) * len(steps)]
            largest, peak = float(values.max()), near[number * len(steps) + int(np.argmax(values))]
            if largest <= (0.0 if name == _GAS else least):
                left_out.append((name, reason))
            else:
                cases.append(_gas_alone(peak) if name == _GAS else peak.named(name))
        return Peaks(joined(cases), tuple(left_out))

    @cached_property
    def increments(self) -> Instants:
        """What acts at the ends of the increments in their order; the first one follows the last.

        They are of whole degrees, divided half by the crank angle, half by the change of the pins' forces.
        """
        every = self.at(BEGINNING + self.engine.cycle_angles)
        forces = np.diff(np.concatenate([every.pin, every.crank]), axis=1)
        changed = np.append(0.0, np.cumsum(np.linalg.norm(forces, axis=0)))
        passed = np.linspace(0.0, 1.0, len(every))
        shares = (passed + changed / changed[-1]) / 2 if changed[-1] > 0 else passed
        count = INCREMENTS * self.engine.strokes // 4
        places = np.interp(np.arange(count) / count, shares, np.arange(len(every)))
        return every[np.unique(np.round(places).astype(int))]

    def places(self, crank_angles: Floats) -> Floats:
        """Numbers (n,) of the increments before crank angles (n,), with the share of the way to the next."""
        first, *_ = angles = self.increments.crank_angle
        cycle = self.engine.cycle
        ends = np.append(angles, first + cycle)
        places = np.interp((crank_angles - first) % cycle, ends - first, np.arange(len(ends)))
        return np.asarray(np.round(places, _DIGITS) % len(angles))


def _coarse_peak(values: Floats, whole: Instants) -> float:
    """Crank angle (rad) of the largest of values (n,) at instants.

    The transverse force at the crank end does not depend on the gas pressure, so it has equal peaks at
    several angles of the cycle: of these, the one with the largest axial force is taken.
    """
    equal = values >= values.max() - _EQUAL * abs(values.max())
    along = np.maximum(np.abs(whole.pin_axial), np.abs(whole.crank_axial))
    return float(whole.crank_angle[int(np.argmax(np.where(equal, along, -1.0)))])


def _gas_alone(peak: Instants) -> Instants:
    """Return the gas force of an instant on a rod at rest along the cylinder."""
    axial, none = np.array([1.0, 0.0]), np.zeros(())
    alone = Instants(names=np.array(_GAS), pin=-peak.gas * axial, crank=peak.gas * axial)
    return replace(alone, crank_angle=peak.crank_angle, gas=peak.gas, wall=none, torque=none)
