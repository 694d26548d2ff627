"""Marin's factors: from the endurance limit of a polished specimen to that of a part.

S_e = k_a k_b k_c k_e S_e′ (Marin 1962), with the factors of Budynas & Nisbett, Shigley's Mechanical
Engineering Design, 9th ed., sections 6-8 and 6-9; k_a of shot-peened forgings is that of the FKM guideline
(Rennert et al., Analytical Strength Assessment of Components, 6th ed. 2012, section 4.3).
"""

from math import log10
from statistics import NormalDist

from fea.base.choices import Finish, Loading
from geometry.errors import require, require_positive

# k_a = a S_u^b, S_u in MPa: table 6-2, after Noll & Lipson (1946).
_FINISHES = {
    Finish.GROUND: (1.58, -0.085),
    Finish.MACHINED: (4.51, -0.265),
    Finish.HOT_ROLLED: (57.7, -0.718),
    Finish.AS_FORGED: (272.0, -0.995),
}
# FKM: K_R = 1 − a_R lg(R_z) lg(2 R_m / R_m,N,min) of steel, with R_z in µm of a rolled or forged skin, and
# K_V of shot peening, the lower end of its range both for smooth and for notched parts.
_ROUGHNESS_CONSTANT, _LEAST_STRENGTH, _SKIN_ROUGHNESS, _PEENING = 0.22, 400.0, 200.0, 1.1
# k_c against rotating bending (equation 6-26).
_LOADS = {Loading.BENDING: 1.0, Loading.AXIAL: 0.85}
# Standard deviation of the endurance limit, relative to its mean (section 6-9, after Stulen, Cummings &
# Schulte 1961).
SCATTER = 0.08
# Of steels: S_e′ = S_u/2, at most 700 MPa (equation 6-8).
_STEEL_RATIO, _STEEL_LIMIT = 0.5, 700.0
_STEEL_MODULI = (185e3, 225e3)


def finish_factor(finish: Finish, ultimate: float) -> float:
    """k_a of a surface finish on a steel of ultimate strength in MPa (equation 6-19), at most 1.

    That of shot-peened forgings is K_R K_V of the FKM guideline, which may exceed 1.
    """
    if finish is Finish.SHOT_PEENED:
        return _PEENING * roughness_factor(_SKIN_ROUGHNESS, ultimate)
    a, b = _FINISHES[finish]
    return float(min(1.0, a * ultimate**b))


def roughness_factor(roughness: float, ultimate: float) -> float:
    """K_R of a steel surface of mean roughness depth R_z in µm, ultimate strength in MPa; at most 1."""
    steeper = log10(max(2 * ultimate / _LEAST_STRENGTH, 1.0))
    return 1 - _ROUGHNESS_CONSTANT * log10(max(roughness, 1.0)) * steeper


def load_factor(loading: Loading) -> float:
    """k_c of a limit measured in rotating bending (equation 6-26); that in torsion is a limit of its own."""
    return _LOADS[loading]


def is_steel(youngs_modulus: float) -> bool:
    """Whether Young's modulus, MPa, is that of a steel."""
    low, high = _STEEL_MODULI
    return low <= youngs_modulus <= high


def size_factor(diameter: float) -> float:
    """k_b of a round section in bending, diameter in mm (equation 6-20); 1 under axial load (6-21).

    Raises
    ------
    InvalidValue
        The diameter exceeds 254 mm, the largest tested.
    """
    require_positive("material.size_mm", diameter)
    require(diameter <= 254, "material.size_mm", diameter, "must not exceed 254 mm, the largest size tested")
    if diameter <= 51:
        return float(min(1.0, (diameter / 7.62) ** -0.107))
    return float(1.51 * diameter**-0.157)


def reliability_factor(percent: float) -> float:
    """k_e = 1 − 0.08 z of the reliability in per cent (equation 6-29).

    Raises
    ------
    InvalidValue
        The reliability is below 50, which would raise the strength, or not below 100.
    """
    require(50 <= percent < 100, "material.reliability_percent", percent, "must be at least 50 and below 100")
    return 1 - SCATTER * NormalDist().inv_cdf(percent / 100)


def estimated_endurance(ultimate: float, youngs_modulus: float) -> float | None:
    """S_e′ of a steel from its ultimate strength, MPa; None for other metals, which may have no limit."""
    if not is_steel(youngs_modulus):
        return None
    return min(_STEEL_RATIO * ultimate, _STEEL_LIMIT)
