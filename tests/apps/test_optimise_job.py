"""The whole job of `fea optimise` on a simple rod: what it finds, leaves and says."""

import json
import re
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest
from program import fea
from studies import OPTIMISE

from fea.apps.optimise.run_optimise import optimise, progress
from fea.machine.system import AtInterrupt
from fea.output.folder import read_columns, require_replaceable
from fea.output.pictures.picture import is_complete_png
from fea.study.flags import Flags
from fea.study.study import load_study

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

# One dimension more than 20 evaluations can decide.
SEVERAL = [
    part
    for name, low, high in (
        ("shank_width", 7, 16), ("shank_depth_big_end", 9, 22), ("shank_depth_small_end", 7, 15),
        ("big_end_ring", 6, 12), ("small_end_ring", 7, 16), ("web_thickness", 3, 7),
        ("flange_thickness", 2.4, 3), ("pocket_corner_radius", 0.5, 9), ("pocket_floor_radius", 0.5, 9),
    )
    for part in ("--free", f"{name}_mm={low}:{high}")
]  # fmt: skip
# Designs after which the search is interrupted; it goes on with the same command.
BEFORE = 4
# Per cent to which the last rod is refined; 2 by default.
WITHIN = 4.0


@pytest.fixture(scope="module")
def sooner():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fea.apps.optimise.run_optimise.TOLERANCE", WITHIN)
        yield


@pytest.fixture(scope="module")
def job(tmp_path_factory, sooner):
    folder = tmp_path_factory.mktemp("job")
    (folder / "own.toml").write_text(OPTIMISE)
    asked = Flags(size=16.0).applied(load_study(folder / "own.toml"))
    asked = replace(asked, optimise=replace(asked.optimise, evaluations=20))
    said = []

    def interrupting(text, **_options):
        said.append(text)
        if text.startswith(f"{BEFORE + 1} of"):
            raise KeyboardInterrupt

    place = folder / "results" / "own-optimised"
    usual = AtInterrupt.message
    with pytest.raises(KeyboardInterrupt):
        optimise(asked, place, interrupting)
    assert "the same command resumes" in AtInterrupt.message
    AtInterrupt.message = usual
    assert re.match(r"about \d+ (s|min), ", said[0])
    assert not place.exists()
    begun = place.with_name("own-optimised.unfinished")
    known = [json.loads(line)["design"] for line in begun.read_text().splitlines()[1:]]
    with begun.open("a") as file:
        file.write('{"kind": "at", "as')  # as a killed process leaves it
    done = fea("optimise", "own.toml", "--size", 16, "--evaluations", 20, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert f"resuming after {len(known)} designs" in done.stderr
    assert not begun.exists()
    tried = json.loads((place / "optimise.json").read_text())["history"]
    masses = [one["mass_kg"] for one in known]
    assert [one["mass_kg"] for one in tried[: len(known)]] == pytest.approx(masses, rel=1e-5)
    return place, done.stdout


def test_the_lighter_rod_holds_on_a_mesh_of_its_own(job):
    folder, said = job
    found = json.loads((folder / "optimise.json").read_text())
    assert found["holds"]
    assert found["trusted"]
    assert found["evaluations"] <= 20
    assert found["tolerance_percent"] == WITHIN
    assert 0 < found["mass_after_kg"] < found["mass_before_kg"]
    assert re.search(r"own: 6[\d.]+ g instead of 7[\d.]+ g, [\d.]+ % lighter", said)
    for limit in found["limits"]:
        assert limit["assured_after"] >= limit["required"]
        assert limit["after_error_percent"] <= WITHIN


def test_its_study_runs_again(job):
    folder, _ = job
    found = json.loads((folder / "optimise.json").read_text())
    study = load_study(folder / "study.toml")
    (dimension,) = found["dimensions"]
    assert study.rod.dimensions.shank_width == pytest.approx(dimension["after_mm"], rel=1e-5)
    assert tomllib.loads(study.text())["analysis"]["tolerance_percent"] == WITHIN


def test_the_history_has_every_design(job):
    folder, _ = job
    columns, found = read_columns(folder / "history.csv"), json.loads((folder / "optimise.json").read_text())
    assert len(columns["number"]) == len(found["history"])
    assert columns["shank_width_mm"][0] == 16.0
    assert is_complete_png(folder / "history.png")
    assert is_complete_png(folder / "rods.png")
    require_replaceable(folder)


def test_what_is_no_search_leaves_nothing(tmp_path):
    (tmp_path / "own.toml").write_text(OPTIMISE)
    for arguments, why in (
        (("own.toml", "--free", "shank_width_mm=20:8"), "must rise"),
        (("leon-2001", *SEVERAL, "--evaluations", 20), "cannot decide 9 free dimensions, which take 21"),
        (("leon-2001-bolted",), "every design would take minutes"),
        (("own.toml", "--out", "own.toml"), "is a file"),
    ):
        done = fea("optimise", *arguments, cwd=tmp_path)
        assert done.returncode in (2, 7), done
        assert why in done.stderr
    assert [entry.name for entry in tmp_path.iterdir()] == ["own.toml"]


def test_a_resumed_search_still_has_the_lightest_rod_of_the_interrupted_one():
    said = []
    listener = progress(lambda text, **_: said.append(text), 20, 3, clock=iter((0.0, 200.0)).__next__)
    listener(SimpleNamespace(margin=0.1, mass_kg=0.7), 15, 0)
    assert not said
    listener(SimpleNamespace(margin=-0.1, mass_kg=0.6), 16, 1)
    assert "as one mesh took 3 min" in said[0]
    assert said[1].endswith("lightest so far: 700 g")
