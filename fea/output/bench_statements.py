"""What a fatigue test does to a rod, in sentences."""

from collections.abc import Iterator

from fea.analysis.figures import BenchFigures, Summary
from fea.base.units import KN
from fea.judge.cycle_life import LONGEST, LOW_CYCLE
from fea.output.units import factor, number, quantity

_MANY = 1e5  # cycles from which they are written with a power of ten


def fatigue_test(summary: Summary) -> Iterator[str]:
    """Yield how many cycles of a fatigue test the worst place lasts, and the factor against fatigue."""
    if (test := summary.bench) is None:
        return
    low, high = (quantity(force / KN, ".4g", "kN") for force in (test.lower_N, test.upper_N))
    mean, half = (quantity(stress, ".0f", "MPa") for stress in (test.mean_MPa, test.amplitude_MPa))
    forces = f"between {low} and {high} (R = {test.ratio:.3g})"
    yield (
        f"Fatigue test {forces}: factor {factor(test.fatigue_safety_factor)} ({test.fatigue_criterion}), "
        f"{test.where}, mean {mean}, amplitude {half}; {_cycles(test)}."
    )


def _cycles(test: BenchFigures) -> str:
    """Return the cycles of a fatigue test, the range first, and where they come from."""
    if test.assumed is None:
        return "no S–N line is known or can be assumed"
    line = "assumed S–N line" if test.assumed else "S–N line"
    if test.by_strain:
        line = f"low-cycle: Coffin–Manson with {'assumed' if test.assumed else 'known'} constants"
    of = f"({line}, strength ± {number(test.band_percent, '.0f')} %)"
    if test.cycles is not None and test.cycles < LOW_CYCLE and not test.by_strain:
        return "fails within 10⁴ cycles, where stress is not elastic: how many is not determined"
    digits = 1 if test.assumed else 2
    low, about, high = (_count(each, digits) for each in (test.low_cycles, test.cycles, test.high_cycles))
    if test.cycles is None or test.cycles > LONGEST:
        endless = "unlimited life" if test.unlimited else "no failure by 10⁸ cycles expected"
        least = "" if test.low_cycles is None or test.low_cycles > LONGEST else f", at least {low} cycles"
        return f"{endless}{least} {of}"
    return f"fails after {low} to {high} cycles, about {about} {of}"


def _count(cycles: float | None, digits: int) -> str:
    if cycles is None:
        return "unlimited"
    rounded = f"{cycles:.{digits - 1}e}"
    return rounded.replace("e+0", "e") if cycles >= _MANY else f"{float(rounded):,.0f}"
