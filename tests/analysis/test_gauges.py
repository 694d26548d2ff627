"""Virtual strain gauges against constant and quadratic fields, and the closed form of a pulled shank."""

from dataclasses import replace

import numpy as np
import pytest

from fea.analysis.gauges import Gauge
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.study.option_tables import ForcesTable, GaugeTable, MeshTable, read_gauges
from fea.study.study import load_study, parse_study
from fea.verify.body import STEEL, rectangle
from geometry.bodies import Prism
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from mesh.generate import mesh_body

SIDES = (Surface.SYMMETRY_Y, Surface.LOADED, Surface.FREE, Surface.CLAMPED)


@pytest.fixture(scope="module")
def block():
    """A block of 30 × 10 × 6 mm, whose sides y = 10 and z = 6 are free."""
    return mesh_body(Prism(rectangle((0.0, 30.0), (0.0, 10.0), SIDES), (0.0, 6.0)), 4.0)


def gauge_on(mesh, at, direction, length=4.0):
    return Gauge.of(GaugeTable(at, direction, length), "test", mesh, [STEEL])


def test_a_constant_strain_is_exact_in_every_direction(block):
    random = np.random.default_rng(5)
    strain = random.normal(size=(3, 3)) * 1e-3
    strain = (strain + strain.T) / 2
    stress = 2 * STEEL.shear_modulus * strain
    E, nu = STEEL.youngs_modulus, STEEL.poissons_ratio
    stress += E * nu / ((1 + nu) * (1 - 2 * nu)) * np.trace(strain) * np.eye(3)
    nodal = stress[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    for angle in (0.0, 0.7, 2.0):
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        # The part of a direction that is normal to the surface does not count.
        gauge = gauge_on(block, (13.0, 4.0, 6.5), (along[0], along[1], 0.5))
        assert (gauge.strain @ nodal).sum() == pytest.approx(1e6 * along @ strain @ along, rel=1e-12)
        assert gauge.place == pytest.approx([13.0, 4.0, 6.0])


def test_strain_is_averaged_over_the_length(block):
    # σ_xx = x² MPa, which elements of second order hold: its mean is x² + L²/12.
    gauge = gauge_on(block, (13.3, 4.2, 6.0), (1.0, 0.0, 0.0), 7.0)
    stress = np.zeros((len(block.points), 6))
    stress[:, 0] = block.points[:, 0] ** 2
    mean = 1e6 * (13.3**2 + 7.0**2 / 12) / STEEL.youngs_modulus
    assert (gauge.strain * stress[gauge.nodes]).sum() == pytest.approx(mean, rel=1e-9)


def test_a_gauge_away_from_the_surface_or_normal_to_it_is_refused(block):
    with pytest.raises(InvalidValue, match=r"5.5 mm from the free surface.*Near it is \[13.0, 4.0, 6.0\]"):
        gauge_on(block, (13.0, 4.0, 11.5), (1.0, 0.0, 0.0))
    with pytest.raises(InvalidValue, match=r"normal to the surface at \[13.0, 4.0, 6.0\]"):
        gauge_on(block, (13.0, 4.0, 6.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("raw", "named"),
    [
        ({"at_mm": [1, 2], "direction": [1, 0, 0], "length_mm": 3}, "gauge.at_mm.*three components"),
        ({"at_mm": [1, 2, 3], "direction": [0, 0, 0], "length_mm": 3}, "gauge.direction.*not all 0"),
        ({"at_mm": [1, 2, 3], "direction": [1, 0, 0], "length_mm": 0}, "gauge.length_mm"),
        ({"at_mm": [1, 2, 3], "direction": [1, 0, 0]}, "gauge.length_mm"),
        ({"at": [1, 2, 3], "direction": [1, 0, 0], "length_mm": 3, "angle": 4}, "at"),
    ],
)
def test_gauges_that_make_no_sense_are_refused(raw, named):
    with pytest.raises(InvalidValue, match=named):
        read_gauges([raw])
    with pytest.raises(InvalidValue, match=r"list of tables"):
        read_gauges(raw)


PULLED = 20_000.0  # N
TEXT = """[rod]
preset = "leon-2001"
[engine]
preset = "toyota-2jz"
[[gauge]]
at = ["2.8 in", "4.2 mm", "6 mm"]
direction = [1, 0, 0]
length = "3 mm"
measured = [1.0, 2.0]
"""


def test_gauges_are_written_and_read_again(tmp_path):
    found = parse_study(TEXT, "gauged", tmp_path)
    assert found.gauge[0].at_mm == pytest.approx((71.12, 4.2, 6.0))
    assert parse_study(found.text(), "gauged", tmp_path).gauge == found.gauge


@pytest.mark.usefixtures("coarse_bores")
def test_a_pulled_shank_has_the_strain_of_its_section():
    base = load_study("leon-2001")
    at = (72.0, 0.0, 6.0)
    study = replace(
        base,
        engine=None,
        forces=ForcesTable((PULLED, 0.0)),
        mesh=MeshTable(size_mm=8.0),
        analysis=replace(base.analysis, pressure="cosine-180"),
        gauge=tuple(
            GaugeTable(at, (1.0, 0.0, 0.0), 3.0, measured=given) for given in (None, (400.0,), (1.0, 2.0))
        ),
    )
    rod = prepare(study)
    gauge, with_measured, wrong = rod.gauges
    result = solve_speed(rod, None)
    found = gauge.figures(list(result.cases.values()), None)
    stations, sections = np.linspace(0.0, rod.mesh.bores.rod_length, len(rod.shank[0])), rod.shank[0]
    area = np.interp(found.at_mm[0], stations, [section.area for section in sections])
    E = rod.materials[0].youngs_modulus
    # Midway along a shank that tapers by a tenth, seven widths from either eye: the stress of a section is
    # even within 3 %.
    strain = found.cases["given"].strain_um_m
    assert strain == pytest.approx(1e6 * PULLED / (E * area), rel=0.03)
    assert 0 < found.cases["given"].error_um_m < 0.05 * strain
    assert with_measured.figures(list(result.cases.values()), None).cases["given"].measured_um_m == 400.0
    with pytest.raises(InvalidValue, match=r"gauge 3: measured.*each of given"):
        wrong.figures(list(result.cases.values()), None)


@pytest.mark.usefixtures("coarse_bores")
def test_the_history_over_the_cycle_passes_through_the_load_cases():
    base = load_study("leon-2001")
    study = replace(
        base,
        mesh=MeshTable(size_mm=14.0),
        analysis=replace(base.analysis, pressure="cosine-180", cycle=True),
        gauge=(GaugeTable((72.0, -4.0, 6.0), (1.0, 0.2, 0.0), 3.0),),
    )
    rod = prepare(study)
    result = with_cycle(rod, solve_speed(rod, 6000.0))
    (gauge,) = rod.gauges
    history = gauge.history(rod.cycle, result.cycle.weights)
    assert len(history) == 721
    for case in result.cases.values():
        if case.load.in_cycle:
            strain = float((gauge.strain * case.stress[gauge.nodes]).sum())
            at = np.interp(case.load.crank_angle, result.cycle.angles, history)
            # Superposed stress differs by less than 1e-3 of the largest, and angles are whole degrees.
            assert at == pytest.approx(strain, abs=2e-3 * np.abs(history).max())
    # At a speed of many, whose cases are superposed alone: the same but for the error of the mesh.
    cases = list(result.cases.values())
    solved = gauge.figures(cases, history)
    found = gauge.superposed(rod.full_cycle, [case.load for case in cases], rod.crank_cycle(6000.0))
    assert found.history_um_m == pytest.approx(solved.history_um_m, rel=1e-9)
    for name, case in solved.cases.items():
        assert found.cases[name].strain_um_m == pytest.approx(case.strain_um_m, rel=1e-3)
        assert found.cases[name].error_um_m is None
