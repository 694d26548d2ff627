"""Molina et al. 2024: kinematics of a 2000 cc engine, printed as figures in the text."""

import numpy as np
import numpy.typing as npt

from fea.units import DEG, M_S2, RPM
from fea.verify.reproduce.printed import decimals, records
from fea.verify.reproduce.row import Row, Slip
from fea.verify.reproduce.table import Table
from geometry.arrays import Floats
from loads.engine import Engine
from loads.slider_crank import Kinematics, kinematics

SOURCE = "molina-2024"
R, L, BORE = 44.0, 150.0, 85.0  # mm
LAMBDA = R / L

# Kinematics need no mass.
_ENGINE = Engine(crank_radius=R, rod_length=L, bore=BORE, piston_mass=1e-3, cylinders=4)
_CM = 10.0  # mm
_FINE = np.linspace(0, 360, 36_001)


def tables() -> list[Table]:
    """Displacement, velocity, acceleration, regression."""
    return [displacement(), velocity(), acceleration(), regression()]


def motion(rpm: float, crank_degrees: npt.ArrayLike) -> Kinematics:
    """Exact kinematics at crank angles in degrees."""
    return kinematics(_ENGINE, np.asarray(crank_degrees, dtype=np.float64) * DEG, rpm * RPM)


def travel(crank_degrees: npt.ArrayLike) -> Floats:
    """Piston displacement from TDC, mm."""
    return R + L - motion(0, crank_degrees).piston_position


