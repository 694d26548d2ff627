"""Packages of other projects with the names of ours, and the wheel that lies beside them."""

import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from fea.base.version import __version__

pytestmark = pytest.mark.slow


ROOT = Path(__file__).parents[2]


def in_folder(folder, *arguments):
    """Run Python with a folder of foreign packages in front."""
    places = os.pathsep.join([str(folder), str(ROOT)])
    return subprocess.run(
        [sys.executable, "-P", *arguments],
        env={**os.environ, "PYTHONPATH": places, "FEA_DEBUG": ""},
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["geometry", "mesh", "loads"])
def test_a_foreign_package_is_named_with_a_remedy(tmp_path, name):
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").write_text("")
    done = in_folder(tmp_path, "-m", "fea", "rod", "--quiet")
    assert done.returncode == 7, done.stderr
    (line,) = done.stderr.splitlines()
    assert f"the package '{name}' in {tmp_path / name} belongs to another project" in line
    assert "environment of its own" in line
    done = in_folder(tmp_path, "-c", "from fea import analyse")
    assert f"ImportError: the package '{name}'" in done.stderr


def test_a_library_that_is_missing_is_not_blamed_on_a_neighbour(tmp_path):
    (tmp_path / "meshio.py").write_text("import no_such_library")
    done = in_folder(tmp_path, "-c", "from fea import analyse")
    assert "belongs to another project" not in done.stderr


def test_the_wheel_holds_one_package_whose_imports_are_complete(tmp_path):
    spec = importlib.util.spec_from_file_location("wheel_layout", ROOT / ".ci" / "wheel.py")
    wheel = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(wheel)
    for name in ("fea", *wheel.INSIDE):
        target = tmp_path / "fea" / ("" if name == "fea" else name)
        wheel.copied(ROOT / name, target)
    for one in (ROOT / "mesh").rglob("*.py"):  # line by line
        two = (tmp_path / "fea" / "mesh" / one.relative_to(ROOT / "mesh")).read_text(encoding="utf-8")
        assert two.count("\n") == one.read_text(encoding="utf-8").count("\n")
    for name in wheel.INSIDE:  # of which the wheel imports none
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('foreign')")
    code = "import fea, fea.pins.contact, fea.cli.run, fea.apps.write_run; print(fea.load_study())"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "leon-2001" in done.stdout, done.stderr
    with pytest.raises(ValueError, match="not rewritten"):
        (tmp_path / "odd").mkdir()
        (tmp_path / "odd" / "one.py").write_text("from mesh\timport tetmesh\n")
        wheel.copied(tmp_path / "odd", tmp_path / "other")


def test_the_version_is_stated_once():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["tool"]["hatch"]["version"]["path"] == "fea/base/version.py"
    cited = re.search(r"(?m)^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"))[1]
    recipe = (ROOT / ".ci" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    assert cited == __version__ == re.search(r"(?m)^  version: (.*)$", recipe)[1].strip('"')


def test_the_conda_recipe_asks_for_what_pip_installs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / ".ci" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    run, _, constraints = (
        recipe.partition("  run:\n")[2].partition("\ntests:")[0].partition("  run_constraints:")
    )
    conda = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base"}
    listed = [dict(re.findall(r"(?m)- ([\w-]+) *(\S*)$", part)) for part in (run, constraints)]
    assert listed[0].pop("python") == project["requires-python"]
    assert listed[0].pop("gmsh") == listed[0]["python-gmsh"]  # the library and what Python calls
    assert listed[0].pop("mkl") == ""  # pypardiso's, which pip takes by itself

    def wanted(requirements):
        found = dict(re.match(r"([\w.-]+)(\S*?)(?:;|$)", one).groups() for one in requirements)
        return {conda.get(name.lower(), name.lower()): version for name, version in found.items()}

    assert listed[0] == wanted(project["dependencies"])
    extras = wanted(one for group in project["optional-dependencies"].values() for one in group)
    assert listed[1] == {name: version for name, version in extras.items() if name not in listed[0]}
    ((name, place),) = project["scripts"].items()
    assert f"- {name} = {place}\n" in recipe
