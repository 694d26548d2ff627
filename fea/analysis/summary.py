"""From what was found to the figures of `summary.json`."""

import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from string import ascii_uppercase

import numpy as np

from fea.analysis.adapt import Adapted, usage
from fea.analysis.assembly_report import assembly_figures, onset_notes, ovality_figures, touch_notes
from fea.analysis.buckling import BucklingReport
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.unit_solutions import Spot
from fea.analysis.figures import (
    AssemblyFigures,
    BoreFigures,
    BucklingFigures,
    CaseFigures,
    CycleFigures,
    EnduranceFigures,
    EngineFigures,
    EnvelopeFigures,
    EnvironmentFigures,
    FilmFigures,
    LiningFigures,
    LoadFigures,
    ModelFigures,
    PassFigures,
    QualityFigures,
    RodFigures,
    SharpEdgeFigures,
    SpotFigures,
    Summary,
    SurfaceFigures,
    WeakestFigures,
    figures,
    plain,
)
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult
from fea.analysis.survival import factors, survival
from fea.base.checks import Check
from fea.base.choices import CONVERGED_PERCENT
from fea.base.material import Material
from fea.base.note import CANNOT_GOVERN, OTHER_RODS, Note, by_consequence, doubt, remark
from fea.base.units import BAR, DEG, KG_M2, KN
from fea.base.version import __version__
from fea.judge.case_result import CaseResult
from fea.judge.fatigue import crossland_factors, fatigue_factor
from fea.judge.governing import Governing
from fea.judge.history import deviatoric, extremes
from fea.judge.safety_factor import SafetyFactor, without_bar
from fea.judge.sharp_places import SharpPlace, worst_of_edges
from fea.judge.verdict import CAP, Verdict, peak, safety_factor
from fea.machine.system import peak_memory
from fea.machine.threads import threads
from fea.rod.loading import EngineLoading
from fea.rod.place_names import place_name
from fea.study.assembly_table import BUSHING
from geometry.arrays import vector
from geometry.surfaces import Surface
from loads.instants import Instants
from mesh.generate import Repair
from mesh.quality import Quality


def endurance_figures(parts: Iterable[str], materials: Sequence[Material]) -> dict[str, EnduranceFigures]:
    """Return the factors of every part, by its name, whose endurance limit is known."""
    return {
        part: _endurance(material, material.endurance_limit)
        for part, material in zip(parts, materials, strict=True)
        if material.endurance_limit is not None
    }


def _endurance(material: Material, limit: float) -> EnduranceFigures:
    marin = material.marin
    return EnduranceFigures(
        specimen_MPa=limit / (marin.size * marin.load * marin.reliability),
        cycles=material.endurance_cycles,
        estimated=material.endurance_estimated,
        size_factor=marin.size,
        load_factor=marin.load,
        reliability_factor=marin.reliability,
        reliability_percent=marin.reliability_percent,
        regions={
            region.value: SurfaceFigures(
                finish=surface.finish,
                surface_factor=surface.factor,
                endurance_MPa=limit * surface.factor,
                assumed=surface.assumed or None,
            )
            for region, surface in marin.surfaces.items()
        },
    )


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
        safety_factor=SafetyFactor.of_stress(place.safety_factor, place.error_percent, place=f"edge {name}"),
        notch_intensity=None if notch is None else notch.intensity,
        required_safety_factor=required,
        fillet_radius_mm=place.fillet(required),
        largest_fillet_mm=None if notch is None else notch.longest,
    )


_PACKAGES = ("gmsh", "scikit-fem", "numpy", "scipy", "pyvista", "vtk")
_versions = cache(lambda: {name: version(name) for name in _PACKAGES})


