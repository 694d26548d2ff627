"""From factors under a prescribed pressure, which are interpolated, to those with the pins in contact.

Contact depends on the load and on what bends the bores, so that its stresses cannot be superposed from unit
solutions as those of a prescribed pressure can. The ratio of the factors with contact to those without hardly
changes from one design to the next: it is taken from the design that was solved last with both, load case by
load case. On 50 designs of five rods, changed by up to ±10 % in four dimensions, corrected factors erred by
less than 1 % in the median (`tests/benchmarks/studio_gap.py contact`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fea.apps.studio.anchors import UNIT
from fea.apps.studio.frame import CaseFigures, Factor, Figures
from fea.judge.safety_factor import SafetyFactor
from geometry.arrays import Floats

# Error, percent, of a factor that is corrected in a design whose dimensions differ by this share, where
# contact changes factors much; less nearby, or where it changes all of them by less than the last share.
_ERROR_PERCENT, _AWAY, _MUCH = 8.0, 0.10, 0.05
_FURTHEST = 2.0  # times that error at most


@dataclass(frozen=True)
class Correction:
    """What contact changed in the factors of one design under one load."""

    x: Floats  #: its scaled dimensions (n,)
    loaded: object  #: what its load cases follow from
    factors: Mapping[str, float]  #: the factor with contact over that without, by load case
    peaks: Mapping[str, float]  #: the largest stress with contact over that without
    yielding: float  #: the factor of the cycle with contact over the least of its load cases
    fatigue: float | None  #: as `factors`; None where fatigue is not known
    #: By how much, percent of the stress, bars are wider with contact, by load case and for ``fatigue``
    wider: Mapping[str, float]

    @classmethod
    def between(cls, pressed: Figures, own: Figures, x: Floats, loaded: object) -> "Correction":
        """Compare the figures of a design under a prescribed pressure with those of its own pins."""
        known = {case.name: case for case in own.cases}
        pairs = [(case, known[case.name]) for case in pressed.cases if case.name in known]
        fatigue, wider = None, {one.name: other.bar_percent - one.bar_percent for one, other in pairs}
        if own.fatigue is not None and pressed.fatigue is not None:
            fatigue = float(own.fatigue.factor / pressed.fatigue.factor)
            wider["fatigue"] = own.fatigue.bar_percent - pressed.fatigue.bar_percent
        return cls(
            x=x,
            loaded=loaded,
            factors={one.name: float(other.factor / one.factor) for one, other in pairs},
            peaks={one.name: other.peak_MPa / one.peak_MPa for one, other in pairs},
            yielding=float(own.yielding.factor) / min(float(case.factor) for case in own.cases),
            fatigue=fatigue,
            wider={name: max(more, 0.0) for name, more in wider.items()},
        )

    def of(self, figures: Figures, x: Floats, loaded: object) -> Figures:
        """Return interpolated figures, corrected; their bars hold the error of the correction."""
        away = float(np.abs(x - self.x).max(initial=0.0)) * UNIT / _AWAY
        away = min(away + (loaded != self.loaded), _FURTHEST)
        ratios = (*self.factors.values(), *([] if self.fatigue is None else [self.fatigue]))
        much = min(1.0, max((abs(ratio - 1) for ratio in ratios), default=0.0) / _MUCH)
        error = _ERROR_PERCENT * away * much
        cases = tuple(self._case(case, error) for case in figures.cases)
        worst = min(cases, key=lambda case: case.factor)
        plain = {name: value for name, value in vars(worst).items() if name not in ("name", "peak_MPa")}
        return replace(
            figures,
            cases=cases,
            governing=worst.name,
            yielding=_times(Factor(**plain), self.yielding),
            fatigue=None
            if figures.fatigue is None or self.fatigue is None
            else _times(figures.fatigue, self.fatigue, error, self.wider.get("fatigue", 0.0)),
        )

    def _case(self, case: CaseFigures, error: float) -> CaseFigures:
        ratio, wider = self.factors.get(case.name, 1.0), self.wider.get(case.name, 0.0)
        changed = _times(case, ratio, error, wider)
        peak = case.peak_MPa * self.peaks.get(case.name, 1.0)
        return CaseFigures(**vars(changed) | {"name": case.name, "peak_MPa": peak})


def _times(known: Factor, ratio: float, error: float = 0.0, wider: float = 0.0) -> Factor:
    factor = SafetyFactor.of_stress(float(known.factor) * ratio, known.bar_percent + wider + error)
    return Factor.of(factor, known.where, known.at_mm, known.gap_percent + error)
