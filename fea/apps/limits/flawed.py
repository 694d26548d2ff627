"""What a given flaw and rubbing parts do at the limits of a rod, as `fea run` finds it there."""

from collections.abc import Callable
from dataclasses import replace
from math import log

from fea.analysis.defects import with_defects
from fea.analysis.pipeline import RefinedRod, solve_speed, with_cycle, with_fretting
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.result import run_result
from fea.analysis.speed_result import SpeedResult
from fea.analysis.survival import flaw_factors
from fea.apps.limits.explore import RodLimits, SafeLimit
from fea.apps.limits.figures import LimitsFigures
from fea.apps.limits.limit_map import Point
from fea.base.root import root
from fea.base.units import BAR
from fea.judge.verdict import CAP
from fea.output.defect_answer import given_flaw
from fea.output.fretting import fretting
from loads.gas import scaled

_WITHIN = 0.02  # how closely the factor of a flaw is the required one at the limit that it sets


def with_flaw(figures: LimitsFigures, found: RodLimits, show: Callable[[str], None]) -> LimitsFigures:
    """Say what a given flaw does at the largest speed and pressure, and up to where the rod holds with it.

    So with fretting, where it was asked for. It takes a run with its cycle for each; a few if the flaw grows.
    """
    study, engine, pressure = found.rod.study, found.engine, found.pressure
    if study.defect.flaw is None and not study.analysis.fretting:
        return figures
    show("flaw and fretting at the limits")
    text, rpm, boost = [figures.text], figures.safe_rpm, figures.safe_boost
    if found.speed is not None:
        lines, rpm = _held(found, found.speed, lambda at: (at, engine.full_load_scale(at)), ("rpm", 1.0))
        text += lines
    if pressure is not None:
        turning = pressure.rpm
        lines, peak = _held(found, pressure, lambda at: (turning, engine.scale(turning, at)), ("bar", BAR))
        text += lines
        boost = None if peak is None or boost is None else engine.boost(engine.scale(turning, peak))
    return replace(figures, text=" ".join(text), safe_rpm=rpm, safe_boost=boost)


def _held(
    found: RodLimits, safe: SafeLimit, point: Callable[[float], Point], unit: tuple[str, float]
) -> tuple[list[str], float | None]:
    """Sentences on the end of a safe interval, and up to which coordinate the rod holds; None: nowhere."""
    rpm, scale = point(safe.high)
    rod, result = _run(found, rpm, scale)
    summary = run_result(rod.study, RefinedRod(rod), result).summary
    at = f"At {rpm:.0f} rpm and {found.engine.peak(rpm, scale) / BAR:.0f} bar peak"
    text = [f"{at}: {line[0].lower()}{line[1:]}" for line in (*given_flaw(summary), *fretting(summary))]
    required, ends = found.rod.options.min_safety or 1.0, (safe.least, safe.high)
    factors = {safe.high: _least(result)}
    if factors[safe.high] >= required:
        return text, safe.high

    def level(x: float) -> float:
        if x not in factors:
            factors[x] = _least(_run(found, *point(x))[1])
        return log(factors[x] / required)

    edge = root(level, [safe.high], -0.5, ends, _WITHIN)
    held = "nowhere below that" if edge is None else f"up to about {edge.x / unit[1]:.0f} {unit[0]}"
    return [*text, f"With the flaw the rod holds {held}."], None if edge is None else edge.x


def _least(result: SpeedResult) -> float:
    """Return the factor of the flaw; the largest that is given where it does not count."""
    return float(min(flaw_factors(result.defect), default=CAP))


def _run(found: RodLimits, rpm: float, scale: float) -> tuple[PreparedRod, SpeedResult]:
    """Run a point of operation on the mesh and with the stiffness of the rod."""
    loading = found.engine.loading
    rod = replace(found.rod, loading=replace(loading, gas=scaled(loading.gas, scale)))
    result = with_cycle(rod, solve_speed(rod, rpm))
    return rod, with_defects(rod, with_fretting(rod, result) if rod.options.fretting else result)
