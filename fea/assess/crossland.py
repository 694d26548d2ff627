"""Crossland's criterion for a multiaxial, non-proportional history.

√J₂,a + α σ_H,max ≤ β (Crossland 1956): the amplitude of the deviatoric stress, which is the radius of the
smallest ball round its path, and the largest mean stress. From the endurance limits f (fully reversed
tension) and t (fully reversed torsion): β = t, α = 3t/f − √3.
"""

import numpy as np
import numpy.typing as npt

from fea.assess.safety import CAP
from fea.material import Material
from geometry.invalid import require

Floats = npt.NDArray[np.float64]

# t/f of wrought steels lies between 0.58 and 0.65: hard steel 0.625 (Nishihara & Kawamoto 1945), 34Cr4 and
# 30NCD16 0.62 (as tabled by Papadopoulos et al. 1997).
TORSION_RATIO = 0.62
# Relative to the radius, which then is that much too large at most.
_TOLERANCE = 1e-4
_MOST_STEPS = 20_000


def ball_radius(path: Floats) -> float:
    """Radius of the smallest ball round the points (n_dimensions, n) of a path.

    The centre is the weighted mean of the points with the weights that make the weighted mean square
    distance largest (Yildirim 2008): Frank & Wolfe's steps towards the farthest point, or away from
    the nearest that still has weight. The radius returned reaches every point.
    """
    weight = np.zeros(path.shape[1])
    weight[np.linalg.norm(path - path[:, :1], axis=0).argmax()] = 1.0
    center = path @ weight
    for _ in range(_MOST_STEPS):
        square = ((path - center[:, None]) ** 2).sum(axis=0)
        mean, far = float(weight @ square), int(square.argmax())
        near = int(np.where(weight > 0, square, np.inf).argmin())
        if square[far] <= mean * (1 + 2 * _TOLERANCE) + 1e-300:
            break
        above, below = square[far] / mean - 1 if mean > 0 else np.inf, 1 - square[near] / max(mean, 1e-300)
        if above >= below:
            step = 0.5 if not np.isfinite(above) else above / (2 * (1 + above))
            point = far
        else:
            step = -min(below / (2 * (1 - below)) if below < 1 else np.inf, weight[near] / (1 - weight[near]))
            point = near
        weight *= 1 - step
        weight[point] = max(weight[point] + step, 0.0)
        center = (1 - step) * center + step * path[:, point]
    return float(np.sqrt(((path - center[:, None]) ** 2).sum(axis=0).max()))


def crossland(history: Floats, material: Material) -> float | None:
    """Return `crossland_factor` of a material; None where its endurance is not known.

    Where the limit in torsion is not known it is taken as `TORSION_RATIO` of that in tension.
    """
    tension, torsion = material.endurance_limit, material.torsion_limit
    if tension is None:
        return None
    return crossland_factor(history, tension, TORSION_RATIO * tension if torsion is None else torsion)


def crossland_factor(history: Floats, tension_limit: float, torsion_limit: float) -> float:
    """Factor by which a history may grow until Crossland's criterion is met, at most `CAP`.

    Parameters
    ----------
    history
        (6, n), MPa, as `fea.assess.deviatoric.deviatoric` gives it.
    tension_limit, torsion_limit
        f and t, MPa, of the part.

    Raises
    ------
    InvalidValue
        t/f is below 1/√3, where mean tension would do good.
    """
    ratio = torsion_limit / tension_limit
    rule = "must be at least 0.577 of the endurance in tension for Crossland's criterion"
    require(ratio >= 3**-0.5 * (1 - 1e-9), "material.endurance_torsion_MPa", torsion_limit, rule)
    amplitude = ball_radius(history[:5]) / 3**0.5
    used = amplitude + (3 * ratio - 3**0.5) * float(history[5].max())
    return float(torsion_limit / max(used, torsion_limit / CAP))
