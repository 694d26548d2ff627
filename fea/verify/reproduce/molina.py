"""Molina et al. 2024: kinematics of a 2000 cc engine, printed as figures in the text."""

import numpy as np
import numpy.typing as npt

from fea.base.units import DEG, M_S2, RPM
from fea.verify.reproduce.printed import Column, column
from fea.verify.reproduce.published import Formula, PublishedStudy
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


def motion(rpm: float, crank_degrees: npt.ArrayLike) -> Kinematics:
    """Exact kinematics at crank angles in degrees."""
    return kinematics(_ENGINE, np.asarray(crank_degrees, dtype=np.float64) * DEG, rpm * RPM)


def travel(crank_degrees: npt.ArrayLike) -> Floats:
    """Piston displacement from TDC, mm."""
    return R + L - motion(0, crank_degrees).piston_position


def fit(degrees: Floats, displacement: Floats) -> tuple[tuple[float, float], float]:
    """Coefficients (a, b) of a + b θ², θ in degrees, and R² of the fit."""
    slope, start = np.polyfit(degrees**2, displacement, 1)
    return (float(start), float(slope)), float(np.corrcoef(degrees**2, displacement)[0, 1] ** 2)


def _two_term_velocity(cells: Column, rpm: int) -> Floats:
    """The printed formula, with its missing bracket."""
    wave = np.sin(cells.theta) + LAMBDA / 2 * np.sin(2 * cells.theta)
    return np.asarray(rpm * RPM * R * wave / _CM)


def _velocity(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    return -motion(rpm, crank_degrees).piston_velocity / _CM


def _acceleration(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    return -motion(rpm, crank_degrees).piston_acceleration / M_S2


def _two_terms(rpm: float, crank_degrees: npt.ArrayLike) -> Floats:
    """Evaluate a = ω² r (cos θ + λ cos 2θ), positive away from TDC."""
    theta = np.asarray(crank_degrees, dtype=np.float64) * DEG
    return np.asarray((rpm * RPM) ** 2 * R * (np.cos(theta) + LAMBDA * np.cos(2 * theta)) / M_S2)


def _speed_of_peak(_: int) -> float:
    """The speed to which the printed largest acceleration would belong, rpm: a = ω² r (1 + λ)."""
    (printed,) = column("molina2024_figures", "value", content={"quantity": "largest acceleration"}).values
    return float(np.sqrt(printed * M_S2 / (R * (1 + LAMBDA)))) / RPM


_DEGREES = np.arange(0.0, 721.0, 10.0)
(_ROUNDED, _), (_EXACT, _QUALITY) = (
    fit(_DEGREES, displacement) for displacement in (np.round(travel(_DEGREES), 2), travel(_DEGREES))
)
_FORMULAS: dict[str, Formula] = {
    "displacement": lambda cells, _: travel(cells.degrees),
    "two-term velocity": _two_term_velocity,
    "velocity": lambda cells, rpm: _velocity(rpm, cells.degrees),
    "largest velocity": lambda _, rpm: _velocity(rpm, _FINE).max(),
    "two-term acceleration": lambda cells, rpm: _two_terms(rpm, cells.degrees),
    "two-term acceleration at TDC, reversed": lambda _, rpm: -_two_terms(rpm, 0),
    "acceleration": lambda cells, rpm: _acceleration(rpm, cells.degrees),
    "two-term sum of the dead centres": lambda _, rpm: _two_terms(rpm, [0, 180]).sum(),
    "sum of the dead centres": lambda _, rpm: _acceleration(rpm, [0, 180]).sum(),
    "intercept of rounded displacements": lambda *_: _ROUNDED[0],
    "intercept": lambda *_: _EXACT[0],
    "coefficient of rounded displacements": lambda *_: _ROUNDED[1],
    "coefficient": lambda *_: _EXACT[1],
    "regression": lambda cells, _: _EXACT[0] + _EXACT[1] * cells.degrees**2,
    "R²": lambda *_: _QUALITY,
}
STUDY = PublishedStudy(
    SOURCE,
    _FORMULAS,
    {
        "fastest": lambda rpm: _FINE[_velocity(rpm, _FINE).argmax()],
        "fastest_again": lambda rpm: _FINE[_velocity(rpm, _FINE).argmax()] + 360,
        "slow_peak": lambda _: float(_two_terms(780, 0)),
        "fast_peak": lambda _: float(_two_terms(800, 0)),
        "speed_of_peak": _speed_of_peak,
        "most_negative": lambda _: _two_terms(780, _FINE).min(),
        "most_negative_at": lambda _: _FINE[_two_terms(780, _FINE).argmin()],
        "quality": lambda _: _QUALITY,
    },
)
