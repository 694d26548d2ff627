"""The summary of a run, as `summary.json` holds it."""

import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from fea.analysis.adapt import Pass
from fea.analysis.envelope_summary import envelope_figures
from fea.analysis.pipeline import Analysis, SpeedResult
from fea.machine.clock import Clock
from fea.machine.peak_memory import peak_memory
from fea.units import DEG, KG, KG_M2, N_M
from loads.cases import LoadCase

SCHEMA = "fea/summary/1"
_PACKAGES = ("conrod-fea", "gmsh", "scikit-fem", "numpy", "scipy", "pyvista", "vtk")


def summary(
    analysis: Analysis,
    result: SpeedResult,
    buckling: Mapping[str, Any],
    clock: Clock,
    passes: Sequence[Pass] = (),
) -> dict[str, Any]:
    """Return the figures of one speed, in the units their names say."""
    mesh, tolerance = analysis.mesh.whole.mesh, analysis.study.analysis.tolerance_percent
    return {
        "schema": SCHEMA,
        "study": analysis.study.name,
        "rpm": result.rpm,
        "trusted": result.trusted,
        "rod": _rod(analysis),
        "engine": _engine(analysis),
        "loads": {case.case.name: load_figures(case.case) for case in result.cases},
        "model": _model(analysis),
        "results": {case.case.name: case.extremes(mesh, tolerance) for case in result.cases},
        **({"passes": [asdict(item) for item in passes]} if passes else {}),
        **_envelope(analysis, result),
        "buckling": dict(buckling),
        "checks": {
            name: {"value": item.value, "limit": item.limit, "pass": item.passed}
            for name, item in result.checks.items()
        },
        "notes": [*result.notes, *analysis.study.rod.mass_remarks(analysis.rod)],
        "timings_s": dict(clock.seconds),
        "total_s": clock.total,
        "peak_memory_MiB": peak_memory(),
        "left_out": [{"what": item.what, "why": item.why} for item in result.left_out],
        "environment": _environment(),
    }


def _envelope(analysis: Analysis, result: SpeedResult) -> dict[str, Any]:
    if result.cycle is None:
        return {}
    mesh, criterion = analysis.mesh.whole.mesh, analysis.study.analysis.fatigue
    return {"envelope": envelope_figures(result.cycle, mesh, criterion, analysis.materials)}


def _rod(analysis: Analysis) -> dict[str, Any]:
    rod = analysis.rod
    return {
        "mass_kg": rod.mass / KG,
        "center_of_gravity_mm": list(rod.center),
        "inertia_kg_m2": rod.inertia_z / KG_M2,
        "length_mm": analysis.mesh.bores.rod_length,
    }


def _engine(analysis: Analysis) -> dict[str, Any] | None:
    engine = analysis.engine
    if engine is None:
        return None
    return {
        "crank_radius_mm": engine.crank_radius,
        "rod_length_mm": engine.rod_length,
        "bore_mm": engine.bore,
        "piston_mass_kg": engine.piston_mass / KG,
    }


def load_figures(case: LoadCase) -> dict[str, float | None]:
    """Return what acts in a load case, as ``loads`` of the summary holds it."""
    return {
        "crank_deg": None if case.crank_angle is None else case.crank_angle / DEG,
        "gas_N": case.gas,
        "pin_axial_N": case.pin_axial,
        "pin_transverse_N": case.pin_transverse,
        "crank_axial_N": case.crank_axial,
        "crank_transverse_N": case.crank_transverse,
        "wall_N": case.wall,
        "torque_Nm": None if case.torque is None else case.torque / N_M,
    }


def _model(analysis: Analysis) -> dict[str, Any]:
    whole, quality = analysis.mesh.whole.mesh, analysis.mesh.quality
    study = analysis.study
    return {
        "nodes": len(whole.points),
        "elements": len(whole.tets),
        "dofs": whole.points.size,
        "solved_dofs": analysis.model.solved_dofs,
        "element": study.mesh.element.value,
        "formulation": analysis.formulation,
        "size_mm": analysis.mesh.size,
        "symmetry": analysis.mesh.symmetry.value,
        "support": study.analysis.support.value,
        "pressure": study.analysis.pressure,
        "solver": analysis.model.solver,
        "quality": {
            "least_scaled_jacobian": quality.least_scaled_jacobian,
            "least_shape": quality.least_shape,
            "median_shape": quality.median_shape,
            "worst_at_mm": list(quality.worst_at),
            "straightened_elements": quality.straightened,
            "repairs": list(analysis.mesh.repair.causes),
            "repaired_size_mm": analysis.mesh.repair.size,
        },
    }


def _environment() -> dict[str, Any]:
    return {
        "versions": {"python": platform.python_version()} | {name: version(name) for name in _PACKAGES},
        "platform": platform.platform(),
        "threads": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
    }


def worst_safety(figures: dict[str, Any]) -> float:
    """Smallest safety factor of a summary: of its cases, against buckling, with the cycle against fatigue."""
    envelope = figures.get("envelope", {})
    factors = [case["min_safety_factor"] for case in figures["results"].values()]
    factors += [envelope.get("min_safety_factor"), envelope.get("min_fatigue_safety_factor")]
    factors.append(figures["buckling"]["min_safety_factor"])
    return min(float(factor) for factor in factors if factor is not None)
