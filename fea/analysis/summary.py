"""From what was found to the figures of `summary.json`."""

import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from string import ascii_uppercase

import numpy as np

from fea.analysis.assembly_report import assembly_figures, onset_notes, ovality_figures, touch_notes
from fea.analysis.bench import bench_cases, bench_figures
from fea.analysis.buckling import BucklingReport
from fea.analysis.cycle.figures import envelope_figures
from fea.analysis.defect_figures import DefectFigures
from fea.analysis.figures import (
    BoreFigures,
    CaseFigures,
    EngineFigures,
    LiningFigures,
    LoadFigures,
    ModelFigures,
    QualityFigures,
    RodFigures,
    SharpEdgeFigures,
    WeakestFigures,
    figures,
    plain,
)
from fea.analysis.fretting_figures import FrettingFigures
from fea.analysis.hand_calculation import hand_calculation
from fea.analysis.head_clearance import head_clearance
from fea.analysis.life_figures import BenchFigures, CycleFigures
from fea.analysis.overload_figures import OverloadFigures
from fea.analysis.pipeline import RefinedRod
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.reliability import duty_reliability
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary_figures import (
    AssemblyFigures,
    BucklingFigures,
    EnvironmentFigures,
    FilmFigures,
    HeadClearanceFigures,
    PassFigures,
    PlasticFigures,
    Summary,
)
from fea.analysis.survival import GIVEN, factors, survival
from fea.base.checks import Check
from fea.base.choices import CONVERGED_PERCENT
from fea.base.note import CANNOT_GOVERN, OTHER_RODS, Note, by_consequence, doubt, remark
from fea.base.units import BAR, DEG, KG_M2, KN
from fea.base.version import __version__
from fea.judge.case_result import CaseResult, Governing
from fea.judge.fatigue import fatigue_notes
from fea.judge.safety_factor import SafetyFactor
from fea.judge.sharp_places import SharpPlace, worst_of_edges
from fea.judge.verdict import CAP, ConvergenceVerdict, peak
from fea.machine.system import peak_memory
from fea.machine.threads import threads
from fea.rod.loading import EngineLoading, Loading
from fea.rod.places import place_name
from fea.study.assembly_table import BUSHING
from geometry.arrays import vector
from geometry.surfaces import Surface
from loads.instants import Instants
from mesh.generate import Repair
from mesh.quality import Quality


def sharp_edge_figures(
    cases: Mapping[str, CaseResult], required: float | None
) -> dict[str, tuple[SharpEdgeFigures, ...]]:
    """Return the edges that matter by load case, the worst first, with the same names in all cases."""
    kept = {name: case.sharp_mattering for name, case in cases.items()}
    least, names = 1.0 if required is None else required, {}
    for number, place in enumerate(worst_of_edges(kept.values())):  # A, B, …, Z, A1, B1 and so on
        turn, letter = divmod(number, len(ascii_uppercase))
        names[place.between] = ascii_uppercase[letter] + (str(turn) if turn else "")
    return {
        name: tuple(_sharp_edge(place, names[place.between], least) for place in places)
        for name, places in kept.items()
    }


def _sharp_edge(place: SharpPlace, name: str, required: float) -> SharpEdgeFigures:
    notch = place.notch
    return figures(
        SharpEdgeFigures,
        place,
        name=name,
        safety_factor=place.safety_factor.against("yielding", place=f"edge {name}"),
        notch_intensity=None if notch is None else notch.intensity,
        required_safety_factor=required,
        fillet_radius_mm=place.fillet(required),
        largest_fillet_mm=None if notch is None else notch.longest,
    )


_PACKAGES = ("gmsh", "scikit-fem", "numpy", "scipy", "pyvista", "vtk")
_versions = cache(lambda: {name: version(name) for name in _PACKAGES})


