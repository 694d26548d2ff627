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

from fea.analysis.prepare import prepare
from fea.analysis.speed import SpeedResult, solve_speed
from fea.judge.case_result import CaseResult
from fea.study.option_tables import ForcesTable, MeshTable
from fea.study.pin_models import PRESCRIBED
from fea.study.study import load_study
from fea.verify.reproduce.printed import Quantity, Slip, Table, cell, records, wrong_digit
from geometry.arrays import Floats

SOURCE = "leon-2001"
SPEEDS = (800.0, 3000.0, 6000.0)  # rpm
STRENGTH = 620.4  # MPa, of the stress model
# Peaks at this size are within a few per cent of mesh-converged ones; the figures differ by factors.
SIZE = 6.5  # mm

_DRAWING = Slip("no drawing is published; our rod has the printed length, mass, A and I")
_SIDEWAYS = "the wall force on the piston was applied to the clamped rod and bends it as a cantilever"
_CIRCULAR = "σ₃ was computed from the von Mises stress, so that the check is circular"

Extreme = Callable[[SpeedResult], float]


def _largest(field: Callable[[CaseResult], Floats]) -> Extreme:
    return lambda result: max(float(field(case).max()) for case in result.cases.values())


_largest_von_mises = _largest(lambda case: case.von_mises)
_largest_principal = _largest(lambda case: case.principal[:, 0])
_largest_displacement = _largest(lambda case: np.linalg.norm(case.displacement, axis=1))


def _least_safety(result: SpeedResult) -> float:
    return min(float(case.safety_factor.min()) for case in result.cases.values())


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
def _corrected() -> dict[float, SpeedResult]:
    """Our rod in balance with its own inertia, by speed, under prescribed pressure."""
    study = load_study("leon-2001")
    pressed = dataclasses.replace(study.analysis, pressure=PRESCRIBED)
    rod = prepare(dataclasses.replace(study, mesh=MeshTable(size_mm=SIZE), analysis=pressed))
    return {rpm: solve_speed(rod, rpm) for rpm in SPEEDS}


def tables() -> list[Table]:
    """Tables 21 (stresses), 22 (safety factors) and 23 (displacements), and the column check."""
    return [_stresses(), _safety(), _displacements(), _column()]


def _stresses() -> Table:
    printed = records("leon2001_table21_stresses_6000rpm")
    quantities = []
    for step, record in enumerate(printed, start=1):
        s1, s2, s3 = (float(record[f"s{axis}_MPa"]) for axis in (1, 2, 3))
        formed = math.sqrt(((s1 - s2) ** 2 + (s2 - s3) ** 2 + (s3 - s1) ** 2) / 2)
        text, slip = record["von_mises_MPa"], Slip("a principal stress was rounded", is_rounding=True)
        if float(text) < 0:
            slip = Slip("a von Mises stress cannot be negative: the lowest legend value was copied")
        name, where = "von Mises of σ₁, σ₂, σ₃", f"step {step}"
        quantities.append(Quantity(name, "MPa", cell(text), formed, formed, _CIRCULAR, where, {"": slip}))
    first = printed[0]
    quantities += _extreme("largest von Mises", "MPa", first["von_mises_MPa"], _largest_von_mises)
    quantities += _extreme("largest principal stress", "MPa", first["s1_MPa"], _largest_principal)
    bent, axial = _largest_von_mises(_as_published()), _largest_von_mises(_as_published(axial_only=True))
    alike, sound = _as_published(bonded=True), _corrected()[6000.0]
    return Table.of(
        SOURCE,
        "21",
        "stresses of the finite-element model",
        quantities,
        f"On a rod with the printed length, mass, A and I, the published conditions give {bent:.0f} MPa and "
        f"{_largest_displacement(_as_published()):.1f} mm, the axial force alone {axial:.0f} MPa: the "
        "transverse force causes most of both.",
        "That force acts between piston and wall; the pin transmits only what the rod's inertia needs.",
        f"Spread over the whole bore (--pressure bonded), the pin force gives "
        f"{_largest_von_mises(alike):.0f} MPa and {_largest_displacement(alike):.1f} mm: how the pin is "
        "modelled does not explain the difference.",
        f"In equilibrium with its inertia at 6000 rpm, the same rod has {_largest_von_mises(sound):.0f} MPa, "
        f"{_largest_displacement(sound):.2f} mm and a safety factor of {_least_safety(sound):.2f}.",
        "The thesis has less than our rod, which suggests a shank stiffer in bending than its A and I.",
        "σ₃ was computed from von Mises, so the table's check is circular; its last row is impossible.",
    )


