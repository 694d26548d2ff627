"""Crossland's criterion for multiaxial, non-proportional histories.

√J₂,a + α σ_H,max ≤ β (Crossland 1956), with the amplitude of the deviatoric stress, which is the radius of
the smallest ball that encloses its path, and the largest hydrostatic stress. From the endurance limits f
(fully reversed tension) and t (fully reversed torsion): β = t, α = 3t/f − √3.
"""

import numpy as np

from fea.assess.ball import ball_radii
from fea.assess.safety import CAP
from fea.material import Material
from geometry.arrays import Floats
from geometry.invalid import require

# t/f of 31 wrought steels: 0.60 ± 0.03, all within 0.52…0.69 (Forrest 1962, as table 6-14 of Budynas &
# Nisbett, Shigley's Mechanical Engineering Design, 9th ed.). Aluminium has 0.55 there and titanium 0.48, both
# below 1/√3, where the criterion is not valid.
TORSION_RATIO = 0.60


def crossland(history: Floats, material: Material, surface: float = 1.0) -> float | None:
    """Return the factor of one history (6, n_instants); None if the endurance limit is not known."""
    factors = crossland_factors(history[None], material, surface)
    return None if factors is None else float(factors[0])


def crossland_factors(histories: Floats, material: Material, surface: Floats | float = 1.0) -> Floats | None:
    """Return `crossland_factor` for a material; None if its endurance limit is not known."""
    limits = _limits(material)
    return None if limits is None else crossland_factor(histories, *limits, surface)


def crossland_factor(
    histories: Floats, tension_limit: float, torsion_limit: float, surface: Floats | float = 1.0
) -> Floats:
    """Factor (n,) by which histories may grow until Crossland's criterion is met, at most `CAP`.

    It is never too large, and too small by at most `fea.assess.ball.TOLERANCE`.

    Parameters
    ----------
    histories
        (n, 6, n_instants), MPa, as `fea.assess.deviatoric.deviatoric` gives them.
    tension_limit, torsion_limit
        f and t, MPa, of the part.
    surface
        Factor k_a of the surface on both, (n,) or one for all.

    Raises
    ------
    InvalidValue
        t/f is below 1/√3, where tensile mean stress would increase the factor.
    """
    radius, mean = ball_radii(histories[:, :5]), histories[:, 5].max(axis=1)
    return _factor(radius, mean, tension_limit, torsion_limit, surface)


def crossland_bound(
    von_mises: Floats, principal: Floats, material: Material, surface: Floats | float = 1.0
) -> Floats | None:
    """Return a lower bound of `crossland_factors` without the histories; None as there.

    The ball about the origin with the largest von Mises stress as radius encloses the path, and the mean
    stress is never above the largest principal stress. A place whose bound exceeds the factor of another
    place cannot be the worst.

    Parameters
    ----------
    von_mises, principal
        (n,) largest von Mises stress and largest principal stress of the histories, MPa.
    material
        Gives the limits.
    surface
        Factor k_a of the surface on both, (n,) or one for all.
    """
    limits = _limits(material)
    return None if limits is None else _factor(von_mises, principal, *limits, surface)


def _limits(material: Material) -> tuple[float, float] | None:
    """Limits f and t of a part; t is assumed as `TORSION_RATIO` times f if it is not known."""
    tension, torsion = material.endurance_limit, material.torsion_limit
    if tension is None:
        return None
    return tension, TORSION_RATIO * tension if torsion is None else torsion


def _factor(
    radius: Floats, mean: Floats, tension_limit: float, torsion_limit: float, surface: Floats | float
) -> Floats:
    ratio = torsion_limit / tension_limit
    valid = ratio >= 3**-0.5 * (1 - 1e-9)
    rule = "must be at least 0.577 times the endurance limit in tension for Crossland's criterion"
    require(valid, "material.endurance_torsion_MPa", torsion_limit, rule, "Check both limits.")
    used = radius / 3**0.5 + (3 * ratio - 3**0.5) * mean
    limit = np.asarray(surface, radius.dtype) * torsion_limit  # in the precision of the stresses
    return np.asarray(limit / np.maximum(used, limit / CAP))
