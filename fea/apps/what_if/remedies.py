"""The least change of one dimension, of the bolts or of the steel with which a rod passes, solved again."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from math import ceil, floor, log

import numpy as np

from fea.analysis.figures import Summary
from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.apps.bolts.fitting import SIZES, TIGHTENING
from fea.apps.bolts.run_bolts import BoltRow, bolts
from fea.apps.optimise.problem import variables
from fea.apps.what_if.draft import Draft
from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer
from fea.machine.clock import Clock
from fea.output.report.advice import OtherSteel
from fea.output.units import factor, quantity
from fea.study.option_tables import OptimiseTable
from fea.study.proportions import dimensions_at
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue

_RANGE = (0.6, 1.4)  # of a dimension of which [optimise] gives none, as there
_STEP, _LEAST_STEP = 1.1, 1.01  # to see what a dimension does
_AIM = 1.01  # of the required factor, which the solution is to reach
_TENTHS = 10  # of a mm, to which a dimension is rounded
_GRID = 4001


@dataclass
class _Dimension:
    """A dimension, what values it can have, and how the least factors depend on it: f = f₀ (x/x₀)^s."""

    name: str
    now: float
    low: float
    high: float
    run: dict[str, SafetyFactor]
    slopes: dict[str, float]

    def learn(self, value: float, found: dict[str, SafetyFactor]) -> None:
        """Take the exponents from the factors at another value."""
        self.slopes = {mode: log(found[mode] / now) / log(value / self.now) for mode, now in self.run.items()}

    def least(self, values: Floats) -> Floats:
        """Return the least assured factor at values (n,)."""
        every = [now.low * (values / self.now) ** self.slopes[mode] for mode, now in self.run.items()]
        return np.asarray(np.min(every, axis=0), float)

    def needed(self, required: float) -> float | None:
        """Return the nearest value with which the rod passes, rounded away from the present one."""
        values = np.geomspace(self.low, self.high, _GRID)
        good = values[self.least(values) >= _AIM * required]
        if not good.size:
            return None
        nearest = float(good[np.abs(np.log(good / self.now)).argmin()])
        rounded = (ceil if nearest > self.now else floor)(_TENTHS * nearest) / _TENTHS
        return min(max(rounded, self.low), self.high)

    def best(self) -> float:
        """Return the value with the largest least factor."""
        values = np.geomspace(self.low, self.high, _GRID)
        return float(values[self.least(values).argmax()])

    def text(self, value: float) -> str:
        """Return the change in words."""
        name = self.name.replace("_", " ")
        return f"{name} {quantity(value, '.1f', 'mm')} (now {quantity(self.now, '.1f', 'mm')})"


def _dimensions(draft: Draft, place: str) -> Iterator[_Dimension]:
    """Yield the dimensions that carry the stress at a place, each solved with a step."""
    study, table = draft.study, draft.study.optimise or OptimiseTable()
    for name in dimensions_at(study.rod.dimensions, place):
        key, now = key_of(name), float(getattr(study.rod.dimensions, name))
        bounds = table.free.get(key, tuple(share * now for share in _RANGE))
        with suppress(InvalidValue):  # it has no effect, or stands outside of its bounds
            one = variables(replace(study, optimise=replace(table, free={key: bounds})))
            low, high = (
                one.dimensions(one.nearest_feasible(np.array([x]), one.start))[key] for x in (0.0, 1.0)
            )
            step = min(_STEP * now, high) if high > _LEAST_STEP * now else max(now / _STEP, low)
            if max(step / now, now / step) >= _LEAST_STEP:
                found = _Dimension(name, now, low, high, draft.run, {})
                found.learn(step, draft.factors(study.with_rod(**{key: step})))
                yield found


def dimension_remedy(draft: Draft, summary: Summary, place: str) -> tuple[str, bool]:
    """Return what one dimension does for the rod, in words, and whether it passes; "" for no dimension."""
    every, required = list(_dimensions(draft, place)), summary.survival.required_safety_factor
    if not every:
        return "", False
    able = [(value, one) for one in every if (value := one.needed(required)) is not None]
    # The least relative change; where none suffices, the largest factor.
    value, one = (
        min(able, key=lambda pair: abs(log(pair[0] / pair[1].now)))
        if able
        else max(
            ((each.best(), each) for each in every), key=lambda pair: float(pair[1].least(np.array(pair[0])))
        )
    )
    study, key = draft.study, key_of(one.name)
    found = draft.factors(study.with_rod(**{key: value}))
    one.learn(value, found)
    again = one.needed(required)
    if again is None:
        most = min(found.values(), key=lambda each: each.low)
        return (
            f"No single dimension there suffices in the range that it may have: the best, {one.text(value)}, has a factor of "
            f"about {factor(most)} against {most.mode}"
        ), False
    return _checked(one.text(again), study.with_rod(**{key: again}), summary.rpm)


def bolt_remedy(study: Study, summary: Summary) -> tuple[str, bool]:
    """Return the bolts with which bolts and joint hold, in words, and whether the rod then passes."""
    at_speed = replace(study, speed=replace(study.speed, rpm=summary.rpm))
    survival, rows = summary.survival, bolts(at_speed).rows
    present, required = next(row for row in rows if row.present), survival.required_safety_factor
    of_joint = survival.mode.endswith("joint")
    least = present.preload_kN * (required / survival.assured_safety_factor if of_joint else 1.0)
    able = [row for row in rows if _holds(row, required) and row.preload_kN >= least and not row.present]
    if not able:
        return "No grade or standard thread that fits the holes suffices", False
    row = min(able, key=lambda row: (row.thread != present.thread, row.preload_kN))
    sizes = {} if row.thread == present.thread else SIZES
    keys = {"bolt_grade": row.grade, "bolt_thread": row.thread}
    other = study.with_(assembly={**TIGHTENING, **sizes, **keys})
    tightened = f"{quantity(row.preload_kN, '.1f', 'kN')}, {quantity(row.torque_Nm, '.0f', 'N·m')}"
    return _checked(f"bolts {row.thread} {row.grade}, tightened to {tightened}", other, summary.rpm)


def _holds(row: BoltRow, required: float) -> bool:
    factors = [one for one in (row.yield_factor, row.fatigue_factor) if one is not None]
    return row.yield_factor is not None and all(one.low >= required for one in factors)


def steel_remedy(study: Study, steel: OtherSteel, summary: Summary) -> tuple[str, bool]:
    """Return what a steel of the library does for the rod, in words, and whether it passes."""
    return _checked(f"the steel {steel.name}", replace(study, material=steel.table), summary.rpm)


def _checked(what: str, study: Study, rpm: float | None) -> tuple[str, bool]:
    """Return a change with what a whole run says of it, and whether the rod passes with it."""
    options, output = replace(study.analysis, film=False), replace(study.output, report=False)
    own = replace(study, analysis=options, output=output)
    adapted = refined_rod(own, [rpm], Clock())
    found = run_result(own, adapted, adapted.at(rpm)).summary.survival
    passes = found.answer in {SurvivalAnswer.SURVIVES, SurvivalAnswer.NOT_JUDGED}
    start, end = (what[0].upper() + what[1:], ": it") if passes else (f"With {what} it still", "")
    return f"{start}{end} {found.text}, solved again", passes
