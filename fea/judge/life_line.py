"""The S–N line of a part, and Palmgren–Miner's sum of the damage of its stress cycles.

Basquin's line of specimens, lowered by Marin's factors: those of loading and reliability lower all of it;
those of size and surface lower the endurance limit, at the knee, and not the strength at 10³ cycles, with a
straight line between them on logarithmic scales (Budynas & Nisbett, Shigley's Mechanical Engineering Design,
9th ed., section 6-8). The knee is where the line of specimens meets their endurance limit.

Steel whose cycles all stay below its endurance limit lasts for ever. Once larger cycles have damaged it, the
smaller ones damage it too: below the knee the line then falls with the slope 2k − 1 instead of k (Haibach,
LBF TM 50/70, 1970). Other metals have no endurance limit (Sonsino, Int. J. Fatigue 29, 2007, 2246): for them
that slope always holds.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from fea.base.material import Basquin, Material, is_steel
from geometry.arrays import Floats
from geometry.errors import require

# Where the factors of size and surface have no effect, and below which stress is not elastic.
SHORT = 1e3


@dataclass(frozen=True)
class LifeLine:
    """The S–N line of places of a part."""

    basquin: Basquin  #: of specimens, with the factors that lower all of it
    knee: float  #: cycles at the endurance limit
    limit: Floats  #: endurance limit of the places, MPa, (n,) or one for all
    endless: bool  #: whether cycles below the limit do no damage alone

    @classmethod
    def of(cls, material: Material, surface: Floats | float = 1.0) -> "LifeLine | None":
        """Return the line of a material at places of surface factors k_a (n,); None where it is not known.

        Raises `InvalidValue`: the endurance limit does not lie on the line beyond 10³ cycles, or surface and
        size raise it above the strength there.
        """
        specimen, limit, marin = material.basquin, material.endurance_limit, material.marin
        if specimen is None or limit is None:
            return None
        whole = marin.load * marin.reliability
        polished = limit / (whole * marin.size)
        knee, most = specimen.cycles(polished), specimen.amplitude(SHORT)
        rule = f"must be below {most:.4g} MPa, which the S–N line gives at {SHORT:g} cycles"
        require(polished < most, "material.endurance_MPa", polished, rule, "Check the line and the limit.")
        limits = limit * np.asarray(surface, np.float64)
        best = float(limits.max(initial=0.0))
        rule = f"raises the endurance limit above the {most * whole:.4g} MPa borne for {SHORT:g} cycles"
        require(best < most * whole, "material.surface", best / limit, rule, "Give a smaller factor.")
        lowered = Basquin(specimen.coefficient * whole, specimen.exponent)
        return cls(lowered, knee, limits, is_steel(material.youngs_modulus))

    def stronger(self, factor: float) -> "LifeLine":
        """Return the line of a part whose every strength is multiplied by a factor."""
        basquin = replace(self.basquin, coefficient=self.basquin.coefficient * factor)
        return replace(self, basquin=basquin, limit=self.limit * factor)

    def cycles(self, amplitude: Floats) -> Floats:
        """Cycles (…, n) to failure at fully reversed amplitudes, MPa, after damage; at least 1."""
        short = self.basquin.amplitude(SHORT)
        slope = np.log(self.knee / SHORT) / np.log(short / self.limit)
        with np.errstate(over="ignore", divide="ignore"):  # no stress: no end
            below = np.where(amplitude > self.limit, slope, 2 * slope - 1)
            long = self.knee * (self.limit / amplitude) ** below
            few = SHORT * (amplitude / short) ** (1 / self.basquin.exponent)
        return np.asarray(np.maximum(np.where(amplitude > short, few, long), 1.0))

    def damage(self, amplitude: Floats, rate: Floats) -> Floats:
        """Damage per hour (k, n) of cycles that a place sees together: its life is 1 over their sum.

        The amplitudes (k, n) are of fully reversed stress, MPa; the rate (k,) is in cycles per hour.
        """
        counted = (amplitude > self.limit).any(axis=0) if self.endless else np.True_
        return np.where(counted, rate[:, None] / self.cycles(amplitude), 0.0)


def require_lines(materials: Iterable[Material]) -> None:
    """Refuse S–N lines that do not fit their material. Raises `InvalidValue` as `LifeLine.of`."""
    for material in materials:
        LifeLine.of(material, np.array([surface.factor for surface in material.marin.surfaces.values()]))


def rainflow(history: Floats) -> tuple[Floats, Floats]:
    """Means and amplitudes of the cycles of a period (n,), each counted whole, wherever the period begins."""
    start = int(np.argmax(history))
    period = np.concatenate([history[start:], history[: start + 1]])
    period = period[np.concatenate([[True], np.diff(period) != 0])]
    rising = np.diff(period) > 0
    turns = np.concatenate([[True], rising[1:] != rising[:-1], [True]]) if len(period) > 1 else [False]
    kept: list[float] = []
    cycles: list[tuple[float, float]] = []
    for value in period[turns].tolist():
        kept.append(value)
        # A range that is not larger than the next one is closed by it.
        while len(kept) > 2 and abs(kept[-1] - kept[-2]) >= abs(kept[-2] - kept[-3]):
            *before, one, other, last = kept
            cycles.append((one, other))
            kept = [*before, last]
    ends = np.array(cycles).reshape(-1, 2)
    return ends.mean(axis=1), np.abs(ends[:, 1] - ends[:, 0]) / 2
