"""Rods that are prepared one after another on a mesh that is moved."""

from dataclasses import replace

import numpy as np

from fea.analysis.meshing import mesh_study
from fea.analysis.pipeline import MovingRod, prepare
from fea.study.study import load_study


def test_a_rod_that_goes_on_with_the_solver_of_the_last_is_solved_the_same():
    study = load_study("leon-2001")
    options = replace(study.analysis, pressure="cosine-180")
    study = replace(study, analysis=options, mesh=replace(study.mesh, size_mm=30.0))
    moving, solved = MovingRod(mesh_study(study, movable=True)), []
    for web in (5.0, 5.2, 4.8):
        own = study.with_rod(web_thickness_mm=web)
        mesh = moving.mesh(own)
        rod, alone = moving.prepared(own, mesh), prepare(own, mesh=mesh)
        found, expected = (one.displacement(6000.0, np.zeros(1)) for one in (rod, alone))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
        solved.append((rod, expected))
    assert not np.allclose(solved[0][1], solved[1][1])
    first, expected = solved[0]  # its solver has the factors of the last one now
    again = first.displacement(6000.0, np.zeros(1))
    np.testing.assert_allclose(again, expected, rtol=1e-9, atol=1e-12)
    handed_on = solved[-1][0].model.handed_on()
    assert handed_on is not None
    assert handed_on.solver is not first.model._solver
