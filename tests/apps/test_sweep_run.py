"""Sweeps as processes, on workers that are processes."""

import csv
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import cheap_sweep
import pytest
from program import fea, started
from studies import PLAIN

from fea.apps.result import analyse
from fea.apps.sweep.journal import write_tables
from fea.apps.sweep.run_sweep import journal_of, run_sweep
from fea.apps.sweep.sweep_file import load_sweep
from fea.apps.sweep.workers import Task, attempt
from fea.study.study import load_study
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


pytest.importorskip("distributed")
COUNT = 24
COMPUTE = "cheap_sweep:compute"
SWEEP = f"""study = "leon-2001"
sampling = "sobol"
samples = {COUNT}
[vary.rod]
web_thickness_mm = {{ from = 4.0, to = 6.0 }}
"""


def undisturbed(path, folder):
    """The table of a sweep computed in this process, rod by rod."""
    sweep = load_sweep(path)
    with journal_of(sweep, folder) as journal:
        common = Task(sweep.base, sweep.outputs, compute=COMPUTE)
        journal.finish([attempt(common.of(journal, job)) for job in journal.pending()])
        write_tables(folder, journal.rows())
    return (folder / "sweep.csv").read_bytes()


def done(folder):
    base = sqlite3.connect(folder / "sweep.sqlite")
    try:
        return [n for (n,) in base.execute("SELECT number FROM rods WHERE state = 'done'")]
    except sqlite3.OperationalError:  # not begun yet
        return []
    finally:
        base.close()


def test_a_sweep_that_is_killed_goes_on_where_it_was(tmp_path):
    (tmp_path / "web.toml").write_text(SWEEP)
    log, out = tmp_path / "log", tmp_path / "out"
    command = [sys.executable, cheap_sweep.__file__, "web.toml", "out"]
    environment = os.environ | {"CHEAP_LOG": str(log), "CHEAP_SECONDS": "0.1"}
    killed = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL)
    limit = time.monotonic() + 60
    while not (out / "sweep.sqlite").exists() or not len(done(out)) >= 4:
        assert time.monotonic() < limit
        assert killed.poll() is None
        time.sleep(0.02)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    before = len(done(out))
    assert before < COUNT
    again = subprocess.run(
        command,
        cwd=tmp_path,
        env=environment | {"CHEAP_SECONDS": "0"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert again.stdout == f"{COUNT - before} {COUNT} 0\n"
    lines = [line.split() for line in log.read_text().splitlines()]
    begun = [web for what, web, *_ in lines if what == "begin"]
    assert len(set(begun)) == COUNT
    assert len(begun) <= COUNT + 2  # what was in flight on two workers, and nothing else
    assert (out / "sweep.csv").read_bytes() == undisturbed(tmp_path / "web.toml", tmp_path / "other")


def test_rods_that_crash_or_never_end_are_failed_and_the_others_done(tmp_path):
    (tmp_path / "web.toml").write_text(SWEEP.replace(f"samples = {COUNT}", "samples = 8"))
    limits = os.environ | {"CHEAP_FATAL": "5.7", "CHEAP_ENDLESS": "5.5", "CHEAP_MINUTES": "0.05"}
    command = [sys.executable, cheap_sweep.__file__, "web.toml", "out"]
    run = subprocess.run(command, cwd=tmp_path, env=limits, capture_output=True, text=True, check=True)
    assert run.stdout == "8 6 2\n"
    with (tmp_path / "out" / "sweep.csv").open() as file:
        found = {float(row["rod.web_thickness_mm"]): row["reason"] for row in csv.DictReader(file)}
    reasons = [found[web] for web in sorted(found)]
    assert reasons[:6] == [""] * 6
    assert reasons[6].startswith("took longer than 0.05 min")
    assert reasons[7] == "its process crashed 3 times (SIGSEGV)"


def test_two_rods_at_two_speeds(tmp_path):
    (tmp_path / "plain.toml").write_text(PLAIN)
    (tmp_path / "two.toml").write_text(
        'study = "plain.toml"\nfrequencies = 1\nlimits = true\n'
        "[set]\nmesh.size_mm = 14.0\nspeed.rpm = [3000.0, 6000.0]\n"
        'analysis.pressure = "cosine-180"\n'
        "[vary.rod]\nshank_width_mm = [10.0, 500.0, 12.0]\n"
    )
    run = started("sweep", "two.toml", "--workers", 1, cwd=tmp_path)
    assert run.returncode == 5, run.stderr  # a design is no rod
    assert "2 rods computed now; 1 failed, 0 not to be trusted" in run.stdout
    folder = tmp_path / "results" / "two"
    assert sorted(path.name for path in folder.iterdir()) == [
        "report.html", "sweep.csv", "sweep.parquet", "sweep.sqlite",
    ]  # fmt: skip
    with (folder / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["state"], row["rpm"]) for row in rows] == [
        ("done", "3000.0"), ("done", "6000.0"), ("failed", ""), ("done", "3000.0"), ("done", "6000.0"),
    ]  # fmt: skip
    assert "shank_width_mm = 500" in rows[2]["reason"]
    assert rows[0]["frequency_1_Hz"] == rows[1]["frequency_1_Hz"] != rows[3]["frequency_1_Hz"]
    thin, thick = float(rows[0]["limit_rpm"]), float(rows[3]["limit_rpm"])
    assert 3000 < thin == float(rows[1]["limit_rpm"]) < thick < 6000
    assert {rows[0]["limit_mode"], rows[3]["limit_mode"]} == {"fatigue"}
    assert 0 < float(rows[0]["limit_rpm_error_percent"]) < 50
    printed = fea("sweep", "two.toml", "--study", 4, cwd=tmp_path)
    (tmp_path / "row.toml").write_text(printed.stdout)
    summary = analyse(load_study(tmp_path / "row.toml")).summary
    assert float(rows[4]["factor"]) == pytest.approx(summary.survival.safety_factor, rel=1e-6)
    assert rows[4]["factor"] == rows[4]["fatigue_at_most"]
    assert float(rows[4]["mass_kg"]) == pytest.approx(summary.rod.mass_kg, rel=1e-9)
    assert float(rows[4]["tension_error_percent"]) == pytest.approx(
        summary.results["tension"].error_percent, rel=1e-4
    )
    page = (folder / "report.html").read_text()
    assert "shank_width_mm = 500" in page  # among the failed rods
    assert "http" not in page.replace("http-equiv", "")


def test_the_folder_of_another_sweep_is_refused_and_a_longer_one_goes_on(tmp_path):
    path, out = tmp_path / "web.toml", tmp_path / "out"
    path.write_text(SWEEP)
    with journal_of(load_sweep(path), out) as journal:
        assert len(journal.pending()) == COUNT
        other = fea("sweep", path, "--out", out, cwd=tmp_path)
        assert other.returncode == 2
        assert "is in use by another fea sweep" in other.stderr
    before = (out / "sweep.sqlite").read_bytes()
    path.write_text(SWEEP.replace("to = 6.0", "to = 6.5"))
    other = fea("sweep", path, "--out", out, cwd=tmp_path)
    assert other.returncode == 2
    assert "holds the journal of another sweep" in other.stderr
    assert (out / "sweep.sqlite").read_bytes() == before
    path.write_text(SWEEP.replace(f"samples = {COUNT}", f"samples = {COUNT + 8}"))
    with journal_of(load_sweep(path), out) as journal:
        assert len(journal.pending()) == COUNT + 8


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "web.toml").write_text(SWEEP)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    run = fea("sweep", "web.toml", "--out", "out", cwd=tmp_path)
    assert run.returncode == 2
    assert "contains notes.txt" in run.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["notes.txt"]


