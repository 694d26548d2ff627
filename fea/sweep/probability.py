"""The share of rods whose factor is below 1, with a confidence interval."""

from dataclasses import dataclass

import numpy as np

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
