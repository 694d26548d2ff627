"""A prepared rod at one speed: solve its load cases, judge the stresses, check everything."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from fea.analysis.prepare import PreparedRod
from fea.analysis.solve import Equilibrium
from fea.analysis.speed_checks import speed_checks
from fea.assess.case_result import CaseResult, case_result
from fea.assess.plausible import unit_remarks
from fea.assess.remarks import check_remarks
from fea.checks import LIMITS, Check
from fea.choices import Element
from fea.cycle.superposition import CycleResult
from fea.rod.load_cases import EngineLoading, SpeedLoads
from fea.rod.omission import Omission
from fea.solid.parity import Parity
from fea.solvers.static import Solution
from fea.units import RPM
from loads.cases import assembled


@dataclass(frozen=True, kw_only=True)
class SpeedResult:
    """Everything found at one speed.

    Attributes
    ----------
    rpm
        None where forces are given instead of an engine.
    loads
        The load cases, and what was left out of them.
    cases
        One result per load case, by its name.
    checks
        By name.
    left_out
        What was not computed, and why.
    notes
        What a reader must know beside the figures.
    cycle
        The whole crank cycle, where it was asked for.
    """

    rpm: float | None
    loads: SpeedLoads
    cases: Mapping[str, CaseResult]
    checks: Mapping[str, Check]
    left_out: tuple[Omission, ...]
    notes: tuple[str, ...]
    cycle: CycleResult | None = None

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return all(item.passed for item in self.checks.values())


def solve_speed(rod: PreparedRod, rpm: float | None) -> SpeedResult:
    """Solve, judge and check the load cases of one speed.

    Parameters
    ----------
    rod
        Ready to be solved.
    rpm
        The speed; None for given forces.

    Raises
    ------
    InvalidValue
        Nothing loads the rod.
    UnderconstrainedError, SingularMatrixError
        See `Model.solve`.
    """
    with rod.clock("loads"):
        loads = rod.loading.at(rod.mass, rpm)
    if rod.putting is not None:
        loads = replace(loads, cases=(*loads.cases, assembled()))
    found = rod.pins.equilibrium(loads.cases)
    with rod.clock("stress"):
        cases = judge(rod, found)
    checks = speed_checks(rod, found, tuple(cases.values()))
    engine = rod.loading.engine if isinstance(rod.loading, EngineLoading) else None
    notes = (
        *check_remarks(checks),
        *unit_remarks(rod.materials, engine),
        *loads.notes,
        *rod.mesh.notes,
        *_pressure_notes(rod),
        *_rim_notes(rod),
    )
    return SpeedResult(
        rpm=rpm,
        loads=loads,
        cases=cases,
        checks=checks,
        left_out=(*rod.mesh.left_out, *_solution_left_out(rod, found.solution), *loads.left_out),
        notes=(*notes, *rod.remarks),
    )


def with_cycle(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Work out the whole crank cycle at a speed whose load cases are solved."""
    engine, gas = rod.engine.engine, rod.engine.gas
    cycle = rod.cycle
    with rod.clock("cycle"):
        history = cycle.at(engine, gas, (static.rpm or 0.0) * RPM, tuple(static.cases.values()))
    checks, notes = {**static.checks, **history.checks()}, (*static.notes, *history.notes())
    return replace(static, checks=checks, notes=notes, cycle=history)


def judge(rod: PreparedRod, found: Equilibrium) -> dict[str, CaseResult]:
    """Recover the stresses of load cases in equilibrium and judge them, by the name of the case."""
    return {
        case.name: case_result(
            case,
            rod.mesh.whole,
            fields.displacement,
            fields.stresses,
            materials=rod.materials,
            error=fields.error,
            contact_pressure=fields.contact_pressure,
            gap=fields.gap,
            assembly=forces.assembly,
            made=rod.made,
            touch=forces.touch,
            sharp=rod.sharp_places,
        )
        for case, forces, fields in zip(found.cases, found.forces, rod.fields(found), strict=True)
    }


def _solution_left_out(rod: PreparedRod, solution: Solution) -> tuple[Omission, ...]:
    """What the loads and the materials spare."""
    spared = []
    if Parity.ANTISYMMETRIC not in solution.displacement and rod.mesh.cut_y:
        spared.append(Omission("antisymmetric part about y = 0", "every load is symmetric about y = 0"))
    if not rod.soft and rod.element is Element.P2:
        why = f"ν is at most {LIMITS['poissons_ratio_p2']} everywhere"
        spared.append(Omission("pressure unknowns", why))
    return tuple(spared)


def _rim_notes(rod: PreparedRod) -> list[str]:
    """Where the stress of parts that touch is left out."""
    places = [f"{rim.name} ({rim.radius:.2g} mm)" for rim in rod.fields.errors.rims]
    return [f"stress: the figures leave out the places near the {', '.join(places)}"] if places else []


def _pressure_notes(rod: PreparedRod) -> list[str]:
    names = list(rod.mesh.parts)
    return [
        f"{names[n]}: solved with a pressure of its own, as ν = {rod.materials[n].poissons_ratio:g}"
        for n in rod.soft
    ]
