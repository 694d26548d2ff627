"""The main job: from a study to a judged rod, stage by stage.

| stage        | here                                                     | below                          |
|--------------|----------------------------------------------------------|--------------------------------|
| mesh         | `refined_rod` takes a mesh from `adaptive_mesh`          | `fea.rod.discretise`, `mesh`   |
| loads, pins  | `prepare` takes the engine and what presses on the bores | `fea.rod.loading`, `fea.pins`  |
| solve        | `solve_speed` brings the load cases into equilibrium     | `fea.solvers`                  |
| recover      | `judge` recovers the stress of every load case           | `fea.analysis.fields`          |
| judge, check | `judge` compares it with the strengths, `speed_checks`   | `fea.judge`, `fea.base.checks` |
| refine       | `refined_rod` repeats this where the error is too large  | `fea.analysis.refinement`      |

`RefinedRod.at` adds plastic flow where something yields, and cycle, overload and films that are asked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fea.analysis.assembling import AssemblySetup
from fea.analysis.defects import with_defects
from fea.analysis.fields import Equilibrium, FieldRecovery
from fea.analysis.film import films_at
from fea.analysis.flow import answer_of, with_flow
from fea.analysis.fretting import fretting
from fea.analysis.gauges import Gauge
from fea.analysis.meshing import adaptive_mesh, mesh_loaded
from fea.analysis.overload import with_overload
from fea.analysis.prepared_rod import PreparedRod, evenly_spread, require_engine, spanned_speeds
from fea.analysis.refinement import MeshErrors
from fea.analysis.responses import causes
from fea.analysis.speed_result import SpeedResult, speed_checks, speed_notes
from fea.analysis.summary_figures import PassFigures
from fea.base.checks import LIMITS
from fea.base.material import Material, of_parts
from fea.base.note import Note, assumption, doubt
from fea.judge.case_result import CaseResult, bore_ends, case_result
from fea.judge.fatigue import require_lines
from fea.machine.clock import Clock, Listener
from fea.pins.model import PinModel, PinModelContext, soft_parts
from fea.plastic.cycling import PlasticAnswer
from fea.rod.discretise import drawn_once, moved
from fea.rod.loading import DutyLoads, EngineLoading, GivenForces, Loading
from fea.rod.meshed_rod import MeshedRod
from fea.solid.inertia import inertia
from fea.solvers.mixed import MixedModel
from fea.solvers.static import Model, Symbolic
from fea.study.option_tables import AnalysisTable
from fea.study.pin_models import PRESCRIBED, contact_excluded_because
from fea.study.study import Study
from geometry.errors import GeometryError, InvalidValue
from loads.instants import Instants, joined
from mesh.sizing import SizeField
from mesh.tetmesh import MeshError

# Nodes whose fields stay in memory over all speeds until they are asked for, at about a kilobyte each; the
# last mesh is solved once more for further speeds.
MAX_KEPT_NODES = 1_000_000


@dataclass(frozen=True)
class RefinedRod:
    """A rod on a mesh that meets the tolerance, and its refinement history."""

    rod: PreparedRod  #: of the last pass
    passes: tuple[PassFigures, ...] = ()  #: all of them; none where no tolerance was asked for
    shortfall: Note | None = None  #: why the tolerance is not met; None where it is
    #: By speed, rpm, as far as they are kept
    results: Mapping[float | None, SpeedResult] = field(default_factory=dict)
    #: By speed, rpm, what plastic flow led to on the mesh before the last one, where it was followed
    coarser: Mapping[float | None, PlasticAnswer | None] = field(default_factory=dict)

    def at(self, rpm: float | None) -> SpeedResult:
        """Solve the load cases of one speed, rpm (None for given forces); errors as of `solve_speed`."""
        result = self.results.get(rpm) or solve_speed(self.rod, rpm)
        if self.rod.options.cycle:
            result = with_cycle(self.rod, result)
        if self.rod.options.fretting:
            result = with_fretting(self.rod, result)
        result = with_overload(self.rod, with_flow(self.rod, result, self.coarser))
        result = with_defects(self.rod, result)
        if self.rod.options.needs_film:
            result = with_film(self.rod, result)
        return result if self.shortfall is None else replace(result, notes=(*result.notes, self.shortfall))


@drawn_once()
def refined_rod(
    study: Study,
    speeds: Sequence[float | None],
    clock: Clock,
    listener: Listener | None = None,
    mesh: MeshedRod | None = None,
    *,
    movable: bool = False,
) -> RefinedRod:
    """Prepare the rod of a study, on finer and finer meshes where a tolerance is asked for.

    The tolerance, `Study.tolerance_percent`, is met for the smallest safety factor at each of the `speeds`,
    rpm (None for given forces), and of the study's duty: against yielding, and with a cycle against fatigue.
    With `AnalysisTable.all_cases` it is met for every load case. `mesh` is the first one, where it is there
    already; `movable` tells whether the last one is to follow other dimensions. Raises `GeometryError`,
    `MeshError`, `InvalidValue`, …: see `prepare`. Where a finer mesh cannot be made, the last one gives the
    answer.
    """
    mesh = adaptive_mesh(study, clock, movable=movable) if mesh is None else mesh
    tolerance = study.tolerance_percent
    if tolerance is None:
        return RefinedRod(prepare(study, clock, mesh=mesh))
    of_duty = () if study.duty is None else study.duty.speeds
    deciding = evenly_spread((*speeds, *of_duty))
    passes, sizes = list[PassFigures](), list[SizeField]()
    coarser = dict[float | None, PlasticAnswer | None]()
    while True:
        rod = prepare(study, clock, mesh=mesh)
        errors, results = MeshErrors(rod, tolerance, refined=bool(sizes)), dict[float | None, SpeedResult]()
        for rpm in deciding:
            result = solve_speed(rod, rpm)
            errors.include(result.cases)
            if len(results) < max(1, MAX_KEPT_NODES // len(rod.mesh.whole.points)):
                results[rpm] = result
        passes.append(errors.figures(clock.total - sum(each.seconds for each in passes)))
        wanted, obstacle, draft = errors.next_mesh(len(passes))
        if listener:
            listener(passes[-1].text(len(passes)))
            if len(passes) == 1 and wanted is not None:
                listener(draft)
        if wanted is None:
            break
        sizes.append(wanted)
        try:
            mesh = adaptive_mesh(study, clock, sizes, movable=movable)
        except (GeometryError, MeshError) as error:
            obstacle = f"no finer mesh could be made. {error}"
            break
        coarser = {rpm: answer_of(rod, result) for rpm, result in results.items()}
        del rod, results  # their memory is that of the next ones
    unmet = f"the tolerance of {tolerance:g} % is not met ({errors.bar.text}): {obstacle}"
    return RefinedRod(rod, tuple(passes), doubt(unmet) if obstacle else None, results, coarser)


def prepare(
    study: Study,
    clock: Clock | None = None,
    *,
    mesh: MeshedRod | None = None,
    known_traction: bool = True,
    symbolic: Symbolic | None = None,
) -> PreparedRod:
    """Prepare the stiffness of a study's rod, its loads and the recovery of its stress.

    `mesh`: of the study's rod; by default it is drawn and meshed; `known_traction`: whether the known
    traction on the surface is used to recover stress there; averaging alone otherwise; `symbolic`: handed on
    by a model of the mesh that was moved to this one. Raises `InvalidValue`: a value of the study breaks a
    rule; `GeometryError`, `MeshError`: no solid or no usable mesh came out.
    """
    clock = clock or Clock()
    mesh = mesh_loaded(study, clock) if mesh is None else mesh
    materials = study.materials(mesh.parts)
    duty: DutyLoads | None = None
    if study.forces is not None:
        loading: Loading = GivenForces(study.forces.pin(), study.forces.levels())
    else:
        loading = EngineLoading.of(study.require_engine(), mesh.bores.rod_length)
        if study.duty is not None:
            duty = DutyLoads.of(study.duty, loading)
            require_lines(materials)
    named = ((each, each.name or f"gauge {number}") for number, each in enumerate(study.gauge, 1))
    gauges = tuple(Gauge.of(each, name, mesh.whole, materials) for each, name in named)
    assembling = AssemblySetup.of(study, mesh)
    structure = _structure(
        study, mesh, materials, loading, assembling=assembling, clock=clock, symbolic=symbolic
    )
    structure, pins, of_pins = chosen_pins(structure, study.analysis)
    of_assembly = () if assembling is None else assembling.notes(study, tuple(mesh.parts))
    prepared = PreparedRod(
        study=study,
        mesh=mesh,
        loading=loading,
        duty=duty,
        gauges=gauges,
        structure=structure,
        pins=pins,
        fields=FieldRecovery.of(structure, mesh, pins, known_traction=known_traction),
        assembling=assembling,
        notes=(
            *study.material_notes,
            *study.rod.mass_notes(structure.inertia.properties),
            *of_pins,
            *of_assembly,
        ),
    )
    _ = prepared.overload  # refused before anything is solved
    list(causes(prepared))  # refuses what the rod has not before anything is solved
    return prepared


def _structure(
    study: Study,
    mesh: MeshedRod,
    materials: tuple[Material, ...],
    loading: Loading,
    *,
    assembling: AssemblySetup | None,
    clock: Clock,
    symbolic: Symbolic | None,
) -> PinModelContext:
    options, elastic, cell = study.analysis, of_parts(materials, mesh.cell.part), mesh.cell
    support, solver, assembly = options.support, options.solver, options.matrix_assembly
    soft = soft_parts(materials, cell)
    if soft and options.buckling:
        nu, most = max(m.poissons_ratio for m in materials), LIMITS["poissons_ratio_p2"]
        rule = f"must not exceed {most} for --buckling, which supports displacement elements only"
        raise InvalidValue("material.nu", nu, rule, "Leave out --buckling: the column formulas remain.")
    with clock("loads"):
        body = inertia(cell, elastic.density)
    if soft:
        model: Model = MixedModel(
            cell, materials, soft, support, solver=solver, clock=clock, assembly=assembly
        )
    else:
        model = Model(cell, elastic, support, solver, clock, assembly=assembly, symbolic=symbolic)
    return PinModelContext(
        model=model,
        bores=mesh.bores,
        drawn=study.rod.dimensions,
        materials=materials,
        inertia=body,
        pressure=options.pin_load,
        support=support,
        contact=study.contact,
        film=study.film,
        pin_stiffness=study.pin_stiffness,
        largest_pin_forces=lambda: _pulled_and_pushed(
            joined([loading.at(body.properties, rpm).cases for rpm in spanned_speeds(study) or (None,)])
        ),
        crank_cycle=lambda speed: require_engine(loading).cycle_at(body.properties, speed),
        assembly=None if assembling is None else assembling.specification(study, mesh),
        clock=clock,
    )


def _pulled_and_pushed(cases: Instants) -> tuple[float, float]:
    """Largest force of the piston pin, N, away from the crank, and towards it."""
    force = np.hypot(*cases.pin)
    pull, push = (float(force[side].max(initial=0.0)) for side in (cases.pin[0] > 0, cases.pin[0] <= 0))
    return pull, push


def chosen_pins(
    structure: PinModelContext, options: AnalysisTable
) -> tuple[PinModelContext, PinModel, tuple[Note, ...]]:
    """Return the model of the pins that was asked for, or contact where that is possible, with its notes.

    A prescribed pressure takes the place of contact that the study or the rod excludes.
    """
    asked_for = options.pressure is not None
    excluded = "" if asked_for else contact_excluded_because(options.support, options.solver)
    if not excluded:
        pins = structure.pins()
        excluded = "" if asked_for else pins.excluded_because
        if not excluded:
            return structure, pins, pins.notes
    structure = replace(structure, pressure=PRESCRIBED)
    pins = structure.pins()
    instead = assumption(f"{PRESCRIBED} takes the place of contact, which {excluded}", "pins")
    return structure, pins, (instead, *pins.notes)


def solve_speed(rod: PreparedRod, rpm: float | None) -> SpeedResult:
    """Solve, judge and check the load cases of one speed, rpm; None for given forces.

    Raises `InvalidValue`: nothing loads the rod; `UnderconstrainedError` and `SingularMatrixError` as
    `Model.solve`.
    """
    with rod.clock("loads"):
        loads = rod.loading.at(rod.mass, rpm)
    loads = replace(loads, cases=joined([loads.cases, rod.pins.resting]))
    solved = rod.equilibrium(loads.cases)
    with rod.clock("stress"):
        cases = judge(rod, solved)
    checks = speed_checks(rod, solved, tuple(cases.values()))
    notes = speed_notes(rod, loads, solved.solution, checks)
    return SpeedResult(rpm=rpm, loads=loads, cases=cases, checks=checks, notes=notes)


def with_cycle(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Work out the whole crank cycle at a speed whose load cases are solved."""
    analysis, cycle = rod.cycle, rod.crank_cycle(static.rpm or 0.0)
    with rod.clock("cycle"):
        found = analysis.at(cycle, tuple(static.cases.values()))
    checks, notes = {**static.checks, **found.checks()}, (*static.notes, *found.notes())
    return replace(static, checks=checks, notes=notes, cycle=found)


