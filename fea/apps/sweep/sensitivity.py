"""Which of the varied keys matters: Sobol's indices, and standardised regression."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fea.apps.sweep.samples import MASS, Samples
from fea.apps.sweep.sampling import Sampling
from geometry.arrays import Floats

# Fewer rods than this give first-order indices that are noise: RBD-FAST takes ten harmonics.
LEAST_FOR_INDICES = 100
_RESAMPLES = 200
_SEED = 0


@dataclass(frozen=True, kw_only=True)
class Influence:
    """The influence of one key on one figure.

    Attributes
    ----------
    key
        What varies.
    regression
        Standardised coefficient of a linear regression, −1 to 1: the change of the figure, in its standard
        deviations, with one standard deviation of the key; None where there are too few rods.
    first, total
        Sobol's indices: the share of the variance that is due to the key alone, and with all its
        interactions; None where the designs do not give them.
    first_bar, total_bar
        Half width of their 95 % intervals.
    """

    key: str
    regression: float | None = None
    first: float | None = None
    first_bar: float | None = None
    total: float | None = None
    total_bar: float | None = None


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """What a figure depends on.

    Attributes
    ----------
    figure
        Its name.
    influences
        The most important key first.
    linear_share
        Share of the variance that the regression explains (R²); None where there is none.
    without_total
        Why there are no total indices; empty where there are.
    """

    figure: str
    influences: tuple[Influence, ...]
    linear_share: float | None
    without_total: str


def sensitivities(samples: Samples, sampling: Sampling | None) -> tuple[Sensitivity, ...]:
    """Return what mass and each factor depend on; figures that do not vary are left out."""
    if not samples.numeric:
        return ()
    found = []
    for figure, values in samples.values.items():
        known = values[np.isfinite(values)]
        if len(known) > 2 and np.ptp(known) > 1e-9 * abs(known).max():
            found.append(_sensitivity(samples, sampling, figure))
    return tuple(sorted(found, key=lambda one: one.figure == MASS))


def _sensitivity(samples: Samples, sampling: Sampling | None, figure: str) -> Sensitivity:
    keys, values = samples.numeric, samples.values[figure]
    chosen = np.isfinite(values)
    X, y = np.stack([samples.column(key) for key in keys], axis=1)[chosen], values[chosen]
    slopes, share = regression(X, y)
    indices, why = _indices(samples, sampling, X, figure)
    influences = [
        Influence(key=key, regression=None if slopes is None else float(slopes[k]), **_of(indices, k))
        for k, key in enumerate(keys)
    ]
    influences.sort(key=lambda one: -abs(one.total or one.first or one.regression or 0.0))
    return Sensitivity(figure=figure, influences=tuple(influences), linear_share=share, without_total=why)


def regression(X: Floats, y: Floats) -> tuple[Floats | None, float | None]:
    """Standardised coefficients (k,) of a linear regression of y (n,) on X (n, k), and its R².

    None where there are fewer than twice as many points as coefficients.
    """
    count, keys = X.shape
    if count < 2 * (keys + 1):
        return None, None
    scaled, target = (X - X.mean(axis=0)) / X.std(axis=0), (y - y.mean()) / y.std()
    slopes, *_ = np.linalg.lstsq(scaled, target)
    return slopes, float(1 - ((target - scaled @ slopes) ** 2).mean())


def _indices(
    samples: Samples, sampling: Sampling | None, X: Floats, figure: str
) -> tuple[dict[str, Floats], str]:
    values = samples.values[figure]
    if sampling is Sampling.SALTELLI:
        if samples.numeric != samples.keys:
            return {}, "some keys are not numbers"
        missing = int((~np.isfinite(values)).sum())
        if missing:
            return {}, f"{missing} rods of Saltelli's designs have no result"
        return sobol_indices(samples.keys, values), ""
    why = 'total indices need sampling = "saltelli"'
    chosen = np.isfinite(values)
    if sampling in (None, Sampling.GRID) or chosen.sum() < LEAST_FOR_INDICES:
        return {}, why
    return first_indices(samples.numeric, X, values[chosen]), why


def sobol_indices(keys: Sequence[str], values: Floats) -> dict[str, Floats]:
    """Sobol's indices from Saltelli's designs, by SALib (Saltelli et al. 2010), with 95 % half widths.

    Parameters
    ----------
    keys
        (k,) names.
    values
        (n (k + 2),) of the designs, in their order.
    """
    from SALib.analyze import sobol  # noqa: PLC0415 - comes with the extra

    found: Any = sobol.analyze(
        _problem(keys), values, calc_second_order=False, num_resamples=_RESAMPLES, seed=_SEED
    )
    return {name: np.asarray(found[name], float) for name in ("S1", "S1_conf", "ST", "ST_conf")}


def first_indices(keys: Sequence[str], X: Floats, values: Floats) -> dict[str, Floats]:
    """First-order indices from any sample, by SALib's RBD-FAST (Tarantola et al. 2006)."""
    from SALib.analyze import rbd_fast  # noqa: PLC0415 - comes with the extra

    found: Any = rbd_fast.analyze(_problem(keys), X, values, num_resamples=_RESAMPLES, seed=_SEED)
    return {name: np.asarray(found[name], float) for name in ("S1", "S1_conf")}


def _problem(keys: Sequence[str]) -> dict[str, Any]:
    return {"num_vars": len(keys), "names": list(keys), "bounds": [[0.0, 1.0]] * len(keys)}


def _of(indices: dict[str, Floats], k: int) -> dict[str, float]:
    names = {"S1": "first", "S1_conf": "first_bar", "ST": "total", "ST_conf": "total_bar"}
    return {names[name]: float(values[k]) for name, values in indices.items()}
