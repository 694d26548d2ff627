"""What a Python user sees: results in memory, files when asked for, examples that run."""

import copy
import dataclasses
import doctest
import json
import os
import pickle
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import meshio
import numpy as np
import pytest
from PIL import Image
from studies import plain_study

import fea
from fea import run
from fea.analysis.life_figures import EnvelopeFigures
from fea.analysis.result import WhatIf
from fea.apps.result import analyse
from fea.output import run_files
from fea.output.folder import write_text
from fea.output.json_file import as_dict, read_summary
from fea.output.run_files import RunFiles, Writer
from fea.study.study import load_study
from geometry.errors import InvalidValue

pytestmark = pytest.mark.usefixtures("coarse_bores")

COARSE = {"rpm": 6000, "size": 14}
PLAIN = plain_study()  # half as many nodes as with pockets


@pytest.fixture(scope="module")
def result():
    return analyse(PLAIN, cycle=True, buckling=True, **COARSE)


def test_an_analysis_touches_no_disk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = analyse("leon-2001", **COARSE)
    assert found.trusted
    assert list(tmp_path.iterdir()) == []


def test_what_is_written_is_what_a_run_leaves(result, tmp_path):
    summary = run(PLAIN, cycle=True, buckling=True, out=tmp_path / "run", **COARSE)
    assert result.write(tmp_path / "result") == tmp_path / "result"
    names = {entry.name for entry in (tmp_path / "run").iterdir()}
    assert {entry.name for entry in (tmp_path / "result").iterdir()} == names == set(summary["files"])
    for name in ("study.toml", "loads.csv"):
        assert (tmp_path / "result" / name).read_bytes() == (tmp_path / "run" / name).read_bytes(), name
    one, other = (meshio.read(tmp_path / folder / "tension.vtu") for folder in ("result", "run"))
    assert one.point_data.keys() == other.point_data.keys()
    for name, values in one.point_data.items():  # the solver's threads may sum in another order
        np.testing.assert_allclose(other.point_data[name], values, atol=1e-9 * np.abs(values).max())
    for name, figures in result.as_dict()["results"].items():
        assert figures["max_von_mises_MPa"] == pytest.approx(summary["results"][name]["max_von_mises_MPa"])


def test_what_is_written_is_read_back_as_the_same_types(result, tmp_path):
    found = read_summary(result.write(tmp_path / "result"))
    assert isinstance(found.envelope, EnvelopeFigures)
    assert found.results["tension"].min_safety_factor == pytest.approx(
        result.cases["tension"].min_safety_factor, rel=1e-5
    )
    assert found.checks.keys() == result.checks.keys()
    assert as_dict(found).keys() == json.loads((tmp_path / "result" / "summary.json").read_text()).keys()


def test_figures_are_attributes_of_frozen_values(result):
    tension = result.cases["tension"]
    assert tension.max_von_mises == pytest.approx(tension.von_mises.max())
    assert tension.at == pytest.approx(result.mesh.points[tension.von_mises.argmax()])
    assert tension.min_safety_factor == pytest.approx(tension.safety_factor.min())
    with pytest.raises(dataclasses.FrozenInstanceError):
        result.mesh = None
    with pytest.raises(dataclasses.FrozenInstanceError):
        tension.stress = None


def test_a_dimension_changes_what_depends_on_it(result):
    thin = analyse(load_study("leon-2001").with_rod(web_thickness_mm=4.0), **COARSE)
    assert thin.summary.rod.mass_kg < result.summary.rod.mass_kg
    assert thin.cases["tension"].max_von_mises > result.cases["tension"].max_von_mises
    with pytest.raises(InvalidValue, match=r"web_thicknes_mm.*unknown key.*web_thickness_mm"):
        load_study("leon-2001").with_rod(web_thicknes_mm=4.0)


def test_a_grid_has_the_arrays_of_the_file(result):
    grid = result.to_pyvista("tension")
    np.testing.assert_array_equal(grid.point_data["von_mises"], result.cases["tension"].von_mises)
    assert "fatigue_safety_factor" in result.to_pyvista("envelope").point_data
    with pytest.raises(InvalidValue, match=r"must be one of .*tension.*envelope"):
        result.to_pyvista("tensile")


def test_a_notebook_shows_every_case_and_the_worst_one_as_a_picture(result):
    html = result._repr_html_()
    assert all(f'<th scope="row">{name}</th>' in html for name in result.cases)
    assert "The rod does not survive" in html
    assert "data:image/png;base64," in html
    assert repr(result).startswith("<leon-2001 at 6000 rpm: fails by fatigue, safety factor 0.")


def test_a_row_for_each_load_case_has_the_names_of_the_summary(result):
    pytest.importorskip("pandas")
    table, summary = result.to_frame(), result.as_dict()
    assert list(table.index) == list(result.cases)
    for column in ("max_von_mises_MPa", "min_safety_factor", "min_safety_factor_low", "verdict"):
        assert list(table[column]) == [figures[column] for figures in summary["results"].values()]
    assert table.loc["gas", "gas_N"] == summary["loads"]["gas"]["gas_N"]
    assert tuple(table.loc["tension", ["x_mm", "y_mm", "z_mm"]]) == pytest.approx(result.cases["tension"].at)


