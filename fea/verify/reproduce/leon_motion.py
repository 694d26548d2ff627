"""León 2001, tables 1–6 and 11: position, rod angle, velocity, acceleration, angular acceleration."""

import numpy as np

from fea.units import DEG, M_S, M_S2
from fea.verify.reproduce.leon_engine import LAMBDA, SOURCE, SPEEDS, L, R, exact_motion
from fea.verify.reproduce.misprint import wrong_digit
from fea.verify.reproduce.printed import Cell, column, degrees, records, values
from fea.verify.reproduce.row import Row, Slip
from fea.verify.reproduce.table import Column, Table, table
from geometry.arrays import Floats

_LAMBDA_SLIP = 0.141  # the rod length in metres
_LAMBDA_ACCELERATION = 0.30
_OMEGA_VELOCITY = 1000.0  # ten times n/60


def tables() -> list[Table]:
    """Tables 1–6 and 11, and the series coefficients of the last."""
    return [
        position(),
        rod_angle(),
        velocity(),
        *(acceleration(number, rpm) for number, rpm in zip((4, 5, 6), SPEEDS, strict=True)),
        angle_series(),
        angular_acceleration(),
    ]


def position() -> Table:
    """Table 1: piston position from TDC."""
    cells = column("leon2001_table1_piston_position", "position_cm")
    theta = degrees(cells) * DEG
    sine = _LAMBDA_SLIP * np.sin(theta)
    as_published = 100 * (R * (1 - np.cos(theta)) + L * (1 - np.sqrt(1 - sine**2)))
    zero_too_many = Slip("misprint: .0075 instead of .075 (one zero too many)", as_published[0] / 10)
    slips = {
        "10": zero_too_many,
        "350": zero_too_many,
        "180": wrong_digit("9.44", 9.4),
    }
    cause = "λ = 0.141, the rod length in metres, instead of r/l = 1/3"
    exact = (1e3 * (L + R) - exact_motion(0, degrees(cells)).piston_position) / 10
    return table(
        SOURCE,
        "1",
        "piston position",
        [
            Column(
                quantity="piston position",
                unit="cm",
                cells=cells,
                as_published=as_published,
                corrected=exact,
                cause=cause,
                slips=slips,
            )
        ],
        ["Truncated, not rounded. At 90° the table has 4.84 cm, but the mechanism gives 5.506 cm."],
    )


def rod_angle() -> Table:
    """Table 2: rod angle and crank-pin coordinates, all without their signs."""
    name = "leon2001_table2_rod_angle"
    cells = {title: column(name, title) for title in ("rod_deg", "x_cm", "y_cm")}
    theta = degrees(cells["rod_deg"]) * DEG
    exact = {
        "rod_deg": np.arcsin(LAMBDA * np.sin(theta)) / DEG,
        "x_cm": 100 * R * np.sin(theta),
        "y_cm": 100 * R * np.cos(theta),
    }
    words = {
        "rod_deg": ("rod angle", "°"),
        "x_cm": ("crank pin across", "cm"),
        "y_cm": ("crank pin along", "cm"),
    }
    cause = "printed without its sign"
    columns = [
        Column(
            *words[key], cells=cells[key], as_published=np.abs(exact[key]), corrected=exact[key], cause=cause
        )
        for key in cells
    ]
    return table(SOURCE, "2", "rod angle and crank-pin position", columns, ["The signs are omitted."])


def velocity() -> Table:
    """Table 3: piston velocity at 6000 rpm, positive away from TDC."""
    cells = column("leon2001_table3_piston_velocity_6000rpm", "velocity_m_s")
    theta = degrees(cells) * DEG
    sine = _LAMBDA_SLIP * np.sin(theta)
    slope = R * np.sin(theta) + L * _LAMBDA_SLIP * sine * np.cos(theta) / np.sqrt(1 - sine**2)
    cause = "derivative of table 1 (λ = 0.141) with ω = 1000 rad/s, ten times n/60; 6000 rpm is 628.3 rad/s"
    exact = -exact_motion(6000, degrees(cells)).piston_velocity / M_S
    return table(
        SOURCE,
        "3",
        "piston velocity at 6000 rpm",
        [
            Column(
                quantity="piston velocity",
                unit="m/s",
                cells=cells,
                as_published=_OMEGA_VELOCITY * slope,
                corrected=exact,
                cause=cause,
            )
        ],
        [
            "It is the exact derivative of table 1, not the two-term formula printed with it.",
            "At 90° it has 47 m/s, but the mechanism gives 29.5 m/s (31.1 m/s at most).",
        ],
    )


