"""From a study to everything found at one speed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from fea.base.checks import Check
from fea.base.material import Material
from fea.judge.case_result import CaseResult
from fea.rod.loading import Loading
from fea.run.adapt import Adapted
from fea.run.buckling import BucklingReport, buckling_report
from fea.run.cycle.superposition import CycleResult
from fea.run.figures import EnvelopeFigures, Summary
from fea.run.instants import Instants
from fea.run.life import Life
from fea.run.motion import Known, Motion, agreeing, motion
from fea.run.prepare import PreparedRod
from fea.run.speed import SpeedResult
from fea.run.summary import speed_summary
from fea.study.study import Study
from geometry.mass import MassProperties
from mesh.tetmesh import TetMesh


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Everything that an analysis found at one speed.

    Attributes
    ----------
    study
        What was asked, with this speed alone.
    summary
        The figures, as `summary.json` holds them.
    mesh
        Of the whole rod.
    materials
        One per part.
    mass
        Mass properties of the meshed rod, t and mm.
    loading
        The engine, or given forces.
    speed
        Fields and checks; None at a speed of many whose figures alone were worked out.
    buckling
        Column formulas, and modes of the solid where they were asked for; None as `speed`.
    motion
        The surface over the whole crank cycle, where a report with the cycle was asked for.
    without_motion
        Why there is none although it was asked for; empty otherwise.
    instants
        Fields over the crank cycle, where they were asked for.
    life
        Life over the duty of the study, where it has one.
    """

    study: Study
    summary: Summary
    mesh: TetMesh
    materials: tuple[Material, ...]
    mass: MassProperties
    loading: Loading
    speed: SpeedResult | None
    buckling: BucklingReport | None
    motion: Motion | None = None
    without_motion: str = ""
    instants: Instants | None = None
    life: Life | None = None

    @property
    def rpm(self) -> float | None:
        """Engine speed; None where forces are given."""
        return self.summary.rpm

    @property
    def cases(self) -> Mapping[str, CaseResult]:
        """One result per load case, by its name."""
        return {} if self.speed is None else self.speed.cases

    @property
    def checks(self) -> Mapping[str, Check]:
        """Value and limit of every check, by its name."""
        return self.summary.checks

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return self.summary.trusted

    @property
    def cycle(self) -> CycleResult | None:
        """The whole crank cycle, where it was asked for."""
        return None if self.speed is None else self.speed.cycle

    def envelope_data(self) -> dict[str, Any]:
        """Arrays at the nodes of the envelope, with the damage of the duty; none without the cycle."""
        if self.cycle is None:
            return {}
        return self.cycle.envelope.point_data() | ({} if self.life is None else self.life.point_data())


def outcome(study: Study, adapted: Adapted, result: SpeedResult) -> Outcome:
    """Gather all that is found at one speed that was solved on the adapted mesh of a study."""
    buckling = buckling_report(adapted.rod, result)
    summary = speed_summary(adapted, result, buckling)
    found = outcome_of(study, adapted.rod, summary, result, buckling)
    if study.output.report:
        moving, why = _motion(adapted.rod, summary, result)
        found = replace(found, motion=moving, without_motion=why)
    step = study.output.pvd_step_deg
    if step is not None and summary.rpm is not None:
        found = replace(found, instants=Instants(adapted.rod, summary.rpm, step))
    return found


def _motion(rod: PreparedRod, summary: Summary, result: SpeedResult) -> tuple[Motion | None, str]:
    """The modes of the cycle, where it was analysed; and why there are none."""
    envelope, cycle = summary.envelope, result.cycle
    if summary.rpm is None or cycle is None or not isinstance(envelope, EnvelopeFigures):
        return None, ""
    peaks = [
        Known(float(case.load.crank_angle), case.von_mises, case.displacement)
        for case in result.cases.values()
        if case.load.in_cycle
    ]
    with rod.clock("report"):
        return agreeing(motion(rod, summary.rpm, envelope.max_von_mises_MPa, cycle.weights), peaks)


def outcome_of(
    study: Study,
    rod: PreparedRod,
    summary: Summary,
    speed: SpeedResult | None = None,
    buckling: BucklingReport | None = None,
) -> Outcome:
    """Gather what was found at one speed."""
    return Outcome(
        study=at_speed(study, summary.rpm),
        summary=summary,
        mesh=rod.mesh.whole,
        materials=rod.materials,
        mass=rod.mass,
        loading=rod.loading,
        speed=speed,
        buckling=buckling,
        life=rod.life,
    )


def at_speed(study: Study, rpm: float | None) -> Study:
    """Return the study of one speed alone, which runs again without replacing what it is part of."""
    output = replace(study.output, directory=None, animate=None)
    speed = study.speed if rpm is None else replace(study.speed, rpm=rpm)
    return replace(study, speed=speed, output=output)