def with_fretting(rod: PreparedRod, solved: SpeedResult) -> SpeedResult:
    """Work out what rubs at a speed whose crank cycle is solved."""
    if solved.cycle is None:
        return solved
    cycle = rod.crank_cycle(solved.rpm or 0.0)
    with rod.clock("fretting"):
        found, notes = fretting(rod, cycle, solved.cycle)
    return replace(solved, notes=(*solved.notes, *notes), fretting=found)


def with_film(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Work out the oil films at a speed whose load cases are solved."""
    films, without = films_at(rod, static.rpm or 0.0)
    checks = dict(static.checks)
    for name, each in (item for film in films for item in film.checks.items()):
        checks[name] = max(checks.get(name, each), each, key=lambda found: found.value)
    notes = (*static.notes, *(note for film in films for note in film.notes), *without)
    return replace(static, checks=checks, notes=notes, films=films)


def judge(rod: PreparedRod, solved: Equilibrium) -> dict[str, CaseResult]:
    """Recover the stresses of load cases in equilibrium and judge them, by the name of the case."""
    rims = bore_ends(rod.mesh.whole)
    return {
        case.name: case_result(
            case,
            rod.mesh.whole,
            fields,
            stresses,
            materials=rod.materials,
            rims=rims,
            from_file=rod.study.rod.from_file,
            refined=rod.mesh.meshing.refined,
            bore_datum=rod.bore_datum,
            sharp=rod.sharp_places,
        )
        for case, (fields, stresses) in zip(solved.instants, rod.fields(solved), strict=True)
    }


class MovingRod:
    """Prepares rods of other dimensions one after another; `base` is the mesh that is moved to each.

    The stiffness of each has the sparsity of that before, whose solver has analysed it already: a rod that is
    solved again after the next one was prepared is factorised anew.
    """

    def __init__(self, base: MeshedRod, rod: PreparedRod | None = None) -> None:
        self.base, self._last = base, rod

    def mesh(self, study: Study) -> MeshedRod | None:
        """Move the mesh to a study's rod; None where it cannot follow: see `fea.rod.discretise.moved`."""
        return moved(self.base, study.rod)

    def prepared(self, study: Study, mesh: MeshedRod) -> PreparedRod:
        """Prepare the rod of a study on the mesh that was moved to it; errors as of `prepare`."""
        symbolic = None if self._last is None else self._last.model.handed_on()
        self._last = prepare(study, mesh=mesh, symbolic=symbolic)
        return self._last

    def forget(self) -> None:
        """Let go of the last rod with its factor, which the next one would take the place of."""
        self._last = None
