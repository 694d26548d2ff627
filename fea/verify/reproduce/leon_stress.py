"""León 2001, tables 21–23 and the column check: the stresses of its finite-element chapter, at 6000 rpm.

The tables contain the legend values of colour plots: their extremes are compared, and the columns with each
other. The thesis has no drawing, so the extremes are those of a rod with the same length, mass, area and
moment of inertia: they show the effect of the published boundary conditions, but cannot repeat three digits.
"""

import dataclasses
import math
from collections.abc import Callable
from functools import cache

import numpy as np

from fea.analysis.pipeline import prepare, solve_speed
from fea.analysis.speed_result import SpeedResult
from fea.judge.case_result import CaseResult
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.pin_models import PRESCRIBED
from fea.study.study import load_study
from fea.verify.reproduce.printed import column, records
from fea.verify.reproduce.published import Fact, Formula
from geometry.arrays import Floats

SPEEDS = (800, 3000, 6000)  # rpm
STRENGTH = 620.4  # MPa, of the stress model
# Peaks at this size are within a few per cent of mesh-converged ones; the figures differ by factors.
SIZE = 6.5  # mm

Extreme = Callable[[SpeedResult], float]


def _largest(field: Callable[[CaseResult], Floats]) -> Extreme:
    return lambda result: max(float(field(case).max()) for case in result.cases.values())


_von_mises = _largest(lambda case: case.von_mises)
_displacement = _largest(lambda case: np.linalg.norm(case.displacement, axis=1))


def _least_safety(result: SpeedResult) -> float:
    return min(float(case.safety_factor.min()) for case in result.cases.values())


_EXTREMES: dict[str, Extreme] = {
    "largest von Mises": _von_mises,
    "largest principal stress": _largest(lambda case: case.principal[:, 0]),
    "largest displacement": _displacement,
    "least safety factor": _least_safety,
}


@cache
def _as_published(*, bonded: bool = False, axial_only: bool = False) -> SpeedResult:
    """Our rod under the published conditions: big end clamped, table 17's forces on the pin bore.

    `bonded` spreads the pin force over the whole bore, as other programs do with a force on a face.
    """
    study = dataclasses.replace(load_study("leon-2001-as-published"), mesh=MeshTable(size_mm=SIZE))
    if bonded:
        study = dataclasses.replace(study, analysis=dataclasses.replace(study.analysis, pressure="bonded"))
    if axial_only:
        axial, _ = study.forces.pin() if study.forces else (0.0, 0.0)
        study = dataclasses.replace(study, forces=ForcesTable(pin_N=(axial, 0.0)))
    return solve_speed(prepare(study), None)


@cache
def _corrected() -> dict[int, SpeedResult]:
    """Our rod in balance with its own inertia, by speed, under prescribed pressure."""
    study = load_study("leon-2001")
    pressed = dataclasses.replace(study.analysis, pressure=PRESCRIBED)
    rod = prepare(dataclasses.replace(study, mesh=MeshTable(size_mm=SIZE), analysis=pressed))
    return {rpm: solve_speed(rod, rpm) for rpm in SPEEDS}


# The rod as a column, by Euler as printed and by Johnson as its slenderness requires.
AREA, SECOND_MOMENT, LENGTH = 89.0, 1260.0, 141.0  # mm², mm⁴, mm
E, YIELD = 207e3, 220.0  # MPa, AISI 1018 as printed
_RADIUS_PRINTED = 3.766  # mm, a misprint of 3.763 that was used for the slenderness
_GYRATION = math.sqrt(SECOND_MOMENT / AREA)
SLENDERNESS = LENGTH / _GYRATION
_TRANSITION = math.sqrt(2 * math.pi**2 * E / YIELD)


def johnson(slenderness: float, strength: float = YIELD) -> float:
    """Johnson's critical load, N: A S_y (1 − S_y (KL/r)²/(4π² E)), for columns shorter than C_c."""
    return AREA * strength * (1 - strength * slenderness**2 / (4 * math.pi**2 * E))


def _equivalent(*_: object) -> Floats:
    """The von Mises stress of the principal stresses of table 21."""
    printed = records("leon2001_table21_stresses_6000rpm")
    s1, s2, s3 = np.array([[float(row[f"s{axis}_MPa"]) for row in printed] for axis in (1, 2, 3)])
    return np.asarray(np.sqrt(((s1 - s2) ** 2 + (s2 - s3) ** 2 + (s3 - s1) ** 2) / 2))


def _extreme(of: Extreme, *, clamped: bool) -> Formula:
    """Of our rod with the published conditions, or in equilibrium."""
    return lambda _, rpm: of(_as_published()) if clamped else of(_corrected()[rpm])


_EULER, _JOHNSON = math.pi**2 * E * AREA / 37.44**2, johnson(SLENDERNESS)
FORMULAS: dict[str, Formula] = {
    "von Mises of the principal stresses": _equivalent,
    "strength over the stresses of table 22": lambda *_: (
        STRENGTH / column("leon2001_table22_safety_6000rpm", "von_mises_MPa").values
    ),
    **{name: _extreme(of, clamped=False) for name, of in _EXTREMES.items()},
    **{f"{name}, clamped": _extreme(of, clamped=True) for name, of in _EXTREMES.items()},
    "radius of gyration": lambda *_: _GYRATION / 10,
    "slenderness, r = 3.766 mm": lambda *_: LENGTH / _RADIUS_PRINTED,
    "slenderness": lambda *_: SLENDERNESS,
    "transition slenderness": lambda *_: _TRANSITION,
    "Euler's load": lambda *_: _EULER,
    "Euler's load / 6": lambda *_: _EULER / 6,
    "Euler's load / 4": lambda *_: _EULER / 4,
    "Johnson's load": lambda *_: _JOHNSON,
    "Johnson's load / 6": lambda *_: _JOHNSON / 6,
    "Johnson's load / 4": lambda *_: _JOHNSON / 4,
}
_DEPTH = math.sqrt(12 * SECOND_MOMENT / AREA)  # of a rectangle with the printed area and second moment, mm
_WIDTH = AREA / _DEPTH
FACTS: dict[str, Fact] = {
    "bent": lambda _: _von_mises(_as_published()),
    "moved": lambda _: _displacement(_as_published()),
    "axial": lambda _: _von_mises(_as_published(axial_only=True)),
    "spread": lambda _: _von_mises(_as_published(bonded=True)),
    "spread_moved": lambda _: _displacement(_as_published(bonded=True)),
    "balanced": lambda _: _von_mises(_corrected()[6000]),
    "balanced_moved": lambda _: _displacement(_corrected()[6000]),
    "balanced_safety": lambda _: _least_safety(_corrected()[6000]),
    "slenderness": lambda _: SLENDERNESS,
    "transition": lambda _: _TRANSITION,
    "column_kN": lambda _: _JOHNSON / 1e3,
    "strongest_kN": lambda _: johnson(SLENDERNESS, STRENGTH) / 1e3,
    "width": lambda _: _WIDTH,
    "depth": lambda _: _DEPTH,
    "weak": lambda _: LENGTH / (_WIDTH / math.sqrt(12)),
}
