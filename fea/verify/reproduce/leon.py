"""León 2001: the engine and the rod as printed, and what computes the figures of its tables.

J. L. León, *Análisis por elemento finito en una biela de motor de combustión interna*, UNAM, 2001.

Tables 21–23, the finite-element chapter at 6000 rpm, contain legend values of colour plots: their extremes
are compared, and the columns with each other. The thesis has no drawing, so the extremes are those of a rod
with the same length, mass, area and moment of inertia: they show the effect of the published boundary
conditions, but cannot repeat three digits.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from fea.analysis.pipeline import prepare, solve_speed
from fea.analysis.speed_result import SpeedResult
from fea.base.units import KG, KG_M2
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.pin_models import PRESCRIBED
from fea.study.study import load_study
from fea.verify.reproduce.tables import PrintedColumn, PublishedStudy, Slip, column, printed
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.engine import Engine

SOURCE = "leon-2001"
SPEEDS = (6000, 3000, 800)

R, L = 0.047, 0.141  # crank radius and rod length, m
LAMBDA = R / L
BORE = 76.0  # mm, as printed
PISTON = 1.3345  # kg, with pin and rings
M_B = 0.356312  # kg: the rod's mass at the piston pin
INERTIA = 3.868e-3  # kg·m², which is m·a·b of the two masses
_ZERO = (0.0, 0.0, 0.0)
ROD = MassProperties(0.785 * KG, (64.0, 0.0, 0.0), (_ZERO, _ZERO, (0.0, 0.0, INERTIA * KG_M2)))

# Values used in the thesis.
M_RECIPROCATING = 1.690  # kg, PISTON + M_B truncated
_M_A_USED = 0.428  # kg: the rod's mass at the crank pin, 0.428687, truncated

# The tables of inertia forces and of forces at the pin, by speed.
INERTIA_FORCE = {rpm: f"leon2001_table{8 + i}_inertia_force_{rpm}rpm" for i, rpm in enumerate(SPEEDS)}
PIN_FORCES = {rpm: f"leon2001_table{13 + i}_forces_{rpm}rpm" for i, rpm in enumerate(SPEEDS)}


def engine(bore: float = BORE) -> Engine:
    """Return the printed engine, optionally with another bore (mm) for the sensitivity study."""
    return Engine(1e3 * R, 1e3 * L, bore, PISTON * KG, cylinders=4, phase=math.pi)


def terms(cells: PrintedColumn, rpm: int) -> tuple[Floats, Floats, Floats, Floats]:
    """The terms of F = F_gas − F_a − s (F_c + |F_αrod|), s the sign of the acceleration, N.

    F_gas is of table 7, F_a = 1.690 a and the sum of table 12; at 800 rpm the crank angle was added.
    """
    turn = np.mod(cells.degrees, 360).astype(int) // 10
    gas = printed("leon2001_table7_gas", f"F_{rpm}rpm_N")[: len(turn)]
    acceleration = printed(INERTIA_FORCE[rpm], "acceleration_m_s2")[turn]
    angular = printed("leon2001_table12_rod_angular_force", f"F_{rpm}rpm_N")[turn]
    centrifugal = _truncated(_M_A_USED * R * (rpm / 60) ** 2, 4)
    rest = np.sign(acceleration) * (centrifugal + np.abs(angular))
    return gas, M_RECIPROCATING * acceleration, rest, cells.degrees * (rpm == 800)


def beside(cells: PrintedColumn, rpm: int, title: str) -> Floats:
    """Figures of a column of tables 13–15 at the crank angles of the cells."""
    by_angle = {cell.key: float(cell.text) for cell in column(PIN_FORCES[rpm], title)}
    return np.array([by_angle[cell.key] for cell in cells])


def _truncated(value: float, places: int) -> float:
    # Decimal figures such as 201.16 are not exact in binary; a tiny increment keeps their last digit.
    scale = 10.0**places
    return math.trunc(value * scale * (1 + 1e-12)) / scale


def rounded_by_hand(total: PrintedColumn, rpm: int) -> dict[str, Slip]:
    """The intermediate figure that was rounded by hand, for the cells that it explains."""
    slips: dict[str, Slip] = {}
    columns = (term.tolist() for term in terms(total, rpm))
    for cell, gas, inertia, rest, angle in zip(total, *columns, strict=True):
        for slip in _roundings(gas + angle, inertia, rest):
            if abs((slip.value or 0.0) - float(cell.text)) <= cell.digit * (1 + 1e-6):
                slips.setdefault(cell.key, slip)
    return slips


def _roundings(force: float, inertia: float, rest: float) -> Iterator[Slip]:
    """Ways in which the sum may have been rounded or misread, the smallest rounding first."""
    cuts: dict[str, Callable[[float, int], float]] = {"rounded": round, "truncated": _truncated}
    for places in (3, 2, 1, 0):
        for how, cut in cuts.items():
            part, total = cut(inertia, places), cut(inertia + rest, places)
            yield Slip(f"F_a {how} to {part:.10g}", force - part - rest, is_rounding=True)
            yield Slip(f"sum of the inertia terms {how} to {total:.10g}", force - total, is_rounding=True)
    yield Slip(f"F_a = {inertia:.10g} read as 31990", force - 31990 - rest)


# Peaks at this size are within a few per cent of mesh-converged ones; the figures differ by factors.
_SIZE = 6.5  # mm


class LargestValues(NamedTuple):
    """Largest stresses, MPa, and displacement, mm, and least safety factor of a run."""

    von_mises: float
    principal: float
    moved: float
    safety: float

    @classmethod
    def of(cls, result: SpeedResult) -> "LargestValues":
        """Find them among all load cases."""
        cases = result.cases.values()
        return cls(
            max(float(case.von_mises.max()) for case in cases),
            max(float(case.principal[:, 0].max()) for case in cases),
            max(float(np.linalg.norm(case.displacement, axis=1).max()) for case in cases),
            min(float(case.safety_factor.min()) for case in cases),
        )


@cache
def clamped(*, bonded: bool = False, axial_only: bool = False) -> LargestValues:
    """Our rod under the published conditions: big end clamped, table 17's forces on the pin bore.

    `bonded` spreads the pin force over the whole bore, as other programs do with a force on a face.
    """
    study = replace(load_study("leon-2001-as-published"), mesh=MeshTable(size_mm=_SIZE))
    if bonded:
        study = replace(study, analysis=replace(study.analysis, pressure="bonded"))
    if axial_only:
        axial, _ = study.forces.pin() if study.forces else (0.0, 0.0)
        study = replace(study, forces=ForcesTable(pin_N=(axial, 0.0)))
    return LargestValues.of(solve_speed(prepare(study), None))


@cache
def balanced() -> dict[int, LargestValues]:
    """Our rod in balance with its own inertia, by speed, under prescribed pressure."""
    study = load_study(SOURCE)
    pressed = replace(study.analysis, pressure=PRESCRIBED)
    rod = prepare(replace(study, mesh=MeshTable(size_mm=_SIZE), analysis=pressed))
    return {rpm: LargestValues.of(solve_speed(rod, rpm)) for rpm in sorted(SPEEDS)}


# The rod as a column, by Euler as printed and by Johnson as its slenderness requires.
AREA, SECOND_MOMENT, LENGTH = 89.0, 1260.0, 141.0  # mm², mm⁴, mm
E, YIELD = 207e3, 220.0  # MPa, AISI 1018 as printed
SLENDERNESS = LENGTH / math.sqrt(SECOND_MOMENT / AREA)


def johnson(slenderness: float, strength: float = YIELD) -> float:
    """Johnson's critical load, N: A S_y (1 − S_y (KL/r)²/(4π² E)), for columns shorter than C_c."""
    return AREA * strength * (1 - strength * slenderness**2 / (4 * math.pi**2 * E))


STUDY = PublishedStudy(SOURCE, globals())
