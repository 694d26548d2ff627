"""Molina et al. 2024: kinematics of a 2000 cc engine, printed as figures in the text."""

import numpy as np
import numpy.typing as npt

from fea.base.units import DEG, RPM
from fea.verify.reproduce.tables import PublishedStudy
from geometry.arrays import Floats
from loads.engine import Engine, Kinematics, kinematics

SOURCE = "molina-2024"
R, L, BORE = 44.0, 150.0, 85.0  # mm
LAMBDA = R / L

# Kinematics need no mass.
ENGINE = Engine(crank_radius=R, rod_length=L, bore=BORE, piston_mass=1e-3, cylinders=4)
FINE = np.linspace(0, 360, 36_001)  # degrees


def motion(rpm: float, degrees: npt.ArrayLike) -> Kinematics:
    """Exact kinematics at crank angles in degrees."""
    return kinematics(ENGINE, np.asarray(degrees, dtype=np.float64) * DEG, rpm * RPM)


def travel(degrees: npt.ArrayLike) -> Floats:
    """Piston displacement from TDC, mm."""
    return R + L - motion(0, degrees).piston_position


def fit(degrees: Floats, displacement: Floats) -> tuple[tuple[float, float], float]:
    """Coefficients (a, b) of a + b θ², θ in degrees, and R² of the fit."""
    slope, start = np.polyfit(degrees**2, displacement, 1)
    return (float(start), float(slope)), float(np.corrcoef(degrees**2, displacement)[0, 1] ** 2)


_DEGREES = np.arange(0.0, 721.0, 10.0)
FIT, QUALITY = fit(_DEGREES, travel(_DEGREES))
FIT_OF_ROUNDED, _ = fit(_DEGREES, np.round(travel(_DEGREES), 2))
STUDY = PublishedStudy(SOURCE, globals())
