"""The map of defects over the cycle of a coarse rod, and flaws on it."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from cycles import analysis

from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.defects import NodeCycles, with_defects
from fea.analysis.pipeline import solve_speed, with_cycle
from fea.analysis.survival import flaw_factors
from fea.base.choices import Symmetry
from fea.judge.defect import LARGEST
from fea.output.defect_answer import given_flaw
from fea.rod.loading import DutyLoads
from fea.solid.stress import across, opened
from fea.study.defect_table import DefectTable
from fea.study.material_table import MaterialTable
from fea.study.speed_tables import DutyTable
from geometry.errors import InvalidValue

RPM = 5000.0


@pytest.fixture(scope="module")
def solved():
    """A rod of plain rectangular section, coarse, and its cycle."""
    rod = analysis(Symmetry.AUTO, 12.0)
    return rod, with_cycle(rod, solve_speed(rod, RPM))


def with_flaw(solved, material=None, **keys):
    rod, speed = solved
    study = replace(rod.study, defect=DefectTable(**keys), material=material or rod.study.material)
    changed = replace(rod, study=study)
    if material is not None:
        changed = replace(
            changed, structure=replace(rod.structure, materials=study.materials(rod.mesh.parts))
        )
    for name in ("full_cycle", "certified_cycle"):  # solved already
        if name in vars(rod):
            vars(changed)[name] = vars(rod)[name]
    return with_defects(changed, speed)


@pytest.fixture(scope="module")
def mapped(solved):
    return with_flaw(solved)


def test_planes_of_known_histories():
    # Alternating tension along (1, 1, 0): the plane is across it, the lowest stress negative.
    along = np.array([1.0, 1.0, 0.0]) / 2**0.5
    x, y, z = along
    dyad = np.array([x * x, y * y, z * z, x * y, y * z, x * z])
    stress = np.stack([np.outer(dyad, [0.0, 100.0, -250.0]), np.outer(dyad, [-10.0, 50.0, 0.0])])
    normals = opened(stress)
    assert np.abs(normals @ along) == pytest.approx(1.0)
    assert across(stress, normals) == pytest.approx(np.array([[0.0, 100, -250], [-10.0, 50, 0]]), abs=1e-9)
    # Pure shear opens the plane at 45°, on which the reverse closes as much.
    shear = np.zeros((1, 6, 2))
    shear[0, 3] = 80.0, -80.0
    assert across(shear, opened(shear)) == pytest.approx(np.array([[80.0, -80.0]]))


def test_nodes_have_the_cycle_of_every_degree(solved):
    rod, speed = solved
    found = NodeCycles.of(rod, speed, speed.cycle, [0])
    chosen = np.random.default_rng(3).choice(len(found.node), 12, replace=False)
    places = [(int(found.node[row]), 0) for row in chosen]
    stress = np.stack(
        [spot.stress for spot in spots(places, rod.cycle.units, speed.cycle.weights, rod.mesh.mirrored)]
    )
    history = across(stress, opened(stress))
    top = np.abs(history).max(axis=1)
    # At every third degree, with the plane of the nearest of every twelfth.
    assert np.abs(found.cycle.highest[chosen] - history.max(axis=1)) == pytest.approx(0, abs=0.02 * top.max())
    assert found.cycle.amplitude[chosen] == pytest.approx(np.ptp(history, axis=1) / 2, rel=0.03)


def test_the_map_and_its_regions(solved, mapped):
    rod, _ = solved
    figures, field = mapped.defect, mapped.largest_defect
    assert field.shape == (len(rod.mesh.whole.points),)
    assert ((field >= 1) & (field <= LARGEST)).all()
    sizes = [place.smallest_um for place in figures.regions]
    assert sizes == sorted(sizes)
    assert len({place.region for place in figures.regions}) == len(sizes) >= 6
    assert (figures.smallest_um, figures.region) == (sizes[0], figures.regions[0].region)
    for place in figures.regions:
        assert place.smallest_um_low <= place.smallest_um <= place.smallest_um_high
        node = np.linalg.norm(rod.mesh.whole.points - place.at_mm, axis=1).argmin()
        assert field[node] == pytest.approx(max(place.smallest_um, 1.0))
    assert "226 HV by the ultimate strength" in " ".join(map(str, mapped.notes))


def test_regression_of_the_map(mapped):
    # Of this mesh, to see a change; rounding is 2 % of the smallest.
    found = {place.region: round(place.smallest_um) for place in mapped.defect.regions}
    assert {name: found[name] for name in KNOWN} == pytest.approx(KNOWN, rel=0.03)


KNOWN = {
    "big-end bore": 28,
    "shank towards the small end": 36,
    "shank at the big end": 49,
    "middle of the shank": 193,
    "small-end bore": 927,
    "small end": 1000,
}


def test_a_lap_along_the_flank_counts_little(solved):
    # The same flaw, with its plane along the rod and across it, on the flank of the shank.
    flank = "0.3x30@75,8,0"
    along = with_flaw(solved, size=flank, normal=(0.0, 1.0, 0.0)).defect.flaw
    crossing = with_flaw(solved, size=flank, normal=(1.0, 0.0, 0.0)).defect.flaw
    worst = with_flaw(solved, size=flank).defect.flaw
    assert along.area_root_um < 0.3 * crossing.area_root_um
    assert along.factor > 1.1 * crossing.factor
    assert crossing.area_root_um == pytest.approx(worst.area_root_um, rel=0.01)
    assert crossing.position == "surface"
    assert np.linalg.norm(np.subtract(along.at_mm, (75.0, 8.0, 0.0))) < 5.0


def test_a_flaw_that_grows_ends_the_rod_sooner_the_larger_it_is(solved):
    flaws = [with_flaw(solved, size=size, service_hours=0.05).defect for size in ("0.3x3", "0.6x6", "1.2x12")]
    hours = [found.flaw.hours for found in flaws]
    assert hours == sorted(hours, reverse=True)
    assert flaws[0].factor == flaws[0].flaw.factor > flaws[2].factor
    assert flaws[0].flaw.depth_after_service_mm > 0.3
    # By default it is where the smallest defect of the surface grows.
    assert flaws[0].flaw.at_mm == pytest.approx(flaws[0].at_mm, abs=0.01)


def test_a_flaw_counts_in_the_answer_unless_it_lasts_until_the_next_inspection(solved):
    defect = with_flaw(solved, size="0.3x2").defect
    (factor,) = flaw_factors(defect)
    assert (float(factor), factor.mode) == (float(defect.factor), "crack growth")
    assert factor.place.startswith("the given flaw, ")
    lasting = replace(defect, flaw=replace(defect.flaw, depth_after_service_mm=0.4))
    assert flaw_factors(lasting) == flaw_factors(None) == []


def test_a_flaw_inside(solved):
    flaw = with_flaw(solved, size="0.4x0.4@75,0,0").defect.flaw
    assert (flaw.position, flaw.at_mm) == ("inside", (75.0, 0.0, 0.0))
    assert flaw.area_root_um == pytest.approx(1e3 * np.sqrt(np.pi / 4) * 0.4)
    assert flaw.criterion == "Murakami"


def test_a_flaw_inside_grows_to_the_surface_first(solved):
    flaw = with_flaw(solved, size="2x2@75,4.5,0").defect.flaw
    assert (flaw.position, flaw.criterion) == ("inside", "El Haddad")
    assert 0 < flaw.hours_to_surface < flaw.hours
    (line,) = given_flaw(SimpleNamespace(defect=SimpleNamespace(flaw=flaw)))
    assert re.search(r"^Flaw of 2 × 2 mm inside, .*: grows, .*; about .* to the surface, .* to .*\.$", line)
    # One that touches the surface counts as one of the surface at once.
    x, y, _ = with_flaw(solved, size="2x2@75,8,0").defect.flaw.at_mm
    touching = with_flaw(solved, size=f"2x2@{x},{y - 1.1},0").defect.flaw
    assert touching.position == "touching"
    assert touching.hours_to_surface == 0
    assert touching.hours < flaw.hours


def over_duty(solved, size, **duty):
    rod, speed = solved
    duty = DutyLoads.of(DutyTable(**duty), rod.engine)
    return with_flaw((replace(rod, duty=duty), speed), size=size).defect


def test_growth_adds_up_over_a_duty(solved):
    flaw = over_duty(solved, "0.3x3", rpm=(RPM,), share_percent=(100.0,)).flaw
    # The duty has the instants of the peak cases beside every degree.
    assert float(flaw.duty.factor) == pytest.approx(float(flaw.factor), rel=1e-3)
    assert flaw.duty.hours == pytest.approx(flaw.hours, rel=5e-3)
    both = over_duty(solved, "0.3x3", rpm=(2000.0, RPM), share_percent=(75.0, 25.0)).flaw
    assert both.duty.rpm == RPM
    assert flaw.hours < both.duty.hours < 4 * flaw.hours
    _, line = given_flaw(SimpleNamespace(defect=SimpleNamespace(flaw=both)))
    assert re.search(r"^Over the duty the flaw grows, factor .* at 5000 rpm; about .*\.$", line)


def test_a_duty_decides_whether_a_flaw_lasts(solved):
    defect = over_duty(solved, "0.3x3", rpm=(1000.0, RPM), share_percent=(99.9, 0.1))
    assert [float(factor) for factor in flaw_factors(defect)] == [float(defect.flaw.duty.factor)]
    lasting = replace(defect.flaw, duty=replace(defect.flaw.duty, depth_after_service_mm=0.4))
    assert flaw_factors(replace(defect, flaw=lasting)) == []


def test_a_flaw_outside_of_the_rod_is_refused(solved):
    with pytest.raises(
        InvalidValue, match=r"defect.size = '@\[75.0, 30.0, 0.0\]': is .* mm outside.*Near it is"
    ):
        with_flaw(solved, size="0.4x6@75,30,0")


def test_aluminium_has_cracks_but_no_map(solved):
    found = with_flaw(solved, MaterialTable(preset="7075-T6"), size="0.4x6@75,8,0")
    assert found.largest_defect is None
    assert found.defect.regions == ()
    assert found.defect.flaw.criterion == "El Haddad"
    steel = with_flaw(solved, size="0.4x6@75,8,0").defect.flaw
    assert found.defect.factor < 0.7 * steel.factor


def test_titanium_is_left_out_unless_a_flaw_is_given(solved):
    assert with_flaw(solved, MaterialTable(preset="Ti-6Al-4V")).defect is None