def speed_summary(adapted: Adapted, result: SpeedResult, buckling: BucklingReport) -> Summary:
    """Return the figures of one speed."""
    rod, passes = adapted.rod, adapted.passes
    cases = tuple(result.cases.values())
    governing = Governing.of(cases)
    edges = sharp_edge_figures(result.cases, rod.options.min_safety)
    assembly = assembly_figures(rod, result.cases, result.cycle)
    return summary_of(
        rod,
        passes,
        rpm=result.rpm,
        fatigue=None if result.cycle is not None or rod.duty is not None else _between(rod, cases),
        loads={name: load_figures(case.load) for name, case in result.cases.items()},
        results={
            name: case_figures(rod, case, governing, edges[name]) for name, case in result.cases.items()
        },
        envelope=None if result.cycle is None else envelope_figures(result.cycle, rod, cases),
        buckling=buckling.figures,
        assembly=assembly,
        film={film.end.value: film.figures for film in result.films} or None,
        checks={**result.checks, **buckling.checks},
        notes=(
            *result.notes,
            *buckling.notes,
            *onset_notes(assembly),
            *touch_notes(assembly),
            *_bar_notes(rod, result, governing),
        ),
    )


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
    used = usage(rod, some) if len(some) > 1 else None
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
    assembly: AssemblyFigures | None = None,
    film: Mapping[str, FilmFigures] | None = None,
    checks: Mapping[str, Check],
    notes: Sequence[Note],
) -> Summary:
    """Return the figures of one speed, with those that all speeds of a rod share."""
    life = rod.life
    shown, left_out = by_consequence((*notes, *(() if life is None else life.notes)))
    return Summary(
        study=rod.study.name,
        rpm=rpm,
        trusted=all(item.passed for item in checks.values()),
        survival=survival(
            factors(results, buckling, envelope, assembly),
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
        engine=figures(EngineFigures, rod.loading.engine) if isinstance(rod.loading, EngineLoading) else None,
        loads=loads,
        model=_model(rod),
        results=results,
        passes=tuple(passes) or None,
        envelope=envelope,
        film=film,
        life=None if life is None else life.figures,
        buckling=buckling,
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
        min_safety_factor=_of_case(case),
        weakest=_weakest(rod, case),
        energy_error_percent=case.error.energy_percent,
        verdict=verdict.value,
        **(_singular(rod, case) if case.error.masked.any() else {}),
        sharp_edges=sharp_edges or None,
        contact={surface.value: _bore(case, surface, length) for surface in case.touch} or None,
        linings=dict(_linings(rod, case)) or None,
    )


def _of_case(case: CaseResult) -> SafetyFactor:
    return SafetyFactor.of_stress(case.min_safety_factor, case.error_percent, instant=case.load.name)


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
        "unmasked_verdict": Verdict.DIVERGING.value,
        "singular_max_von_mises_MPa": case.peak.singular,
        "singular_verdict": Verdict.DIVERGING.value,
        "singular_where": where,
    }


def _bore(case: CaseResult, surface: Surface, rod_length: float) -> BoreFigures:
    touch, x = case.touch[surface], rod_length if surface is Surface.SMALL_END_BORE else 0.0
    return figures(BoreFigures, touch, **vars(ovality_figures(case, surface, x)))


def envelope_figures(result: CycleResult, rod: PreparedRod, cases: Sequence[CaseResult]) -> EnvelopeFigures:
    """Return the worst of the cycle and its worst places; errors are those of its load cases."""
    mesh, materials = rod.mesh.whole, rod.materials
    found, counts = result.envelope, result.counts
    worst = int(np.where(counts, found.usage, -np.inf).argmax())
    # of the rod: the field has the linings of the bores, too
    factor = max(float(found.safety_factor[worst]), min(1 / float(found.usage[worst]), CAP))
    fatigue, multiaxial = (
        None if spot is None else _spot(spot, result, rod) for spot in (result.weakest, result.multiaxial)
    )
    off = fatigue_error(result, rod, cases)
    if fatigue is not None and fatigue.fatigue_safety_factor is not None:
        least = SafetyFactor.of_stress(fatigue.fatigue_safety_factor, off, mode="fatigue")
        fatigue = replace(fatigue, fatigue_safety_factor=least)
    singular = not counts.all()
    return EnvelopeFigures(
        min_safety_factor=SafetyFactor.of_stress(factor, _of_peaks(cases)),
        at_mm=vector(mesh.points[worst]),
        where=place_name(rod.mesh, worst),
        crank_deg=float(found.usage_angle[worst]) / DEG,
        max_von_mises_MPa=float(found.von_mises[counts].max()),
        max_principal_MPa=float(found.principal_1[counts].max()),
        min_principal_MPa=float(found.principal_3[counts].min()),
        min_fatigue_safety_factor=None if fatigue is None else fatigue.fatigue_safety_factor,
        fatigue_criterion=rod.options.fatigue.value,
        fatigue=fatigue,
        fatigue_error_percent=off,
        min_crossland_safety_factor=None if multiaxial is None else multiaxial.crossland_safety_factor,
        crossland=multiaxial,
        endurance=endurance_figures(rod.mesh.parts, materials) or None,
        spots=tuple(_spot(spot, result, rod) for spot in result.spots),
        unit_solutions=result.unit_solutions,
        instants=len(result.angles),
        superposition_error=result.superposition,
        unmasked_max_von_mises_MPa=float(found.von_mises.max()) if singular else None,
        unmasked_min_safety_factor=SafetyFactor(float(found.safety_factor.min())) if singular else None,
    )


