"""A run's rod on a coarse mesh: what a change does to its safety factors, and what assumptions do."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import isfinite

from fea.analysis.meshing import COARSER, mesh_loaded
from fea.analysis.pipeline import MovingRod, RefinedRod
from fea.analysis.result import Change, run_result
from fea.analysis.summary_figures import Summary
from fea.analysis.survival import FATIGUE, factors
from fea.base.shipped import shipped_toml
from fea.judge.safety_factor import SafetyFactor
from fea.machine.clock import Clock
from fea.rod.meshed_rod import MeshedRod
from fea.study.load_cases import load_cases_alone
from fea.study.option_tables import PINS, MeshTable
from fea.study.proportions import assumed_at
from fea.study.study import Study
from geometry.dimensions import key as key_of

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
