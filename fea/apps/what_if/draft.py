"""A run's rod on a coarse mesh, to see what a change does to each of its safety factors."""

from dataclasses import replace
from math import isfinite

from fea.analysis.figures import Summary
from fea.analysis.meshing import COARSER, mesh_loaded
from fea.analysis.pipeline import MovingRod, RefinedRod
from fea.analysis.result import run_result
from fea.analysis.survival import FATIGUE, factors
from fea.judge.safety_factor import SafetyFactor
from fea.machine.clock import Clock
from fea.rod.meshed_rod import MeshedRod
from fea.study.option_tables import PINS, MeshTable
from fea.study.study import Study


def least_factors(summary: Summary) -> dict[str, SafetyFactor]:
    """Return the least safety factor of a run, less its error bar, against each mode of failure."""
    found = factors(summary.results, summary.buckling, summary.envelope, summary.assembly)
    if (most := summary.survival.fatigue_at_most) is not None:
        found.append(most.against(FATIGUE))
    every = sorted((one for one in found if isfinite(one)), key=lambda one: -one.low)
    return {one.mode: one for one in every}


class Draft:
    """A run's rod on the coarse mesh with which a refinement begins, solved with changes at its load cases.

    Stress on such a mesh is off by some percent, but by nearly the same before and after a change: the ratio
    is right within 0.5 % (docs/do/report.md). `alone`: without cap and bolts. Raises as `prepare`.
    """

    def __init__(self, study: Study, summary: Summary, *, alone: bool) -> None:
        self.study, self.run = study, least_factors(summary)
        self._rpm, self.alone = summary.rpm, alone
        own = self._of(study)
        self._moving = MovingRod(_meshed(own))
        self._base = self._solved(own, self._moving.base)

    def factors(self, study: Study) -> dict[str, SafetyFactor]:
        """Return the run's least safety factor against each mode with what a study has changed."""
        own, base = self._of(study), self._moving.base
        mesh = base if own.rod == self.study.rod else self._moving.mesh(own) or _meshed(own)
        changed = self._solved(own, mesh)
        share = {mode: changed[mode] / now for mode, now in self._base.items() if mode in changed}
        return {mode: _times(now, share.get(mode, 1.0)) for mode, now in self.run.items()}

    def _of(self, study: Study) -> Study:
        options = replace(study.analysis, cycle=False, film=False, buckling=False, tolerance_percent=0.0)
        own = replace(study, analysis=options, duty=None, mesh=MeshTable(element=study.mesh.element))
        if self._rpm is not None:
            own = replace(own, speed=replace(own.speed, rpm=self._rpm))
        if not self.alone:
            return own
        pins = {name: table for name, table in own.part_material.items() if name in PINS}
        return replace(own, assembly=None, part_material=pins)

    def _solved(self, study: Study, mesh: MeshedRod) -> dict[str, SafetyFactor]:
        adapted = RefinedRod(self._moving.prepared(study, mesh))
        return least_factors(run_result(study, adapted, adapted.at(self._rpm)).summary)


def _meshed(study: Study) -> MeshedRod:
    return mesh_loaded(study, Clock(), movable=True, coarser=COARSER)


def _times(factor: SafetyFactor, share: float) -> SafetyFactor:
    return SafetyFactor(share * factor, share * factor.low, share * factor.high, mode=factor.mode)