def speed_summary(adapted: RefinedRod, result: SpeedResult, buckling: BucklingReport) -> Summary:
    """Return the figures of one speed."""
    rod, passes = adapted.rod, adapted.passes
    cases = tuple(result.cases.values())
    governing = Governing.of(cases)
    edges = sharp_edge_figures(result.cases, rod.options.min_safety)
    assembly = assembly_figures(rod, result.cases, result.cycle)
    bench = bench_figures(rod, result)
    summary = summary_of(
        rod,
        passes,
        rpm=result.rpm,
        fatigue=None if result.cycle is not None or rod.duty is not None else _between(rod, cases),
        loads={name: load_figures(case.load) for name, case in result.cases.items()},
        results={
            name: case_figures(rod, case, governing, edges[name]) for name, case in result.cases.items()
        },
        envelope=None if result.cycle is None else envelope_figures(result.cycle, rod, cases, result.rpm),
        buckling=buckling.figures,
        plastic=result.plastic,
        overload=result.overload,
        bench=bench,
        defect=result.defect,
        assembly=assembly,
        film={film.end.value: film.figures for film in result.films} or None,
        fretting=None if result.fretting is None else result.fretting.figures(rod.mesh.bores.rod_length),
        head_clearance=head_clearance(rod, result),
        checks={**result.checks, **buckling.checks},
        notes=(
            *result.notes,
            *buckling.notes,
            *(fatigue_notes(rod.materials, rod.options.fatigue) if bench_cases(result.cases) else ()),
            *onset_notes(assembly),
            *touch_notes(assembly),
            *_bar_notes(rod, result, governing),
        ),
    )
    cycle = result.cycle
    histories = (None if cycle is None else gauge.history(rod.cycle, cycle.weights) for gauge in rod.gauges)
    gauges = tuple(gauge.figures(cases, own) for gauge, own in zip(rod.gauges, histories, strict=True))
    if summary.life is not None:
        summary = replace(summary, life=replace(summary.life, reliability=duty_reliability(rod)))
    hand = hand_calculation(rod, result.cases, summary)
    return replace(summary, hand=hand, gauges=gauges or None)


def _bar_notes(rod: PreparedRod, result: SpeedResult, governing: Governing) -> Iterator[Note]:
    tolerance = rod.options.tolerance_percent or CONVERGED_PERCENT
    finer = " (--all-cases refines for them too)" if rod.study.tolerance_percent else ""
    loose = [
        f"{name} ± {case.error_percent:.2g} %"
        for name, case in result.cases.items()
        if case.error_percent > tolerance and governing.covers(case, tolerance)
    ]
    if loose:
        yield remark(f"{', '.join(loose)}{finer}", CANNOT_GOVERN)
    for place in worst_of_edges(case.sharp_governing for case in result.cases.values()):
        if place.error_percent > tolerance and place.highest > governing.highest:
            why, remedy = "the elements it is read from reach into the notch effect", "draw the fillet"
            if place.change > place.bar / 2:
                why = "it changes towards where the face beside the edge ends"
            elif finer:
                remedy += ", or refine with --all-cases"
            yield doubt(
                f"its structural stress may govern and is known to ± {place.error_percent:.2g} % only, as "
                f"{why}: {remedy}",
                f"sharp edge between {place.between[0]} and {place.between[1]}",
            )


def _between(rod: PreparedRod, cases: Sequence[CaseResult]) -> SafetyFactor | None:
    some = [case for case in cases if case.load.in_cycle]
    used = usage(rod, some, with_support=True) if len(some) > 1 else None
    if used is None:
        return None
    worst = peak(*used, cases[0].error.masked)
    place = place_name(rod.mesh, worst.node)
    return SafetyFactor.of_stress(1 / worst.value, worst.error_percent, mode="fatigue", place=place)


_CARRIES = "it carries other rods, whose forces are left out"


