"""The samples of a sweep, the probability of failure and the sensitivities."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from fea.analysis.figures import Figures
from fea.apps.sweep.journal import Entry, State
from fea.apps.sweep.sampling import Sampling, Span
from fea.apps.sweep.sweep_file import Sweep
from geometry.arrays import Floats, Ints

MASS, FACTOR = "mass_kg", "factor"


@dataclass(frozen=True)
class Samples:
    """The designs of a sweep with their results.

    `rows` are those of the table that stand for each design: of its least factor. `values` has (n,) of each
    figure by its name, NaN for a design that failed or whose results are not to be trusted.
    """

    keys: tuple[str, ...]
    designs: tuple[Mapping[str, Any], ...]
    rows: tuple[int, ...]
    values: Mapping[str, Floats]

    @property
    def complete(self) -> Any:
        """Whether each design (n,) has trusted results."""
        return np.isfinite(self.values[MASS]) if MASS in self.values else np.zeros(len(self.rows), bool)

    @property
    def numeric(self) -> tuple[str, ...]:
        """The keys whose values are numbers and differ."""
        return tuple(key for key in self.keys if self._is_numeric(key))

    def column(self, key: str) -> Floats:
        """Values (n,) of a numeric key."""
        return np.array([float(design[key]) for design in self.designs])

    @property
    def front(self) -> Ints:
        """Numbers of the designs of which none is both lighter and stronger."""
        known = MASS in self.values and FACTOR in self.values
        return pareto_front(self.values[MASS], self.values[FACTOR]) if known else np.zeros(0, np.int64)

    def part(self, chosen: Any) -> "Samples":
        """Return some of the designs, by their numbers or a mask."""
        numbers = np.arange(len(self.rows))[chosen]
        return Samples(
            self.keys,
            tuple(self.designs[n] for n in numbers),
            tuple(self.rows[n] for n in numbers),
            {name: values[numbers] for name, values in self.values.items()},
        )

    def _is_numeric(self, key: str) -> bool:
        values = [design.get(key) for design in self.designs]
        numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
        return numbers and len(set(values)) > 1


def samples_of(entries: Iterable[Entry]) -> Samples:
    """Gather the rows of a journal by their design."""
    groups = [list(group) for _, group in groupby(entries, lambda entry: entry.sample)]
    figures = dict.fromkeys(name for group in groups for entry in group for name in entry.figures)
    # Factors of the whole rod, not those of one of its load cases.
    factors = {name for name in figures if name.endswith("_factor")}
    factors -= {name for name in factors if f"{name.removesuffix('_factor')}_von_mises_MPa" in figures}
    names = [name for name in figures if name in {MASS, "factor", *factors}]
    values = {name: np.array([_worst(group, name) for group in groups]) for name in names}
    keys = tuple(dict.fromkeys(key for group in groups for key in group[0].design))
    worst = [min(group, key=lambda entry: entry.figures.get("factor", np.inf)) for group in groups]
    shown = tuple(entry.number for entry in worst)
    return Samples(keys, tuple(group[0].design for group in groups), shown, values)


def _worst(group: Sequence[Entry], name: str) -> float:
    """Of several speeds the least."""
    if any(entry.state is not State.DONE or not entry.figures.get("trusted", True) for entry in group):
        return np.nan
    return float(np.min([entry.figures.get(name, np.nan) for entry in group]))


def pareto_front(mass: Floats, factor: Floats) -> Ints:
    """Return the numbers of the rods on the front of (n,) values, NaN for no result, the lightest first."""
    known = np.flatnonzero(np.isfinite(mass) & np.isfinite(factor))
    order = known[np.lexsort([-factor[known], mass[known]])]
    best = np.maximum.accumulate(factor[order]) if len(order) else factor[order]
    before = np.concatenate([[-np.inf], best[:-1]])[: len(order)]
    return np.asarray(order[factor[order] > before])


# Fewer rods than this give first-order indices that are noise: RBD-FAST takes ten harmonics.
LEAST_FOR_INDICES = 100
_RESAMPLES = 200
_SEED = 0


class Influence(Figures):
    """The influence of one key on one figure; what the designs do not give is None.

    `regression` is the standardised coefficient of a linear regression, −1 to 1. `first` and `total` are
    Sobol's indices, the shares of the variance due to the key alone and with all its interactions; their bars
    are half widths of 95 % intervals.
    """

    key: str
    regression: float | None = None
    first: float | None = None
    first_bar: float | None = None
    total: float | None = None
    total_bar: float | None = None

    @property
    def strength(self) -> float:
        """How much the key matters, by the best measure that there is."""
        return abs(self.total or self.first or self.regression or 0.0)


class Sensitivity(Figures):
    """The sensitivities of a figure to each key, the most important first.

    `linear_share` is the share of the variance that the regression explains (R²); `without_total` says why
    there are no total indices.
    """

    figure: str
    influences: tuple[Influence, ...]
    linear_share: float | None
    without_total: str


def sensitivities(samples: Samples, sampling: Sampling | None) -> tuple[Sensitivity, ...]:
    """Return what mass and each factor depend on; figures that do not vary are left out."""
    if not samples.numeric:
        return ()
    results = []
    for figure, values in samples.values.items():
        known = values[np.isfinite(values)]
        if len(known) > 2 and np.ptp(known) > 1e-9 * abs(known).max():
            results.append(_sensitivity(samples, sampling, figure))
    return tuple(sorted(results, key=lambda one: one.figure == MASS))


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
    influences.sort(key=lambda one: -one.strength)
    return Sensitivity(figure=figure, influences=tuple(influences), linear_share=share, without_total=why)


def regression(X: Floats, y: Floats) -> tuple[Floats | None, float | None]:
    """Standardised coefficients (k,) of y (n,) on X (n, k), and R²; None where n < 2 k."""
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
    """Sobol's indices from (n (k + 2),) values of Saltelli's designs, by SALib (Saltelli et al. 2010)."""
    from SALib.analyze import sobol  # noqa: PLC0415 - comes with the extra

    indices: Any = sobol.analyze(
        _problem(keys), values, calc_second_order=False, num_resamples=_RESAMPLES, seed=_SEED
    )
    return {name: np.asarray(indices[name], float) for name in ("S1", "S1_conf", "ST", "ST_conf")}


def first_indices(keys: Sequence[str], X: Floats, values: Floats) -> dict[str, Floats]:
    """First-order indices from any sample, by SALib's RBD-FAST (Tarantola et al. 2006)."""
    from SALib.analyze import rbd_fast  # noqa: PLC0415 - comes with the extra

    indices: Any = rbd_fast.analyze(_problem(keys), X, values, num_resamples=_RESAMPLES, seed=_SEED)
    return {name: np.asarray(indices[name], float) for name in ("S1", "S1_conf")}


