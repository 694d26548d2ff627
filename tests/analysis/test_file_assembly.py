"""A two-piece STEP file is analysed as an assembly, like the rod that it was written from."""

from dataclasses import replace

import numpy as np
import pytest
from assemblies import NUTS, SIMPLE, write_assembly

from fea.analysis.assembling import AssemblySetup
from fea.analysis.meshing import mesh_study
from fea.apps.result import analyse
from fea.contact.bolts import BoltPull
from fea.pins.assembly import _ends
from fea.study.assembly_table import AssemblyTable
from fea.study.flags import Flags
from fea.study.rod_table import rod_of_file
from fea.study.study import load_study
from geometry.assembly import Assembly
from geometry.surfaces import Surface

pytestmark = pytest.mark.usefixtures("coarse_bores")

PLAIN = replace(SIMPLE, bushing=0.0, oil_hole=0.0, big_end_chamfer=0.0)
COARSE = Flags(size=14.0)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = write_assembly(PLAIN, Assembly(bolt=NUTS), tmp_path_factory.mktemp("rod") / "rod.step")
    own = replace(load_study("leon-2001"), rod=rod_of_file(path))
    return COARSE.applied(replace(own, assembly=AssemblyTable(bolt_preload_kN=25.0)))


@pytest.fixture(scope="module")
def mesh(study):
    return mesh_study(study)


def test_the_bolts_of_a_file_are_those_of_the_dimensions(study, mesh):
    drawn = load_study("leon-2001")
    bolts = AssemblyTable(bolt_preload_kN=25.0, bolt_head_mm=14.0, bolt_nut_mm=13.0)
    drawn = replace(drawn, rod=replace(drawn.rod, dimensions=PLAIN), assembly=bolts)
    found, expected = AssemblySetup.of(study, mesh), AssemblySetup.of(drawn)
    assert vars(found.bolt.bolt) == {
        key: pytest.approx(value) if isinstance(value, float) else value
        for key, value in vars(expected.bolt.bolt).items()
    }
    assert found.geometry.split == pytest.approx(0.0, abs=1e-9)


def test_the_force_of_a_bolt_acts_along_its_axis(mesh):
    """Head and nut of different size are meshed differently, but their resultants oppose each other."""
    assert len(mesh.cell.facets[Surface.BOLT_HEAD]) != len(mesh.cell.facets[Surface.BOLT_THREAD])
    (first, _) = mesh.bolts
    (ends,) = _ends(mesh.cell, [first])
    at, along = np.array(first.point), np.array(first.direction)
    pull = BoltPull.of(mesh.cell, dict(ends.seats), along, 1e6, share=ends.share, point=at)
    forces = pull.forces(len(mesh.cell.points)).toarray().reshape(-1, 3)
    away = mesh.cell.points - np.array(first.point)
    moment = away[:, 0] @ forces[:, 1] - away[:, 1] @ forces[:, 0]
    for surface in (Surface.BOLT_HEAD, Surface.BOLT_THREAD):
        nodes = np.unique(mesh.cell.facets[surface])
        assert np.abs(forces[nodes].sum(axis=0)) == pytest.approx([0.5, 0.0, 0.0], abs=1e-12)
        assert away[nodes, 1] @ forces[nodes, 0] == pytest.approx(0.0, abs=1e-12)
    assert moment == pytest.approx(0.0, abs=1e-12)


def test_a_two_piece_file_is_analysed(study):
    result = analyse(study, rpm=6000)
    assert result.trusted
    assert result.checks["moment_balance"].value < 1e-10
    assert result.cases["tension"].max_von_mises > 0