def summary_of(
    rod: PreparedRod,
    passes: Sequence[PassFigures],
    *,
    rpm: float | None,
    loads: Mapping[str, LoadFigures],
    results: Mapping[str, CaseFigures],
    envelope: CycleFigures | None,
    buckling: BucklingFigures,
    fatigue: SafetyFactor | None = None,
    plastic: PlasticFigures | None = None,
    overload: OverloadFigures | None = None,
    bench: BenchFigures | None = None,
    defect: DefectFigures | None = None,
    assembly: AssemblyFigures | None = None,
    film: Mapping[str, FilmFigures] | None = None,
    fretting: FrettingFigures | None = None,
    head_clearance: HeadClearanceFigures | None = None,
    checks: Mapping[str, Check],
    notes: Sequence[Note],
) -> Summary:
    """Return the figures of one speed, with those that all speeds of a rod share."""
    life = rod.life
    shown, left_out = by_consequence((*notes, *(() if life is None else life.notes)))
    tested = [] if bench is None else [bench.safety_factor]
    return Summary(
        study=rod.study.name,
        rpm=rpm,
        trusted=all(item.passed for item in checks.values()),
        survival=survival(
            factors(results, buckling, envelope, assembly, plastic, overload=overload, defect=defect)
            + tested,
            rod.options.min_safety,
            given_mesh=bool(rod.mesh.meshing.given),
            fatigue_at_most=fatigue,
            by_duty=rod.duty is not None,
            unanalysed=next((_CARRIES for note in shown if note.topic == OTHER_RODS), None),
            stands_on=_operation(rod, rpm, loads, assembly),
        ),
        rod=figures(
            RodFigures,
            rod.mass,
            center_of_gravity_mm=rod.mass.center,
            inertia_kg_m2=rod.mass.inertia_z / KG_M2,
            length_mm=rod.mesh.bores.rod_length,
        ),
        engine=_engine(rod.loading),
        loads=loads,
        model=_model(rod),
        results=results,
        passes=tuple(passes) or None,
        envelope=envelope,
        film=film,
        fretting=fretting,
        life=None if life is None else life.figures,
        buckling=buckling,
        plastic=plastic,
        overload=overload,
        bench=bench,
        defect=defect,
        head_clearance=head_clearance,
        assembly=assembly,
        checks=checks,
        notes=shown,
        timings_s=dict(rod.clock.seconds),
        total_s=rod.clock.total,
        peak_memory_MiB=peak_memory(),
        left_out=left_out,
        environment=EnvironmentFigures(
            versions={"python": platform.python_version(), "conrod-fea": __version__} | _versions(),
            platform=platform.platform(),
            threads=threads(),
        ),
    )


def load_figures(case: Instants) -> LoadFigures:
    """Return what acts in a load case."""
    return figures(LoadFigures, case, crank_deg=plain(case.crank_angle / DEG))


def case_figures(
    rod: PreparedRod,
    case: CaseResult,
    governing: Governing | None = None,
    sharp_edges: tuple[SharpEdgeFigures, ...] = (),
) -> CaseFigures:
    """Return a case's extremes away from singular places, judged alone or beside a `governing` case."""
    length, tolerance = rod.mesh.bores.rod_length, rod.options.tolerance_percent or CONVERGED_PERCENT
    if governing is None or rod.options.all_cases:
        verdict = case.verdict(tolerance)
    else:
        verdict = governing.verdict(case, tolerance)
    return figures(
        CaseFigures,
        case,
        weakest=_weakest(rod, case),
        energy_error_percent=case.error.energy_percent,
        verdict=verdict.value,
        **(_singular(rod, case) if case.error.masked.any() else {}),
        sharp_edges=sharp_edges or None,
        contact={surface.value: _bore(case, surface, length) for surface in case.touch} or None,
        linings=dict(_linings(rod, case)) or None,
    )


def _linings(rod: PreparedRod, case: CaseResult) -> Iterator[tuple[str, LiningFigures]]:
    bores = rod.mesh.bores
    small, big = bores.small_radius * bores.small_width, bores.big_radius * bores.big_width
    for part, material, stress in zip(rod.mesh.parts, rod.materials, case.part_von_mises, strict=True):
        if material.lining:
            force, half = (case.load.pin, small) if part == BUSHING else (case.load.crank, big)
            factor = min(material.yield_strength / float(np.nanmax(stress[case.counts])), CAP)
            load = float(np.linalg.norm(force)) / (2 * half)
            yield part, LiningFigures(safety_factor=SafetyFactor(factor), specific_load_MPa=load)


