"""The cycle in a run's summary."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fea.assess.crossland import crossland
from fea.assess.deviatoric import deviatoric
from fea.choices import Fatigue
from fea.cycle.analysis import CycleResult
from fea.cycle.spots import Spot
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
    fatigue = None if result.weakest is None else _place(result.weakest, result, materials)
    multiaxial = None if result.multiaxial is None else _place(result.multiaxial, result, materials)
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
        "spots": [_place(spot, result, materials) for spot in result.spots],
        "unit_solutions": result.unit_solutions,
        "instants": len(result.angles),
    } | ({} if counts.all() else unmasked)


def _place(spot: Spot, result: CycleResult, materials: Sequence[Material]) -> dict[str, Any]:
    """Return the extremes of a place; ``history_MPa`` is its signed von Mises stress at every degree."""
    found, node = result.envelope, spot.node
    factor = None if found.fatigue_factor is None else float(found.fatigue_factor[node])
    material = materials[int(found.part[node])]
    return {
        "at_mm": spot.place.tolist(),
        "max_von_mises_MPa": material.yield_strength * float(found.usage[node]),
        "crank_deg": float(found.usage_angle[node]) / DEG,
        "mean_MPa": float(found.mean[node]),
        "amplitude_MPa": float(found.amplitude[node]),
        "stress_ratio": float(found.ratio[node]),
        "safety_factor": float(found.safety_factor[node]),
        "fatigue_safety_factor": factor,
        "crossland_safety_factor": crossland(deviatoric(spot.stress), material),
        "history_MPa": spot.signed.tolist(),
    }
