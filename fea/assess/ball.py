"""The smallest enclosing balls of many paths at once."""

import numpy as np

from geometry.arrays import Floats, Ints

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
