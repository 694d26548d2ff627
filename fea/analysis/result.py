"""A run at one speed: from a study to everything found there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from fea.analysis.buckling import BucklingReport, buckling_report
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.film import FilmResult
from fea.analysis.forces import force_columns
from fea.analysis.fretting import RubbedSurfaces
from fea.analysis.life import Life
from fea.analysis.life_figures import EnvelopeFigures
from fea.analysis.motion import Motion, SolvedInstant, agreeing, motion
from fea.analysis.pipeline import RefinedRod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary import speed_summary
from fea.analysis.summary_figures import Summary
from fea.base.checks import Check
from fea.base.material import Material
from fea.base.units import DEG
from fea.judge.case_result import CaseResult, masked_array, nodal_arrays, of_weakest
from fea.rod.loading import EngineLoading, Loading
from fea.solid.stress import principal, von_mises
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.mass import MassProperties
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Array = npt.NDArray[Any]
Arrays = Mapping[str, Array]
# Of the names of the surfaces; the big end's first.
BORES = (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)


# Instants computed together: each takes some 200 bytes per node of the whole rod.
_BLOCK = 8


@dataclass(frozen=True)
class InstantFields:
    """The rod at every so many degrees of a cycle."""

    rod: PreparedRod  #: with its unit solutions
    rpm: float  #: engine speed
    step: float  #: degrees from one instant to the next

    @property
    def degrees(self) -> list[float]:
        """The crank angles: the last is before the cycle begins anew."""
        whole = self.rod.engine.engine.cycle_degrees
        return [self.step * k for k in range(int(np.ceil(whole / self.step - 1e-9)))]

    def fields(self) -> Iterator[dict[str, Array]]:
        """Yield the nodal arrays of each instant, named as in a load case, in single precision."""
        for moved, stress, equivalent, factor in self.solved():
            arrays = nodal_arrays(moved, stress, equivalent, principal(stress), factor)
            yield {name: np.ascontiguousarray(values, np.float32) for name, values in arrays.items()}

    def solved(self) -> Iterator[tuple[Floats, Floats, Floats, Floats]]:
        """Yield displacement (n_nodes, 3), stress (n_nodes, 6), its von Mises stress and the safety factor.

        The last two are (n_nodes,). Displacement is solved for, stress is superposed; where parts meet, it is
        that of the part that is closer to yielding.
        """
        angles = np.array(self.degrees) * DEG
        weights = self.rod.cycle.weights(self.rod.crank_cycle(self.rpm), angles)
        for start in range(0, len(angles), _BLOCK):
            block = slice(start, start + _BLOCK)
            moved = self.rod.displacement(self.rpm, angles[block])
            at, whole = weights.at(block), self.rod.mesh.mirrored
            tensors = [self.rod.cycle.units.tensor(n, at, whole) for n in range(len(self.rod.materials))]
            for k in range(moved.shape[-1]):
                stresses = [tensor[..., k] for tensor in tensors]
                equivalents = [von_mises(stress) for stress in stresses]
                factor, equivalent, stress = of_weakest(self.rod.materials, equivalents, stresses)
                yield moved[..., k], stress, equivalent, factor


class DrawnBore(NamedTuple):
    """A bore as a drawing of its loads needs it: the x of its centre, its radius and its ends along z, mm."""

    x: float
    radius: float
    low: float
    high: float


def drawn_bores(mesh: TetMesh, rod_length: float) -> tuple[DrawnBore, ...]:
    """Measure the bores of a mesh with named surfaces; none if it has no names."""
    bores = []
    for surface, x in zip(BORES, (0.0, rod_length), strict=True):
        if surface not in mesh.facets:
            return ()
        points = mesh.points[np.unique(mesh.facets[surface])]
        radius = float(np.hypot(points[:, 0] - x, points[:, 1]).mean())
        bores.append(DrawnBore(x, radius, float(points[:, 2].min()), float(points[:, 2].max())))
    return tuple(bores)


class Change(NamedTuple):
    """A change that was solved: what it is, in words, and the least safety factor before and after it."""

    text: str
    now: float
    then: float


class WhatIf(NamedTuple):
    """What was solved beside a run: see `fea.apps.what_if`."""

    assumed: tuple[Change, ...] = ()  #: of values that are assumed
    remedies: tuple[str, ...] = ()  #: what would make the rod pass, in words
    left_out: str = ""  #: why some of it was not solved


ELSEWHERE = WhatIf(left_out="Other assumptions are solved in the report of the governing speed only.")


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """All results of one speed. Names without a unit are those of `fea.output.stored_run.StoredRun`, too."""

    study: Study  #: what was asked, with this speed alone
    summary: Summary  #: the figures, as `summary.json` holds them
    mesh: TetMesh  #: the whole rod, mm
    materials: tuple[Material, ...]  #: one per part
    mass: MassProperties  #: of the meshed rod, t and mm
    loading: Loading
    speed: SpeedResult | None  #: None at a speed of many whose figures alone were worked out, as the buckling
    buckling: BucklingReport | None
    motion: Motion | None = None  #: the surface over the cycle, where a report with the cycle was asked for
    without_motion: str = ""  #: why there is none although it was asked for
    instants: InstantFields | None = None  #: fields over the crank cycle, where they were asked for
    pictured: bool = False  #: whether pictures are drawn where it is written
    life: Life | None = None  #: over the duty of the study, where it has one
    what_if: WhatIf = field(default_factory=WhatIf)  #: what was solved beside it for a report

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

    @cached_property
    def fields(self) -> Mapping[str, Arrays]:
        """Nodal arrays of each load case by their names in its VTU file; nothing for figures alone."""
        return {name: case.point_data() for name, case in self.cases.items()}

    @cached_property
    def envelope(self) -> Arrays | None:
        """Nodal arrays of the whole crank cycle, with the damage of the duty; None without the cycle."""
        if self.cycle is None:
            return None
        damage = {} if self.life is None else self.life.point_data()
        defect = None if self.speed is None else self.speed.largest_defect
        largest = {} if defect is None else {"largest_defect_um": defect}
        return self.cycle.envelope.point_data() | damage | largest | masked_array(self.cycle.counts)

    @cached_property
    def left(self) -> Mapping[str, Arrays]:
        """Nodal arrays of what flow leaves without load: ``plastic`` in running, ``overload`` after that."""
        flows = {} if self.speed is None else self.speed.flows
        return {name: each.left for name, each in flows.items() if each.ends_with_flow}

    @cached_property
    def forces(self) -> Mapping[str, npt.ArrayLike] | None:
        """The columns of ``loads.csv``; None where forces are given."""
        if not isinstance(self.loading, EngineLoading) or self.rpm is None:
            return None
        return force_columns(self.loading.engine, self.mass, self.loading.gas, self.rpm)

    @property
    def fretting(self) -> RubbedSurfaces | None:
        """The surfaces that rub over the cycle, where that was asked for."""
        return None if self.speed is None or self.speed.fretting is None else self.speed.fretting.drawn

    @property
    def films(self) -> tuple[FilmResult, ...]:
        """The oil films, where they were asked for."""
        return () if self.speed is None else self.speed.films

    @property
    def film(self) -> Mapping[str, npt.ArrayLike] | None:
        """The columns of ``film.csv``; None where no oil film was computed."""
        return {name: values for film in self.films for name, values in film.columns.items()} or None

    @property
    def log(self) -> Mapping[str, npt.ArrayLike] | None:
        """The columns of ``log.csv``; None where the duty is not a log."""
        return None if self.life is None else self.life.log

    @cached_property
    def contact(self) -> Arrays | None:
        """The columns of ``contact.csv``; None where there is no contact over the cycle."""
        cycle = self.cycle
        return cycle.contact_columns() if cycle is not None and cycle.touches else None

    @property
    def bores(self) -> tuple[DrawnBore, ...]:
        """The two bores, the big end's first; empty where they were not found."""
        return drawn_bores(self.mesh, self.summary.rod.length_mm)


