"""A file may hold its solids in any order: the shank is of its own material."""

import math

import gmsh
import pytest

from fea.analysis.buckling import column_figures
from fea.analysis.pipeline import prepare
from fea.study.study import parse_study
from geometry.session import session
from loads.instants import given

STUDY = """
[rod]
step = "rod.step"
[material]
E_GPa = 200.0
nu = 0.3
density_kg_m3 = 7800.0
yield_MPa = 500.0
[material."part {bushing}"]
E_GPa = 20.0
nu = 0.3
density_kg_m3 = 8800.0
yield_MPa = 50.0
[forces]
pin_N = [-1000.0, 0.0]
[mesh]
size_mm = 14.0
"""
WIDTH, THICKNESS = 40.0, 12.0


def strap(occ):
    bar = occ.addBox(-25, -WIDTH / 2, -THICKNESS / 2, 150, WIDTH, THICKNESS)
    bores = [(3, occ.addCylinder(x, 0, -50, 0, 0, 100, radius)) for x, radius in ((0, 10), (100, 8))]
    occ.cut([(3, bar)], bores)


def bushing(occ):
    ring = occ.addCylinder(100, 0, -THICKNESS / 2, 0, 0, THICKNESS, 8)
    occ.cut([(3, ring)], [(3, occ.addCylinder(100, 0, -50, 0, 0, 100, 6))])


@pytest.mark.parametrize(("solids", "number"), [((strap, bushing), 2), ((bushing, strap), 1)])
def test_the_column_is_of_the_shanks_material_wherever_the_file_holds_it(solids, number, tmp_path):
    with session():
        gmsh.model.add("drawn")
        for draw in solids:
            draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "rod.step"))
    analysis = prepare(parse_study(STUDY.format(bushing=number), "strap", tmp_path))
    column = column_figures(analysis, given(-1000.0)[None])
    squash, slenderness = 500.0 * WIDTH * THICKNESS, 0.5 * 100 / (THICKNESS / 12**0.5)
    rankine = squash / (1 + 500.0 / (math.pi**2 * 200e3) * slenderness**2)
    assert column.planes["sideways"].rankine_N == pytest.approx(rankine, rel=0.02)
    assert column.least_area_mm2 == pytest.approx(WIDTH * THICKNESS, rel=1e-6)
