"""Crossland's criterion for multiaxial, non-proportional histories.

√J₂,a + α σ_H,max ≤ β (Crossland 1956), with the amplitude of the deviatoric stress, which is the radius of
the smallest ball that encloses its path, and the largest hydrostatic stress. From the endurance limits f
(fully reversed tension) and t (fully reversed torsion): β = t, α = 3t/f − √3.
"""

import numpy as np

from fea.base.material import Material
from fea.judge.verdict import CAP
from geometry.arrays import Floats, Ints
from geometry.errors import require

# Relative: a radius is never too small, and at most this fraction too large.
TOLERANCE = 1e-3
# Few paths need more than ten; a radius that is not converged then is still an upper bound.
_MOST_CARRIERS = 40
_MOST_STEPS = 500
_TINY = 1e-300


def ball_radii(paths: Floats) -> Floats:
    """Radius (n,) of the smallest enclosing ball of each path (n, n_dimensions, n_points).

    The ball is determined by a few points of the path on its surface, the carriers. The point farthest from
    the centre of the carriers' ball is added to them (Bădoiu & Clarkson 2003) until it is not farther away
    than the carriers. The farthest distance is never below the true radius and the radius of the carriers'
    ball is never above it, so that both enclose it within `TOLERANCE`.
    """
    radius = np.empty(len(paths))
    open_ = np.arange(len(paths))
    squares = np.einsum("ndt,ndt->nt", paths, paths)
    carriers = _farthest(paths, squares, paths[:, :, 0], open_)[1][:, None]
    weights = np.ones((len(paths), 1))
    while len(open_):
        center, inner = _carried(carriers, weights)
        outer, point = _farthest(paths, squares, center, open_)
        radius[open_] = np.sqrt(np.maximum(outer, 0))
        more = (outer > inner * (1 + TOLERANCE) ** 2 + _TINY) & (carriers.shape[1] < _MOST_CARRIERS)
        open_ = open_[more]
        carriers = np.concatenate([carriers, point[:, None]], axis=1)[more]
        weights = np.pad(weights, ((0, 0), (0, 1)))[more]
    return radius


def _farthest(paths: Floats, squares: Floats, center: Floats, rows: Ints) -> tuple[Floats, Floats]:
    """Square of the largest distance from centres (n, d) to the paths of some rows, and that point (n, d)."""
    if len(rows) < len(paths):
        paths, squares = paths[rows], squares[rows]
    distance = squares - 2 * (center[:, None] @ paths)[:, 0]
    which = distance.argmax(axis=1)
    point = paths[np.arange(len(paths)), :, which]
    return ((point - center) ** 2).sum(axis=1), point


def _carried(carriers: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Centre (n, d) and lower bound of the squared radius (n,) of the balls of carriers (n, m, d).

    The centre is the weighted mean with the weights that maximise the weighted mean square distance; for any
    weights this is at most the square of the radius (Yildirim 2008). `weights` (n, m) are the starting values
    and are improved in place, by steps of optimal length towards the farthest carrier or away from the
    nearest one with a positive weight.
    """
    rows = np.arange(len(carriers))
    center = (weights[:, None] @ carriers)[:, 0]
    for _ in range(_MOST_STEPS):
        square = ((carriers - center[:, None]) ** 2).sum(axis=2)
        mean = (weights * square).sum(axis=1)
        far, near = square.argmax(axis=1), np.where(weights > 0, square, np.inf).argmin(axis=1)
        above = square[rows, far] - mean
        below = mean - square[rows, near]
        if (above <= TOLERANCE / 4 * mean + _TINY).all():
            break
        out = above >= below
        chosen = np.where(out, far, near)
        # Along the line to a point at square distance s the mean square distance is a parabola with its
        # top at (s − mean)/2s; weights must not become negative.
        reach = square[rows, chosen]
        best = np.divide(reach - mean, 2 * reach, out=np.full_like(reach, -np.inf), where=reach > _TINY)
        own = weights[rows, chosen]
        least = -np.divide(own, 1 - own, out=np.full_like(own, np.inf), where=own < 1)
        step = np.maximum(best, least)
        weights *= (1 - step)[:, None]
        weights[rows, chosen] = np.maximum(weights[rows, chosen] + step, 0)
        center += step[:, None] * (carriers[rows, chosen] - center)
    return center, mean


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

    It is never too large, and too small by at most `fea.judge.crossland.TOLERANCE`.

    Parameters
    ----------
    histories
        (n, 6, n_instants), MPa, as `fea.judge.history.deviatoric` gives them.
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
