"""From a study to a meshed rod that is ready to be solved at any speed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from fea.base.checks import LIMITS
from fea.base.choices import CONTACT, Element, SolverName, Support
from fea.base.material import Material, Materials, of_parts
from fea.base.note import Note
from fea.judge.case_error import CaseErrors
from fea.judge.life_line import require_lines
from fea.judge.sharp_places import SharpPlaces
from fea.machine.clock import Clock
from fea.pins.bonded_loads import BondedLoads
from fea.pins.case_forces import NodalForces
from fea.pins.pressure_loads import PressureLoads
from fea.pins.unit_loads import UnitLoads
from fea.rod.loading import DutyLoads, EngineLoading, GivenForces, Loading
from fea.rod.meshed_rod import MeshedRod
from fea.rod.shank import part_at, shank
from fea.rod.surface_regions import SurfaceRegions
from fea.run.assembling import Assembling
from fea.run.cycle.superposition import CycleAnalysis, Direct
from fea.run.cycle.unit_solutions import unit_solutions
from fea.run.fields import FieldRecovery
from fea.run.meshing import mesh_loaded
from fea.run.solve import PinModel
from fea.solid.bore_motion import held_by_pins
from fea.solid.inertia import Inertia, inertia
from fea.solid.parity import Split
from fea.solvers.buckling import Buckling
from fea.solvers.static import Model
from fea.stress.recovery import PartRecovery
from fea.stress.section_balance import SectionBalance
from fea.stress.sharp_edges import SharpEdges
from fea.study.option_tables import AnalysisTable, ContactTable
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from geometry.mass import MassProperties
from geometry.rod import Rod
from geometry.section import Section
from geometry.surfaces import INTERFACES, Surface
from loads.bearing import Bonded
from loads.cases import assembled
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

if TYPE_CHECKING:
    from fea.pins.assembled_loads import AssembledLoads
    from fea.pins.assembled_rod import AssembledRod, Putting
    from fea.pins.fits import Fits
    from fea.pins.rod_contact import RodContact
    from fea.run.life import Life

# Speeds whose opening and slip the unit loads of an assembly span.
MOST_COURSES = 5
# Surfaces of known traction.
_SURFACES = (
    Surface.FREE,
    Surface.BIG_END_BORE,
    Surface.SMALL_END_BORE,
    *(side for sides in INTERFACES for side in sides),
    Surface.BOLT_HEAD,
    Surface.BOLT_THREAD,
)


@dataclass(frozen=True, kw_only=True)
class PreparedRod:
    """A meshed rod with its stiffness, loads and recovery; speeds are solved one by one.

    Attributes
    ----------
    name
        Of the study.
    options
        How it is analysed.
    dimensions
        Of a parametric rod; None for a solid from a file.
    mesh
        The meshed rod.
    materials
        One per part.
    loading
        The engine, or given forces.
    inertia
        Mass properties and inertia forces, from one quadrature.
    model
        The stiffness of the cell, factorised when it is first needed.
    nodal_forces
        Turns a load case into nodal forces on the cell, with the pins' pressure as prescribed.
    pin_table, pin_stiffness
        What the study says of the pins, and E, MPa, and ν of those whose material is given.
    speeds
        Of the study and of its duty, rpm; empty where forces are given.
    duty
        How long the engine runs at which speeds; None where the study does not say.
    assembling, putting
        What the rod is put together from, and how; None for a rod of one piece.
    fields
        Carries solutions to the whole rod.
    notes
        What a reader must know of the study's rod.
    clock
        Times the stages.
    """

    name: str
    options: AnalysisTable
    dimensions: Rod | None
    mesh: MeshedRod
    materials: tuple[Material, ...]
    loading: Loading
    inertia: Inertia
    model: Model
    nodal_forces: NodalForces
    pin_table: ContactTable
    pin_stiffness: Mapping[str, tuple[float, float]]
    speeds: tuple[float, ...]
    duty: DutyLoads | None
    assembling: Assembling | None
    putting: "Putting | None"
    fields: FieldRecovery
    notes: tuple[Note, ...]
    clock: Clock

    @property
    def mass(self) -> MassProperties:
        """Mass properties of the meshed rod."""
        return self.inertia.properties

    @property
    def element(self) -> Element:
        """Order of the elements."""
        return Element.P1 if self.mesh.cell.order == 1 else Element.P2

    @property
    def clamped(self) -> bool:
        """Whether the big end is clamped."""
        return self.options.support is Support.CLAMPED

    @property
    def soft(self) -> tuple[int, ...]:
        """Numbers of the parts that are solved with a pressure of their own."""
        return soft_parts(self.materials, self.element)

    @property
    def engine(self) -> EngineLoading:
        """The engine that loads the rod.

        Raises
        ------
        InvalidValue
            Forces are given instead.
        """
        if not isinstance(self.loading, EngineLoading):
            rule = "has no [engine], so there is no crank cycle"
            raise InvalidValue("STUDY", self.name, rule, "Add an [engine].")
        return self.loading

    def crank_cycle(self, rpm: float) -> CrankCycle:
        """Return the crank cycle at a speed; errors as of `engine`."""
        return self.engine.crank_cycle(self.mass, rpm)

    @property
    def material(self) -> Material | Materials:
        """Elastic constants of every element of the cell, or of each part."""
        return of_parts(self.materials, self.mesh.cell.part)

    def case_forces(self, name: str, rpm: float | None = None) -> Split:
        """Nodal forces (n_nodes, 3) of a load case on the cell, N, by their parity about y = 0.

        Parameters
        ----------
        name
            ``"tension"``, ``"compression"``, ``"side"``, ``"bending"``, ``"gas"`` or ``"given"``.
        rpm
            Engine speed; None for given forces.

        Raises
        ------
        InvalidValue
            There is no such case at this speed.
        """
        cases = {case.name: case for case in self.loading.at(self.mass, rpm).cases}
        require(name in cases, "case", name, f"must be one of {', '.join(cases)}")
        return self.nodal_forces(cases[name]).forces

    def displacement(self, rpm: float, angles: Floats) -> Floats:
        """Displacement (n_nodes, 3, n) of the whole rod at crank angles (n,), rad: mm, relative to the bores.

        Raises
        ------
        InvalidValue
            There is no engine.
        """
        return self.fields.displaced(self.pins.equilibrium(self.crank_cycle(rpm).at(angles)))

    @cached_property
    def cycle(self) -> CycleAnalysis:
        """Unit solutions that span the whole crank cycle at any speed, solved when first asked for."""
        with self.clock("cycle"):
            mesh, (loads, direct) = self.mesh, self._unit_loads()
            recovery = self.fields.recovery
            units = unit_solutions(self.model, recovery, loads, self.materials, cut_y=mesh.cut_y)
        masked = self.fields.errors.masked
        return CycleAnalysis(
            mesh=mesh,
            materials=self.materials,
            loads=loads,
            units=units,
            fatigue=self.options.fatigue,
            masked=masked,
            regions=SurfaceRegions.of(mesh.cell, mesh.bores),
            direct=direct,
        )

    def _directly(self, loads: "AssembledLoads", instants: Instants, cycle: CrankCycle) -> list[Floats]:
        """Stress per part (n_nodes, 6, n) of an assembled rod at n instants of a cycle."""
        states = iter(loads.states(instants, cycle))
        pins = PinModel(lambda case: self.held_together.under(case, next(states)), self.model)
        return self.fields.stresses(pins.equilibrium(instants))

    @cached_property
    def life(self) -> "Life | None":
        """Life over the duty, worked out when first asked for; None where the study has none."""
        if self.duty is None:
            return None
        from fea.run.life import life_of  # noqa: PLC0415 - only a duty needs it

        _ = self.cycle  # timed by itself
        with self.clock("life"):
            return life_of(self, self.duty)

    @property
    def pins(self) -> PinModel:
        """How the pins load the rod."""
        return PinModel(self.contact if self.options.in_contact else self.nodal_forces, self.model)

    @cached_property
    def contact(self) -> "RodContact":
        """The contact of both pins with their bores, whose compliance is computed when first asked for.

        Raises
        ------
        InvalidValue
            A pin does not fit the rod, or contact cannot be combined with something else that was asked for.
        """
        from fea.pins.rod_contact import RodContact  # noqa: PLC0415 - prescribed pressures do without

        why = self.without_contact
        require(not why, "analysis.pressure", CONTACT, why, "Choose another --pressure.")
        with self.clock("contact"):
            if self.putting is None:
                return RodContact(self.model, self.mesh.bores, self.inertia, self.fits)
            from fea.pins.assembled_rod import AssembledRod  # noqa: PLC0415 - rods of one piece do without

            return AssembledRod(self.model, self.mesh.bores, self.inertia, self.fits, self.putting)

    @cached_property
    def made(self) -> Floats | None:
        """Displacement (n_nodes, 3) at which the bores were made round, mm; None for a rod of one piece."""
        if self.putting is None:
            return None
        forces = self.held_together.assembly(warm=False)
        found = PinModel(lambda _: forces, self.model).equilibrium(assembled()[None])
        return np.asarray(self.fields.displaced(found)[..., 0])

    @cached_property
    def fits(self) -> "Fits":
        """The pins: what the study says of them, and what is assumed.

        Raises
        ------
        InvalidValue
            A pin does not fit the rod.
        """
        from fea.pins.fits import Fits  # noqa: PLC0415 - prescribed pressures do without

        return Fits.of(self.pin_table, self.mesh.bores, self.pin_stiffness)

    @cached_property
    def held_together(self) -> "AssembledRod":
        """The contact of an assembly: `contact`, of a rod of separate parts.

        Raises
        ------
        TypeError
            The rod is of one piece.
        """
        from fea.pins.assembled_rod import AssembledRod  # noqa: PLC0415 - rods of one piece do without

        if not isinstance(self.contact, AssembledRod):
            raise TypeError("the rod is of one piece")
        return self.contact

    @property
    def without_contact(self) -> str:
        """Why there can be no contact, as a rule; empty where it is possible."""
        if self.soft and not self.clamped:
            nu, most = max(m.poissons_ratio for m in self.materials), LIMITS["poissons_ratio_p2"]
            return f"supports displacement elements only, and ν = {nu:g} of a part exceeds {most}"
        solver = SolverName(self.model.solver)  # the one that was chosen
        return AnalysisTable(support=self.options.support, solver=solver).contact_obstacle

    @property
    def _spanned_speeds(self) -> list[float]:
        """The study's speeds, rpm, or some of many."""
        some = np.linspace(0, len(self.speeds) - 1, min(len(self.speeds), MOST_COURSES)).round().astype(int)
        return [sorted(self.speeds)[number] for number in some]

    def _assembled_loads(self) -> "AssembledLoads":
        from fea.pins.assembled_loads import AssembledLoads  # noqa: PLC0415 - rods of one piece do without

        speeds = self._spanned_speeds
        cycles = [self.crank_cycle(rpm) for rpm in speeds]
        alone = [self.loading.at(self.mass, rpm).cases for rpm in speeds]
        return AssembledLoads(self.held_together, self.inertia, cycles, alone)

    def _unit_loads(self) -> tuple[UnitLoads, Direct | None]:
        """Unit loads, and what solves instants of a cycle without them."""
        if self.putting is not None:
            assembled_loads = self._assembled_loads()
            return assembled_loads, partial(self._directly, assembled_loads)
        if self.options.in_contact:
            from fea.pins.contact_loads import ContactLoads  # noqa: PLC0415 - prescribed pressures do without

            return ContactLoads(self.contact, self.inertia), None
        mesh, support, prescribed = self.mesh, self.options.support, self.options.prescribed
        if isinstance(prescribed, Bonded):
            return BondedLoads(mesh.cell, mesh.bores, self.inertia, support), None
        return PressureLoads(mesh.cell, mesh.bores, self.inertia, prescribed, support), None

    @cached_property
    def buckling(self) -> Buckling:
        """The rod held by its pins, factorised when first asked for: its buckling modes at any speed."""
        model = self.model
        if self.clamped:
            relief, solver = Support.INERTIA_RELIEF, self.options.solver
            model = Model(
                self.mesh.cell, model.material, relief, solver, assembly=self.options.matrix_assembly
            )
        return Buckling(model, held_by_pins(self.mesh.bores.rod_length))

    @cached_property
    def sharp_places(self) -> SharpPlaces | None:
        """Judges load cases at the sharp re-entrant edges; None where the rod has none."""
        mesh = self.mesh
        if mesh.creases is None or not self.fields.errors.masked.any():
            return None
        edges = SharpEdges.of(mesh.whole, mesh.creases.on(mesh.drawn_node))
        return None if edges is None else SharpPlaces(edges, self.materials[0].poissons_ratio)

    @cached_property
    def sections(self) -> tuple[tuple[Section, ...], Section]:
        """Cross-sections from pin to pin, and the smallest one: by the dimensions, or cut from the mesh."""
        return shank(self.dimensions, self.mesh.whole, self.mesh.bores)

    @cached_property
    def shank_material(self) -> Material:
        """Material at the smallest section: a file may hold its parts in any order."""
        return self.materials[part_at(self.mesh.whole, self.sections[1].x)]

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


