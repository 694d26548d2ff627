"""The figures of a crank cycle in `summary.json`: its worst values, and the histories of its worst places."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.unit_solutions import PlaceHistory
from fea.analysis.life_figures import (
    CycleLifeFigures,
    EnduranceFigures,
    EnvelopeFigures,
    SpotFigures,
    SurfaceFigures,
)
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.reliability import reliability_figures, speed_operation
from fea.base.material import Material
from fea.base.units import DEG
from fea.judge.case_result import CaseResult
from fea.judge.cycle_life import cycle_life
from fea.judge.fatigue import crossland_factors, fatigue_factor
from fea.judge.history import deviatoric, extremes
from fea.judge.safety_factor import CycleLife, SafetyFactor, without_bar
from fea.judge.verdict import CAP, peak, safety_factor
from fea.rod.loading import EngineLoading
from fea.rod.places import place_name
from geometry.arrays import vector


def envelope_figures(
    result: CycleResult, rod: PreparedRod, cases: Sequence[CaseResult], rpm: float | None
) -> EnvelopeFigures:
    """Return the worst of the cycle at a speed and its worst places; errors are those of its load cases."""
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
        min_fatigue_safety_factor_without_support=_without_support(result, rod),
        life=life_figures(result, rod, rpm),
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


def life_figures(result: CycleResult, rod: PreparedRod, rpm: float | None) -> CycleLifeFigures | None:
    """Return the hours at a speed until the worst place fails; None where no S–N line can be assumed."""
    spot, loading = result.weakest, rod.loading
    if spot is None or not rpm or not isinstance(loading, EngineLoading):
        return None
    material = rod.materials[spot.part]
    surface = result.regions.factor(spot.node, material)
    operation = speed_operation(result, rod, rpm)
    (place,) = operation.places([(spot.node, spot.part)])
    varied = [(share, signed) for share, (signed,) in operation.varied(*place)]
    found = cycle_life(spot.signed, material, surface, rod.options.fatigue, varied)
    if found is None:
        return None
    steady = cycle_life(spot.signed, material, surface, rod.options.fatigue)
    undamaged = steady is not None and steady.cycles == np.inf > found.cycles
    return replace(
        cycle_life_figures(found, loading.engine.cycles_per_hour * rpm),
        steady_is_undamaged=undamaged or None,
        reliability=reliability_figures(result, rod, operation),
    )


def cycle_life_figures(found: CycleLife, an_hour: float) -> CycleLifeFigures:
    """Return a life in hours, of so many cycles an hour."""
    cycles, low, high = (
        each if np.isfinite(each) else None for each in (found.cycles, found.low, found.high)
    )
    return CycleLifeFigures(
        hours=None if cycles is None else cycles / an_hour,
        low_hours=None if low is None else low / an_hour,
        high_hours=None if high is None else high / an_hour,
        band_percent=found.band_percent,
        cycles=cycles,
        assumed=found.assumed,
        unlimited=found.unlimited,
        by_strain=found.by_strain,
    )


def _without_support(result: CycleResult, rod: PreparedRod) -> float | None:
    """Return the least factor against fatigue with the local stress in full; None where it always is."""
    found, regions = result.envelope, result.regions.without_support()
    if result.regions.gradient is None or found.fatigue_factor is None:
        return None
    least = CAP
    for number, material in enumerate(rod.materials):
        rows = result.counts & (found.fatigue_part == number)
        surface = regions.factors(material)[rows]
        stress = found.mean[rows], found.amplitude[rows]
        factors = fatigue_factor(rod.options.fatigue, *stress, material, surface)
        least = least if factors is None else min(least, float(factors.min(initial=CAP)))
    return least


def _of_peaks(cases: Sequence[CaseResult]) -> float | None:
    """Return the bar, percent, of the smallest factor of load cases: down to the least that any can be."""
    every = [case.min_safety_factor for case in cases]
    least, lowest = min(every), min(factor.low for factor in every)
    return 100 * (least / lowest - 1)


def fatigue_error(result: CycleResult, rod: PreparedRod, cases: Sequence[CaseResult]) -> float | None:
    """Return the error bar, percent, of the smallest factor against fatigue: that between the load cases."""
    used = usage(rod, cases)
    return None if used is None else peak(*used, ~result.counts).error_percent


def _spot(spot: PlaceHistory, result: CycleResult, rod: PreparedRod) -> SpotFigures:
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
        support_factor=float(here.support(material)[0]) if material.support else None,
        history_MPa=tuple(spot.signed.tolist()),
    )


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
