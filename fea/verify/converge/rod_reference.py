"""The rod's peak on meshes that are ever finer where it is hot."""

import dataclasses

import numpy as np

from fea.adaptive.wanted_size import wanted_sizes
from fea.machine.clock import Clock
from fea.pipeline import Analysis
from fea.study.study import MeshTable, Study
from fea.verify.converge.reference import Reference, extrapolated

# Elements shrink by these factors, in constant ratio, where the stress exceeds `HOT` of the peak.
FACTORS = (1.8, 2.7, 4.05)
HOT = 0.75
# Elsewhere, over the default size.
ELSEWHERE = 0.9


def rod_reference(study: Study) -> Reference:
    """Extrapolate the largest von Mises stress of the first case at the first speed.

    Uniform meshes as fine would not fit a machine; the rest of the rod touches the peak by far less than the
    uncertainty that is given.
    """
    options = dataclasses.replace(study.analysis, tolerance_percent=None, cycle=False)
    plain = dataclasses.replace(study, analysis=options, mesh=MeshTable())
    speed = study.speed.speeds()[0] if study.engine else None
    analysis = Analysis(plain, Clock())
    mesh, case = analysis.mesh, analysis.at(speed).cases[0]
    hot = case.von_mises > HOT * case.peak.value
    fine = dataclasses.replace(plain, mesh=MeshTable(size_mm=ELSEWHERE * mesh.size))
    del analysis
    values = []
    for factor in FACTORS:
        wanted = wanted_sizes(mesh, np.where(hot, 1 / factor, 1.0))
        fields = [] if wanted is None else [wanted]
        values.append(Analysis(fine, Clock(), fields).at(speed).cases[0].peak.value)
    return extrapolated([1 / factor for factor in FACTORS], values)