def _of_peaks(cases: Sequence[CaseResult]) -> float | None:
    """Return the bar, percent, of the smallest factor of load cases: down to the least that any can be."""
    every = [_of_case(case) for case in cases]
    least, lowest = min(every), min(factor.low for factor in every)
    return 100 * (least / lowest - 1)


def fatigue_error(result: CycleResult, rod: PreparedRod, cases: Sequence[CaseResult]) -> float | None:
    """Return the error bar, percent, of the smallest factor against fatigue: that between the load cases."""
    used = usage(rod, cases)
    return None if used is None else peak(*used, ~result.counts).error_percent


def _spot(spot: Spot, result: CycleResult, rod: PreparedRod) -> SpotFigures:
    """Return the extremes of a place.

    All are of the part that the spot is of; where the envelope is another part's there, they are taken from
    every degree.
    """
    found, node, material = result.envelope, spot.node, rod.materials[spot.part]
    criterion = rod.options.fatigue
    components = deviatoric(spot.stress)
    own = extremes(components[None])
    largest, angle = own.von_mises[0], result.angles[own.instant[0]]
    if spot.part == found.part[node]:
        largest, angle = material.yield_strength * found.usage[node], found.usage_angle[node]
    mean, amplitude, ratio = own.mean, own.amplitude, own.ratio
    here = result.regions.at(np.array([node]))
    surface, region = float(here.factors(material)[0]), here.region(0, material)
    factor = fatigue_factor(criterion, mean, amplitude, material, surface)
    multiaxial = crossland_factors(components[None], material, surface)
    if spot.part == found.fatigue_part[node]:
        mean, amplitude, ratio = found.mean[[node]], found.amplitude[[node]], found.ratio[[node]]
        if factor is not None and found.fatigue_factor is not None:
            factor = found.fatigue_factor[[node]]
    return SpotFigures(
        at_mm=vector(spot.place),
        where=place_name(rod.mesh, node),
        max_von_mises_MPa=float(largest),
        crank_deg=float(angle) / DEG,
        mean_MPa=float(mean[0]),
        amplitude_MPa=float(amplitude[0]),
        stress_ratio=float(ratio[0]),
        safety_factor=SafetyFactor(float(safety_factor(np.asarray(largest), material.yield_strength))),
        fatigue_safety_factor=None if factor is None else without_bar(float(factor[0])),
        crossland_safety_factor=None if multiaxial is None else without_bar(float(multiaxial[0])),
        endurance_MPa=None if material.endurance_limit is None else surface * material.endurance_limit,
        surface_region=None if region is None else region.value,
        history_MPa=tuple(spot.signed.tolist()),
    )


def quality_figures(quality: Quality, repair: Repair) -> QualityFigures:
    """Return the quality of a mesh."""
    repaired = {"repairs": tuple(repair.causes), "repaired_size_mm": repair.size}
    return figures(QualityFigures, quality, straightened_elements=quality.straightened, **repaired)


def _operation(
    rod: PreparedRod, rpm: float | None, loads: Mapping[str, LoadFigures], assembly: AssemblyFigures | None
) -> str:
    """What the rod is judged for, in words."""
    said = ["the given forces"]
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
