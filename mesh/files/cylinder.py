"""Fit circles and cylinders to points and facets."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.circle import fitted_circle
from geometry.frame import basis_across


def circles_through(triples: Floats) -> tuple[Floats, Floats]:
    """Centres (n, 2) and radii (n,) of the circles through three places each (n, 3, 2); NaN for lines."""
    first = triples[:, 0]
    spans = triples[:, 1:] - first[:, None]
    cross = 2 * (spans[:, 0, 0] * spans[:, 1, 1] - spans[:, 0, 1] * spans[:, 1, 0])
    squares = (spans**2).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (spans[:, 1, 1] * squares[:, 0] - spans[:, 0, 1] * squares[:, 1]) / cross
        y = (spans[:, 0, 0] * squares[:, 1] - spans[:, 1, 0] * squares[:, 0]) / cross
    center = np.column_stack([x, y])
    radius = np.linalg.norm(center, axis=1)
    wrong = ~np.isfinite(radius)
    radius[wrong] = np.nan
    return center + first, radius


@dataclass(frozen=True)
class Axes:
    """Cylinders with parallel axes.

    Attributes
    ----------
    direction
        Unit vector (3,).
    centers
        (n, 3) a point on each axis, mm.
    radii
        (n,) mm.
    residual
        Root mean square distance of the points from their cylinder, over its radius, the largest of all.
    """

    direction: Floats
    centers: Floats
    radii: Floats
    residual: float


def fitted_axes(clouds: list[Floats], direction: Floats) -> Axes:
    """Least-squares cylinders with one common direction.

    Parameters
    ----------
    clouds
        Points (n, 3) on each of the cylinders, mm.
    direction
        A first guess, unit vector.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - only meshes from files need it

    across = basis_across(direction)
    middles = [cloud.mean(axis=0) for cloud in clouds]
    starts = [
        fitted_circle((cloud - middle) @ across.T) for cloud, middle in zip(clouds, middles, strict=True)
    ]
    first = [(*circle.center, circle.radius) if circle else (0.0, 0.0, 1.0) for circle in starts]
    scale = max(radius for *_, radius in first)

    def turned(tilt: Floats) -> Floats:
        vector = direction + tilt @ across
        return np.asarray(vector / np.linalg.norm(vector))

    def off(unknowns: Floats) -> Floats:
        axis = turned(unknowns[:2])
        parts = []
        for cloud, middle, (u, v, radius) in zip(
            clouds, middles, scale * unknowns[2:].reshape(-1, 3), strict=True
        ):
            arm = cloud - middle - (u * across[0] + v * across[1])
            parts.append(np.linalg.norm(np.cross(arm, axis), axis=1) / radius - 1)
        return np.concatenate(parts)

    found = least_squares(off, np.concatenate([[0, 0], np.ravel(first) / scale])).x
    axis, own = turned(found[:2]), scale * found[2:].reshape(-1, 3)
    centers = np.array([m + u * across[0] + v * across[1] for m, (u, v, _) in zip(middles, own, strict=True)])
    ends = np.cumsum([len(cloud) for cloud in clouds])[:-1]
    worst = max(float(np.sqrt((part**2).mean())) for part in np.split(off(found), ends))
    return Axes(axis, centers, own[:, 2], worst)


def straightest(normals: Floats, areas: Floats) -> Floats:
    """Direction (3,) that normals (n, 3) are most nearly across, weighted by areas (n,)."""
    _, vectors = np.linalg.eigh((normals * areas[:, None]).T @ normals)
    return np.asarray(vectors[:, 0])


def covered(angles: Floats, bins: int = 360) -> float:
    """Share of a turn that intervals (n, k) of angles, rad, cover; each spans less than half a turn."""
    if not len(angles):
        return 0.0
    start = angles[:, :1]
    off = start + (angles - start + np.pi) % (2 * np.pi) - np.pi
    low = np.floor(off.min(axis=1) / (2 * np.pi) * bins).astype(int)
    high = np.ceil(off.max(axis=1) / (2 * np.pi) * bins).astype(int)
    marks = np.zeros(3 * bins + 2)
    np.add.at(marks, low + bins, 1)
    np.add.at(marks, np.maximum(high, low + 1) + bins, -1)
    open_bins = np.cumsum(marks)[: 3 * bins].reshape(3, bins).sum(axis=0) <= 0
    return float(1 - open_bins.mean())
