"""The samples of a sweep, the probability of failure and the sensitivities."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from fea.analysis.figures import Figures
from fea.apps.sweep.sampling import Sampling, Span
from fea.apps.sweep.sweep_file import RowState, Sweep, SweepRow
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

    @classmethod
    def of(cls, rows: Iterable[SweepRow]) -> "Samples":
        """Gather the rows of a journal by their design."""
        groups = [list(group) for _, group in groupby(rows, lambda row: row.sample)]
        figures = dict.fromkeys(name for group in groups for row in group for name in row.figures)
        of_cases = {name.replace("_von_mises_MPa", "_factor") for name in figures if "_von_mises_" in name}
        # Factors of the whole rod, not those of one of its load cases.
        wanted = {MASS, FACTOR, *(name for name in figures if name.endswith("_factor"))} - of_cases
        names = [name for name in figures if name in wanted]
        return cls(
            tuple(dict.fromkeys(key for group in groups for key in group[0].design)),
            tuple(group[0].design for group in groups),
            tuple(min(group, key=lambda row: row.figures.get(FACTOR, np.inf)).number for group in groups),
            {name: np.array([_least(group, name) for group in groups]) for name in names},
        )

    def known(self, figure: str) -> Any:
        """Whether each design (n,) has a trusted result."""
        return np.isfinite(self.values.get(figure, np.full(len(self.rows), np.nan)))

    @property
    def numeric(self) -> tuple[str, ...]:
        """The keys whose values are numbers and differ."""
        columns = {key: [design.get(key) for design in self.designs] for key in self.keys}
        kinds = {key: {type(value) for value in column} for key, column in columns.items()}
        words = {key for key in kinds if any(k is bool or not issubclass(k, int | float) for k in kinds[key])}
        return tuple(key for key in self.keys if key not in words and len(set(columns[key])) > 1)

    def column(self, key: str) -> Floats:
        """Values (n,) of a numeric key."""
        return np.array([float(design[key]) for design in self.designs])

    @property
    def front(self) -> Ints:
        """Numbers of the designs of which none is both lighter and stronger."""
        complete = MASS in self.values and FACTOR in self.values
        return pareto_front(self.values[MASS], self.values[FACTOR]) if complete else np.zeros(0, np.int64)

    def part(self, chosen: Any) -> "Samples":
        """Return some of the designs, by their numbers or a mask."""
        numbers = np.arange(len(self.rows))[chosen]
        return Samples(
            self.keys,
            tuple(self.designs[n] for n in numbers),
            tuple(self.rows[n] for n in numbers),
            {name: values[numbers] for name, values in self.values.items()},
        )


def _least(group: Sequence[SweepRow], name: str) -> float:
    """Least figure of a design over its speeds."""
    if any(row.state is not RowState.DONE or not row.figures.get("trusted", True) for row in group):
        return np.nan
    return float(np.min([row.figures.get(name, np.nan) for row in group]))


def pareto_front(mass: Floats, factor: Floats) -> Ints:
    """Return the numbers of the rods on the front of (n,) values, NaN for no result, the lightest first."""
    complete = np.flatnonzero(np.isfinite(mass) & np.isfinite(factor))
    order = complete[np.lexsort([-factor[complete], mass[complete]])]
    best = np.maximum.accumulate(np.concatenate([[-np.inf], factor[order]]))
    return np.asarray(order[factor[order] > best[:-1]])


# Fewer rods than this give first-order indices that are noise: RBD-FAST takes ten harmonics.
LEAST_FOR_INDICES = 100
_RESAMPLES = 200
_INDICES = {"S1": "first", "S1_conf": "first_bar", "ST": "total", "ST_conf": "total_bar"}


class Influence(Figures):
    """The influence of one key on one figure; None where the designs do not determine it.

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
    """Return the sensitivities of mass and each factor; figures that do not vary are left out."""
    if not samples.numeric:
        return ()
    results = []
    for figure, values in samples.values.items():
        finite = values[np.isfinite(values)]
        if len(finite) > 2 and np.ptp(finite) > 1e-9 * abs(finite).max():
            results.append(_sensitivity(samples, sampling, figure))
    return tuple(sorted(results, key=lambda each: each.figure == MASS))


