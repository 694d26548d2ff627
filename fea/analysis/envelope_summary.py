"""The cycle in a run's summary."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fea.assess.crossland import crossland
from fea.assess.deviatoric import deviatoric
from fea.assess.fatigue import fatigue_factor
from fea.assess.history import extremes
from fea.assess.safety import safety_factor
from fea.choices import Fatigue
from fea.cycle.spots import Spot
from fea.cycle.superposition import CycleResult
from fea.material import Material
from fea.units import DEG
from mesh.tetmesh import TetMesh


def envelope_figures(
    result: CycleResult, mesh: TetMesh, criterion: Fatigue, materials: Sequence[Material]
) -> dict[str, Any]:
    """Return the figures of ``envelope`` in ``summary.json``: the worst of the cycle and its worst places."""
    found = result.envelope
    counts = result.counts
    worst = int(np.where(counts, found.usage, -np.inf).argmax())
    unmasked = {
        "unmasked_max_von_mises_MPa": float(found.von_mises.max()),
        "unmasked_min_safety_factor": float(found.safety_factor.min()),
    }
    fatigue, multiaxial = (
        None if spot is None else _place(spot, result, materials, criterion)
        for spot in (result.weakest, result.multiaxial)
    )
    return {
        "min_safety_factor": float(found.safety_factor[worst]),
        "at_mm": mesh.points[worst].tolist(),
        "crank_deg": float(found.usage_angle[worst]) / DEG,
        "max_von_mises_MPa": float(found.von_mises[counts].max()),
        "max_principal_MPa": float(found.principal_1[counts].max()),
        "min_principal_MPa": float(found.principal_3[counts].min()),
        "min_fatigue_safety_factor": None if fatigue is None else fatigue["fatigue_safety_factor"],
        "fatigue_criterion": criterion.value,
        "fatigue": fatigue,
        "min_crossland_safety_factor": None if multiaxial is None else multiaxial["crossland_safety_factor"],
        "crossland": multiaxial,
        "spots": [_place(spot, result, materials, criterion) for spot in result.spots],
        "unit_solutions": result.unit_solutions,
        "instants": len(result.angles),
    } | ({} if counts.all() else unmasked)


def _place(
    spot: Spot, result: CycleResult, materials: Sequence[Material], criterion: Fatigue
) -> dict[str, Any]:
    """Return the extremes of a place; ``history_MPa`` is its signed von Mises stress at every degree.

    All are of the part that the spot is of; where the envelope is another's there, they are of every degree.
    """
    found, node, material = result.envelope, spot.node, materials[spot.part]
    components = deviatoric(spot.stress)
    own = extremes(components[None])
    largest, angle = own.von_mises[0], result.angles[own.instant[0]]
    if spot.part == found.part[node]:
        largest, angle = material.yield_strength * found.usage[node], found.usage_angle[node]
    mean, amplitude, ratio = own.mean, own.amplitude, own.ratio
    factor = fatigue_factor(criterion, mean, amplitude, material)
    if spot.part == found.fatigue_part[node]:
        mean, amplitude, ratio = found.mean[[node]], found.amplitude[[node]], found.ratio[[node]]
        factor = None if found.fatigue_factor is None else found.fatigue_factor[[node]]
    return {
        "at_mm": spot.place.tolist(),
        "max_von_mises_MPa": float(largest),
        "crank_deg": float(angle) / DEG,
        "mean_MPa": float(mean[0]),
        "amplitude_MPa": float(amplitude[0]),
        "stress_ratio": float(ratio[0]),
        "safety_factor": float(safety_factor(np.asarray(largest), material.yield_strength)),
        "fatigue_safety_factor": None if factor is None else float(factor[0]),
        "crossland_safety_factor": crossland(components, material),
        "history_MPa": spot.signed.tolist(),
    }
