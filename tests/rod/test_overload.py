"""Overloads of a study: what liquid does to the compression, and values that are refused."""

import math
from dataclasses import replace

import pytest

from fea import load_study
from fea.rod.loading import EngineLoading, GivenForces
from fea.rod.overload import Overload
from fea.study.overload_table import OverloadTable
from fea.study.study import parse_study
from geometry.errors import InvalidValue
from geometry.mass import MassProperties
from loads.hydrolock import BULK

RATIO, EXPONENT, ML = 10.0, 1.4, 1e3
ENGINE = replace(load_study("leon-2001").engine, compression_ratio=RATIO)
LOADING = EngineLoading.of(ENGINE, 144.0)
ROD = MassProperties(5e-4, (40.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
SWEPT = LOADING.engine.piston_area * LOADING.engine.stroke
CHAMBER = SWEPT / (RATIO - 1)


def overload(**keys):
    return Overload.of(OverloadTable(**keys), LOADING, ROD, (6000.0,))


def test_less_liquid_than_the_chamber_holds_raises_the_compression_ratio():
    liquid = 0.5 * CHAMBER
    trapped = overload(liquid_ml=liquid / ML)
    found = trapped.liquid
    ratio = (SWEPT + CHAMBER - liquid) / (CHAMBER - liquid)
    pressure = ENGINE.intake * ratio**EXPONENT
    # The liquid yields by its pressure over its bulk modulus, which leaves more room for the gas.
    force = trapped.on_elastic_rod(0.0)
    gas = CHAMBER - liquid * (1 - (found.pressure(force) - ENGINE.intake) / BULK)
    assert found.pressure(force) == pytest.approx(pressure * ((CHAMBER - liquid) / gas) ** EXPONENT, rel=1e-6)
    assert found.pressure(force) == pytest.approx(pressure, rel=0.01)


def test_more_liquid_fixes_how_far_the_piston_stays_away():
    liquid = 1.2 * CHAMBER
    found = overload(liquid_ml=liquid / ML).liquid
    pressure = 1000.0  # of which the gas is all but gone
    shortening = found.shortening((pressure - found.crankcase) * found.piston_area)
    excess = (liquid * (1 - pressure / BULK) - CHAMBER) / found.piston_area
    assert shortening == pytest.approx(excess, abs=0.15)


def test_the_energy_that_compresses_the_gas_is_that_of_its_law():
    found = overload(liquid_ml=0.5 * CHAMBER / ML).liquid
    force = 20e3
    gas = found.closed - found.liquid
    steps = [force * number / 4000 for number in range(4001)]
    volume = [gas * (found.intake / found.pressure(each)) ** (1 / EXPONENT) for each in steps]
    work = sum(
        (a - b) * (f + g) / 2 for a, b, f, g in zip(volume, volume[1:], steps, steps[1:], strict=False)
    )
    work /= found.piston_area
    liquid = found.liquid * (found.pressure(force) - found.intake) ** 2 / (2 * BULK)
    assert found.work(force) == pytest.approx(work + liquid, rel=1e-3)
    some = overload(liquid_ml=0.5 * CHAMBER / ML, energy_J=found.work(force) / 1e3)
    assert some.on_elastic_rod(0.0) == pytest.approx(force)
    assert some.on_elastic_rod(1e-6) < force


def test_knock_is_the_mean_over_the_piston():
    found = overload(knock_bar=150.0)
    assert found.force == pytest.approx((15.0 - ENGINE.atmosphere) * math.pi * 76.0**2 / 4)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"knock_bar": 60.0}, r"overload.knock_bar = 60: must exceed the peak pressure of the engine, 71"),
        ({"liquid_ml": 450.0}, r"liquid_ml = 450: is more than the cylinder holds when the intake shuts, 4"),
    ],
)
def test_an_overload_that_cannot_be_is_refused(keys, message):
    with pytest.raises(InvalidValue, match=message):
        overload(**keys)


def test_one_load_and_an_engine_are_needed():
    with pytest.raises(InvalidValue, match="is given with liquid_ml: an overload is one load"):
        OverloadTable(knock_bar=150.0, liquid_ml=30.0)
    with pytest.raises(InvalidValue, match="energy_J = 50: needs liquid_ml"):
        OverloadTable(energy_J=50.0)
    with pytest.raises(InvalidValue, match="presses on a piston, which \\[forces\\] do not have"):
        Overload.of(OverloadTable(knock_bar=90.0), GivenForces((1e4, 0.0)), ROD, ())
    loading = EngineLoading.of(replace(ENGINE, compression_ratio=None), 144.0)
    with pytest.raises(InvalidValue, match=r"engine.compression_ratio is missing: overload.liquid_ml needs"):
        Overload.of(OverloadTable(liquid_ml=30.0), loading, ROD, ())


def test_units_are_read(tmp_path):
    text = '[rod]\npreset = "leon-2001"\n[overload]\nliquid = "3 in³"\nenergy = "0.4 kJ"\n'
    table = parse_study(text, "test", tmp_path).overload
    assert table.liquid_ml == pytest.approx(49.161192)
    assert table.energy_J == pytest.approx(400.0)