def _problem(keys: Sequence[str]) -> dict[str, Any]:
    return {"num_vars": len(keys), "names": list(keys), "bounds": [[0.0, 1.0]] * len(keys)}


def _of(indices: dict[str, Floats], k: int) -> dict[str, float]:
    names = {"S1": "first", "S1_conf": "first_bar", "ST": "total", "ST_conf": "total_bar"}
    return {names[name]: float(values[k]) for name, values in indices.items()}


CONFIDENCE = 0.95


class Probability(Figures):
    """P(factor < 1): of `rods`, with its interval of `CONFIDENCE`, which allows for `missing` rods."""

    name: str
    below: int
    rods: int
    missing: int
    estimate: float
    low: float
    high: float


def below_one(name: str, values: Floats) -> Probability | None:
    """Estimate P(factor < 1) from (n,) independent rods, NaN for no result, by Clopper & Pearson (1934).

    Of a Latin hypercube or Sobol's sequence, which are more even than independent samples, the interval is
    wider than it need be.
    """
    from scipy.stats import binomtest  # noqa: PLC0415 - only robustness needs it

    known = values[np.isfinite(values)]
    if not len(known):
        return None
    below, missing = int((known < 1).sum()), len(values) - len(known)
    low, high = (
        binomtest(count, len(values)).proportion_ci(CONFIDENCE, "exact") for count in (below, below + missing)
    )
    return Probability(
        name=name,
        below=below,
        rods=len(known),
        missing=missing,
        estimate=below / len(known),
        low=float(low.low),
        high=float(high.high),
    )


@dataclass(frozen=True)
class Statistics:
    """Probabilities of failure and sensitivities, as far as the designs give them."""

    probabilities: tuple[Probability, ...]
    sensitivities: tuple[Sensitivity, ...]


def statistics(sweep: Sweep, samples: Samples) -> Statistics:
    """Return the statistics of the designs of a sweep."""
    return Statistics(_probabilities(sweep, samples), sensitivities(samples, sweep.sampling))


def _probabilities(sweep: Sweep, samples: Samples) -> tuple[Probability, ...]:
    drawn = any(isinstance(one, Span) for one in sweep.varied.values())
    if not drawn or sweep.sampling in (None, Sampling.GRID):
        return ()
    alone = samples.part(_independent(sweep, len(samples.rows)))
    probabilities = [below_one(name, values) for name, values in alone.values.items() if name != MASS]
    return tuple(one for one in probabilities if one is not None)


def _independent(sweep: Sweep, count: int) -> Any:
    if sweep.sampling is not Sampling.SALTELLI:
        return slice(None)
    block = len(sweep.varied) + 2
    return np.isin(np.arange(count) % block, (0, block - 1))
