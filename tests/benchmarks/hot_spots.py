"""Peaks on meshes that are far finer where the stress is high."""

import dataclasses
from collections.abc import Collection, Mapping

import numpy as np

from fea.analysis.meshing import mesh_study
from fea.analysis.pipeline import prepare, solve_speed
from fea.judge.case_result import CaseResult
from fea.study.option_tables import MeshTable
from fea.study.study import Study
from mesh.sizing import SizeField


def hot_ratio(cases: Collection[CaseResult], hot: Mapping[float, float]) -> np.ndarray:
    """Factor (n_nodes,) on the size where the stress of any case exceeds a share of its peak."""
    heat = np.max([case.von_mises / case.peak.value for case in cases], axis=0)
    ratio = np.ones_like(heat)
    for share, factor in hot.items():
        ratio[heat > share] = factor
    return ratio


def solved_finely(study: Study, size: float, sizes: SizeField, rpm: float | None) -> Collection[CaseResult]:
    """The load cases on elements of a size, mm, and of these sizes where they are smaller."""
    fine = dataclasses.replace(study, mesh=MeshTable(size_mm=size))
    return solve_speed(prepare(fine, mesh=mesh_study(fine, wanted=[sizes])), rpm).cases.values()