def _safety() -> Table:
    printed = records("leon2001_table22_safety_6000rpm")
    least = _extreme("least safety factor", "1", printed[0]["safety_factor"], _least_safety)
    factors = [record["safety_factor"] for record in printed]
    return Table.of(SOURCE, "22", "safety factors of the finite-element model", [*_ratios(factors), *least])


def _displacements() -> Table:
    printed = records("leon2001_table23_displacement_safety")
    top = Slip("3 was added by hand to the legend of the plot, which ends at 2.245 mm")
    text = printed[0]["displacement_mm"]
    largest = _extreme("largest displacement", "mm", text, _largest_displacement, slip=top)
    return Table.of(
        SOURCE,
        "23",
        "displacements of the finite-element model",
        [*_ratios([record["safety_factor"] for record in printed]), *largest],
        "The legend has steps of .187 mm and ends at 2.245 mm: 3 was added by hand, a step is missing.",
    )


def _ratios(factors: list[str]) -> list[Quantity]:
    """Printed safety factors against those of the printed stresses of table 22."""
    stresses = [float(record["von_mises_MPa"]) for record in records("leon2001_table22_safety_6000rpm")]
    negative = {"": Slip("computed from a negative von Mises stress")}
    return [
        Quantity(
            *("safety factor", "1", cell(text), STRENGTH / stress, STRENGTH / stress),
            where=f"step {step}",
            slips=negative if stress < 0 else {},
        )
        for step, (text, stress) in enumerate(zip(factors, stresses, strict=True), start=1)
    ]


def _extreme(name: str, unit: str, text: str, of: Extreme, *, slip: Slip = _DRAWING) -> list[Quantity]:
    """The printed extreme against ours with the published conditions, and ours in equilibrium by speed."""
    sound = {rpm: of(result) for rpm, result in _corrected().items()}
    ours = of(_as_published())
    return [
        Quantity(name, unit, cell(text), ours, sound[6000.0], _SIDEWAYS, "6000 rpm", {"": slip}),
        *(
            Quantity(name, unit, cell(""), math.nan, sound[rpm], "not printed", f"{rpm:g} rpm")
            for rpm in SPEEDS[:-1]
        ),
    ]


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


def _column() -> Table:
    euler, load = math.pi**2 * E * AREA / 37.44**2, johnson(SLENDERNESS)
    cause = "Euler's formula was used, although KL/r is below C_c and Johnson's formula governs"
    both: dict[str, tuple[float, float, str]] = {
        "radius of gyration": (_GYRATION / 10, _GYRATION / 10, ""),
        "slenderness KL/r": (LENGTH / _RADIUS_PRINTED, SLENDERNESS, "r = .3766 cm instead of .3763"),
        "transition slenderness Cc": (_TRANSITION, _TRANSITION, ""),
        "critical load": (euler, load, cause),
        "allowable load N = 6": (euler / 6, load / 6, cause),
        "allowable load N = 4": (euler / 4, load / 4, cause),
    }
    slips = {"radius of gyration": {"": wrong_digit("0.3766", _GYRATION / 10)}}
    depth = math.sqrt(12 * SECOND_MOMENT / AREA)
    width = AREA / depth
    weak, strongest = LENGTH / (width / math.sqrt(12)), johnson(SLENDERNESS, STRENGTH)
    return Table.of(
        SOURCE,
        "column",
        "the rod as a column",
        [
            Quantity(name, r["unit"], cell(r["value"]), *both[name], slips=slips.get(name, {}))
            for r in records("leon2001_column")
            for name in (r["quantity"],)
        ],
        f"KL/r = {SLENDERNESS:.1f} is far below C_c = {_TRANSITION:.0f}: Johnson's formula governs.",
        f"It gives {load / 1e3:.1f} kN with the printed yield, {strongest / 1e3:.1f} kN with that of the "
        "stress model.",
        "The load of table 17, 45.9 kN, exceeds the former and both printed allowables (21.6 and 32.4 kN).",
        f"A and I are those of a rectangle of {width:.2f} × {depth:.2f} mm about its strong axis.",
        f"About the weak axis, KL/r = {weak:.1f}.",
    )
