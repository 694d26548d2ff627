"""The main job: a study through geometry, mesh, loads, solution and judgement, to figures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.analysis.check import run_checks
from fea.assess.case_error import CaseErrors
from fea.assess.case_result import CaseResult, case_result
from fea.assess.plausible import unit_remarks
from fea.assess.remarks import check_remarks
from fea.checks import LIMITS, Check
from fea.choices import Element, Support
from fea.cycle.superposition import CycleAnalysis, CycleResult
from fea.cycle.unit_loads import UnitLoads
from fea.cycle.unit_solutions import unit_solutions
from fea.machine.clock import Clock
from fea.material import Material, Materials, of_parts
from fea.rod.case_forces import CaseForces, CaseLoads
from fea.rod.discretise import Discretised, discretise
from fea.rod.load_cases import SpeedLoads, speed_loads
from fea.rod.omission import Omission
from fea.rod.shank import part_at, shank
from fea.solid.datum import referred_to_bores
from fea.solid.inertia import inertia
from fea.solid.parity import Parity, Split
from fea.solid.pins import held_by_pins
from fea.solvers.buckling import Buckling
from fea.solvers.static import Model, Solution
from fea.stress.part_recovery import PartRecovery
from fea.stress.section_balance import SectionBalance
from fea.study.study import Study
from fea.units import RPM
from geometry.arrays import Floats
from geometry.invalid import InvalidValue
from geometry.mass import MassProperties
from geometry.section import Section
from geometry.surfaces import Surface
from loads.bearing import BorePressure
from loads.cases import LoadCase
from loads.engine import Engine
from loads.gas import GasModel
from loads.peaks import load_case
from mesh.size_field import SizeField


@dataclass(frozen=True)
class SpeedResult:
    """Everything a run at one speed found.

    Attributes
    ----------
    rpm
        None where forces were given in place of an engine.
    cases
        One result a load case.
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
    cases: tuple[CaseResult, ...]
    checks: dict[str, Check]
    left_out: tuple[Omission, ...]
    notes: tuple[str, ...]
    cycle: CycleResult | None = None

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return all(item.passed for item in self.checks.values())


