"""How far a rod can be turned and pressed: closed forms, the whole job, and what it says."""

import csv
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from program import fea as program

import fea
from fea.analysis.buckling import column_figures
from fea.apps.limits.figures import Largest
from fea.apps.limits.limit_map import Axes, Limit, LimitMap, root
from fea.apps.limits.operation import Operation
from fea.apps.limits.states import Mode, States, Worst
from fea.rod.loading import EngineLoading
from fea.study.flags import Flags
from fea.study.option_tables import ForcesTable
from fea.study.study import load_study
from geometry.errors import InvalidValue

COARSE = {"size": 14.0, "pressure": "cosine-180"}


def study(**changes):
    own = Flags(**COARSE).applied(load_study("leon-2001"))
    return replace(own, **changes)


def with_engine(**keys):
    return study(engine=replace(study().engine, **keys))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("limits")
    flags = ("--size", 14, "--pressure", "cosine-180", "--min-rpm", 3000, "--min-boost", 5, "--units", "us")
    done = program("limits", "leon-2001", *flags, "--out", "out", cwd=place)
    assert done.returncode == 6, done.stderr  # it stands no such boost
    assert "Up to" in done.stdout
    return place / "out"


def test_limits_of_the_files_are_those_of_a_direct_run(folder):
    """At a limit by fatigue a run with its speed and its scale has a factor of 1: to 0.5 %, as promised."""
    rows = list(csv.DictReader((folder / "limits.csv").read_text().splitlines()))
    row = [each for each in rows if each["mode"] == "fatigue"][10]
    engine = replace(study().engine, gas_scale=float(row["gas_scale"]))
    result = fea.analyse(study(engine=engine), rpm=float(row["rpm"]), cycle=True)
    assert result.summary.envelope.min_fatigue_safety_factor == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize(
    "flags", [("--min-rpm", "nan"), ("--min-rpm", -5), ("--min-boost", "nan"), ("--rpm", 0)], ids=str
)
def test_speeds_and_boosts_that_are_none_are_refused(flags, tmp_path):
    done = program("limits", "leon-2001", *flags, cwd=tmp_path)
    assert done.returncode == 2
    assert "rpm" in done.stderr or "boost" in done.stderr


def test_summary_and_its_sentence(folder):
    summary = json.loads((folder / "summary.json").read_text())
    largest, pressure = summary["largest_rpm"], summary["largest_peak_pressure_bar"]
    assert summary["trusted"]
    assert largest["mode"] == "fatigue"
    assert 0 < largest["bar"] < 0.5 * largest["value"]  # elements are 2.8 times too large
    assert f"{10 * round(largest['value'] / 10)} ±" in summary["text"]
    assert pressure["rpm"] == 3000 < summary["rpm"]
    assert "no peak pressure" not in summary["text"]
    assert summary["closed_throttle"]["value"] > largest["value"]  # no gas pushes, and gas relieves little
    page = (folder / "report.html").read_text()
    shown = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert shown["unit"] == "psi"
    assert shown["closed"][1] == pytest.approx(
        summary["closed_throttle"]["peak_pressure_bar"] * 14.5038, rel=1e-3
    )
    assert set(summary["files"]) == {path.name for path in folder.iterdir()}


def test_speed_by_inertia_alone_grows_with_the_root_of_strength():
    """Stress by inertia is in proportion to speed squared; 1 %, as stated."""
    engine = with_engine(gas="none")
    twice = replace(engine.material.resolved(), yield_MPa=1240.0, ultimate_MPa=None, endurance_MPa=None)
    once = replace(twice, yield_MPa=620.0)
    low, high = (fea.limits(replace(engine, material=own)).largest_rpm for own in (once, twice))
    assert (low.mode, high.mode) == ("yield", "yield")
    assert high.value / low.value == pytest.approx(math.sqrt(2), rel=1e-2)


def test_rods_that_never_fail_and_that_fail_at_idling_speed_are_told_so():
    own = with_engine(gas="none")
    strong, weak = (
        fea.limits(replace(own, analysis=replace(own.analysis, min_safety=least))) for least in (0.01, 200.0)
    )
    assert re.search(r"nothing fails up to \d+ rpm, a mean piston speed of 50 m/s", strong.text)
    assert strong.largest_rpm is None
    assert strong.limits == ()
    assert strong.reaches(15000, None)
    assert "does not reach the required safety factor at any speed" in weak.text
    assert not weak.reaches(100, None)
    slower = Largest(
        mode="yield",
        rpm=1000.0,
        peak_pressure_bar=100.0,
        bar=None,
        gas_scale=2.0,
        at_mm=None,
        crank_deg=0.0,
        value=100.0,
        place="",
        boost_bar=1.0,
        safe_from=None,
    )
    assert not replace(strong, largest_peak_pressure_bar=slower).reaches(None, 0.5)  # not at its speed


