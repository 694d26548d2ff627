"""Figures of runs that were never computed."""

from fea.analysis.figures import CaseFigures, LoadFigures, ModelFigures, QualityFigures, RodFigures
from fea.analysis.life_figures import CycleFigures
from fea.analysis.summary_figures import (
    BucklingFigures,
    ColumnFigures,
    EnvironmentFigures,
    PlaneFigures,
    Summary,
)
from fea.analysis.survival import survival
from fea.base.checks import Check
from fea.judge.safety_factor import SafetyFactor


def load(**figures):
    """Forces and motion of a load case."""
    usual = {
        "crank_deg": 10.0,
        "gas_N": None,
        "pin_axial_N": 1e4,
        "pin_transverse_N": 0.0,
        "crank_axial_N": 1e4,
        "crank_transverse_N": 0.0,
        "wall_N": 0.0,
        "torque_Nm": None,
    }
    return LoadFigures(**usual | figures)


def result(**figures):
    """The extremes of a load case."""
    usual = {
        "max_von_mises_MPa": 100.0,
        "at_mm": (1.0, 2.0, 3.0),
        "max_principal_MPa": 110.0,
        "min_principal_MPa": -20.0,
        "max_displacement_mm": 0.1,
        "min_safety_factor": 9.0,
        "error_percent": None,
        "verdict": None,
    }
    return CaseFigures(**usual | figures)


def buckling(*factors, modes=None):
    """Column formulas with a factor per plane, and modes."""
    planes = {
        name: PlaneFigures(slenderness=20.0, euler_N=2e5, johnson_N=1e5, rankine_N=9e4, safety_factor=factor)
        for name, factor in zip(("in_plane", "sideways"), factors, strict=False)
    }
    case = "compression" if factors else None
    column = ColumnFigures(force_N=1e4, case=case, least_area_mm2=100.0, planes=planes)
    return BucklingFigures(column=column, modes=modes, min_safety_factor=min(factors, default=None))


def cycle(**figures):
    """The extremes of the whole cycle."""
    usual = {
        "min_safety_factor": 0.89,
        "at_mm": (1.0, 2.0, 3.0),
        "crank_deg": 5.0,
        "min_fatigue_safety_factor": 0.54,
        "fatigue_criterion": "goodman",
        "fatigue": None,
        "min_crossland_safety_factor": None,
        "unit_solutions": 74,
        "instants": 721,
    }
    return CycleFigures(**usual | figures)


def summary(**figures):
    """A run of one load case in tension."""
    quality = QualityFigures(
        least_scaled_jacobian=0.5,
        least_shape=0.3,
        median_shape=0.8,
        worst_at_mm=(0.0, 0.0, 0.0),
        straightened_elements=0,
        repairs=(),
        repaired_size_mm=None,
    )
    model = ModelFigures(
        nodes=21500,
        elements=12000,
        dofs=64500,
        solved_dofs=30000,
        element="p2",
        formulation="displacement",
        size_mm=3.0,
        symmetry="quarter",
        support="inertia-relief",
        pressure="cosine-180",
        solver="pardiso",
        assembly="batched",
        quality=quality,
    )
    usual = {
        "study": "leon-2001",
        "rpm": 6000.0,
        "trusted": True,
        "rod": RodFigures(
            mass_kg=0.6, center_of_gravity_mm=(40.0, 0.0, 0.0), inertia_kg_m2=2e-3, length_mm=141.0
        ),
        "engine": None,
        "survival": survival([SafetyFactor.of_stress(1.9884, 3.14, instant="tension")]),
        "loads": {"tension": load()},
        "model": model,
        "results": {"tension": result()},
        "buckling": buckling(),
        "checks": {"finite": Check(0.0, 0.0)},
        "notes": (),
        "timings_s": {"mesh": 1.0},
        "total_s": 2.345,
        "peak_memory_MiB": 300.0,
        "left_out": (),
        "environment": EnvironmentFigures(versions={}, platform="", threads=1),
    }
    return Summary(**usual | figures)
