"""Load cases: the crank angles of a cycle with the largest forces on the rod, and cases of a rod at rest."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geometry.arrays import Floats
from geometry.errors import require, require_number
from loads.crank_cycle import CrankCycle
from loads.gas import CYCLE
from loads.instants import Instants, joined

Measure = Callable[[Instants], Floats]

# A grid of half a degree finds every peak of the motion, and a trace's own samples find every peak of the
# pressure. A grid a hundred times finer then locates the peak (not a parabola, because a trace has kinks).
_COARSE = math.radians(0.5)
_FINE = _COARSE / 100
# Peaks that differ by less than this (relative) are repetitions of one peak.
_EQUAL = 1e-6


class Peaks(NamedTuple):
    """The load cases that occur, and the names of the others with the reason why they do not."""

    cases: Instants
    left_out: tuple[tuple[str, str], ...]


# Forces below this fraction of the largest axial force are rounding errors.
_ROUNDING = 1e-12
# The quantity that is largest in each case; if even its maximum is not positive, the case does not occur.
_PUSHED, _PULLED = (f"the rod is in {state} throughout the cycle" for state in ("compression", "tension"))
_MEASURES: dict[str, tuple[Measure, str]] = {
    "tension": (lambda c: np.maximum(c.pin_axial, c.crank_axial), _PUSHED),
    "compression": (lambda c: -np.minimum(c.pin_axial, c.crank_axial), _PULLED),
    "side": (lambda c: np.abs(c.wall), "there is no force between piston and wall"),
    "bending": (lambda c: np.abs(c.crank_transverse), "there is no transverse force on the crank end"),
}


def peak_cases(cycle: CrankCycle) -> Peaks:
    """Find the peak cases of a cycle.

    ``tension`` and ``compression`` have the largest axial force at either end of the rod, ``side`` the
    largest wall force, ``bending`` the largest transverse force at the crank end; each contains everything
    that acts at its crank angle, which is located to 0.005°. ``gas`` is the peak gas force alone, on a rod
    at rest along the cylinder: the condition of low speed, where inertia does not relieve the gas force
    (Shenoy & Fatemi, SAE 2005-01-0987).
    """
    coarse = np.union1d(np.arange(0, CYCLE - _COARSE / 2, _COARSE), cycle.gas.samples)
    whole = cycle.at(coarse)
    least = _ROUNDING * max(np.abs(whole.pin_axial).max(), np.abs(whole.crank_axial).max())
    cases, left_out = [], []
    for name, (measure, reason) in _MEASURES.items():
        angle, largest = _refine(measure, cycle, whole)
        if largest > least:
            cases.append(cycle.at(np.array([angle]))[0].named(name))
        else:
            left_out.append((name, reason))
    angle, largest = _refine(lambda c: c.gas, cycle, whole)
    if largest > 0:
        alone = Instants(names=np.array("gas"), pin=np.array([-largest, 0.0]), crank=np.array([largest, 0.0]))
        at, gas, none = np.array(angle), np.array(largest), np.zeros(())
        cases.append(replace(alone, crank_angle=at, gas=gas, wall=none, torque=none))
    else:
        left_out.append(("gas", "there is no gas force on the piston"))
    return Peaks(joined(cases), tuple(left_out))


# Nothing but bolts and fits.
ASSEMBLY = "assembly"


def assembled() -> Instants:
    """Return the case of an assembled rod at rest: nothing acts on it but its bolts and fits."""
    return Instants(names=np.array(ASSEMBLY), pin=np.zeros(2), crank=np.zeros(2))


def given(pin_axial: float, pin_transverse: float = 0.0) -> Instants:
    """Return the case of a given pin force, N, on a rod at rest, which the crank end reacts.

    The axial part is balanced at the crank end; a transverse part is not (its moment needs a clamped big
    end). Raises `InvalidValue`: a force is not a finite number, or there is none.
    """
    force = [require_number("forces.pin_N", pin_axial), require_number("forces.pin_N", pin_transverse)]
    rule, remedy = "at least one component must not be zero", "Give [axial, transverse] in newtons."
    require(any(force), "forces.pin_N", force, rule, remedy)
    return Instants(names=np.array("given"), pin=np.array(force), crank=-np.array(force))


def _refine(measure: Measure, cycle: CrankCycle, whole: Instants) -> tuple[float, float]:
    """Crank angle (rad, within the cycle) and value of the largest `measure`.

    The transverse force at the crank end does not depend on the gas pressure, so it has equal peaks at
    several angles of the cycle: of these, the one with the largest axial force is taken.
    """
    values = measure(whole)
    equal = values >= values.max() - _EQUAL * abs(values.max())
    along = np.maximum(np.abs(whole.pin_axial), np.abs(whole.crank_axial))
    peak = whole.crank_angle[int(np.argmax(np.where(equal, along, -1.0)))]
    # The fine grid contains the coarse peak, so that its maximum is never smaller.
    near = peak + _FINE * np.arange(-100, 101)
    values = measure(cycle.at(near))
    i = int(np.argmax(values))
    return float(np.mod(near[i], CYCLE)), float(values[i])
