"""What a fatigue test does to a rod, in sentences."""

from collections.abc import Iterator

from fea.analysis.life_figures import CycleLifeFigures, TestLifeFigures
from fea.analysis.summary_figures import Summary
from fea.base.units import KN
from fea.judge.cycle_life import LONGEST
from fea.output.units import factor, quantity


def fatigue_test(summary: Summary) -> Iterator[str]:
    """Yield the factor of a fatigue test, and the cycles that the worst place lasts, the range first."""
    if (test := summary.bench) is None:
        return
    high, low = (quantity(force / KN, ".4g", "kN") for force in test.forces_N)
    mean, half = (quantity(stress, ".0f", "MPa") for stress in (test.mean_MPa, test.amplitude_MPa))
    lasts, life = "no S–N line is known or can be assumed", test.life
    if life is not None:
        least, middle, most = (_count(life, each) for each in (life.low, life.cycles, life.high))
        about = "" if least == most else f", {middle} in the middle"
        lasts = f"lasts {' to '.join(dict.fromkeys((least, most)))} cycles{about} {source_of(life)}"
    ratio = test.forces_N[1] / test.forces_N[0]
    yield (
        f"Fatigue test between {low} and {high} (R = {ratio:.3g}): factor {factor(test.safety_factor)} "
        f"(local stress in full), {test.where}, mean {mean}, amplitude {half}; {lasts}."
    )


def _count(life: TestLifeFigures, cycles: float | None) -> str:
    if cycles is None or cycles > LONGEST:
        return "unlimited" if life.unlimited else "more than 10⁸"
    return f"{float(f'{cycles:.{0 if life.assumed else 1}e}'):,.0f}"


def source_of(life: CycleLifeFigures | TestLifeFigures) -> str:
    """Return where a life comes from, in brackets."""
    line = "assumed S–N line" if life.assumed else "S–N line"
    if life.by_strain:
        line = f"low-cycle: Coffin–Manson with {'assumed' if life.assumed else 'known'} constants"
    return f"({line}, strength ± {life.band_percent:.0f} %)"
