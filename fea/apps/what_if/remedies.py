"""The least change of one dimension, of the bolts or of the steel with which a rod passes, solved again.

A rod on a coarse mesh (`Draft`) shows what a change does to its safety factors, and what assumptions do.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import ceil, floor, isfinite, log
from typing import NamedTuple

import numpy as np

from fea.analysis.meshing import COARSER, mesh_loaded
from fea.analysis.pipeline import MovingRod, RefinedRod, refined_rod
from fea.analysis.result import Change, run_result
from fea.analysis.summary_figures import Summary
from fea.analysis.survival import FATIGUE, factors
from fea.apps.bolts.run_bolts import SIZES, TIGHTENING, bolts
from fea.apps.optimise.problem import variables
from fea.base.shipped import shipped_toml
from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer
from fea.machine.clock import Clock
from fea.output.report.advice import OtherSteel
from fea.output.units import factor, quantity
from fea.rod.meshed_rod import MeshedRod
from fea.study.changes import load_cases_alone
from fea.study.option_tables import PINS, MeshTable, OptimiseTable
from fea.study.plausibility import assumed_at, dimensions_at
from fea.study.study import Study
from geometry.dimensions import key as key_of
from geometry.errors import InvalidValue

VARIED = shipped_toml("study/varied.toml")
# In notes: of an assumed value its key and the value; of a computed peak those of late and early combustion.
_KEY = re.compile(r"^assumed (\w+) = |^assumed .*\((\w+\.\w+)\)$")
_VALUE = re.compile(r"\d+(?:\.\d+)?")
_PEAKS = re.compile(r"late to early combustion it is (\d+) to (\d+) bar")
_MOST, _THINNER = 4, 0.95  # assumptions that are solved; share of dimensions that are assumed
_meshed = partial(mesh_loaded, clock=Clock(), movable=True, coarser=COARSER)


def least_factors(summary: Summary) -> dict[str, SafetyFactor]:
    """Return the least safety factor of a run, less its error bar, against each mode of failure."""
    found = factors(summary.results, summary.buckling, summary.envelope, summary.assembly)
    if (most := summary.survival.fatigue_at_most) is not None:
        found.append(most.against(FATIGUE))
    return {one.mode: one for one in sorted(filter(isfinite, found), key=lambda one: -one.low)}


class Draft:
    """A run's rod on the coarse mesh with which a refinement begins, solved with changes at its load cases.

    Stress on such a mesh is off by some percent, but by nearly the same before and after a change: the ratio
    is right within 0.5 % (docs/do/study.md). `alone`: without cap and bolts. Raises as `prepare`.
    """

    def __init__(self, study: Study, summary: Summary, *, alone: bool) -> None:
        self.study, self.run = study, least_factors(summary)
        self.rpm, self.alone = summary.rpm, alone
        own = self._of(study)
        self._moving = MovingRod(_meshed(own))
        self._base = self._solved(own, self._moving.base)

    def factors(self, study: Study) -> dict[str, SafetyFactor]:
        """Return the run's least safety factor against each mode with what a study has changed."""
        own, same = self._of(study), study.rod == self.study.rod
        changed = self._solved(own, self._moving.base if same else self._moving.mesh(own) or _meshed(own))
        share = {mode: changed.get(mode, now) / now for mode, now in self._base.items()}
        each = [(share.get(mode, 1.0), now) for mode, now in self.run.items()]
        return {now.mode: SafetyFactor(k * now, k * now.low, k * now.high, mode=now.mode) for k, now in each}

    def _of(self, study: Study) -> Study:
        own = load_cases_alone(study, film=False, buckling=False, tolerance_percent=0.0)
        own = replace(own, mesh=MeshTable(element=study.mesh.element))
        own = own if self.rpm is None else replace(own, speed=replace(own.speed, rpm=self.rpm))
        pins = {name: table for name, table in own.part_material.items() if name in PINS}
        return replace(own, assembly=None, part_material=pins) if self.alone else own

    def _solved(self, study: Study, mesh: MeshedRod) -> dict[str, SafetyFactor]:
        adapted = RefinedRod(self._moving.prepared(study, mesh))
        return least_factors(run_result(study, adapted, adapted.at(self.rpm)).summary)


def assumed_changes(draft: Draft, summary: Summary, place: str) -> Iterator[Change]:
    """Yield what assumptions change: the least factor of the run, and what it becomes."""
    now = min(draft.run.values())
    for words, study in list(_varied(draft, summary, place))[:_MOST]:
        yield Change(words, now, min(draft.factors(study).values()))


def _varied(draft: Draft, summary: Summary, place: str) -> Iterator[tuple[str, Study]]:
    study, rod, notes = draft.study, draft.study.rod.dimensions, [note.text for note in summary.notes]
    for low, high in (found.groups() for text in notes if (found := _PEAKS.search(text))):
        late = study.with_(engine={"peak_pressure_bar": float(low)})
        yield f"peak pressure {high} bar, of early combustion; {low} bar of late", late
    if names := assumed_at(rod, place):
        sizes = {key_of(name): _THINNER * getattr(rod, name) for name in names}
        yield "dimensions there by assumed proportions, 5 % less", study.with_rod(**sizes)
    values = {
        found[1] or found[2]: float(value[0])
        for text in notes
        if (found := _KEY.search(text)) and (value := _VALUE.search(text))
    }
    for key, varied in VARIED.items():
        if key in values and not (draft.alone and key.startswith("assembly.")):
            table, _, name = key.rpartition(".")
            other: dict[str, object] = {table or "engine": {name: varied["share"] * values[key]}}
            yield varied["words"], study.with_(**other)  # type: ignore[arg-type]


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
