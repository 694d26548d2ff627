"""The peak load cases of a cycle: the crank angles with the largest forces on the rod."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.cases import LoadCase
from loads.dynamics import Cycle, cycle, rod_motion
from loads.engine import Engine
from loads.gas import CYCLE, GasModel

Measure = Callable[[Cycle], Floats]

# A grid of half a degree finds every peak of the motion, and a trace's own samples find every peak of the
# pressure. A grid a hundred times finer then locates the peak (not a parabola, because a trace has kinks).
_COARSE = math.radians(0.5)
_FINE = _COARSE / 100
# Peaks that differ by less than this (relative) are repetitions of one peak.
_EQUAL = 1e-6


class Peaks(NamedTuple):
    """The load cases that occur, and the names of the others with the reason why they do not."""

    cases: tuple[LoadCase, ...]
    left_out: tuple[tuple[str, str], ...]


# Forces below this fraction of the largest axial force are rounding errors.
_ROUNDING = 1e-12
# The quantity that is largest in each case; if even its maximum is not positive, the case does not occur.
_MEASURES: dict[str, tuple[Measure, str]] = {
    "tension": (
        lambda c: np.maximum(c.pin_axial, c.crank_axial),
        "the rod is in compression throughout the cycle",
    ),
    "compression": (
        lambda c: -np.minimum(c.pin_axial, c.crank_axial),
        "the rod is in tension throughout the cycle",
    ),
    "side": (lambda c: np.abs(c.wall), "there is no force between piston and wall"),
    "bending": (lambda c: np.abs(c.crank_transverse), "there is no transverse force on the crank end"),
}


def peak_cases(engine: Engine, rod: MassProperties, gas: GasModel, speed: float) -> Peaks:
    """Find the peak cases of one cycle at a constant speed (rad/s).

    ``tension`` and ``compression`` have the largest axial force at either end of the rod, ``side`` the
    largest wall force, ``bending`` the largest transverse force at the crank end; each contains everything
    that acts at its crank angle, which is located to 0.005°. ``gas`` is the peak gas force alone, on a rod
    at rest along the cylinder: the condition of low speed, where inertia does not relieve the gas force
    (Shenoy & Fatemi, SAE 2005-01-0987).
    """

    def at(angles: Floats) -> Cycle:
        return cycle(engine, rod, gas, speed, angles)

    coarse = np.union1d(np.arange(0, CYCLE - _COARSE / 2, _COARSE), gas.samples)
    whole = at(coarse)
    least = _ROUNDING * max(np.abs(whole.pin_axial).max(), np.abs(whole.crank_axial).max())
    cases, left_out = [], []
    for name, (measure, reason) in _MEASURES.items():
        angle, largest = _refine(measure, at, whole)
        if largest > least:
            cases.append(load_case(engine, rod, gas, speed, angle, name=name))
        else:
            left_out.append((name, reason))
    angle, largest = _refine(lambda c: c.gas, at, whole)
    if largest > 0:
        cases.append(gas_alone(largest, angle))
    else:
        left_out.append(("gas", "there is no gas force on the piston"))
    return Peaks(tuple(cases), tuple(left_out))


def load_case(
    engine: Engine, rod: MassProperties, gas: GasModel, speed: float, crank_angle: float, *, name: str
) -> LoadCase:
    """Everything that acts on the rod at one crank angle (rad) and speed (rad/s)."""
    c = cycle(engine, rod, gas, speed, crank_angle)
    return LoadCase(
        name=name,
        crank_angle=crank_angle,
        pin_axial=float(c.pin_axial),
        pin_transverse=float(c.pin_transverse),
        crank_axial=float(c.crank_axial),
        crank_transverse=float(c.crank_transverse),
        gas=float(c.gas),
        wall=float(c.wall),
        torque=float(c.torque),
        motion=rod_motion(engine, speed, crank_angle),
    )


def gas_alone(force: float, crank_angle: float) -> LoadCase:
    """Return the case of the gas force (N, towards the crank; peak at `crank_angle`) on a rod at rest."""
    return LoadCase(
        name="gas",
        crank_angle=crank_angle,
        pin_axial=-force,
        pin_transverse=0.0,
        crank_axial=-force,
        crank_transverse=0.0,
        gas=force,
        wall=0.0,
        torque=0.0,
    )


def _refine(measure: Measure, at: Callable[[Floats], Cycle], whole: Cycle) -> tuple[float, float]:
    """Crank angle (rad, within the cycle) and value of the largest `measure`.

    The transverse force at the crank end does not depend on the gas pressure, so it has equal peaks at
    several angles of the cycle: of these, the one with the largest axial force is taken.
    """
    values = measure(whole)
    equal = values >= values.max() - _EQUAL * abs(values.max())
    along = np.maximum(np.abs(whole.pin_axial), np.abs(whole.crank_axial))
    peak = whole.motion.crank_angle[int(np.argmax(np.where(equal, along, -1.0)))]
    # The fine grid contains the coarse peak, so that its maximum is never smaller.
    near = peak + _FINE * np.arange(-100, 101)
    values = measure(at(near))
    i = int(np.argmax(values))
    return float(np.mod(near[i], CYCLE)), float(values[i])
