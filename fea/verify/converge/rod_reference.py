"""The reference value of the rod's peak, from meshes that are refined where the stress is high."""

import dataclasses

import numpy as np

from fea.judge.case_result import CaseResult
from fea.run.meshing import mesh_study
from fea.run.prepare import prepare
from fea.run.speed import SpeedResult, solve_speed
from fea.run.wanted_size import wanted_sizes
from fea.study.option_tables import MeshTable
from fea.study.study import Study
from fea.verify.converge.reference import Reference, extrapolated

# Sizes of the meshes relative to the default size, in constant ratio, and the additional factor on the
# element size where the stress exceeds a fraction of the peak.
SCALES = (1.0, 0.75, 0.5625)
HOT = {0.75: 1 / 2.0, 0.9: 1 / 5.0}


def rod_reference(study: Study) -> Reference:
    """Extrapolate the largest von Mises stress of the first case at the first speed.

    All elements shrink in proportion from mesh to mesh, so that Richardson extrapolation applies. They are
    smallest at the peak, because equally fine uniform meshes would not fit into memory.
    """
    options = dataclasses.replace(study.analysis, tolerance_percent=None, cycle=False)
    plain = dataclasses.replace(study, analysis=options, mesh=MeshTable())
    speed = study.speeds()[0]
    rod = prepare(plain)
    mesh, case = rod.mesh, first_case(solve_speed(rod, speed))
    del rod
    values = []
    for scale in SCALES:
        ratio = np.ones_like(case.von_mises)
        for share, factor in HOT.items():
            ratio[case.von_mises > share * case.peak.value] = scale * factor
        fields = [field for field in (wanted_sizes(mesh, ratio),) if field]
        fine = dataclasses.replace(plain, mesh=MeshTable(size_mm=scale * mesh.meshing.size))
        rod = prepare(fine, mesh=mesh_study(fine, wanted=fields))
        values.append(first_case(solve_speed(rod, speed)).max_von_mises)
        del rod
    return extrapolated(SCALES, values)


def first_case(result: SpeedResult) -> CaseResult:
    """Return the first load case of a speed."""
    return next(iter(result.cases.values()))