def test_without_pandas_the_remedy_is_named(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install pandas"):
        result.to_frame()


def test_a_pickled_result_is_its_figures(result, tmp_path, monkeypatch):
    pickled = pickle.dumps(result)
    assert len(pickled) < 5e5  # of any mesh; of this small one, fields and mesh are 4.8 MB
    kept = pickle.loads(pickled)  # noqa: S301 - our own
    assert kept.as_dict() == result.as_dict()
    assert kept.study == result.study
    assert kept.forces.keys() == result.forces.keys()
    assert repr(kept) == repr(result)
    assert dict(kept.cases) == {}
    for ask in (lambda: kept.cases["tension"], kept.plot, lambda: kept.to_pyvista("tension")):
        with pytest.raises(fea.InvalidValue, match=r"kept without its fields.*analyse\(result.study\)"):
            ask()
    monkeypatch.setattr("fea.apps.what_if.solve.what_if", lambda _run, _clock: WhatIf())  # takes seconds
    kept.write(tmp_path / "run", report=True)
    assert read_summary(tmp_path / "run").rod == read_summary(result.write(tmp_path / "whole")).rod
    assert copy.deepcopy(result) is result  # a copy keeps the fields


def test_a_picture_is_of_what_governs_or_of_what_is_asked_for(result, monkeypatch):
    drawn = []

    def draw(pictures):
        drawn.extend(pictures)
        Image.new("RGB", (4, 3), "red").save(pictures[0].png)

    monkeypatch.setattr("fea.apps.result.draw_pictures", draw)
    assert result.plot().size == (4, 3)
    assert result.plot("tension", "displacement")._repr_png_()
    assert [(picture.vtu.stem, picture.field) for picture in drawn] == [
        ("envelope", "fatigue_safety_factor"),
        ("tension", "displacement"),
    ]
    with pytest.raises(fea.InvalidValue, match=r"^case = 'tensile': must be one of tension"):
        result.plot("tensile")
    with pytest.raises(fea.InvalidValue, match=r"^field = 'nonsense': must be one of von_mises"):
        result.plot("tension", "nonsense")


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: fea.load_study("nonsense"), r"^study = 'nonsense': is neither"),
        (lambda: fea.analyse(rpm="fast"), r"^rpm = 'fast': is not a speed"),
        (
            lambda: fea.analyse(fatigue="goodman"),
            r"^fatigue = .*has no effect without cycle=True\. Add cycle=True",
        ),
        (lambda: fea.prepare(size=0.01), "unusual=True"),
        (lambda: fea.run(engine="toyota-2jx"), r"^engine = 'toyota-2jx': is not an engine"),
        (lambda: fea.limits(fea.load_study().with_(engine=None)), "Add one of them"),
    ],
)
def test_errors_speak_python(call, says):
    with pytest.raises(fea.InvalidValue, match=says) as refused:
        call()
    assert "--" not in str(refused.value)
    assert type(pickle.loads(pickle.dumps(refused.value))) is fea.InvalidValue  # noqa: S301 - our own


def test_errors_have_one_name_wherever_the_package_lies():
    errors = [name for name in fea.__all__ if isinstance(getattr(fea, name), type) and "Error" in name]
    assert len(errors) == 10
    for name in (*errors, "InvalidValue"):
        assert f"{getattr(fea, name).__module__}.{getattr(fea, name).__qualname__}" == f"fea.{name}"


def test_functions_can_be_sent_to_other_processes():
    assert pickle.loads(pickle.dumps(fea.analyse)) is fea.analyse  # noqa: S301 - our own


def test_flags_that_write_files_are_not_for_an_analysis():
    with pytest.raises(InvalidValue, match=r"flag 'out' is an unknown key.*rpm"):
        analyse("leon-2001", out="here")


def test_several_speeds_are_no_result():
    with pytest.raises(InvalidValue, match=r"has 3 speeds.*rpm=6000"):
        analyse("columba-2022", size=14)


def test_a_new_format_needs_its_writer_alone(tmp_path, monkeypatch, result):
    def points(outcome):
        text = f"{len(outcome.mesh.points)}\n"
        yield RunFiles(("points.csv",), lambda folder: write_text(folder / "points.csv", text))

    monkeypatch.setattr(run_files, "WRITERS", (*run_files.WRITERS, Writer("write", points)))
    folder = result.write(tmp_path / "run")
    assert "points.csv" in read_summary(folder).files
    assert result.write(folder) == folder  # it is recognised as an earlier run


@pytest.mark.parametrize("module", ["fea", "fea.apps.result", "fea.study.study", "fea.solid.scikit_fem"])
def test_examples_in_docstrings_run(module):
    found = doctest.testmod(import_module(module), raise_on_error=False)
    assert found.attempted > 0
    assert found.failed == 0


def test_importing_the_package_loads_nothing_else():
    code = "import sys, fea; print([m for m in ('numpy', 'gmsh', 'skfem', 'pyvista') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(("said", "threads"), [(None, {1}), ("2", {2})])
def test_openblas_has_one_thread_even_where_numpy_was_loaded_before(said, threads):
    code = (
        "import numpy, fea, scipy.linalg, threadpoolctl as t; "
        "print({info['num_threads'] for info in t.threadpool_info() if info['internal_api'] == 'openblas'})"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    environment |= {"OMP_NUM_THREADS": "2"} | ({} if said is None else {"OPENBLAS_NUM_THREADS": said})
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout.strip() in (str(threads), "set()")  # none where NumPy has another library


def test_every_public_name_is_there():
    assert all(getattr(fea, name) is not None for name in fea.__all__)
    assert set(dir(fea)) - {"__doc__", "__version__"} == set(fea.__all__)
    documented = (Path(__file__).parent.parent / "docs/reference/api.md").read_text(encoding="utf-8")
    assert all(re.search(rf"::(?: fea\.)? {name}$", documented, re.MULTILINE) for name in fea.__all__)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = fea.nonsense


def test_the_rooms_of_the_package_hide_no_public_name():
    program = (
        "import fea, fea.analysis.pipeline; from fea import run; assert callable(fea.run) and callable(run)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
