"""León 2001, tables 1–17: the engine as printed, and its figures.

J. L. León, *Análisis por elemento finito en una biela de motor de combustión interna*, UNAM, 2001.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import numpy.typing as npt

from fea.base.units import BAR, DEG, KG, KG_M2, M_S, M_S2, RPM
from fea.study.traces import shipped_trace
from fea.verify.reproduce import leon_stress
from fea.verify.reproduce.printed import Column, Quantity, Slip, Table, cell, column, records, wrong_digit
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
ROD = MassProperties(
    mass=0.785 * KG,
    center=(64.0, 0.0, 0.0),
    inertia=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, INERTIA * KG_M2)),
)

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
_NUMBER = {rpm: 13 + i for i, rpm in enumerate(SPEEDS)}  # of the table of forces at the pin

_table = partial(Table.of, SOURCE)


def engine(bore: float = BORE) -> Engine:
    """Return the printed engine, optionally with another bore (mm) for the sensitivity study."""
    return Engine(
        crank_radius=1e3 * R,
        rod_length=1e3 * L,
        bore=bore,
        piston_mass=PISTON * KG,
        cylinders=4,
        phase=math.pi,
    )


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


def tables() -> list[Table]:
    """All tables in the order of the thesis."""
    return [
        _position(),
        _rod_angle(),
        _velocity(),
        *(_acceleration(str(4 + i), rpm) for i, rpm in enumerate(SPEEDS)),
        _gas(),
        *(_inertia_force(8 + i, rpm) for i, rpm in enumerate(SPEEDS)),
        _angular_acceleration(),
        _angle_series(),
        _angular_force(),
        *(_pin_forces(rpm) for rpm in SPEEDS),
        _pin_loads(),
        *leon_stress.tables(),
    ]


def _position() -> Table:
    cells = column("leon2001_table1_piston_position", "position_cm")
    theta, sine = cells.theta, _LAMBDA_POSITION * np.sin(cells.theta)
    printed = 100 * (R * (1 - np.cos(theta)) + L * (1 - np.sqrt(1 - sine**2)))
    exact = (1e3 * (L + R) - exact_motion(0, cells.degrees).piston_position) / 10
    zero = Slip("misprint: .0075 instead of .075 (one zero too many)", printed[0] / 10)
    slips = {"10": zero, "350": zero, "180": wrong_digit("9.44", 9.4)}
    cause = "λ = 0.141, the rod length in metres, instead of r/l = 1/3"
    return _table(
        "1",
        "piston position",
        [Quantity("piston position", "cm", cells, printed, exact, cause, slips=slips)],
        "Truncated, not rounded. At 90° the table has 4.84 cm, but the mechanism gives 5.506 cm.",
    )


def _rod_angle() -> Table:
    exact: dict[str, tuple[str, str, Callable[[Floats], Floats]]] = {
        "rod_deg": ("rod angle", "°", lambda theta: np.arcsin(LAMBDA * np.sin(theta)) / DEG),
        "x_cm": ("crank pin across", "cm", lambda theta: 100 * R * np.sin(theta)),
        "y_cm": ("crank pin along", "cm", lambda theta: 100 * R * np.cos(theta)),
    }
    quantities = []
    for title, (name, unit, figure) in exact.items():
        cells = column("leon2001_table2_rod_angle", title)
        signed = figure(cells.theta)
        quantities.append(Quantity(name, unit, cells, np.abs(signed), signed, "printed without its sign"))
    return _table("2", "rod angle and crank-pin position", quantities, "The signs are omitted.")


def _velocity() -> Table:
    cells = column("leon2001_table3_piston_velocity_6000rpm", "velocity_m_s")
    theta, sine = cells.theta, _LAMBDA_POSITION * np.sin(cells.theta)
    slope = R * np.sin(theta) + L * _LAMBDA_POSITION * sine * np.cos(theta) / np.sqrt(1 - sine**2)
    exact = -exact_motion(6000, cells.degrees).piston_velocity / M_S
    cause = "derivative of table 1 (λ = 0.141) with ω = 1000 rad/s, ten times n/60; 6000 rpm is 628.3 rad/s"
    return _table(
        "3",
        "piston velocity at 6000 rpm",
        [Quantity("piston velocity", "m/s", cells, _OMEGA_VELOCITY * slope, exact, cause)],
        "It is the exact derivative of table 1, not the two-term formula printed with it.",
        "At 90° it has 47 m/s, but the mechanism gives 29.5 m/s (31.1 m/s at most).",
    )


_ACCELERATION_REMARKS = {
    6000: ["At TDC it has 36 660 m/s², but the printed two-term formula gives 24 740 m/s²."],
    3000: ["Every cell is that of table 4 divided by four, including the misprints at 150° and 210°."],
    800: [],
}


def _acceleration(number: str, rpm: int) -> Table:
    """Tables 4–6: positive away from TDC."""
    cells = column(_ACCELERATION[rpm], "acceleration_m_s2")
    wave = np.cos(cells.theta) + _LAMBDA_ACCELERATION * np.cos(2 * cells.theta)
    printed = rpm**2 / 60 * R * wave
    cause = "ω² taken as n²/60 (n in rpm: only n was squared) and λ = 0.30"
    if rpm == 3000:
        # The table for 3000 rpm is the table for 6000 rpm divided by four, including its misprints.
        printed = column(_ACCELERATION[6000], "acceleration_m_s2").values / 4
        cause += "; table 4 divided by four"
    slips = {k: wrong_digit("-20191.0", -20191.9164) for k in ("150", "210")} if rpm == 6000 else {}
    exact = -exact_motion(rpm, cells.degrees).piston_acceleration / M_S2
    quantity = Quantity("piston acceleration", "m/s²", cells, printed, exact, cause, f"{rpm} rpm", slips)
    title = f"piston acceleration at {rpm} rpm"
    return _table(number, title, [quantity], *_ACCELERATION_REMARKS[rpm])


def _gas() -> Table:
    quantities = []
    cause = "piston area 5944 mm² (a bore of 87 mm) instead of 4536 mm² (76 mm)"
    for rpm in SPEEDS:
        titles = f"p_{rpm}rpm_bar", f"F_{rpm}rpm_N"
        pressure, force = (column("leon2001_table7_gas", title) for title in titles)
        trace = shipped_trace(SOURCE).pressure(pressure.theta, np.array(rpm * RPM))
        open_end = {
            c.key: Slip("the measured values at 0° and 720° differ; here that at 0° is used", float(c.text))
            for c in pressure
            if float(c.key) >= 720
        }
        bars, where = trace / BAR, f"{rpm} rpm"
        used, exact = _AREA_USED * pressure.values * BAR, trace * engine().piston_area
        quantities += [
            Quantity("gas pressure", "bar", pressure, bars, bars, where=where, slips=open_end),
            Quantity("gas force", "N", force, used, exact, cause, where),
        ]
    return _table(
        "7",
        "measured gas pressure and its force",
        quantities,
        "Two litres with 94 mm stroke need a bore of 82.3 mm; 76 mm gives 1.71 and 87 mm 2.24 litres.",
    )


def _inertia_force(number: int, rpm: int) -> Table:
    """Tables 8–10: acceleration of tables 4–6, and 1.690 kg times it."""
    acceleration, force = (column(_INERTIA_FORCE[rpm], title) for title in ("acceleration_m_s2", "F_N"))
    before = column(_ACCELERATION[rpm], "acceleration_m_s2").values
    exact = -exact_motion(rpm, acceleration.degrees).piston_acceleration / M_S2
    cause, where = f"acceleration of table {number - 4}", f"{rpm} rpm"
    used = _M_RECIPROCATING * acceleration.values
    digit = wrong_digit("-8279.170675", _M_RECIPROCATING * -4898.9175)
    misprints = rpm == 3000
    slips = {"130": digit, "230": digit} if misprints else {}
    remark = "At 130° and 230° one digit of the force is wrong (…175 × 1.690 ends in 575)."
    quantities = [
        Quantity("piston acceleration", "m/s²", acceleration, before, exact, cause, where),
        Quantity("inertia force", "N", force, used, (PISTON + M_B) * exact, cause, where, slips),
    ]
    title = f"inertia force of the reciprocating mass at {rpm} rpm"
    return _table(str(number), title, quantities, *[remark] * misprints)


def _angular_acceleration() -> Table:
    b1, b3, b5 = (float(record["value"]) for record in records("leon2001_angle_series"))
    cause = "ω = n/60 rev/s instead of 2πn/60 rad/s, too small by (2π)² = 39.5; series truncated after λ⁵"
    quantities = []
    for rpm in SPEEDS:
        cells = column("leon2001_table11_rod_angular_acceleration", f"alpha_{rpm}rpm")
        theta, exact = cells.theta, exact_motion(rpm, cells.degrees).rod_acceleration
        wave = b1 * np.sin(theta) + 9 * b3 * np.sin(3 * theta) + 25 * b5 * np.sin(5 * theta)
        series, name = -((rpm / 60) ** 2) * wave, "rod angular acceleration"
        quantities.append(Quantity(name, "rad/s²", cells, series, exact, cause, f"{rpm} rpm"))
    return _table("11", "angular acceleration of the rod", quantities)


def _angle_series() -> Table:
    """Coefficients of β = Σ bₙ sin nθ, to λ⁵: λ + λ³/8 + 3λ⁵/64, −(λ³/24 + 3λ⁵/128), 3λ⁵/640."""
    n, cut = 256, "series truncated after λ⁵"
    exact = -2 * np.fft.rfft(np.arcsin(LAMBDA * np.sin(2 * np.pi * np.arange(n) / n))).imag / n
    used = 0.333
    rounded = f"λ = 0.333 instead of 1/3; {cut}"
    fifth = {
        "b1": (LAMBDA + LAMBDA**3 / 8 + 3 * LAMBDA**5 / 64, exact[1], cut),
        "b3": (-(used**3 / 24 + 3 * used**5 / 128), exact[3], rounded),
        "b5": (3 * used**5 / 640, exact[5], rounded),
    }
    return _table(
        "11 (series)",
        "coefficients of the rod angle",
        [
            Quantity(f"coefficient {r['coefficient']}", "rad", cell(r["value"]), *fifth[r["coefficient"]])
            for r in records("leon2001_angle_series")
        ],
        "b₁ was computed with λ = 1/3, b₃ and b₅ with 0.333; 1/3 gives −1.6397e-3 and 19.29e-6.",
    )


def _angular_force() -> Table:
    """Table 12: F = I α / (l cos β) from table 11 and the angles of table 2."""
    name = "leon2001_table12_rod_angular_force"
    angles = column(name, "rod_deg")
    beta = column("leon2001_table2_rod_angle", "rod_deg").values
    exact_beta = np.arcsin(LAMBDA * np.sin(angles.theta)) / DEG
    misprint = {"110": wrong_digit("18.15", 18.25)}
    quantities = [
        Quantity("rod angle", "°", angles, beta, exact_beta, "printed without its sign", slips=misprint)
    ]
    misread, force = "62.61 was used instead of the 62.81 rad/s² of table 11", 62.61 * INERTIA
    force /= L * np.cos(19.47 * DEG)
    for rpm in SPEEDS:
        cells = column(name, f"F_{rpm}rpm_N")
        alpha = column("leon2001_table11_rod_angular_acceleration", f"alpha_{rpm}rpm").values
        motion = exact_motion(rpm, cells.degrees)
        printed = INERTIA * alpha / (L * np.cos(beta * DEG))
        exact = INERTIA * motion.rod_acceleration / (L * np.cos(motion.rod_angle))
        cause = "α of table 11, which is too small by (2π)²"
        slips = {"90": Slip(misread, -force), "270": Slip(misread, force)} if rpm == 800 else {}
        of_speed = f"{rpm} rpm", slips
        quantities.append(Quantity("rod angular force", "N", cells, printed, exact, cause, *of_speed))
    return _table(
        "12",
        "angular inertia force of the rod",
        quantities,
        "At 800 rpm, 90° and 270°, the force follows from 62.61 rad/s², but table 11 has 62.81.",
        "At 110° the angle is misprinted; the force was computed with 18.25°.",
        "It counts inertia twice: m_A and m_B already include I = m·a·b, and (I − m·a·b)·α = 0.",
    )


_PIN_TITLES = ("rod_deg", "F_resultant_N", "F_normal_N", "F_rod_N")
_PIN_REMARKS = {
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
_OUT_OF_PHASE = "rod angle 90° out of phase: asin(cos θ/3) instead of asin(sin θ/3)"
_RESULTANT_CAUSE = (
    "accelerations of tables 4–6; gas force on 5944 mm²; F_c + |F_α| added to the piston force, although "
    "they act on the crank pin or are counted twice"
)
_ROD_CAUSE = "√(F² − F_n²), unsigned, instead of F sec β (compression positive); resultant; normal force"


def _pin_forces(rpm: int) -> Table:
    """Tables 13–15: rod angle, resultant, normal and rod force."""
    angle, total, normal, along = (column(_PIN_FORCES[rpm], title) for title in _PIN_TITLES)
    exact = exact_forces(rpm, angle.degrees)
    gas, inertia, rest, slip = _terms(rpm, angle)
    tangent = np.tan(angle.values * _PI / 180)
    where, unsigned = f"{rpm} rpm", np.abs(total.values) * np.sqrt(1 - tangent**2)
    turned = np.arcsin(np.cos(angle.theta) / 3) / DEG
    normal_cause = f"{_OUT_OF_PHASE}; resultant; π = 3.1416"
    # The rod angle at 10° follows from the forces printed in the same row.
    used = math.atan(normal.values[1] / total.values[1]) * 180 / _PI
    misprint = Slip("misprint: 19.126 instead of 19.163, used in the forces of this row", used)
    digits = {"170": ("9279.692334", 9279.892334), "180": ("10072.679", 10072.673004)}
    rod_slips = {key: wrong_digit(*pair) for key, pair in digits.items()} if rpm == 3000 else {}
    by_hand = _rounded_by_hand(rpm, total)
    beta, sums = exact.motion.rod_angle / DEG, gas - inertia - rest + slip
    return _table(
        str(_NUMBER[rpm]),
        f"forces at the piston pin, {rpm} rpm",
        [
            Quantity("rod angle", "°", angle, turned, beta, _OUT_OF_PHASE, where, {"10": misprint}),
            Quantity("resultant", "N", total, sums, -along_cylinder(exact), _RESULTANT_CAUSE, where, by_hand),
            Quantity("normal force", "N", normal, total.values * tangent, exact.wall, normal_cause, where),
            Quantity("rod force", "N", along, unsigned, -exact.pin_axial, _ROD_CAUSE, where, rod_slips),
        ],
        *_PIN_REMARKS[rpm],
    )


def _terms(rpm: int, cells: Column) -> tuple[Floats, Floats, Floats, Floats]:
    """The terms of F = F_gas − F_a − s (F_c + |F_αrod|), s the sign of the acceleration, N.

    F_gas is of table 7, F_a = 1.690 a and the sum of table 12; at 800 rpm the crank angle was added.
    """
    turn = np.mod(cells.degrees, 360).astype(int) // 10
    gas = column("leon2001_table7_gas", f"F_{rpm}rpm_N").values[: len(turn)]
    acceleration = column(_INERTIA_FORCE[rpm], "acceleration_m_s2").values[turn]
    angular = column("leon2001_table12_rod_angular_force", f"F_{rpm}rpm_N").values[turn]
    centrifugal = _truncated(_M_A_USED * R * (rpm / 60) ** 2, 4)
    rest = np.sign(acceleration) * (centrifugal + np.abs(angular))
    return gas, _M_RECIPROCATING * acceleration, rest, cells.degrees * (rpm == 800)


def _truncated(value: float, places: int) -> float:
    # Decimal figures such as 201.16 are not exact in binary; a tiny increment keeps their last digit.
    scale = 10.0**places
    return math.trunc(value * scale * (1 + 1e-12)) / scale


def _rounded_by_hand(rpm: int, total: Column) -> dict[str, Slip]:
    """The intermediate figure that was rounded by hand, for the cells that it explains."""
    slips = {}
    for printed, *terms in zip(total, *(term.tolist() for term in _terms(rpm, total)), strict=True):
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


def _pin_loads() -> Table:
    """Table 17: the loads of the finite-element model, taken from tables 13–15."""
    quantities = []
    for record in records("leon2001_table17_pin_loads"):
        rpm, key = int(record["rpm"]), record["crank_deg"]
        exact, cause, where = exact_forces(rpm, float(key)), f"table {_NUMBER[rpm]}", f"{rpm} rpm"
        quantities.append(_critical_angle(rpm, key))
        forces = -along_cylinder(exact), np.abs(exact.wall), -exact.pin_axial
        corrected = exact.motion.rod_angle / DEG, *forces
        names = (("rod angle", "°"), ("resultant", "N"), ("normal force", "N"), ("rod force", "N"))
        for title, named, figure in zip(_PIN_TITLES, names, corrected, strict=True):
            beside = next(float(c.text) for c in column(_PIN_FORCES[rpm], title) if c.key == key)
            beside = beside if title == "rod_deg" else abs(beside)
            quantities.append(Quantity(*named, cell(record[title], key), beside, figure, cause, where))
    return _table(
        "17",
        "loads of the finite-element model",
        quantities,
        (
            "6000 rpm: 47 060.64 N is the largest *compression* of table 13; the largest force is the "
            "tension of 59 719.52 N at 0°."
        ),
        "3000 rpm: 460° is the third largest of table 14 (450° has 18 510.34 N, 470° 18 180.47 N).",
        "The normal force acts between piston and wall; on the pin bore of a clamped rod it is bending.",
    )


def _critical_angle(rpm: int, key: str) -> Quantity:
    """The crank angle of the largest force: as published, in the printed table, and in the exact cycle."""
    cells, table = column(_PIN_FORCES[rpm], "F_resultant_N"), f"table {_NUMBER[rpm]}"
    force = {cell.key: float(cell.text) for cell in cells}
    largest = max(force, key=lambda at: abs(force[at]))
    compression = "the largest compression, " if key == max(force, key=force.__getitem__) else ""
    text = f"the largest force of {table} is {force[largest]:.2f} N at {largest}°; used was {compression}"
    slip = Slip(f"{text}{force[key]:.2f} N", float(key))
    fine = np.arange(0, 720, 0.1)
    exact = fine[np.argmax(np.abs(exact_forces(rpm, fine).pin_axial))]
    name, where = "crank angle of the largest force", f"{rpm} rpm"
    return Quantity(name, "°", cell(key), float(largest), exact, table, where, {"": slip})
