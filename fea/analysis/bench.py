"""A fatigue test between two forces along the rod: cycles until the worst place fails, and the factor."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fea.analysis.figures import BenchFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.speed_result import SpeedResult
from fea.base.note import Note, assumptions, omission
from fea.judge.cycle_life import cycle_life
from fea.judge.fatigue import fatigue_factor, fatigue_notes
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import peak
from fea.rod.loading import LOWER, UPPER, GivenForces
from fea.rod.places import place_name
from geometry.arrays import vector
from loads.instants import ASSEMBLY


def bench_figures(rod: PreparedRod, result: SpeedResult) -> BenchFigures | None:
    """Return what a fatigue test does to a rod; None without one, or where no fatigue strength is known.

    Raises `InvalidValue`: the S–N line of a material does not fit its endurance limit.
    """
    if not isinstance(rod.loading, GivenForces) or rod.loading.levels is None:
        return None
    cases = [result.cases[name] for name in (UPPER, LOWER) if name in result.cases]
    if len(cases) == 1:  # the other level is no force: bolts and fits remain, if there are any
        free = replace(cases[0], stress=0 * cases[0].stress, von_mises_error=0 * cases[0].von_mises_error)
        cases.append(result.cases.get(ASSEMBLY, free))
    used = usage(rod, cases)
    if used is None:
        return None
    worst, criterion = peak(*used, cases[0].error.masked), rod.options.fatigue
    stress = np.stack([case.stress[worst.node] for case in cases], axis=-1)
    signed = signed_equivalent(deviatoric(stress[None]))[0]
    mean, amplitude = np.array([signed.mean()]), np.array([np.ptp(signed) / 2])
    here = rod.regions.at(np.array([worst.node]))
    factors = {}
    for material, of_part in zip(rod.materials, cases[0].part_von_mises, strict=True):
        factor = fatigue_factor(criterion, mean, amplitude, material, here.factors(material))
        if factor is not None and not np.isnan(of_part[worst.node]):
            factors[material] = float(factor[0])
    material = min(factors, key=factors.__getitem__)
    life = cycle_life(signed, material, float(here.factors(material)[0]), criterion)
    cycles = (None,) * 3 if life is None else (life.cycles, life.low, life.high)
    count, low, high = (None if each is None or np.isinf(each) else each for each in cycles)
    where = place_name(rod.mesh, worst.node)
    largest, least = rod.loading.levels
    return BenchFigures(
        upper_N=largest,
        lower_N=least,
        ratio=least / largest,
        fatigue_safety_factor=SafetyFactor.of_stress(
            1 / worst.value, worst.error_percent, mode="fatigue", place=where
        ),
        fatigue_criterion=criterion.value,
        at_mm=vector(rod.mesh.whole.points[worst.node]),
        where=where,
        mean_MPa=float(mean[0]),
        amplitude_MPa=float(amplitude[0]),
        cycles=count,
        low_cycles=low,
        high_cycles=high,
        band_percent=None if life is None else life.band_percent,
        assumed=None if life is None else life.assumed,
        unlimited=None if life is None else life.unlimited,
        by_strain=None if life is None else life.by_strain,
    )


def bench_notes(rod: PreparedRod) -> Iterator[Note]:
    """Yield what the factor and the cycles of a fatigue test presume; nothing without one."""
    if isinstance(rod.loading, GivenForces) and rod.loading.levels is not None:
        yield from fatigue_notes(rod.materials, rod.options.fatigue, strokes=None)
        yield from assumptions("fatigue test", ["stress between the two forces lies between that at either"])
        if any(material.support for material in rod.materials):
            yield omission("support of the gradient of stress", "the local stress counts in full in a test")