def test_designs_with_a_fault_leave_no_folder(tmp_path):
    (tmp_path / "designs.csv").write_text("rod.web_thickness_mm,rod.length_mm\n5.0,140\n\n5.5\n")
    (tmp_path / "some.toml").write_text('study = "leon-2001"\ndesigns = "designs.csv"\n')
    with (
        pytest.raises(InvalidValue, match=r"designs\.csv, line 4"),
        journal_of(load_sweep(tmp_path / "some.toml"), tmp_path / "out"),
    ):
        pass
    assert not (tmp_path / "out").exists()


def test_failed_rods_are_tried_again_when_asked(tmp_path, monkeypatch):
    (tmp_path / "web.toml").write_text(SWEEP.replace(f"samples = {COUNT}", "samples = 6"))
    sweep, out = load_sweep(tmp_path / "web.toml"), tmp_path / "out"
    computed = []

    def inline(journal, _workers, common, _listener):
        computed.append(journal.pending())
        journal.finish([attempt(common.of(journal, job)) for job in journal.pending()])

    monkeypatch.setattr("fea.apps.sweep.run_sweep.compute_pending", inline)
    monkeypatch.setattr("fea.apps.sweep.run_sweep.cluster", lambda *_: __import__("contextlib").nullcontext())
    monkeypatch.setenv("CHEAP_REFUSED", "5.0")
    first = run_sweep(sweep, out, compute=COMPUTE)
    assert first.failed > 0
    assert list(first.reasons) == ["internal error: ValueError: too thick for this test"]
    monkeypatch.delenv("CHEAP_REFUSED")
    assert run_sweep(sweep, out, compute=COMPUTE).failed == first.failed
    assert len(computed) == 1  # nothing was left to do
    again = run_sweep(sweep, out, compute=COMPUTE, retry_failed=True)
    assert (again.failed, len(computed[-1])) == (0, first.failed)
    assert Path(out / "report.html").is_file()
