"""A fatigue test between two forces along the rod: the factor, and cycles until the worst place fails."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fea.analysis.life_figures import BenchFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.speed_result import SpeedResult
from fea.judge.case_result import CaseResult
from fea.judge.cycle_life import cycle_life
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import peak
from fea.rod.loading import LOWER, UPPER
from fea.rod.places import place_name
from geometry.arrays import vector
from loads.instants import ASSEMBLY


def bench_cases(cases: Mapping[str, CaseResult]) -> list[CaseResult]:
    """Return the two levels of a fatigue test among load cases; none without one."""
    found = [cases[name] for name in (UPPER, LOWER) if name in cases]
    if len(found) == 1:  # the other level is no force: bolts and fits remain, if there are any
        free = replace(found[0], stress=0 * found[0].stress, von_mises_error=0 * found[0].von_mises_error)
        found.append(cases.get(ASSEMBLY, free))
    return found


def bench_figures(rod: PreparedRod, result: SpeedResult) -> BenchFigures | None:
    """Return what a fatigue test does to a rod; None without one, or where no fatigue strength is known.

    Raises `InvalidValue`: the S–N line of a material does not fit its endurance limit.
    """
    cases = bench_cases(result.cases)
    used = usage(rod, cases) if cases else None
    if used is None:
        return None
    worst = peak(*used, cases[0].error.masked)
    stress = np.stack([case.stress[worst.node] for case in cases], axis=-1)
    signed = signed_equivalent(deviatoric(stress[None]))[0]
    where = place_name(rod.mesh, worst.node)
    parts = zip(rod.materials, cases[0].part_von_mises, strict=True)
    there = [one for one, own in parts if one.endurance_limit and not np.isnan(own[worst.node])]
    material = min(there, key=lambda one: (one.endurance_limit or 0.0) * rod.regions.factor(worst.node, one))
    life = cycle_life(signed, material, rod.regions.factor(worst.node, material), rod.options.fatigue)
    named = {"mode": "fatigue", "place": where}
    return BenchFigures(
        forces_N=tuple(float(case.load.pin_axial) if case.stress.any() else 0.0 for case in cases),
        safety_factor=SafetyFactor.of_stress(1 / worst.value, worst.error_percent, **named),
        at_mm=vector(rod.mesh.whole.points[worst.node]),
        where=where,
        mean_MPa=float(signed.mean()),
        amplitude_MPa=float(np.ptp(signed) / 2),
        life=life,
    )
