"""León 2001, tables 13–15: forces at the piston pin."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from fea.units import DEG
from fea.verify.reproduce.leon_engine import (
    M_A_USED,
    M_RECIPROCATING,
    SOURCE,
    SPEEDS,
    R,
    along_cylinder,
    exact_forces,
)
from fea.verify.reproduce.misprint import wrong_digit
from fea.verify.reproduce.printed import Cell, column, degrees, values
from fea.verify.reproduce.row import Slip
from fea.verify.reproduce.table import Column, Table, table
from geometry.arrays import Floats

TABLES = {6000: 13, 3000: 14, 800: 15}
_INERTIATABLES = {6000: 8, 3000: 9, 800: 10}
_PI = 3.1416  # the value used for the tangents, which explains relative errors of 2.5e-6 at 19.47°

_RESULTANT_CAUSE = (
    "accelerations of tables 4–6; gas force on 5944 mm²; F_c + |F_α| added to the piston force, although "
    "they act on the crank pin or are counted twice"
)


def tables() -> list[Table]:
    """Tables 13–15."""
    return [pin_forces(rpm) for rpm in SPEEDS]


def pin_forces(rpm: int) -> Table:
    """Tables 13–15: rod angle, resultant, normal and rod force."""
    name = f"leon2001_table{TABLES[rpm]}_forces_{rpm}rpm"
    angle, total, normal, along = (
        column(name, title) for title in ("rod_deg", "F_resultant_N", "F_normal_N", "F_rod_N")
    )
    theta = degrees(angle) * DEG
    exact = exact_forces(rpm, degrees(angle))
    summed = _resultant_as_published(rpm, angle)
    tangent = np.tan(values(angle) * _PI / 180)
    speed = f"{rpm} rpm"
    out_of_phase = "rod angle 90° out of phase: asin(cos θ/3) instead of asin(sin θ/3)"
    return table(
        SOURCE,
        str(TABLES[rpm]),
        f"forces at the piston pin, {rpm} rpm",
        [
            Column(
                quantity="rod angle",
                unit="°",
                cells=angle,
                as_published=np.arcsin(np.cos(theta) / 3) / DEG,
                corrected=exact.motion.rod_angle / DEG,
                cause=out_of_phase,
                speed=speed,
                slips={"10": _angle_used(total, normal)},
            ),
            Column(
                quantity="resultant",
                unit="N",
                cells=total,
                as_published=summed,
                corrected=-along_cylinder(exact),
                cause=_RESULTANT_CAUSE,
                speed=speed,
                slips=_resultant_slips(rpm, total),
            ),
            Column(
                quantity="normal force",
                unit="N",
                cells=normal,
                as_published=values(total) * tangent,
                corrected=exact.wall,
                cause=f"{out_of_phase}; resultant; π = 3.1416",
                speed=speed,
            ),
            Column(
                quantity="rod force",
                unit="N",
                cells=along,
                as_published=np.abs(values(total)) * np.sqrt(1 - tangent**2),
                corrected=-exact.pin_axial,
                cause="√(F² − F_n²), unsigned, instead of F sec β (compression positive); resultant; "
                "normal force",
                speed=speed,
                slips=_rod_slips(rpm),
            ),
        ],
        _REMARKS[rpm],
    )


_REMARKS = {
    6000: (
        "Tables 13–15: the tangents of the angles were computed with π = 3.1416.",
        "Tables 13–15: at 10° the rod angle is 19.126 instead of 19.163, and the forces of the row use it.",
        "F_a, or the sum of the inertia terms, was rounded or truncated by hand in some of the rows.",
        "At 320° and 680° the inertia force 38 990.85 was read as 31 990, 7001 N too little.",
    ),
    3000: (
        "The sums use 1.690·a, not the misprinted forces of table 9 at 130° and 230°.",
        "One digit of the rod force is wrong at 170° and one at 180°.",
    ),
    800: ("The crank angle in degrees was added to the sum: one newton too much per degree.",),
}


def _resultant_as_published(rpm: int, cells: list[Cell]) -> Floats:
    """F = F_gas − F_a − s (F_c + |F_αrod|), s the sign of the acceleration; 800 rpm adds the crank angle."""
    force_gas, inertia, rest = _terms(rpm, cells)
    slip = degrees(cells) if rpm == 800 else np.zeros(len(cells))
    return np.asarray(force_gas - inertia - rest + slip, dtype=np.float64)


def _terms(rpm: int, cells: list[Cell]) -> tuple[Floats, Floats, Floats]:
    """F_gas of table 7, F_a = 1.690 a, and s (F_c + |F_αrod|) of table 12, N."""
    turn = np.mod(degrees(cells), 360).astype(int) // 10
    force_gas = values(column("leon2001_table7_gas", f"F_{rpm}rpm_N"))[: len(cells)]
    name = f"leon2001_table{_INERTIATABLES[rpm]}_inertia_force_{rpm}rpm"
    acceleration = values(column(name, "acceleration_m_s2"))[turn]
    angular = values(column("leon2001_table12_rod_angular_force", f"F_{rpm}rpm_N"))[turn]
    centrifugal = _truncated(M_A_USED * R * (rpm / 60) ** 2, 4)
    return force_gas, M_RECIPROCATING * acceleration, np.sign(acceleration) * (centrifugal + np.abs(angular))


def _truncated(value: float, places: int) -> float:
    """Truncate to a number of decimals."""
    # Decimal figures such as 201.16 are not exact in binary; a tiny increment keeps their last digit.
    scale = 10.0**places
    return math.trunc(value * scale * (1 + 1e-12)) / scale


def _resultant_slips(rpm: int, cells: list[Cell]) -> dict[str, Slip]:
    """The intermediate figure that was rounded by hand, for the cells that it explains."""
    slips = {}
    slip = degrees(cells) if rpm == 800 else np.zeros(len(cells))
    for cell, *terms in zip(cells, *_terms(rpm, cells), slip, strict=True):
        gas_force, inertia, rest, angle = (float(term) for term in terms)
        candidates = _by_hand(gas_force + angle, inertia, rest)
        found = next((s for s in candidates if s.value is not None and _same(s.value, cell)), None)
        if found is not None:
            slips[cell.key] = found
    return slips


def _by_hand(force: float, inertia: float, rest: float) -> Iterator[Slip]:
    """Ways in which the sum may have been rounded or misread, the smallest rounding first."""
    cuts: dict[str, Callable[[float, int], float]] = {"rounded": round, "truncated": _truncated}
    for places in (3, 2, 1, 0):
        for how, cut in cuts.items():
            part, total = cut(inertia, places), cut(inertia + rest, places)
            yield Slip(f"F_a {how} to {part:.10g}", force - part - rest, is_rounding=True)
            yield Slip(f"sum of the inertia terms {how} to {total:.10g}", force - total, is_rounding=True)
    yield Slip(f"F_a = {inertia:.10g} read as 31990", force - 31990 - rest)


def _same(value: float, cell: Cell) -> bool:
    return abs(value - cell.value) <= cell.digit * (1 + 1e-6)


def _angle_used(total: list[Cell], normal: list[Cell]) -> Slip:
    """Compute the rod angle at 10° from the forces printed in the same row."""
    tangent = normal[1].value / total[1].value
    text = "misprint: 19.126 instead of 19.163, used in the forces of this row"
    return Slip(text, math.atan(tangent) * 180 / _PI)


def _rod_slips(rpm: int) -> dict[str, Slip]:
    if rpm != 3000:
        return {}
    return {
        "170": wrong_digit("9279.692334", 9279.892334),
        "180": wrong_digit("10072.679", 10072.673004),
    }