def acceleration(number: int, rpm: int) -> Table:
    """Tables 4–6: piston acceleration, positive away from TDC."""
    cells = column(f"leon2001_table{number}_piston_acceleration_{rpm}rpm", "acceleration_m_s2")
    cause = "ω² taken as n²/60 (n in rpm: only n was squared) and λ = 0.30"
    if rpm == 3000:
        # The table for 3000 rpm is the table for 6000 rpm divided by four, including its misprints.
        as_published = values(column("leon2001_table4_piston_acceleration_6000rpm", "acceleration_m_s2")) / 4
        cause += "; table 4 divided by four"
    else:
        as_published = _acceleration_as_published(rpm, degrees(cells) * DEG)
    slips = {k: wrong_digit("-20191.0", -20191.9164) for k in ("150", "210")} if rpm == 6000 else {}
    exact = -exact_motion(rpm, degrees(cells)).piston_acceleration / M_S2
    remarks = {
        6000: ["At TDC it has 36 660 m/s², but the printed two-term formula gives 24 740 m/s²."],
        3000: ["Every cell is that of table 4 divided by four, including the misprints at 150° and 210°."],
        800: [],
    }
    return table(
        SOURCE,
        str(number),
        f"piston acceleration at {rpm} rpm",
        [
            Column(
                quantity="piston acceleration",
                unit="m/s²",
                cells=cells,
                as_published=as_published,
                corrected=exact,
                cause=cause,
                speed=f"{rpm} rpm",
                slips=slips,
            )
        ],
        remarks[rpm],
    )


def _acceleration_as_published(rpm: float, theta: Floats) -> Floats:
    wave = np.cos(theta) + _LAMBDA_ACCELERATION * np.cos(2 * theta)
    return np.asarray(rpm**2 / 60 * R * wave, dtype=np.float64)


def angle_series() -> Table:
    """Coefficients of β = Σ bₙ sin nθ, to λ⁵: λ + λ³/8 + 3λ⁵/64, −(λ³/24 + 3λ⁵/128), 3λ⁵/640."""
    fifth = {
        "b1": lambda x: x + x**3 / 8 + 3 * x**5 / 64,
        "b3": lambda x: -(x**3 / 24 + 3 * x**5 / 128),
        "b5": lambda x: 3 * x**5 / 640,
    }
    used = {"b1": LAMBDA, "b3": 0.333, "b5": 0.333}
    exact = dict(zip(fifth, _sine_series()[[1, 3, 5]], strict=True))
    rows = []
    for record in records("leon2001_angle_series"):
        name, text = record["coefficient"], record["value"]
        series = "series truncated after λ⁵"
        cause = series if used[name] == LAMBDA else f"λ = 0.333 instead of 1/3; {series}"
        rows.append(
            Row(
                source=SOURCE,
                table="11 (series)",
                quantity=f"coefficient {name}",
                at="",
                unit="rad",
                published=float(text),
                digit=10.0 ** -len(text.partition(".")[2]),
                as_published=fifth[name](used[name]),
                corrected=float(exact[name]),
                formula_cause=cause,
            )
        )
    return Table(
        SOURCE,
        "11 (series)",
        "coefficients of the rod angle",
        tuple(rows),
        ("b₁ was computed with λ = 1/3, b₃ and b₅ with 0.333; 1/3 gives −1.6397e-3 and 19.29e-6.",),
    )


def _sine_series() -> Floats:
    """Sine coefficients of asin(λ sin θ), to rounding."""
    n = 256
    samples = np.arcsin(LAMBDA * np.sin(2 * np.pi * np.arange(n) / n))
    return np.asarray(-2 * np.fft.rfft(samples).imag / n, dtype=np.float64)


def angular_acceleration() -> Table:
    """Table 11: angular acceleration of the rod."""
    columns = []
    for rpm in SPEEDS:
        cells = column("leon2001_table11_rod_angular_acceleration", f"alpha_{rpm}rpm")
        exact = exact_motion(rpm, degrees(cells)).rod_acceleration
        cause = "ω = n/60 rev/s instead of 2πn/60 rad/s, too small by (2π)² = 39.5; series truncated after λ⁵"
        series = _angular_acceleration_as_published(rpm, cells)
        columns.append(
            Column(
                quantity="rod angular acceleration",
                unit="rad/s²",
                cells=cells,
                as_published=series,
                corrected=exact,
                cause=cause,
                speed=f"{rpm} rpm",
            )
        )
    return table(SOURCE, "11", "angular acceleration of the rod", columns)


def _angular_acceleration_as_published(rpm: float, cells: list[Cell]) -> Floats:
    theta = degrees(cells) * DEG
    b1, b3, b5 = (float(record["value"]) for record in records("leon2001_angle_series"))
    wave = b1 * np.sin(theta) + 9 * b3 * np.sin(3 * theta) + 25 * b5 * np.sin(5 * theta)
    return np.asarray(-((rpm / 60) ** 2) * wave, dtype=np.float64)
