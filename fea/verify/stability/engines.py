"""Engines with extreme parameters: pin, crank and inertia forces of the rod must still sum to zero."""

import math

import numpy as np

from fea.units import BAR, KG, KG_M2, RPM
from fea.verify.stability.row import ExtremeRow, judged
from geometry.mass import MassProperties
from loads.dynamics import cycle
from loads.engine import Engine
from loads.gas import Otto

LENGTH = 141.0
_ZERO = (0.0, 0.0, 0.0)
ROD = MassProperties(0.785 * KG, (64.0, 0.0, 0.0), (_ZERO, _ZERO, (0.0, 0.0, 3e-3 * KG_M2)))
SPEEDS = (0.0, 1.0, 6000.0, 20_000.0, 50_000.0)
RATIOS = (0.05, 0.3, 0.6, 0.9)
PEAKS = (20.0, 100.0, 399.0)  # bar; the last, at rest, is a hydraulic lock
# Relative to the largest force on the rod, or to that force times the rod's length.
TOLERANCE_PERCENT = 1e-10


def rows() -> list[ExtremeRow]:
    """Vary the speed with León's proportions, λ at 6000 rpm, and the gas pressure at rest."""
    return [
        *(_row("engine speed", "rpm", rpm, rpm=rpm) for rpm in SPEEDS),
        *(_row("crank ratio", "λ", ratio, ratio=ratio) for ratio in RATIOS),
        *(_row("gas pressure at rest", "bar", peak, rpm=0.0, peak=peak) for peak in PEAKS),
    ]


def _row(
    case: str, parameter: str, value: float, *, ratio: float = 1 / 3, rpm: float = 6000.0, peak: float = 60.0
) -> ExtremeRow:
    engine = Engine(crank_radius=ratio * LENGTH, rod_length=LENGTH, bore=76.0, piston_mass=1.0 * KG)
    gas = Otto(engine, 8.0, peak * BAR)
    error = 100 * max(_imbalance(engine, gas, rpm * RPM, angle) for angle in np.arange(0, 4 * math.pi, 0.1))
    return ExtremeRow(
        case=case,
        parameter=parameter,
        value=value,
        verdict=judged(error, TOLERANCE_PERCENT, marked=False),
        result_error_percent=error,
        tolerance_percent=TOLERANCE_PERCENT,
    )


def _imbalance(engine: Engine, gas: Otto, speed: float, angle: float) -> float:
    """Largest resultant, force or moment about the crank pin, relative to the largest force."""
    c = cycle(engine, ROD, gas, speed, angle)
    x, y, _ = ROD.center
    along, square, across, alpha = map(float, c.motions)
    a_x = along - alpha * y - square * x
    a_y = across + alpha * x - square * y
    along = float(c.pin_axial - c.crank_axial) - ROD.mass * a_x
    across = float(c.pin_transverse + c.crank_transverse) - ROD.mass * a_y
    turning = float(c.pin_transverse) * LENGTH - ROD.inertia_z * alpha - ROD.mass * (x * a_y - y * a_x)
    largest = float(np.abs([c.pin, c.crank]).max())
    return max(abs(along), abs(across), abs(turning) / LENGTH) / (largest or 1.0)