class Analysis:
    """A study whose rod is meshed and whose stiffness stands ready; speeds are solved one by one.

    Parameters
    ----------
    study
        What is asked.
    clock
        Times the stages.
    wanted
        Element sizes that earlier solutions ask for.
    coarser
        Factor on the default element size.

    Raises
    ------
    InvalidValue
        A value of the study breaks a rule.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """

    def __init__(
        self, study: Study, clock: Clock, wanted: Sequence[SizeField] = (), coarser: float = 1.0
    ) -> None:
        self.study, self._clock = study, clock
        self.materials: tuple[Material, ...] = ()
        self.pressure = BorePressure.parse(study.analysis.pressure)
        self.engine: Engine | None = None
        self.gas: GasModel | None = None
        # Refused before anything is meshed.
        if study.engine is None and study.forces is None:
            rule = "has neither [engine] nor [forces]"
            raise InvalidValue("STUDY", study.name, rule, "Add one of them.")
        study.require_balance()
        if study.engine is not None and study.rod.length is not None:
            study.engine.gas_model(study.engine.engine(study.rod.length))
        self.mesh: Discretised = discretise(study, clock, wanted, coarser)
        if study.engine is not None:
            self.engine = study.engine.engine(self.mesh.bores.rod_length)
            self.gas = study.engine.gas_model(self.engine)
        self.materials = study.materials(self.mesh.parts)
        if self.soft and study.analysis.buckling:
            nu, most = max(m.poissons_ratio for m in self.materials), LIMITS["poissons_ratio_p2"]
            rule = f"must not exceed {most} for buckling, which knows displacement elements alone"
            raise InvalidValue("material.nu", nu, rule, "Leave out --buckling: the column formulas remain.")
        cell = self.mesh.cell
        elastic = of_parts(self.materials, cell.part)
        with clock("loads"):
            self._inertia = inertia(cell, elastic.density, study.analysis.assembly)
            self.case_loads = CaseLoads(
                cell, self.mesh.bores, self._inertia, self.pressure, study.analysis.support
            )
        self.model = self._model(elastic)
        with clock("stress"):
            self._recovery = PartRecovery(cell, self.mesh.symmetry.planes, self._free_surfaces())
            held = () if study.analysis.support is not Support.CLAMPED else (Surface.BIG_END_BORE,)
            self._errors = CaseErrors(self.mesh, self.materials, held)

    @property
    def soft(self) -> tuple[int, ...]:
        """Numbers of the parts that displacement alone would not hold: they get a pressure of their own."""
        if self.study.mesh.element is not Element.P2:
            return ()
        limit = LIMITS["poissons_ratio_p2"]
        return tuple(n for n, material in enumerate(self.materials) if material.poissons_ratio > limit)

    @property
    def formulation(self) -> str:
        """What is solved for."""
        return "displacement-pressure" if self.soft else "displacement"

    def _pressure_notes(self) -> list[str]:
        names = list(self.mesh.parts)
        return [
            f"{names[n]}: solved with a pressure of its own, as ν = {self.materials[n].poissons_ratio:g}"
            for n in self.soft
        ]

    def _pressure_left_out(self) -> tuple[Omission, ...]:
        if self.soft or self.study.mesh.element is not Element.P2:
            return ()
        return (Omission("pressure unknowns", f"ν is at most {LIMITS['poissons_ratio_p2']} everywhere"),)

    def _model(self, elastic: Material | Materials) -> Model:
        cell, asked = self.mesh.cell, self.study.analysis
        if not self.soft:
            return Model(cell, elastic, asked.support, asked.solver, self._clock, assembly=asked.assembly)
        from fea.solvers.mixed import MixedModel  # noqa: PLC0415 - metal rods do without

        return MixedModel(
            cell,
            self.materials,
            self.soft,
            asked.support,
            solver=asked.solver,
            clock=self._clock,
            assembly=asked.assembly,
        )

    @property
    def rod(self) -> MassProperties:
        """Mass properties of the meshed rod."""
        return self._inertia.properties

    def forces(self, rpm: float | None) -> list[Split]:
        """Nodal forces of each load case on the cell, N."""
        return [self.case_loads(case).forces for case in self._loads(rpm).cases]

    def at(self, rpm: float | None, *, cycle: bool = True) -> SpeedResult:
        """Solve the load cases of one speed (rpm); None for given forces.

        Parameters
        ----------
        rpm
            The speed.
        cycle
            Whether the whole crank cycle is worked out as well, where the study asks for it.
        """
        with self._clock("loads"):
            loads = self._loads(rpm)
            forces = [self.case_loads(case) for case in loads.cases]
        solution = self.model.solve([case.forces for case in forces])
        with self._clock("stress"):
            cases = tuple(self._judged(loads.cases, forces, solution))
        checks = run_checks(
            self.mesh,
            self.materials,
            forces,
            solution,
            cases,
            mass=self.rod.mass,
            sections=self._amid,
            displacement_only=[n for n in range(len(self.materials)) if n not in self.soft],
            held=self.study.analysis.support is Support.CLAMPED,
        )
        parities = (
            ()
            if Parity.ANTISYMMETRIC in solution.displacement or not self.mesh.cut_y
            else (Omission("antisymmetric part about y = 0", "every load is symmetric about y = 0"),)
        )
        left_out = (*self.mesh.left_out, *parities, *self._pressure_left_out(), *loads.left_out)
        remarks = (*check_remarks(checks), *unit_remarks(self.materials, self.engine))
        notes = (*remarks, *loads.notes, *self.mesh.notes, *self._pressure_notes())
        history = self._cycle_at(rpm, cases) if cycle else None
        if history is not None:
            checks |= history.checks()
            notes += history.notes()
        return SpeedResult(rpm, cases, checks, left_out, notes, history)

    def displacement(self, rpm: float, angles: Floats) -> Floats:
        """Displacement (n_nodes, 3, n) of the whole rod at crank angles (n,), rad: mm, seen from the bores.

        Raises
        ------
        InvalidValue
            There is no engine.
        """
        if self.engine is None or self.gas is None:
            raise InvalidValue("study", self.study.name, "has no [engine]", "Add one.")
        engine, gas, speed = self.engine, self.gas, rpm * RPM
        cases = [load_case(engine, self.rod, gas, speed, angle, name="instant") for angle in angles]
        solution = self.model.solve([self.case_loads(case).forces for case in cases])
        return self._on_whole(solution)

    @cached_property
    def cycle_analysis(self) -> CycleAnalysis:
        """The unit solutions of the whole crank cycle at any speed, solved when first asked for."""
        with self._clock("cycle"):
            loads = UnitLoads(
                self.mesh.cell, self.mesh.bores, self._inertia, self.pressure, self.study.analysis.support
            )
            units = unit_solutions(self.model, self._recovery, loads, self.materials, cut_y=self.mesh.cut_y)
        fatigue = self.study.analysis.fatigue
        masked = self._errors.masked
        return CycleAnalysis(self.mesh, self.rod, self.materials, loads, units, fatigue, masked)

    @cached_property
    def buckling(self) -> Buckling:
        """The rod held by its pins, factorised when first asked for: its modes of buckling at any speed."""
        model = self.model
        if self.study.analysis.support is not Support.INERTIA_RELIEF:
            asked = self.study.analysis
            model = Model(
                self.mesh.cell,
                model.material,
                Support.INERTIA_RELIEF,
                asked.solver,
                assembly=asked.assembly,
            )
        return Buckling(model, held_by_pins(self.mesh.bores.rod_length))

    @cached_property
    def sections(self) -> tuple[tuple[Section, ...], Section]:
        """Cross-sections from pin to pin, and the least of the shank: by its dimensions or else its mesh."""
        return shank(self.study.rod.rod, self.mesh.whole.mesh, self.mesh.bores)

    @cached_property
    def shank_material(self) -> Material:
        """Material of the least section: a file may hold its parts in any order."""
        return self.materials[part_at(self.mesh.whole.mesh, self.sections[1].x)]

    @cached_property
    def _amid(self) -> tuple[SectionBalance, ...]:
        """Sections midway between the pins, or between bores that reach over it, then to either side."""
        bores, mesh = self.mesh.bores, self.mesh
        low, high = bores.between
        middle = bores.rod_length / 2
        middle = middle if low < middle < high else (low + high) / 2
        density = self.model.material.density
        return tuple(
            SectionBalance(mesh.whole.mesh, mesh.cell, density, bores.rod_length, station)
            for station in (middle, (low + middle) / 2, (middle + high) / 2)
        )

    def _cycle_at(self, rpm: float | None, cases: tuple[CaseResult, ...]) -> CycleResult | None:
        if not self.study.analysis.cycle or self.engine is None or self.gas is None or rpm is None:
            return None
        analysis = self.cycle_analysis
        with self._clock("cycle"):
            return analysis.at(self.engine, self.gas, rpm * RPM, cases)

    def _loads(self, rpm: float | None) -> SpeedLoads:
        return speed_loads(self.study, self.engine, self.gas, self.rod, rpm)

    def _free_surfaces(self) -> tuple[Surface, ...]:
        """The surfaces whose traction is known."""
        held = {Surface.BIG_END_BORE} if self.study.analysis.support is Support.CLAMPED else set()
        return tuple(
            surface
            for surface in (Surface.FREE, Surface.BIG_END_BORE, Surface.SMALL_END_BORE)
            if surface not in held
        )

    def _judged(
        self, cases: tuple[LoadCase, ...], forces: list[CaseForces], solution: Solution
    ) -> Iterator[CaseResult]:
        whole = self.mesh.whole
        stress = {
            parity: self._recovery.nodal_stress(
                u, self.materials, parity, _traction(forces, parity), solution.pressure.get(parity)
            )
            for parity, u in solution.displacement.items()
        }
        displacement, odd = self._on_whole(solution), Parity.ANTISYMMETRIC
        tensors = [
            whole.tensor(even, stress[odd][number] if odd in stress else None)
            for number, even in enumerate(stress[Parity.SYMMETRIC])
        ]
        errors = self._errors(solution.displacement, stress, solution.pressure)
        for index, (case, error) in enumerate(zip(cases, errors, strict=True)):
            stresses = [tensor[..., index] for tensor in tensors]
            yield case_result(case, displacement[..., index], stresses, self.materials, error)

    def _on_whole(self, solution: Solution) -> Floats:
        """Displacement (n_nodes, 3, n_loads) of the whole rod, seen from the bores."""
        whole = self.mesh.whole
        symmetric = solution.displacement[Parity.SYMMETRIC]
        displacement = whole.vector(symmetric, solution.displacement.get(Parity.ANTISYMMETRIC))
        if self.study.analysis.support is Support.CLAMPED:
            return displacement
        return referred_to_bores(whole.mesh, displacement, self.mesh.bores.rod_length)


def _traction(forces: list[CaseForces], parity: Parity) -> dict[Surface, Floats]:
    """Traction (n_nodes, 3, n_cases) of one parity on each pressed surface."""
    return {
        surface: np.stack([case.traction[surface].part(parity) for case in forces], axis=-1)
        for surface in forces[0].traction
    }
