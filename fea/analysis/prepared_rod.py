"""A meshed rod that can be solved at any speed, and what is worked out of it when it is first needed."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from fea.analysis.assembling import AssemblySetup
from fea.analysis.cycle.basis import Basis, FullBasis, spanned
from fea.analysis.cycle.rows import counting
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import UnitSolutions, unit_solutions
from fea.analysis.fields import Equilibrium, FieldRecovery, equilibrium
from fea.analysis.gauges import Gauge
from fea.analysis.life import Life, life_of
from fea.analysis.scatter import scatter_of
from fea.base.choices import CycleAccuracy, Support
from fea.base.material import Material, Materials, of_parts
from fea.base.note import Note
from fea.judge.sharp_places import SharpPlaces
from fea.machine.clock import Clock
from fea.pins.assembly import AssemblyPins
from fea.pins.lubrication import Films
from fea.pins.model import PinModel, PinModelContext, UnitLoadFields, UnitLoads
from fea.pins.yielding import End
from fea.rod.loading import DutyLoads, EngineLoading, Loading
from fea.rod.meshed_rod import MeshedRod
from fea.rod.overload import Overload
from fea.rod.places import SurfaceRegions
from fea.solid.inertia import Inertia, SectionBalance
from fea.solid.parity import ParityPair
from fea.solid.sharp_edges import SharpEdges
from fea.solid.supports import constrained_by_pins
from fea.solvers.buckling import Buckling
from fea.solvers.static import Model
from fea.study.option_tables import AnalysisTable
from fea.study.pin_models import PRESCRIBED, pin_model
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from geometry.mass import MassProperties
from geometry.section import CrossSection, HeightField, least_section
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh import slices

# Of many speeds this many, evenly spread, decide on the mesh and on what the unit loads of a cycle span:
# between them the shape of the stress changes little.
MOST_SPEEDS = 5
# Sections of the shank from pin to pin.
_STATIONS = 121


@dataclass(frozen=True, kw_only=True)
class PreparedRod:
    """A meshed rod with its stiffness, the model of its pins, and the recovery of its stress."""

    study: Study
    mesh: MeshedRod
    loading: Loading  #: the engine, or given forces
    gauges: tuple[Gauge, ...]  #: on the surface of the whole rod
    duty: DutyLoads | None  #: how long the engine runs at which speeds, where the study says
    structure: PinModelContext  #: stiffness and inertia
    pins: PinModel  #: what loads the rod
    fields: FieldRecovery  #: carries solutions to the whole rod
    assembling: AssemblySetup | None  #: what the rod is put together from; None for a rod of one piece
    notes: tuple[Note, ...]  #: what a reader must know of the study's rod

    @property
    def options(self) -> AnalysisTable:
        """How the rod is analysed."""
        return self.study.analysis

    @property
    def clock(self) -> Clock:
        """Times the stages."""
        return self.structure.clock

    @property
    def materials(self) -> tuple[Material, ...]:
        """One per part."""
        return self.structure.materials

    @property
    def material(self) -> Material | Materials:
        """Elastic constants of every element of the cell, or of each part."""
        return of_parts(self.materials, self.mesh.cell.part)

    @property
    def model(self) -> Model:
        """The stiffness of the cell, factorised when it is first needed."""
        return self.structure.model

    @property
    def inertia(self) -> Inertia:
        """Mass properties and inertia forces, from one quadrature."""
        return self.structure.inertia

    @property
    def mass(self) -> MassProperties:
        """Mass properties of the meshed rod."""
        return self.inertia.properties

    @cached_property
    def overload(self) -> Overload | None:
        """The single overload of the study, if it has one. Raises `InvalidValue`: see `Overload.of`."""
        table = self.study.overload
        if table is None or not table.load:
            return None
        return Overload.of(table, self.loading, self.mass, spanned_speeds(self.study))

    @property
    def clamped(self) -> bool:
        """Whether the big end is clamped."""
        return self.options.support is Support.CLAMPED

    @property
    def engine(self) -> EngineLoading:
        """The engine that loads the rod. Raises `InvalidValue`: forces are given instead."""
        return require_engine(self.loading, self.study.name)

    def crank_cycle(self, rpm: float) -> CrankCycle:
        """Return the crank cycle at a speed; errors as of `engine`."""
        return self.engine.crank_cycle(self.mass, rpm)

    @property
    def assembly_contact(self) -> AssemblyPins | None:
        """The pins and parts of an assembly; None for a rod of one piece."""
        return self.pins if isinstance(self.pins, AssemblyPins) else None

    @cached_property
    def films(self) -> Films:
        """The oil films of the big end's bearing."""
        return self._films_of(End.BIG)

    @cached_property
    def small_end_films(self) -> Films:
        """The oil films of the small end's bearing."""
        return self._films_of(End.SMALL)

    def _films_of(self, end: End) -> Films:
        return self.pins.films.get(end) or Films(self.structure, end, self.assembly_contact)

    @cached_property
    def prescribed(self) -> PinModel:
        """The model of the pins, or one that prescribes their load where they are in contact."""
        in_contact = pin_model(self.structure.pressure).in_contact
        return self.structure.pins(PRESCRIBED) if in_contact else self.pins

    def under_prescribed(self) -> "PreparedRod":
        """Return the rod, with its stiffness, under a prescribed pressure where its pins are in contact."""
        if self.prescribed is self.pins:
            return self
        study = replace(self.study, analysis=replace(self.options, pressure=PRESCRIBED))
        return replace(self, study=study).with_pins(self.prescribed, pressure=PRESCRIBED)

    def with_pins(self, pins: PinModel | None = None, **changed: Any) -> "PreparedRod":
        """Return the rod, with its stiffness, under other pins; `changed`: fields that these follow from."""
        structure = replace(self.structure, **changed)
        pins = structure.pins() if pins is None else pins
        fields = FieldRecovery.of(structure, self.mesh, pins)
        return replace(self, structure=structure, pins=pins, fields=fields)

    def case_forces(self, name: str, rpm: float | None = None) -> ParityPair:
        """Nodal forces (n_nodes, 3) of a load case on the cell under prescribed pressures, N.

        `name`: ``"tension"``, ``"compression"``, ``"side"``, ``"bending"``, ``"gas"`` or ``"given"``. Raises
        `InvalidValue`: there is no such case at this speed.
        """
        cases = {case.name: case for case in self.loading.at(self.mass, rpm).cases}
        require(name in cases, "case", name, f"must be one of {', '.join(cases)}")
        (response,) = self.prescribed.respond(cases[name][None])
        return response.forces

    def equilibrium(
        self, instants: Instants, cycle: CrankCycle | None = None, pins: PinModel | None = None
    ) -> Equilibrium:
        """Solve instants, all with one factorisation per parity.

        `cycle`: that they belong to: see `fea.pins.model.PinModel.respond`. Raises `UnderconstrainedError`: a
        rigid motion is left free; `SingularMatrixError`: the factorisation broke down; `ContactError`: no
        state of contact carries the load.
        """
        return equilibrium((pins or self.pins).respond(instants, cycle), self.model, instants)

    def displacement(self, rpm: float, angles: Floats) -> Floats:
        """Displacement (n_nodes, 3, n), mm, relative to the bores, at angles (n,), rad; for engines only."""
        return self.fields.displaced(self.equilibrium(self.crank_cycle(rpm).at(angles)))

    @cached_property
    def bore_datum(self) -> Floats | None:
        """Displacement (n_nodes, 3) at which the bores were made round, mm; None where nothing acted then."""
        datum = self.pins.datum()
        if datum is None:
            return None
        return np.asarray(self.fields.displaced(equilibrium([datum], self.model, self.pins.resting))[..., 0])

    @cached_property
    def regions(self) -> SurfaceRegions:
        """How the regions of the whole rod's surface were made."""
        return SurfaceRegions.of(self.mesh.whole, self.mesh.bores)

    @property
    def cycle(self) -> CycleAnalysis:
        """Unit solutions of crank cycles, solved when first needed."""
        exact = self.options.cycle_accuracy is CycleAccuracy.EXACT
        return self.full_cycle if exact or "full_cycle" in self.__dict__ else self.certified_cycle

    @cached_property
    def full_cycle(self) -> CycleAnalysis:
        """All unit solutions: they span the whole crank cycle at any speed."""
        return self._cycle(lambda loads, _: FullBasis(loads, partial(self.solved_units, single=False)))

    @cached_property
    def certified_cycle(self) -> CycleAnalysis:
        """A small basis where pins are in contact, else all unit solutions."""
        if not self.study.in_contact:
            return self.full_cycle
        counts, solve = counting(self.fields.errors.masked), partial(self.solved_units, single=True)
        return self._cycle(lambda loads, cycles: spanned(loads, solve, counts, cycles))

    def solved_units(self, fields: tuple[UnitLoadFields, UnitLoadFields], *, single: bool) -> UnitSolutions:
        """Solve unit loads: see `fea.analysis.cycle.unit_solutions.unit_solutions`."""
        return unit_solutions(
            self.model, self.fields.recovery, self.materials, fields, cut_y=self.mesh.cut_y, single=single
        )

    def spanned_cycle(self, cycles: Sequence[CrankCycle]) -> CycleAnalysis:
        """All unit solutions that span some cycles, where they depend on these."""
        solve = partial(self.solved_units, single=True)
        return self._cycle(lambda loads, _: FullBasis(loads, solve), cycles)

    def _cycle(
        self,
        spanning: Callable[[UnitLoads, Sequence[CrankCycle]], Basis],
        cycles: Sequence[CrankCycle] | None = None,
    ) -> CycleAnalysis:
        with self.clock("cycle"):
            cycles = cycles or [self.crank_cycle(rpm) for rpm in spanned_speeds(self.study)]
            basis = spanning(self.pins.span(cycles), cycles)
        return self.superposing(basis)

    def superposing(self, basis: Basis) -> CycleAnalysis:
        """What superposes the unit solutions of a basis."""
        return CycleAnalysis(
            mesh=self.mesh,
            materials=self.materials,
            basis=basis,
            fatigue=self.options.fatigue,
            masked=self.fields.errors.masked,
            regions=SurfaceRegions.of(self.mesh.cell, self.mesh.bores),
            direct=lambda instants, cycle: self.fields.stresses(self.equilibrium(instants, cycle)),
        )

    @cached_property
    def life(self) -> Life | None:
        """Life over the duty, worked out when first asked for; None where the study has none."""
        if self.duty is None:
            return None
        cycle = self.cycle  # timed by itself
        with self.clock("life"):
            scatter = scatter_of(self.study.scatter, self.engine, self.options.fatigue).cycle_pressure
            return life_of(cycle, self.mass, self.duty, scatter)

    @cached_property
    def buckling(self) -> Buckling:
        """The rod held by its pins, factorised when first asked for: its buckling modes at any speed."""
        model = self.model
        if self.clamped:
            relief, solver = Support.INERTIA_RELIEF, self.options.solver
            model = Model(
                self.mesh.cell, model.material, relief, solver, assembly=self.options.matrix_assembly
            )
        return Buckling(model, constrained_by_pins(self.mesh.bores.rod_length))

    @cached_property
    def sharp_places(self) -> SharpPlaces | None:
        """Judges load cases at the sharp re-entrant edges; None where the rod has none."""
        mesh = self.mesh
        if mesh.creases is None or not self.fields.errors.masked.any():
            return None
        edges = SharpEdges.of(mesh.whole, mesh.creases.on(mesh.drawn_node))
        return None if edges is None else SharpPlaces(edges, self.materials[0].poissons_ratio)

    @cached_property
    def shank(self) -> tuple[tuple[CrossSection, ...], CrossSection]:
        """Sections from pin to pin, and the least between the bores; without dimensions, of the mesh."""
        drawn, mesh, bores = self.study.rod.dimensions, self.mesh.whole, self.mesh.bores
        places = np.linspace(0.0, bores.rod_length, _STATIONS)
        if drawn is None:
            return slices.sections(mesh, places), slices.least_section(mesh, *bores.between)
        return HeightField(drawn).sections(places), least_section(drawn)

    @cached_property
    def mid_sections(self) -> tuple[SectionBalance, ...]:
        """Sections midway between the pins, or between bores that extend beyond that, then to either side."""
        bores, mesh = self.mesh.bores, self.mesh
        low, high = bores.between
        middle = bores.rod_length / 2
        middle = middle if low < middle < high else (low + high) / 2
        density = self.model.material.density
        return tuple(
            SectionBalance(mesh.whole, mesh.cell, density, bores.rod_length, station)
            for station in (middle, (low + middle) / 2, (middle + high) / 2)
        )


def require_engine(loading: Loading, name: str = "") -> EngineLoading:
    """Return the engine that loads the rod of a study. Raises `InvalidValue`: forces are given instead."""
    if not isinstance(loading, EngineLoading):
        rule = "has no [engine], so there is no crank cycle"
        raise InvalidValue("STUDY", name, rule, "Add an [engine].")
    return loading


_Speed = TypeVar("_Speed", float, float | None)


def evenly_spread(speeds: Iterable[_Speed]) -> list[_Speed]:
    """Choose at most `MOST_SPEEDS` of the speeds, rpm, each once; of more, in rising order."""
    every = list(dict.fromkeys(speeds))
    if len(every) <= MOST_SPEEDS:
        return every
    rising = sorted(every, key=lambda rpm: rpm or 0.0)
    return [rising[index] for index in np.linspace(0, len(rising) - 1, MOST_SPEEDS).round().astype(int)]


def spanned_speeds(study: Study) -> list[float]:
    """Choose speeds, rpm, of a study and its duty that stand for all of them; none where forces are given."""
    of_duty = () if study.duty is None else study.duty.speeds
    return sorted(rpm for rpm in evenly_spread((*study.speeds(), *of_duty)) if rpm is not None)