def soft_parts(materials: Sequence[Material], element: Element) -> tuple[int, ...]:
    """Return the numbers of the parts that second-order displacement elements alone would lock in."""
    if element is not Element.P2:
        return ()
    limit = LIMITS["poissons_ratio_p2"]
    return tuple(n for n, material in enumerate(materials) if material.poissons_ratio > limit)


def prepare(
    study: Study,
    clock: Clock | None = None,
    *,
    mesh: MeshedRod | None = None,
    known_traction: bool = True,
) -> PreparedRod:
    """Prepare the stiffness of a study's rod, its loads and the recovery of its stress.

    Parameters
    ----------
    study
        What is asked.
    clock
        Times the stages.
    mesh
        Of the study's rod; by default it is drawn and meshed.
    known_traction
        Whether the known traction on the surface is used to recover stress there; averaging alone otherwise.

    Raises
    ------
    InvalidValue
        A value of the study breaks a rule.
    GeometryError, MeshError
        No solid or no usable mesh came out.
    """
    clock = clock or Clock()
    mesh = mesh_loaded(study, clock) if mesh is None else mesh
    options, cell = study.analysis, mesh.cell
    loading: Loading
    if study.forces is not None:
        loading = GivenForces(study.forces.pin())
    else:
        loading = EngineLoading.of(study.require_engine(), mesh.bores.rod_length)
    materials = study.materials(mesh.parts)
    duty = None
    if study.duty is not None and isinstance(loading, EngineLoading):
        duty = DutyLoads.of(study.duty, loading)
        require_lines(materials)
    sharp: tuple[Surface, ...] = ()
    notes: tuple[Note, ...] = ()
    if options.in_contact:
        from fea.pins.fits import Fits  # noqa: PLC0415 - prescribed pressures do without

        fits = Fits.of(study.contact, mesh.bores, study.pin_stiffness)
        sharp, notes = fits.sharp, fits.notes
    assembling = Assembling.of(study, mesh)
    putting = None if assembling is None else assembling.putting(study, mesh)
    if assembling is not None:
        notes += assembling.notes(study, tuple(mesh.parts))
    soft = soft_parts(materials, Element.P1 if cell.order == 1 else Element.P2)
    if soft and options.buckling:
        nu, most = max(m.poissons_ratio for m in materials), LIMITS["poissons_ratio_p2"]
        rule = f"must not exceed {most} for --buckling, which supports displacement elements only"
        raise InvalidValue("material.nu", nu, rule, "Leave out --buckling: the column formulas remain.")
    elastic = of_parts(materials, cell.part)
    with clock("loads"):
        body = inertia(cell, elastic.density, options.matrix_assembly)
        forces = NodalForces(cell, mesh.bores, body, options.prescribed, options.support)
    model = _model(mesh, materials, soft, options, clock)
    held = (Surface.BIG_END_BORE,) if options.support is Support.CLAMPED else ()
    with clock("stress"):
        known = tuple(surface for surface in _SURFACES if surface not in held) if known_traction else ()
        fields = FieldRecovery(
            mirrored=mesh.mirrored,
            materials=materials,
            recovery=PartRecovery(cell, mesh.symmetry.planes, known),
            errors=CaseErrors(mesh, materials, held or sharp),
            rod_length=None if held else mesh.bores.rod_length,
        )
    return PreparedRod(
        name=study.name,
        options=options,
        dimensions=study.rod.dimensions,
        mesh=mesh,
        materials=materials,
        loading=loading,
        inertia=body,
        model=model,
        nodal_forces=forces,
        pin_table=study.contact,
        pin_stiffness=study.pin_stiffness,
        speeds=_speeds(study),
        duty=duty,
        assembling=assembling,
        putting=putting,
        fields=fields,
        notes=(*study.material_notes, *study.rod.mass_notes(body.properties), *notes),
        clock=clock,
    )


def _speeds(study: Study) -> tuple[float, ...]:
    """Return the speeds of a study, rpm, each once: those that are run, then those of its duty alone."""
    own = [rpm for rpm in study.speeds() if rpm is not None]
    return tuple(dict.fromkeys((*own, *(() if study.duty is None else study.duty.speeds))))


def _model(
    mesh: MeshedRod,
    materials: tuple[Material, ...],
    soft: tuple[int, ...],
    options: AnalysisTable,
    clock: Clock,
) -> Model:
    if not soft:
        elastic = of_parts(materials, mesh.cell.part)
        return Model(
            mesh.cell, elastic, options.support, options.solver, clock, assembly=options.matrix_assembly
        )
    from fea.solvers.mixed import MixedModel  # noqa: PLC0415 - metal rods do without

    return MixedModel(
        mesh.cell,
        materials,
        soft,
        options.support,
        solver=options.solver,
        clock=clock,
        assembly=options.matrix_assembly,
    )
