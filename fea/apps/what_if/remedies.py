"""The least change of one dimension, of the bolts or of the steel with which a rod passes, solved again."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from math import ceil, floor, log
from typing import NamedTuple

import numpy as np

from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.analysis.summary_figures import Summary
from fea.apps.bolts.fitting import SIZES, TIGHTENING
from fea.apps.bolts.run_bolts import bolts
from fea.apps.optimise.problem import variables
from fea.apps.what_if.draft import Draft
from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer
from fea.machine.clock import Clock
from fea.output.report.advice import OtherSteel
from fea.output.units import factor, quantity
from fea.study.option_tables import OptimiseTable
from fea.study.proportions import dimensions_at
from fea.study.study import Study
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue

Factors = Mapping[str, SafetyFactor]
_RANGE = (0.6, 1.4)  # of a dimension of which [optimise] gives none, as there
_STEP, _LEAST_STEP = 1.1, 1.01  # to see what a dimension does
_AIM = 1.01  # of the required factor, which the solution is to reach
_TENTHS, _GRID = 10, 4001  # of a mm, to which a dimension is rounded; values of it that are tried


class DimensionEffect(NamedTuple):
    """A dimension, mm, its range, and the exponents of the least factors f = f₀ (x/x₀)^s by mode."""

    name: str
    now: float
    low: float
    high: float
    exponents: Mapping[str, float]

    def wanted(self, run: Factors, required: float) -> tuple[float, float]:
        """Return the nearest value that suffices, or else the best one, and the least assured factor."""
        values = np.geomspace(self.low, self.high, _GRID)
        every = [one.low * (values / self.now) ** self.exponents[mode] for mode, one in run.items()]
        least = np.min(every, axis=0)
        good = np.flatnonzero(least >= _AIM * required)
        if not good.size:
            return float(values[least.argmax()]), float(least.max())
        nearest = float(values[good[np.abs(np.log(values[good] / self.now)).argmin()]])
        rounded = (ceil if nearest > self.now else floor)(_TENTHS * nearest) / _TENTHS
        return min(max(rounded, self.low), self.high), _AIM * required


def exponents(run: Factors, found: Factors, share: float) -> dict[str, float]:
    """Return the exponents from the factors of a run and those at a share of the dimension."""
    return {mode: log(found[mode] / now) / log(share) for mode, now in run.items()}


def _effects(draft: Draft, place: str) -> Iterator[DimensionEffect]:
    """Yield the dimensions that carry the stress at a place, each solved with a step."""
    study, table = draft.study, draft.study.optimise or OptimiseTable()
    for name in dimensions_at(study.rod.dimensions, place):
        key, now = key_of(name), float(getattr(study.rod.dimensions, name))
        free = {key: table.free.get(key, tuple(share * now for share in _RANGE))}
        with suppress(InvalidValue):  # it has no effect, or stands outside of its bounds
            one = variables(replace(study, optimise=replace(table, free=free)))
            ends = (one.nearest_feasible(np.array([x]), one.start) for x in (0.0, 1.0))
            low, high = (one.dimensions(end)[key] for end in ends)
            step = min(_STEP * now, high) if high > _LEAST_STEP * now else max(now / _STEP, low)
            if max(step / now, now / step) >= _LEAST_STEP:
                found = draft.factors(study.with_rod(**{key: step}))
                yield DimensionEffect(name, now, low, high, exponents(draft.run, found, step / now))


def dimension_remedy(draft: Draft, summary: Summary, place: str) -> tuple[str, bool]:
    """Return what one dimension does for the rod, in words, and whether it passes; "" for no dimension."""
    run, study, required = draft.run, draft.study, summary.survival.required_safety_factor
    every = [(*one.wanted(run, required), one) for one in _effects(draft, place)]
    if not every:
        return "", False
    # The largest factor, and of those that suffice the least relative change.
    value, _, one = max(every, key=lambda each: (each[1], -abs(log(each[0] / each[2].now))))
    key, words = key_of(one.name), one.name.replace("_", " ")
    found = draft.factors(study.with_rod(**{key: value}))
    one = one._replace(exponents=exponents(run, found, value / one.now))
    value, least = one.wanted(run, required)
    what = f"{words} {quantity(value, '.1f', 'mm')} (now {quantity(one.now, '.1f', 'mm')})"
    if least >= _AIM * required:
        return _checked(what, study.with_rod(**{key: value}), summary.rpm)
    most = min(found.values(), key=lambda each: each.low)
    best = f"the best, {what}, has a factor of about {factor(most)} against {most.mode}"
    return f"No single dimension there suffices: {best}", False


def bolt_remedy(study: Study, summary: Summary) -> str:
    """Return the bolts with which bolts and joint hold, in words."""
    survival, rows = summary.survival, bolts(replace(study, speed=replace(study.speed, rpm=summary.rpm))).rows
    present, required = next(row for row in rows if row.present), survival.required_safety_factor
    of_joint = survival.mode.endswith("joint")
    least = present.preload_kN * (required / survival.assured_safety_factor if of_joint else 1.0)
    able = [
        row
        for row in rows
        if row.preload_kN >= least and not row.present and row.yield_factor is not None
        if min(each.low for each in (row.yield_factor, row.fatigue_factor) if each is not None) >= required
    ]
    if not able:
        return "No grade or standard thread that fits the holes suffices"
    row = min(able, key=lambda row: (row.thread != present.thread, row.preload_kN))
    sizes = {} if row.thread == present.thread else SIZES
    bolt = {**TIGHTENING, **sizes, "bolt_grade": row.grade, "bolt_thread": row.thread}
    tightened = f"{quantity(row.preload_kN, '.1f', 'kN')}, {quantity(row.torque_Nm, '.0f', 'N·m')}"
    what = f"bolts {row.thread} {row.grade}, tightened to {tightened}"
    return _checked(what, study.with_(assembly=bolt), summary.rpm)[0]


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
    said = f"{what[0].upper()}{what[1:]}: it" if passes else f"With {what} it still"
    return f"{said} {found.text}, solved again", passes
