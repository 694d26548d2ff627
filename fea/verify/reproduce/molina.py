"""Molina et al. 2024: kinematics of a 2000 cc engine, printed as figures in the text."""

from functools import partial

import numpy as np
import numpy.typing as npt

from fea.base.units import DEG, M_S2, RPM
from fea.verify.reproduce.printed import Quantity, Slip, Table, cell, records
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

_table = partial(Table.of, SOURCE)


def tables() -> list[Table]:
    """Displacement, velocity, acceleration, regression."""
    return [_displacement(), _velocity(), _acceleration(), _regression()]


def motion(rpm: float, crank_degrees: npt.ArrayLike) -> Kinematics:
    """Exact kinematics at crank angles in degrees."""
    return kinematics(_ENGINE, np.asarray(crank_degrees, dtype=np.float64) * DEG, rpm * RPM)


def travel(crank_degrees: npt.ArrayLike) -> Floats:
    """Piston displacement from TDC, mm."""
    return R + L - motion(0, crank_degrees).piston_position


def two_term_acceleration(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    """Evaluate a = ω² r (cos θ + λ cos 2θ), mm/s², positive away from TDC."""
    theta = np.asarray(crank_degrees, dtype=np.float64) * DEG
    return np.asarray((rpm * RPM) ** 2 * R * (np.cos(theta) + LAMBDA * np.cos(2 * theta)), dtype=np.float64)


def _displacement() -> Table:
    both = [(record, travel(_at(record))) for record in _records("displacement")]
    quantities = [_quantity(record, exact, exact) for record, exact in both]
    return _table("displacement", "piston displacement", quantities)


def _velocity() -> Table:
    """The printed formula, with its missing bracket, at the dead centres and at the printed peaks."""

    def two_term(record: dict[str, str]) -> float:
        theta = _at(record) * DEG
        wave = float(np.sin(theta) + LAMBDA / 2 * np.sin(2 * theta))
        return float(record["rpm"]) * RPM * R * wave / _CM

    quantities = []
    for record in _records("velocity"):
        exact = -motion(float(record["rpm"]), _at(record)).piston_velocity / _CM
        quantities.append(_quantity(record, two_term(record), exact))
    for record in _records("largest velocity"):
        at, speed = _at(record), -motion(float(record["rpm"]), _FINE).piston_velocity / _CM
        cause = f"ωr, the velocity at {at:g}°; the peak is at {_FINE[speed.argmax()] + at - 90:.1f}°"
        cause += "; printed as m/s" if record["rpm"] == "800" else ""
        quantities.append(_quantity(record, two_term(record), speed.max(), cause))
    return _table(
        "velocity",
        "piston velocity",
        quantities,
        "The printed formula lacks a bracket: V = ω r (sin θ + (λ/2) sin 2θ).",
        "The true peak is before 90°, not at 90°.",
        "In the text the peak angles of velocity and acceleration are swapped, and so are TDC and BDC.",
    )


def _acceleration() -> Table:
    tdc, bdc = _records("acceleration")
    (peak,), (difference,) = _records("largest acceleration"), _records("difference of the dead centres")
    printed, printed_bdc = (float(two_term_acceleration(780, at)) / M_S2 for at in (0, 180))
    exact, exact_bdc = (-float(motion(780, at).piston_acceleration) / M_S2 for at in (0, 180))
    wave = two_term_acceleration(780, _FINE) / M_S2
    turned = Slip("the value of TDC with its sign changed", -printed)
    apart = Slip("neither the printed nor the computed accelerations differ by this")
    return _table(
        "acceleration",
        "piston acceleration at 780 rpm",
        [
            _quantity(tdc, printed, exact),
            _quantity(bdc, printed_bdc, exact_bdc, slip=turned),
            _quantity(peak, printed, exact, slip=_stray_peak(float(peak["value"]))),
            _quantity(difference, printed + printed_bdc, exact + exact_bdc, slip=apart),
        ],
        f"The most negative value is {wave.min():.0f} m/s² at {_FINE[wave.argmin()]:.0f}°, not at BDC.",
    )


def _stray_peak(printed: float) -> Slip:
    """Explain the printed peak by the speed that it would belong to: a = ω² r (1 + λ)."""
    rpm = float(np.sqrt(printed * M_S2 / (R * (1 + LAMBDA)))) / RPM
    slow, fast = (float(two_term_acceleration(n, 0)) / M_S2 for n in (780, 800))
    return Slip(
        f"matches neither 780 rpm ({slow:.1f}) nor 800 rpm ({fast:.1f}): ω²r(1 + λ) has this value at "
        f"{rpm:.0f} rpm"
    )


def _regression() -> Table:
    """Least-squares fit a + b θ² to the displacement every 10° over 0–720°."""
    degrees = np.arange(0.0, 721.0, 10.0)
    rounded, _ = fit(degrees, np.round(travel(degrees), 2))
    exact, quality = fit(degrees, travel(degrees))
    cause = f"fitted to displacements rounded to .01 mm; R² = {quality:.4f}, so that it explains nothing"
    quantities = [
        _quantity(_records(f"regression {name}")[0], rounded[i], exact[i], cause)
        for i, name in enumerate(("intercept", "coefficient"))
    ]
    unprinted = Quantity("R²", "1", cell(""), quality, quality, "not printed; the fit explains nothing")
    remark = f"R² = {quality:.4f}: a parabola over two revolutions of a periodic motion explains nothing."
    return _table("regression", "regression of the displacement on θ²", [*quantities, unprinted], remark)


def fit(degrees: Floats, displacement: Floats) -> tuple[tuple[float, float], float]:
    """Coefficients (a, b) of a + b θ², θ in degrees, and R² of the fit."""
    design = np.stack([np.ones_like(degrees), degrees**2], axis=1)
    coefficients, *_ = np.linalg.lstsq(design, displacement, rcond=None)
    residual = displacement - design @ coefficients
    quality = 1 - float(residual @ residual) / float(np.sum((displacement - displacement.mean()) ** 2))
    return (float(coefficients[0]), float(coefficients[1])), quality


def _records(quantity: str) -> list[dict[str, str]]:
    return [record for record in records("molina2024_figures") if record["quantity"] == quantity]


def _at(record: dict[str, str]) -> float:
    return float(record["crank_deg"])


def _quantity(
    record: dict[str, str],
    as_published: npt.ArrayLike,
    corrected: npt.ArrayLike,
    cause: str = "",
    *,
    slip: Slip | None = None,
) -> Quantity:
    key = record["crank_deg"]
    return Quantity(
        record["quantity"],
        record["unit"],
        cell(record["value"], key),
        as_published,
        corrected,
        cause,
        where=f"{record['rpm']} rpm" if record["rpm"] else "",
        slips={key: slip} if slip else {},
    )
