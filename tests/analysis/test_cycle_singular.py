"""Where the exact stress is infinite no cycle is judged, as no case is."""

import gmsh
import pytest

from fea.analysis.cycle.figures import envelope_figures
from fea.analysis.many_speeds import SpeedSearch
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.study.study import parse_study
from geometry.session import session

STUDY = """
[rod]
step = "rod.step"
[material]
preset = "forged-steel-2005"
[engine]
stroke_mm = 90.0
bore_mm = 84.0
piston_mass_kg = 0.55
gas = "otto"
compression_ratio = 10.0
peak_pressure_bar = 70.0
[speed]
rpm = 6000
[mesh]
size_mm = 10.0
[analysis]
cycle = true
pressure = "cosine-180"
"""
LENGTH = 140.0
SHANK = 14.0  # its width: it meets the rings at sharp edges


@pytest.fixture(scope="module")
def analysis(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sharp")
    with session():
        gmsh.model.add("drawn")
        occ = gmsh.model.occ
        rings = [(3, occ.addCylinder(x, 0, -12, 0, 0, 24, r)) for x, r in ((0, 38), (LENGTH, 20))]
        body, _ = occ.fuse([(3, occ.addBox(0, -SHANK / 2, -6, LENGTH, SHANK, 12))], rings)
        occ.cut(body, [(3, occ.addCylinder(x, 0, -12, 0, 0, 24, r)) for x, r in ((0, 26), (LENGTH, 12))])
        occ.synchronize()
        gmsh.write(str(folder / "rod.step"))
    return prepare(parse_study(STUDY, "sharp", folder))


@pytest.fixture(scope="module")
def result(analysis):
    return with_cycle(analysis, solve_speed(analysis, 6000.0))


def test_the_worst_of_the_cycle_lies_away_from_sharp_edges(analysis, result):
    found = envelope_figures(result.cycle, analysis, tuple(result.cases.values()), 6000.0)
    masked = result.cases["tension"].error.masked
    sharp = {tuple(point) for point in analysis.mesh.whole.points[masked].round(6)}
    places = [found, found.fatigue, found.crossland, *found.spots]
    assert not any(tuple(round(x, 6) for x in place.at_mm) in sharp for place in places)
    least = min(case.min_safety_factor for case in result.cases.values())
    assert found.min_safety_factor == pytest.approx(least, rel=1e-3)
    assert found.unmasked_min_safety_factor <= found.min_safety_factor
    assert any("leave out places where the exact stress is infinite" in str(note) for note in result.notes)


def test_the_search_over_speeds_finds_the_same(analysis, result):
    found = envelope_figures(result.cycle, analysis, tuple(result.cases.values()), 6000.0)
    worst = SpeedSearch(analysis.full_cycle, analysis.crank_cycle, [6000.0]).at(6000.0)
    for peak, case in zip(worst.peaks, result.cases.values(), strict=True):
        assert peak.max_von_mises_MPa == pytest.approx(case.peak.value, rel=5e-3)
    assert worst.fatigue.factor == pytest.approx(found.min_fatigue_safety_factor, rel=1e-3)
