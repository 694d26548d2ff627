"""León 2001, tables 1–17: the engine as printed, and its figures.

J. L. León, *Análisis por elemento finito en una biela de motor de combustión interna*, UNAM, 2001.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from fea.base.units import BAR, DEG, KG, KG_M2, M_S, M_S2, RPM
from fea.study.traces import shipped_trace
from fea.verify.reproduce import leon_stress
from fea.verify.reproduce.printed import Column, Slip, column, records
from fea.verify.reproduce.published import Formula, PublishedStudy
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import EngineInstants, cycle
from loads.engine import Engine
from loads.slider_crank import Kinematics, kinematics

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
_M_RECIPROCATING = 1.690  # kg, PISTON + M_B truncated
_M_A_USED = 0.428  # kg: the rod's mass at the crank pin, 0.428687, truncated
_AREA_USED = 5944.0  # mm²: a bore of 87 mm
_LAMBDA_POSITION = 0.141  # the rod length in metres
_LAMBDA_ACCELERATION = 0.30
_OMEGA_VELOCITY = 1000.0  # ten times n/60
_PI = 3.1416  # the value used for the tangents, which explains relative errors of 2.5e-6 at 19.47°

# The tables of accelerations, of inertia forces and of forces at the pin, by speed.
_ACCELERATION = {rpm: f"leon2001_table{4 + i}_piston_acceleration_{rpm}rpm" for i, rpm in enumerate(SPEEDS)}
_INERTIA_FORCE = {rpm: f"leon2001_table{8 + i}_inertia_force_{rpm}rpm" for i, rpm in enumerate(SPEEDS)}
_PIN_FORCES = {rpm: f"leon2001_table{13 + i}_forces_{rpm}rpm" for i, rpm in enumerate(SPEEDS)}


def engine(bore: float = BORE) -> Engine:
    """Return the printed engine, optionally with another bore (mm) for the sensitivity study."""
    return Engine(1e3 * R, 1e3 * L, bore, PISTON * KG, cylinders=4, phase=math.pi)


def exact_motion(rpm: float, degrees: npt.ArrayLike) -> Kinematics:
    """Kinematics of the mechanism at crank angles in degrees."""
    return kinematics(engine(), np.asarray(degrees, dtype=np.float64) * DEG, rpm * RPM)


def exact_forces(rpm: float, degrees: npt.ArrayLike) -> EngineInstants:
    """Forces with the measured gas pressure at crank angles in degrees."""
    angles = np.asarray(degrees, dtype=np.float64) * DEG
    return cycle(engine(), ROD, shipped_trace(SOURCE), rpm * RPM, angles)


def along_cylinder(instants: EngineInstants) -> Floats:
    """Force on the rod at the piston pin along the cylinder, N."""
    return instants.in_engine_axes(instants.pin).x


def _position(cells: Column, _: int) -> Floats:
    sine = _LAMBDA_POSITION * np.sin(cells.theta)
    return np.asarray(100 * (R * (1 - np.cos(cells.theta)) + L * (1 - np.sqrt(1 - sine**2))))


def _velocity(cells: Column, _: int) -> Floats:
    """The derivative of `_position`."""
    sine = _LAMBDA_POSITION * np.sin(cells.theta)
    slope = L * _LAMBDA_POSITION * sine * np.cos(cells.theta) / np.sqrt(1 - sine**2)
    return np.asarray(_OMEGA_VELOCITY * (R * np.sin(cells.theta) + slope))


def _acceleration(cells: Column, rpm: int) -> Floats:
    if rpm == 3000:
        # The table for 3000 rpm is the table for 6000 rpm divided by four, including its misprints.
        return column(_ACCELERATION[6000], "acceleration_m_s2").values / 4
    wave = np.cos(cells.theta) + _LAMBDA_ACCELERATION * np.cos(2 * cells.theta)
    return np.asarray(rpm**2 / 60 * R * wave)


def _exact_acceleration(cells: Column, rpm: int) -> Floats:
    return -exact_motion(rpm, cells.degrees).piston_acceleration / M_S2


def _trace(cells: Column, rpm: int) -> Floats:
    return shipped_trace(SOURCE).pressure(cells.theta, np.array(rpm * RPM))


def _accelerations(rpm: int) -> Floats:
    """As printed beside the inertia forces."""
    return column(_INERTIA_FORCE[rpm], "acceleration_m_s2").values


def _series(cells: Column, rpm: int) -> Floats:
    b1, b3, b5 = (float(record["value"]) for record in records("leon2001_angle_series"))
    theta = cells.theta
    wave = b1 * np.sin(theta) + 9 * b3 * np.sin(3 * theta) + 25 * b5 * np.sin(5 * theta)
    return np.asarray(-((rpm / 60) ** 2) * wave)


def _coefficient(n: int) -> float:
    """The exact coefficient of β = Σ bₙ sin nθ."""
    count = 256
    theta = 2 * np.pi * np.arange(count) / count
    return float(-2 * np.fft.rfft(np.arcsin(LAMBDA * np.sin(theta))).imag[n] / count)


def _angular_force(_: Column, rpm: int) -> Floats:
    """F = I α / (l cos β) from table 11 and the angles of table 2."""
    alpha = column("leon2001_table11_rod_angular_acceleration", f"alpha_{rpm}rpm").values
    beta = column("leon2001_table2_rod_angle", "rod_deg").values
    return np.asarray(INERTIA * alpha / (L * np.cos(beta * DEG)))


def _exact_angular_force(cells: Column, rpm: int) -> Floats:
    motion = exact_motion(rpm, cells.degrees)
    return np.asarray(INERTIA * motion.rod_acceleration / (L * np.cos(motion.rod_angle)))


def _terms(cells: Column, rpm: int) -> tuple[Floats, Floats, Floats, Floats]:
    """The terms of F = F_gas − F_a − s (F_c + |F_αrod|), s the sign of the acceleration, N.

    F_gas is of table 7, F_a = 1.690 a and the sum of table 12; at 800 rpm the crank angle was added.
    """
    turn = np.mod(cells.degrees, 360).astype(int) // 10
    gas = column("leon2001_table7_gas", f"F_{rpm}rpm_N").values[: len(turn)]
    acceleration = _accelerations(rpm)[turn]
    angular = column("leon2001_table12_rod_angular_force", f"F_{rpm}rpm_N").values[turn]
    centrifugal = _truncated(_M_A_USED * R * (rpm / 60) ** 2, 4)
    rest = np.sign(acceleration) * (centrifugal + np.abs(angular))
    return gas, _M_RECIPROCATING * acceleration, rest, cells.degrees * (rpm == 800)


def _resultant(cells: Column, rpm: int) -> Floats:
    gas, inertia, rest, added = _terms(cells, rpm)
    return gas - inertia - rest + added


def _of_pin(rpm: int, title: str) -> Floats:
    """A column of tables 13–15 as printed."""
    return column(_PIN_FORCES[rpm], title).values


def _tangent(rpm: int) -> Floats:
    return np.asarray(np.tan(_of_pin(rpm, "rod_deg") * _PI / 180))


def _beside(title: str) -> Formula:
    """Figures of a column of tables 13–15 at the crank angles of the cells."""

    def printed(cells: Column, rpm: int) -> Floats:
        by_angle = {cell.key: float(cell.text) for cell in column(_PIN_FORCES[rpm], title)}
        return np.array([by_angle[cell.key] for cell in cells])

    return printed


def _largest_at(_: Column, rpm: int) -> float:
    forces = column(_PIN_FORCES[rpm], "F_resultant_N")
    return float(forces.degrees[np.abs(forces.values).argmax()])


def _exact_largest_at(_: Column, rpm: int) -> float:
    fine = np.arange(0, 720, 0.1)
    return float(fine[np.argmax(np.abs(exact_forces(rpm, fine).pin_axial))])


def _truncated(value: float, places: int) -> float:
    # Decimal figures such as 201.16 are not exact in binary; a tiny increment keeps their last digit.
    scale = 10.0**places
    return math.trunc(value * scale * (1 + 1e-12)) / scale


def _rounded_by_hand(total: Column, rpm: int) -> dict[str, Slip]:
    """The intermediate figure that was rounded by hand, for the cells that it explains."""
    slips = {}
    for printed, *terms in zip(total, *(term.tolist() for term in _terms(total, rpm)), strict=True):
        gas, inertia, rest, angle = terms
        reach = printed.digit * (1 + 1e-6)
        ways = (
            slip
            for slip in _roundings(gas + angle, inertia, rest)
            if abs((slip.value or 0.0) - float(printed.text)) <= reach
        )
        if slip := next(ways, None):
            slips[printed.key] = slip
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


_OF_PINS = ("rod_deg", "F_resultant_N", "F_normal_N", "F_rod_N")
_USED = 0.333  # λ in the coefficients b₃ and b₅ of the series
_FORMULAS: dict[str, Formula] = {
    "printed": lambda cells, _: cells.values,
    "position, λ = l": _position,
    "tenth of the position, λ = l": lambda cells, _: _position(cells, 0) / 10,
    "piston position": lambda cells, _: (1e3 * (L + R) - exact_motion(0, cells.degrees).piston_position) / 10,
    "rod angle": lambda cells, _: np.arcsin(LAMBDA * np.sin(cells.theta)) / DEG,
    "crank pin across": lambda cells, _: 100 * R * np.sin(cells.theta),
    "crank pin along": lambda cells, _: 100 * R * np.cos(cells.theta),
    "derivative of the position": _velocity,
    "piston velocity": lambda cells, rpm: -exact_motion(rpm, cells.degrees).piston_velocity / M_S,
    "acceleration, ω² = n²/60": _acceleration,
    "piston acceleration": _exact_acceleration,
    "gas pressure": lambda cells, rpm: _trace(cells, rpm) / BAR,
    "gas force": lambda cells, rpm: _trace(cells, rpm) * engine().piston_area,
    "gas force on 5944 mm²": lambda _, rpm: (
        _AREA_USED * column("leon2001_table7_gas", f"p_{rpm}rpm_bar").values * BAR
    ),
    "acceleration of tables 4–6": lambda _, rpm: column(_ACCELERATION[rpm], "acceleration_m_s2").values,
    "1.690 times the acceleration": lambda _, rpm: _M_RECIPROCATING * _accelerations(rpm),
    "inertia force": lambda cells, rpm: (PISTON + M_B) * _exact_acceleration(cells, rpm),
    "series of the rod's angular acceleration": _series,
    "rod angular acceleration": lambda cells, rpm: exact_motion(rpm, cells.degrees).rod_acceleration,
    # β = Σ bₙ sin nθ to λ⁵: λ + λ³/8 + 3λ⁵/64, −(λ³/24 + 3λ⁵/128), 3λ⁵/640.
    "b1 to λ⁵": lambda *_: LAMBDA + LAMBDA**3 / 8 + 3 * LAMBDA**5 / 64,
    "b3 to λ⁵": lambda *_: -(_USED**3 / 24 + 3 * _USED**5 / 128),
    "b5 to λ⁵": lambda *_: 3 * _USED**5 / 640,
    "b1": lambda *_: _coefficient(1),
    "b3": lambda *_: _coefficient(3),
    "b5": lambda *_: _coefficient(5),
    "rod angle of table 2": lambda *_: column("leon2001_table2_rod_angle", "rod_deg").values,
    "angular force of tables 2 and 11": _angular_force,
    "rod angular force": _exact_angular_force,
    "angular force from 62.61 rad/s²": lambda cells, _: (
        -np.sign(np.sin(cells.theta)) * 62.61 * INERTIA / (L * np.cos(19.47 * DEG))
    ),
    "rod angle out of phase": lambda cells, _: np.arcsin(np.cos(cells.theta) / 3) / DEG,
    "rod angle from the forces": lambda _, rpm: (
        np.arctan(_of_pin(rpm, "F_normal_N") / _of_pin(rpm, "F_resultant_N")) * 180 / _PI
    ),
    "sum of the forces": _resultant,
    "resultant": lambda cells, rpm: -along_cylinder(exact_forces(rpm, cells.degrees)),
    "resultant times the tangent": lambda _, rpm: _of_pin(rpm, "F_resultant_N") * _tangent(rpm),
    "normal force": lambda cells, rpm: exact_forces(rpm, cells.degrees).wall,
    "√(F² − F_n²)": lambda _, rpm: np.abs(_of_pin(rpm, "F_resultant_N")) * np.sqrt(1 - _tangent(rpm) ** 2),
    "rod force": lambda cells, rpm: -exact_forces(rpm, cells.degrees).pin_axial,
    "angle of the largest printed force": _largest_at,
    "angle of the largest force": _exact_largest_at,
    **{f"{title} of tables 13–15": _beside(title) for title in _OF_PINS},
}
STUDY = PublishedStudy(
    SOURCE,
    _FORMULAS | leon_stress.FORMULAS,
    {"forces_table": lambda rpm: 13 + SPEEDS.index(rpm)} | leon_stress.FACTS,
    {"rounded by hand": _rounded_by_hand},
)
