"""What a run loads, and when: imports are a good part of a short run."""

import subprocess
import sys
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from fea.apps import run_study as runs

pytestmark = pytest.mark.slow

HEAVY = {"skfem", "scipy", "vtkmodules", "pypardiso", "rich", "matplotlib", "PIL"}
# Notes which modules are there when the first mesh is, and at the end of the run those that came later.
WATCHED = """
import sys
from contextlib import contextmanager
from fea.apps import run_study as runs
from fea.rod import discretise

discretise.PER_TOUCHED_BORE = 16  # it is solved sooner
imported_meanwhile = runs.imported_meanwhile

@contextmanager
def watched(names):
    with imported_meanwhile({names}):
        yield
    watched.there = set(sys.modules)

runs.imported_meanwhile = watched
from fea.__main__ import call
code = call(["run", "--size", "{size}", "--out", "r"])
print(*watched.there)
print(*sorted(set(sys.modules) - watched.there))
sys.exit(code)
"""


def said(code, folder):
    """What Python code prints."""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def watched(folder, names, size):
    """Modules that were there with the mesh, and later ones, of a run that imports names ahead."""
    there, late = said(WATCHED.format(names=names, size=size), folder).splitlines()[-2:]
    return set(there.split()), set(late.split())


def heavy(names):
    return {name for name in names if name.partition(".")[0] in HEAVY}


def test_a_fine_mesh_needs_nothing_heavy_and_every_run_what_is_imported_ahead(tmp_path):
    there, late = watched(tmp_path, (), size=6)
    assert heavy(there) == set()
    assert {*runs.AFTER_THE_MESH, "fea.output.terminal.run"} <= late


def test_a_coarse_mesh_needs_only_what_is_imported_first(tmp_path):
    there, _ = watched(tmp_path, (), size=14)
    first = said(f"import sys, {runs.AFTER_THE_MESH[0]}; print(*sys.modules)", tmp_path).split()
    assert "skfem" in there
    assert heavy(there) <= set(first)


def test_after_the_mesh_only_the_library_of_the_solver_is_left_to_load(tmp_path):
    _, late = watched(tmp_path, "names", size=14)
    packages = {name.partition(".")[0] for name in late - {"rich._emoji_codes"}}
    assert packages & {*HEAVY, "fea", "geometry", "mesh", "loads"} <= {"pypardiso"}


@pytest.mark.parametrize("step", [None, "rod.step"])
def test_no_thread_imports_while_a_fork_reads_a_cad_file(monkeypatch, step):
    asked = []

    @contextmanager
    def imported_meanwhile(names):
        asked.append(names)
        yield

    def meshed(_study, _clock):
        raise InterruptedError

    monkeypatch.setattr(runs, "places_of", lambda _: [])
    monkeypatch.setattr(runs, "imported_meanwhile", imported_meanwhile)
    monkeypatch.setattr(runs, "adaptive_mesh", meshed)
    study = SimpleNamespace(
        rod=SimpleNamespace(from_file=step is not None),
        output=SimpleNamespace(screenshot=False, report=False),
    )
    with pytest.raises(InterruptedError):
        runs.run_study(study, ahead=("json",))
    assert asked == [("json",) if step is None else ()]


def test_forces_need_nothing_that_meshes_or_solves(tmp_path):
    code = "import sys; from fea.__main__ import call; call(['loads']); print(*sys.modules)"
    loaded = said(code, tmp_path).splitlines()[-1].split()
    assert "loads.dynamics" in loaded
    assert not {"skfem", "scipy", "vtkmodules", "fea.analysis.meshing", "importlib.metadata"} & set(loaded)


def test_leaving_does_not_search_the_libraries_for_garbage(tmp_path):
    code = (
        "import atexit, gc, sys; from fea.__main__ import main; sys.argv = ['fea', '--version']; "
        "atexit.register(lambda: print(gc.get_freeze_count() > 0)); main()"
    )
    assert said(code, tmp_path).endswith("True\n")
