"""Logs of engines in use: their columns, units and bins, and what is refused."""

import numpy as np
import pytest

from fea.rod.loading import EngineLoading, charge
from fea.study.duty_log import LogColumn, parse_log, read_log
from fea.study.engine_table import EngineTable
from fea.study.speed_tables import DutyTable
from fea.study.trace_table import find_long_table, find_table
from geometry.errors import InvalidValue

HEAD = "time [s],rpm,load [%]\n"
LAP = HEAD + "".join(
    f"{0.05 * k:.2f},{3000 + 100 * (k % 40)},{50 if k % 40 < 20 else 100}\n" for k in range(400)
)


def test_bins_hold_all_of_the_time_and_stand_for_their_damage():
    log = parse_log(LAP, "lap.csv")
    assert log.kind is LogColumn.LOAD
    assert log.hours == pytest.approx(400 * 0.05 / 3600)
    assert sum(each.share for each in log.bins) == pytest.approx(1)
    # Within each bin, time times speed to the power 16, as damage goes where inertia loads the rod.
    of_samples = (log.step * log.rpm**16.0).sum() / 3600
    of_bins = sum(log.hours * each.share * each.rpm**16.0 for each in log.bins)
    assert of_bins == pytest.approx(of_samples, rel=2e-3)  # speeds of bins are whole
    assert len(log.bins) <= 24


@pytest.mark.parametrize(
    ("head", "scale"),
    [
        ("time [s],rpm,boost [kPa]", (1, 1, 100)),
        ("Time [ms];Engine speed [1/min];Boost pressure [bar]", (1000, 1, 1)),
        ("time_s\tn [Hz]\tboost_psi", (1, 1 / 60, 14.503774)),
        ("t (min),drehzahl,ladedruck", (1 / 60, 1, 1)),
    ],
)
def test_units_stand_in_the_headings(head, scale):
    separator = next(each for each in ";\t," if each in head)
    rows = [(0.1 * k, 4000 + 500 * (k % 3), 0.8) for k in range(30)]
    lines = [
        separator.join(f"{value * by:.7g}" for value, by in zip(row, scale, strict=True)) for row in rows
    ]
    log = parse_log("\n".join([head, *lines]), "lap.csv")
    assert log.hours == pytest.approx(3 / 3600, rel=1e-5)
    assert log.rpm.max() == pytest.approx(5000, rel=1e-5)
    assert log.kind is LogColumn.BOOST
    assert {each.load for each in log.bins} == {0.8}


def test_long_tables_are_those_that_are_read_line_by_line():
    for text in (LAP, LAP.replace(",", ";").replace(".", ","), LAP + "# a remark\n20.1,3000,50\n"):
        slow, fast = find_table(text, "lap.csv"), find_long_table(text, "lap.csv")
        np.testing.assert_array_equal(fast.values, slow.values)
        assert (fast.names, fast.lines) == (slow.names, slow.lines)


def test_pauses_and_a_standing_engine_take_no_time():
    rows = [f"{k * 0.1:.1f},{0 if k < 10 else 5000}" for k in range(50)]
    rows += [f"{600 + k * 0.1:.1f},5000" for k in range(50)]
    log = parse_log("\n".join(["time [s],rpm", *rows]), "lap.csv")
    assert log.hours == pytest.approx(9.0 / 3600)
    assert log.pauses == 1
    assert len(log.visited) == 1
    texts = " ".join(note.text for note in log.notes())
    assert "pauses 1 times" in texts
    assert "has no load" in texts
    assert "smoothed logs are too favourable" in texts  # a sample every tenth of a second


def test_shares_of_damage_add_up_along_the_log():
    log = parse_log(LAP, "lap.csv")
    along = log.along(np.arange(1.0, len(log.bins) + 1))
    assert along["damage_percent"].sum() == pytest.approx(100)
    assert along["rpm"].max() == log.rpm.max()


TABLE = EngineTable(
    stroke_mm=90.0,
    bore_mm=80.0,
    piston_mass_kg=0.4,
    gas="otto",
    compression_ratio=10.0,
    peak_pressure_bar=60.0,
)
OTTO = EngineLoading.of(TABLE, 140.0)


def test_the_charge_follows_from_load_boost_and_throttle():
    assert charge(None, None, OTTO) == 1
    assert charge(LogColumn.LOAD, 50.0, OTTO) == pytest.approx(0.5)
    closed = 0.3 / 1.01325
    assert charge(LogColumn.LOAD, 5.0, OTTO) == pytest.approx(closed, rel=1e-3)
    assert charge(LogColumn.THROTTLE, 0.0, OTTO) == pytest.approx(closed, rel=1e-3)
    assert charge(LogColumn.THROTTLE, 100.0, OTTO) == 1
    assert charge(LogColumn.BOOST, 1.01325, OTTO) == pytest.approx(2)
    assert charge(LogColumn.BOOST, -0.8, OTTO) == pytest.approx(closed, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("time [s],load [%]\n0,50\n1,60\n", "no column of engine speed; its columns of numbers are time"),
        ("rpm,load [%]\n3000,50\n3100,60\n", "no column of time"),
        (LAP.replace("0.10,", "0.05,", 1), r"lap.csv line 4 = '0.05 s after 0.05 s': time must increase"),
        (LAP.replace("rpm", "rpm [furlong]"), "furlong.* unit of the right kind"),
        (LAP.replace("[s]", "[furlong]"), "furlong"),
        (LAP.replace("[%]", "[mm]"), "mm"),
        (LAP.replace(",100\n", ",400\n"), "between 0 and 300 percent"),
        (LAP.replace(",3000,", ",60000,"), "between 0 and 50000 rpm"),
        ("time [s],rpm\n0,0\n1,0\n", "no speed above 50 rpm"),
        ("nothing here", "duty.log"),
    ],
)
def test_logs_that_make_no_sense_are_refused(text, named):
    with pytest.raises(InvalidValue, match=named):
        parse_log(text, "lap.csv")


def test_a_log_beside_speeds_and_one_that_is_missing_are_refused(tmp_path):
    with pytest.raises(InvalidValue, match=r"duty.rpm.* duty.log"):
        DutyTable(rpm=(3000.0,), log="lap.csv")
    with pytest.raises(InvalidValue, match=r"duty.log.* cannot be read"):
        read_log(tmp_path / "lap.csv")
    with pytest.raises(InvalidValue, match=r"engine.boost_bar"):
        charge(LogColumn.BOOST, 1.0, OTTO.with_gas("leon-2001"))


def test_a_log_runs_its_highest_speed(tmp_path):
    (tmp_path / "lap.csv").write_text(LAP)
    duty = DutyTable(log="lap.csv").located(tmp_path)
    assert duty.run_speeds == (max(each.rpm for each in duty.read.bins),)
    assert sum(entry.share for entry in duty.entries) == pytest.approx(1)
    assert duty.total_hours == pytest.approx(400 * 0.05 / 3600)
