"""What a sweep tells: how likely failure is, and what matters."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fea.sweep.probability import Probability, below_one
from fea.sweep.samples import MASS, Samples
from fea.sweep.sampling import Sampling
from fea.sweep.sensitivity import Sensitivity, sensitivities
from fea.sweep.sweep_file import Sweep
from fea.sweep.variation import Span


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