def _sensitivity(samples: Samples, sampling: Sampling | None, figure: str) -> Sensitivity:
    keys, values = samples.numeric, samples.values[figure]
    finite = np.isfinite(values)
    X, y = np.stack([samples.column(key) for key in keys], axis=1)[finite], values[finite]
    slopes, share = regression(X, y)
    indices, why = _indices(samples, sampling, X, values)
    named = {field: indices[name] for name, field in _INDICES.items() if name in indices}
    influences = [
        Influence(
            key=key,
            regression=None if slopes is None else float(slopes[k]),
            **{name: float(index[k]) for name, index in named.items()},
        )
        for k, key in enumerate(keys)
    ]
    influences.sort(key=lambda each: -each.strength)
    return Sensitivity(figure=figure, influences=tuple(influences), linear_share=share, without_total=why)


def regression(X: Floats, y: Floats) -> tuple[Floats | None, float | None]:
    """Standardised coefficients (k,) of y (n,) on X (n, k), and R²; None where n < 2 (k + 1)."""
    count, keys = X.shape
    if count < 2 * (keys + 1):
        return None, None
    scaled, target = (X - X.mean(axis=0)) / X.std(axis=0), (y - y.mean()) / y.std()
    slopes, *_ = np.linalg.lstsq(scaled, target)
    return slopes, float(1 - ((target - scaled @ slopes) ** 2).mean())


def _indices(
    samples: Samples, sampling: Sampling | None, X: Floats, values: Floats
) -> tuple[Mapping[str, Any], str]:
    """Sobol's indices by SALib's names, and why there are no total ones.

    Of Saltelli's designs by Saltelli et al. (2010), of other random ones, of first order only, by RBD-FAST
    (Tarantola et al. 2006); `X` (m, k) are the keys where the (n,) values are finite.
    """
    finite, names = np.isfinite(values), list(samples.numeric)
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    if sampling is Sampling.SALTELLI:
        if samples.numeric != samples.keys:
            return {}, "some keys are not numbers"
        if not finite.all():
            return {}, f"{int((~finite).sum())} rods of Saltelli's designs have no result"
        from SALib.analyze import sobol  # noqa: PLC0415 - comes with the extra

        # To SALib a seed of 0 is none: error bars would differ from call to call.
        options = {"calc_second_order": False, "num_resamples": _RESAMPLES, "seed": 1}
        return sobol.analyze(problem, values, **options), ""
    why = 'total indices need sampling = "saltelli"'
    if sampling in (None, Sampling.GRID) or finite.sum() < LEAST_FOR_INDICES:
        return {}, why
    from SALib.analyze import rbd_fast  # noqa: PLC0415 - comes with the extra

    return rbd_fast.analyze(problem, X, values[finite], num_resamples=_RESAMPLES, seed=0), why


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

    finite = values[np.isfinite(values)]
    if not len(finite):
        return None
    below, missing = int((finite < 1).sum()), len(values) - len(finite)
    low, high = (
        binomtest(count, len(values)).proportion_ci(CONFIDENCE, "exact") for count in (below, below + missing)
    )
    return Probability(
        name=name,
        below=below,
        rods=len(finite),
        missing=missing,
        estimate=below / len(finite),
        low=float(low.low),
        high=float(high.high),
    )


@dataclass(frozen=True)
class Statistics:
    """Probabilities of failure and sensitivities, as far as the designs determine them."""

    probabilities: tuple[Probability, ...]
    sensitivities: tuple[Sensitivity, ...]


def statistics(sweep: Sweep, samples: Samples) -> Statistics:
    """Return the statistics of the designs of a sweep."""
    estimates: list[Probability | None] = []
    random = any(isinstance(variation, Span) for variation in sweep.varied.values())
    if random and sweep.sampling not in (None, Sampling.GRID):
        independent: Any = slice(None)
        if sweep.sampling is Sampling.SALTELLI:  # the first and the last row of each block
            block = len(sweep.varied) + 2
            independent = np.isin(np.arange(len(samples.rows)) % block, (0, block - 1))
        values = samples.part(independent).values
        estimates = [below_one(name, values[name]) for name in values if name != MASS]
    probabilities = tuple(estimate for estimate in estimates if estimate is not None)
    return Statistics(probabilities, sensitivities(samples, sweep.sampling))