def test_a_column_buckles_at_its_critical_load():
    """At idling speed the gas alone presses: p A is the load of the column formulas, to 1 % (inertia)."""
    rod = fea.prepare(study())
    operation, cycle = Operation(rod.engine, rod.mass), rod.crank_cycle(800.0)
    states = States(rod, rod.spanned_cycle([cycle]))
    scale, _ = root(lambda at: math.log(states.buckling(operation.cycle(800.0, at)).factor), 50.0, [1.0])
    formulas = column_figures(rod, rod.engine.at(rod.mass, 800.0).cases)
    critical = min(min(each.euler_N, each.johnson_N, each.rankine_N) for each in formulas.planes.values())
    gauge = operation.peak(800.0, scale) - 0.101325
    assert gauge * rod.engine.engine.piston_area == pytest.approx(critical, rel=1e-2)


def test_a_root_is_found_where_a_bolt_yields():
    """VDI 2230: F_S = F_V + Φ F_A; the load at which the bolt yields follows from its diagram."""
    preload, share, strength = 30e3, 0.2, 45e3

    def level(load):
        return math.log(strength / (preload + share * load))

    x, slope = root(level, 1e6, [20e3])
    assert x == pytest.approx((strength - preload) / share, rel=1e-2)
    # d ln F_A/d ln f = −F_S/(Φ F_A): a bar of the stress is a wider one of the load.
    assert slope == pytest.approx(-strength / (strength - preload), rel=0.05)
    assert root(level, 50e3, [20e3]) is None


def test_charge_scales_the_ideal_cycle_and_a_trace():
    own = replace(study().engine, gas="otto", compression_ratio=10.0, peak_pressure_bar=60.0)
    for engine in (own, study().engine):
        loading = EngineLoading.of(engine, 150.0)
        operation = Operation(loading, None)
        peak = operation.peak(3000.0, 1.7)
        assert operation.scale(3000.0, peak) == pytest.approx(1.7)
        scaled = EngineLoading.of(replace(engine, gas_scale=1.7), 150.0)
        assert Operation(scaled, None).peak(3000.0) == pytest.approx(peak)
    assert Operation(EngineLoading.of(own, 150.0), None).boost(2.0) == pytest.approx(1.01325)


def test_full_load_is_read_and_refused(tmp_path):
    path = tmp_path / "own.toml"
    table = (
        '[engine]\npreset = "toyota-2jz"\n[[engine.full_load]]\nrpm = 3000\n{}\n[rod]\npreset = "leon-2001"\n'
    )
    path.write_text(table.format("torque_Nm = 280"))
    engine = load_study(path).engine
    assert engine.full_load == ({"rpm": 3000.0, "torque_Nm": 280.0},)
    path.write_text(table.format("power_kW = 280"))
    with pytest.raises(InvalidValue, match="must have rpm and one of"):
        load_study(path)


def test_a_rod_in_parts_is_refused():
    with pytest.raises(InvalidValue, match="cannot be combined with fea limits"):
        fea.limits("leon-2001-bolted")


def test_given_forces_have_no_speed():
    own = study(engine=None, forces=ForcesTable((1000.0, 0.0)))
    with pytest.raises(InvalidValue, match="without an engine has no speed"):
        fea.limits(own)


def test_ray_estimates_are_exact_where_loads_are_proportional():
    axes, angles = Axes(4000.0, 2.0), np.linspace(0.1, 1.4, 5)
    limits = []
    for angle in angles:  # a straight limit: along + up = 1
        load = 1 / (math.cos(angle) + math.sin(angle))
        limits.append(Limit(Mode.YIELD, *axes.point(angle, load), 1.0, Worst(1.0), -1.0))
    of_rays = LimitMap(axes, angles, {Mode.YIELD: tuple(limits)})
    rpm, charge = axes.point(float(angles[2]), 0.25)
    factor = of_rays.factors(np.array([rpm]), np.array([charge]))[Mode.YIELD]
    assert factor[0] == pytest.approx(4 / (math.cos(angles[2]) + math.sin(angles[2])))