def _weakest(rod: PreparedRod, case: CaseResult) -> WeakestFigures:
    node, strengths = case.worst.node, [material.yield_strength for material in rod.materials]
    used = [
        np.nan if material.lining else stress[node] / material.yield_strength
        for stress, material in zip(case.part_von_mises, rod.materials, strict=True)
    ]
    part = int(np.nan_to_num(used).argmax())
    return WeakestFigures(
        at_mm=vector(rod.mesh.whole.points[node]),
        where=place_name(rod.mesh, node),
        part=list(rod.mesh.parts)[part],
        yield_MPa=strengths[part],
    )


def _singular(rod: PreparedRod, case: CaseResult) -> dict[str, float | str | None]:
    node = case.peak.singular_node
    where = None if node is None else rod.fields.errors.singular_name(int(rod.mesh.mirrored.source[node]))
    return {
        "unmasked_max_von_mises_MPa": case.peak.unmasked,
        "unmasked_min_safety_factor": 1 / case.worst.unmasked,
        "unmasked_verdict": ConvergenceVerdict.DIVERGING.value,
        "singular_max_von_mises_MPa": case.peak.singular,
        "singular_verdict": ConvergenceVerdict.DIVERGING.value,
        "singular_where": where,
    }


def _bore(case: CaseResult, surface: Surface, rod_length: float) -> BoreFigures:
    touch, x = case.touch[surface], rod_length if surface is Surface.SMALL_END_BORE else 0.0
    return figures(BoreFigures, touch, **vars(ovality_figures(case, surface, x)))


def quality_figures(quality: Quality, repair: Repair) -> QualityFigures:
    """Return the quality of a mesh."""
    repaired = {"repairs": tuple(repair.causes), "repaired_size_mm": repair.size}
    return figures(QualityFigures, quality, straightened_elements=quality.straightened, **repaired)


def _engine(loading: Loading) -> EngineFigures | None:
    if not isinstance(loading, EngineLoading):
        return None
    return figures(EngineFigures, loading.engine, strokes=loading.engine.strokes)


def _operation(
    rod: PreparedRod, rpm: float | None, loads: Mapping[str, LoadFigures], assembly: AssemblyFigures | None
) -> str:
    """What the rod is judged for, in words."""
    said = [GIVEN]
    if isinstance(rod.loading, EngineLoading) and rpm is not None:
        said = [f"{rpm:.0f} rpm"]
        pressed = max((load.gas_N or 0.0 for load in loads.values()), default=0.0)
        if pressed:
            peak = pressed / rod.loading.engine.piston_area + rod.loading.table.atmosphere
            said.append(f"a mean peak of {peak / BAR:.0f} bar")
        said.append("pins supplied with oil")
    if assembly is not None:
        said.insert(-1, f"bolts at {assembly.bolts.preload_N / KN:.1f} kN")
    return f"{', '.join(said[:-1])} and {said[-1]}" if len(said) > 1 else said[0]


def _model(rod: PreparedRod) -> ModelFigures:
    whole, meshing = rod.mesh.whole, rod.mesh.meshing
    return ModelFigures(
        nodes=len(whole.points),
        elements=len(whole.tets),
        dofs=whole.points.size,
        solved_dofs=rod.model.solved_dofs,
        element=f"p{rod.mesh.cell.order}",
        formulation="displacement-pressure" if rod.structure.soft else "displacement",
        size_mm=meshing.size,
        symmetry=rod.mesh.symmetry.value,
        support=rod.options.support.value,
        pressure=rod.structure.pressure,
        solver=rod.model.solver,
        assembly=rod.options.matrix_assembly.value,
        quality=quality_figures(meshing.quality, meshing.repair),
        mesh_from_file=True if meshing.given else None,
    )
