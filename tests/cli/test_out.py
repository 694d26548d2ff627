"""Files where `--out` says, and what `fea view` draws of the folder of a run."""

import json

import pytest
from program import PLAIN, fea

from fea.output.json_file import governing_file
from fea.output.pictures.picture import is_complete_png
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


QUICK = (PLAIN[0], "--size", 20, "--pressure", "cosine-180")


def printed(*arguments, cwd):
    done = fea(*arguments, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("runs")
    printed("run", *QUICK, "--rpm", "3000,6000", "--quiet", "--out", "speeds", cwd=place)
    return place


def test_the_folder_of_a_run_is_drawn_where_it_governs(folder):
    first, second = printed("view", "speeds", cwd=folder)
    assert first.startswith("plain at 6000 rpm: ")
    assert second == "Wrote speeds/6000rpm/tension.png"
    assert is_complete_png(folder / "speeds/6000rpm/tension.png")


def test_what_governs_is_that_of_the_worst_speed(folder):
    runs = {rpm: json.loads((folder / f"speeds/{rpm}rpm/summary.json").read_text()) for rpm in (3000, 6000)}
    assured = {rpm: run["survival"]["assured_safety_factor"] for rpm, run in runs.items()}
    assert assured[6000] < assured[3000]
    vtu, summary = governing_file(folder / "speeds")
    assert summary.rpm == 6000
    assert vtu == folder / "speeds" / "6000rpm" / f"{summary.governing_result}.vtu"
    assert governing_file(folder / "speeds" / "3000rpm")[1].rpm == 3000


def test_a_run_without_the_fields_that_govern_is_refused(folder, tmp_path):
    for name in ("summary.json", "study.toml"):
        (tmp_path / name).write_bytes((folder / "speeds" / "3000rpm" / name).read_bytes())
    with pytest.raises(InvalidValue, match=r"\.vtu.*: is missing, which shows what governs\. Repeat the run"):
        governing_file(tmp_path)


def test_a_report_goes_where_it_is_asked_for(folder):
    printed("report", "speeds/6000rpm", "--out", "other.html", cwd=folder)
    assert (folder / "other.html").stat().st_size > 1e5
    assert not (folder / "speeds/6000rpm/report.html").exists()
    done = fea("report", "speeds", "--out", "all.html", cwd=folder)
    assert (done.returncode, "Name one of the runs, such as speeds/3000rpm" in done.stderr) == (2, True)


def test_a_rod_goes_into_the_file_of_its_ending(tmp_path):
    assert printed("rod", PLAIN[0], "--size", 30, "--out", "a.step", cwd=tmp_path)[-1] == "Wrote a.step"
    assert (tmp_path / "a.step").read_bytes().startswith(b"ISO-10303-21;")
    fit = ("--fit", "big_end_ring_mm", "--mass-kg", "0.7", "--out", "fitted.toml")
    assert printed("rod", PLAIN[0], *fit, cwd=tmp_path)[-1] == "Wrote fitted.toml"
    assert "[rod]" in (tmp_path / "fitted.toml").read_text()


def test_loads_and_schema_go_into_files(tmp_path):
    assert printed("loads", PLAIN[0], "--out", "cycle.csv", cwd=tmp_path)[-1] == "Wrote cycle.csv"
    assert (tmp_path / "cycle.csv").read_text().startswith("rpm,")
    assert printed("schema", "--out", "schema.json", cwd=tmp_path) == ["Wrote schema.json"]
    assert "$defs" in json.loads((tmp_path / "schema.json").read_text())
