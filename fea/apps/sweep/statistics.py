"""What a sweep tells: how likely failure is, and what matters."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fea.apps.sweep.samples import MASS, Samples
from fea.apps.sweep.sampling import Sampling
from fea.apps.sweep.sensitivity import Sensitivity, sensitivities
from fea.apps.sweep.sweep_file import Sweep
from fea.apps.sweep.variation import Span
from geometry.arrays import Floats

CONFIDENCE = 0.95


@dataclass(frozen=True, kw_only=True)
class Probability:
    """P(factor < 1).

    Attributes
    ----------
    name
        Of the factor.
    below, rods
        Rods whose factor is below 1, and all with a factor.
    missing
        Rods without one: the interval allows for any factor of theirs.
    estimate, low, high
        Share of the rods, and its interval of `CONFIDENCE`.
    """

    name: str
    below: int
    rods: int
    missing: int
    estimate: float
    low: float
    high: float


def below_one(name: str, values: Floats) -> Probability | None:
    """Estimate P(factor < 1) from independent rods.

    Of a Latin hypercube or Sobol's sequence, which are more even than independent samples, the interval is
    wider than it need be.

    Parameters
    ----------
    name
        Of the factor.
    values
        (n,) NaN where there is none.
    """
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    below, missing = int((known < 1).sum()), len(values) - len(known)
    low, _ = clopper_pearson(below, len(values))
    _, high = clopper_pearson(below + missing, len(values))
    return Probability(
        name=name,
        below=below,
        rods=len(known),
        missing=missing,
        estimate=below / len(known),
        low=low,
        high=high,
    )


def clopper_pearson(successes: int, trials: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the exact interval of a binomial proportion (Clopper & Pearson 1934)."""
    from scipy.stats import beta  # noqa: PLC0415 - only robustness needs it

    tail, failures = (1 - confidence) / 2, trials - successes
    low = 0.0 if successes == 0 else float(beta.ppf(tail, successes, failures + 1))
    high = 1.0 if failures == 0 else float(beta.ppf(1 - tail, successes + 1, failures))
    return low, high


@dataclass(frozen=True)
class Statistics:
    """Both, as far as the designs give them."""

    probabilities: tuple[Probability, ...]
    sensitivities: tuple[Sensitivity, ...]


def statistics(sweep: Sweep, samples: Samples) -> Statistics:
    """Return what the designs of a sweep tell."""
    return Statistics(_probabilities(sweep, samples), sensitivities(samples, sweep.sampling))


def _probabilities(sweep: Sweep, samples: Samples) -> tuple[Probability, ...]:
    """P(factor < 1), where designs are drawn from distributions."""
    drawn = any(isinstance(one, Span) for one in sweep.varied.values())
    if not drawn or sweep.sampling in (None, Sampling.GRID):
        return ()
    alone = samples.part(_independent(sweep, len(samples.rows)))
    found = [below_one(name, values) for name, values in alone.values.items() if name != MASS]
    return tuple(one for one in found if one is not None)


def _independent(sweep: Sweep, count: int) -> Any:
    """Which designs are independent: of Saltelli's blocks the first and the last."""
    if sweep.sampling is not Sampling.SALTELLI:
        return slice(None)
    block = len(sweep.varied) + 2
    return np.isin(np.arange(count) % block, (0, block - 1))