def two_term_velocity(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    """V = ω r (sin θ + λ/2 sin 2θ), mm/s: the printed formula with its missing bracket."""
    theta = np.asarray(crank_degrees, dtype=np.float64) * DEG
    return np.asarray(rpm * RPM * R * (np.sin(theta) + LAMBDA / 2 * np.sin(2 * theta)), dtype=np.float64)


def two_term_acceleration(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    """Evaluate a = ω² r (cos θ + λ cos 2θ), mm/s², positive away from TDC."""
    theta = np.asarray(crank_degrees, dtype=np.float64) * DEG
    return np.asarray((rpm * RPM) ** 2 * R * (np.cos(theta) + LAMBDA * np.cos(2 * theta)), dtype=np.float64)


def displacement() -> Table:
    """Displacement at the dead centres."""
    rows = [
        _row(
            "displacement",
            record,
            float(travel(float(record["crank_deg"]))),
            float(travel(float(record["crank_deg"]))),
        )
        for record in _records("displacement")
    ]
    return Table(SOURCE, "displacement", "piston displacement", tuple(rows))


def velocity() -> Table:
    """Velocity at the dead centres and its printed peaks."""
    rows = []
    for record in _records("velocity"):
        rpm, at = float(record["rpm"]), float(record["crank_deg"])
        exact = -float(motion(rpm, at).piston_velocity) / _CM
        rows.append(_row("velocity", record, float(two_term_velocity(rpm, at)) / _CM, exact))
    for record in _records("largest velocity"):
        rpm, at = float(record["rpm"]), float(record["crank_deg"])
        speed = -motion(rpm, _FINE).piston_velocity / _CM
        cause = f"ωr, the velocity at {at:g}°; the peak is at {_FINE[speed.argmax()] + at - 90:.1f}°"
        if rpm == 800:
            cause += "; printed as m/s"
        rows.append(
            _row("velocity", record, float(two_term_velocity(rpm, at)) / _CM, float(speed.max()), cause)
        )
    return Table(
        SOURCE,
        "velocity",
        "piston velocity",
        tuple(rows),
        (
            "The printed formula lacks a bracket: V = ω r (sin θ + (λ/2) sin 2θ).",
            "The true peak is before 90°, not at 90°.",
            "In the text the peak angles of velocity and acceleration are swapped, and so are TDC and BDC.",
        ),
    )


def acceleration() -> Table:
    """Acceleration at the dead centres."""
    tdc, bdc, peak, difference = (_records(name)[i] for name, i in _ACCELERATIONS)
    rpm = 780
    two_term = {at: float(two_term_acceleration(rpm, at)) / M_S2 for at in (0, 180)}
    exact = {at: -float(motion(rpm, at).piston_acceleration) / M_S2 for at in (0, 180)}
    wave = two_term_acceleration(rpm, _FINE) / M_S2
    rows = (
        _row("acceleration", tdc, two_term[0], exact[0]),
        _row(
            "acceleration",
            bdc,
            two_term[180],
            exact[180],
            slip=Slip("the value of TDC with its sign changed", -two_term[0]),
        ),
        _row("acceleration", peak, two_term[0], exact[0], slip=Slip(_stray_peak(float(peak["value"])), None)),
        _row(
            "acceleration",
            difference,
            two_term[0] + two_term[180],
            exact[0] + exact[180],
            slip=Slip("neither the printed nor the computed accelerations differ by this", None),
        ),
    )
    return Table(
        SOURCE,
        "acceleration",
        "piston acceleration at 780 rpm",
        rows,
        (f"The most negative value is {wave.min():.0f} m/s² at {_FINE[wave.argmin()]:.0f}°, not at BDC.",),
    )


_ACCELERATIONS = (
    ("acceleration", 0),
    ("acceleration", 1),
    ("largest acceleration", 0),
    ("difference of the dead centres", 0),
)


def _stray_peak(printed: float) -> str:
    """Explain the printed peak by the speed that it would belong to: a = ω² r (1 + λ)."""
    rpm = float(np.sqrt(printed * M_S2 / (R * (1 + LAMBDA)))) / RPM
    slow, fast = (float(two_term_acceleration(n, 0)) / M_S2 for n in (780, 800))
    return (
        f"matches neither 780 rpm ({slow:.1f}) nor 800 rpm ({fast:.1f}): ω²r(1 + λ) has this value at "
        f"{rpm:.0f} rpm"
    )


def regression() -> Table:
    """Least-squares fit a + b θ² to the displacement every 10° over 0–720°."""
    degrees = np.arange(0.0, 721.0, 10.0)
    rounded, _ = fit(degrees, np.round(travel(degrees), 2))
    exact, quality = fit(degrees, travel(degrees))
    intercept, coefficient = (_records(f"regression {name}")[0] for name in ("intercept", "coefficient"))
    cause = f"fitted to displacements rounded to .01 mm; R² = {quality:.4f}, so that it explains nothing"
    rows = (
        _row("regression", intercept, rounded[0], exact[0], cause),
        _row("regression", coefficient, rounded[1], exact[1], cause),
        Row(
            source=SOURCE,
            table="regression",
            quantity="R²",
            at="",
            unit="1",
            published=None,
            digit=0.0,
            as_published=quality,
            corrected=quality,
            formula_cause="not printed; the fit explains nothing",
        ),
    )
    return Table(
        SOURCE,
        "regression",
        "regression of the displacement on θ²",
        rows,
        (f"R² = {quality:.4f}: a parabola over two revolutions of a periodic motion explains nothing.",),
    )


def fit(degrees: Floats, displacement: Floats) -> tuple[tuple[float, float], float]:
    """Coefficients (a, b) of a + b θ², θ in degrees, and R² of the fit."""
    design = np.stack([np.ones_like(degrees), degrees**2], axis=1)
    coefficients, *_ = np.linalg.lstsq(design, displacement, rcond=None)
    residual = displacement - design @ coefficients
    quality = 1 - float(residual @ residual) / float(np.sum((displacement - displacement.mean()) ** 2))
    return (float(coefficients[0]), float(coefficients[1])), quality


def _records(quantity: str) -> list[dict[str, str]]:
    return [record for record in records("molina2024_figures") if record["quantity"] == quantity]


def _row(
    table: str,
    record: dict[str, str],
    as_published: float,
    corrected: float,
    cause: str = "",
    *,
    slip: Slip | None = None,
) -> Row:
    at = ", ".join(
        f"{record[name]}{unit}" for name, unit in (("rpm", " rpm"), ("crank_deg", "°")) if record[name]
    )
    digit = 10.0 ** -decimals(record["value"])
    return Row(
        source=SOURCE,
        table=table,
        quantity=record["quantity"],
        at=at,
        unit=record["unit"],
        published=float(record["value"]),
        digit=digit,
        as_published=as_published,
        corrected=corrected,
        formula_cause=cause,
        slip=slip,
    )