def run_result(study: Study, adapted: RefinedRod, result: SpeedResult) -> RunResult:
    """Gather all that is found at one speed that was solved on the adapted mesh of a study."""
    buckling = buckling_report(adapted.rod, result)
    summary = speed_summary(adapted, result, buckling)
    run = gathered_result(study, adapted.rod, summary, result, buckling)
    if study.output.report:
        moving, why = _motion(adapted.rod, summary, result)
        run = replace(run, motion=moving, without_motion=why)
    step = study.output.pvd_step_deg
    if step is not None and summary.rpm is not None:
        run = replace(run, instants=InstantFields(adapted.rod, summary.rpm, step))
    return run


def _motion(rod: PreparedRod, summary: Summary, result: SpeedResult) -> tuple[Motion | None, str]:
    envelope, cycle = summary.envelope, result.cycle
    if summary.rpm is None or cycle is None or not isinstance(envelope, EnvelopeFigures):
        return None, ""
    peaks = [
        SolvedInstant(float(case.load.crank_angle), case.von_mises, case.displacement)
        for case in result.cases.values()
        if case.load.in_cycle
    ]
    with rod.clock("report"):
        return agreeing(motion(rod, summary.rpm, envelope.max_von_mises_MPa), peaks)


def gathered_result(
    study: Study,
    rod: PreparedRod,
    summary: Summary,
    speed: SpeedResult | None = None,
    buckling: BucklingReport | None = None,
) -> RunResult:
    """Gather what was found at one speed: its study runs again without replacing what it is part of."""
    rpm, output = summary.rpm, replace(study.output, directory=None, animate=None)
    at_speed = study.speed if rpm is None else replace(study.speed, rpm=rpm)
    return RunResult(
        study=replace(study, speed=at_speed, output=output),
        summary=summary,
        mesh=rod.mesh.whole,
        materials=rod.materials,
        mass=rod.mass,
        loading=rod.loading,
        speed=speed,
        buckling=buckling,
        life=rod.life,
    )
