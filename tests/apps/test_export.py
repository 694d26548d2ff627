"""Runs written for other programs: in again they give the same rod, and CalculiX the same displacement."""

import json
import re
import shutil
import subprocess
from dataclasses import replace

import gmsh
import h5py
import meshio
import numpy as np
import pytest
import pyvista as pv
from studies import ENGINE as RUNNING
from studies import PRESSED
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

from fea import run
from fea.apps.export_run import export_run, write_mesh
from fea.apps.result import analyse
from fea.output.inp import read_frd
from fea.output.stored_run import read_run
from fea.solid.assembly import volume_points
from fea.study.study import load_study, parse_study
from geometry.errors import InvalidValue
from geometry.session import session
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh, boundary_facets

pytestmark = pytest.mark.slow


MATERIAL = '[material]\npreset = "leon-2001"\n'
ENGINE = RUNNING + "[speed]\nrpm = 6000\n" + PRESSED
ROD = """
[rod]
length_mm = 141.0
big_end_bore_mm = 50.0
small_end_bore_mm = 24.0
shank_section = "rectangular"
[mesh]
size_mm = 20.0
"""
BUSHED = """
[rod]
length_mm = 141.0
big_end_bore_mm = 50.0
small_end_bore_mm = 24.0
shank_section = "rectangular"
bushing_mm = 2.0
[material]
preset = "leon-2001"
[material.bushing]
E_GPa = 110.0
nu = 0.34
density_kg_m3 = 8800.0
yield_MPa = 250.0
[forces]
pin_N = [20000.0, 0.0]
[mesh]
size_mm = 14.0
"""
AGREE = 1e-3


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """The folder of a coarse run of given forces and what its summary says."""
    folder = tmp_path_factory.mktemp("export")
    return folder / "run", run(parse_study(ROD + MATERIAL + ENGINE, "plain", folder), out=folder / "run")


def mesh_study_of(path):
    return parse_study(f'[rod]\nmesh = "{path.name}"\n' + MATERIAL + ENGINE, "mine", path.parent)


@pytest.mark.parametrize("suffix", [".inp", ".msh", ".med", ".xdmf", ".bdf"])
def test_a_run_out_and_in_again_is_the_same_rod(left, tmp_path, suffix):
    folder, summary = left
    file = tmp_path / f"rod{suffix}"
    export_run(folder, file)
    if suffix == ".bdf":
        assert file.read_bytes().count(b"\nCTETRA  ") == summary["model"]["elements"]
    again = analyse(mesh_study_of(file))
    assert again.trusted
    # Nastran's large fields hold twelve digits of each coordinate, which move bores by less than that.
    assert again.summary.rod.mass_kg == pytest.approx(summary["rod"]["mass_kg"], rel=1e-6)
    for name, case in summary["results"].items():
        found = again.summary.results[name].max_von_mises_MPa
        assert found == pytest.approx(case["max_von_mises_MPa"], rel=5e-3), name
    assert any("not refined" in str(note) for note in again.summary.notes)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_the_deck_runs_in_calculix_and_gives_the_same_displacement(left, tmp_path):
    folder, summary = left
    made = export_run(folder, tmp_path / "rod.inp")
    assert made.files == (tmp_path / "rod.inp",)
    names = list(summary["results"])
    ours = {name: meshio.read(folder / f"{name}.vtu") for name in names}
    mesh = ours[names[0]]
    subprocess.run(["ccx", "-i", "rod"], cwd=tmp_path, check=True, capture_output=True)
    steps = re.findall(r"^\*\* (\w+), crank angle", (tmp_path / "rod.inp").read_text(), re.MULTILINE)
    assert sorted(steps) == sorted(names)
    assert steps[-1] == "gas"  # which nothing but the pins load: no earlier load may stay
    tets = mesh.cells[0].data.astype(int)
    inside = np.setdiff1d(tets, boundary_facets(tets))
    assert inside.size > 100
    for number, name in enumerate(steps, start=1):
        u, s = (
            read_frd(tmp_path / "rod.frd", field, len(mesh.points), number) for field in ("DISP", "STRESS")
        )
        known = ours[name].point_data["displacement"]
        assert np.abs(u - known).max() < AGREE * np.abs(known).max(), name
        # On the surface ours is recovered with the known traction, inside as CalculiX does it.
        stress = ours[name].point_data["stress"][inside]
        off = np.sqrt(np.mean((s[inside] - stress) ** 2))
        assert off < AGREE * np.sqrt(np.mean(stress**2)), name


def test_parts_keep_their_materials(tmp_path):
    folder = tmp_path / "run"
    run(parse_study(BUSHED + PRESSED, "bushed", tmp_path), out=folder)
    export_run(folder, tmp_path / "rod.inp")
    text = (tmp_path / "rod.inp").read_text()
    assert "*SOLID SECTION, ELSET=E_BUSHING, MATERIAL=BUSHING" in text
    assert "110000,0.34" in text
    read = meshio.read(tmp_path / "rod.inp")
    counts = {name: len(sets[0]) for name, sets in read.cell_sets.items()}
    assert counts["E_ROD"] + counts["E_BUSHING"] == len(read.cells[0].data)
    assert set(read.point_sets) >= {
        surface.name for surface in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)
    }


def test_the_named_bores_are_in_a_gmsh_file(left, tmp_path):
    made = export_run(left[0], tmp_path / "rod.msh")
    read = meshio.read(tmp_path / "rod.msh")
    assert {"big_end_bore", "small_end_bore", "free", "rod"} <= set(read.field_data)
    assert read.point_data["tension_displacement"].shape == (len(read.points), 3)
    assert any("arrays of the elements" in str(note) for note in made.notes)


def test_the_surface_goes_to_stl(left, tmp_path):
    folder, _ = left
    made = export_run(folder, tmp_path / "rod.stl")
    assert (tmp_path / "rod.stl").read_bytes().count(b"facet normal") > 1000
    assert any("does not carry the solid elements" in str(note) for note in made.notes)


def refused(folder, file):
    with pytest.raises(InvalidValue) as caught:
        export_run(folder, file)
    return str(caught.value)


def exact_volume(mesh):
    """Volume by quadrature over the curved elements, mm³."""
    _, weights = volume_points(mesh)
    return float(weights.sum())


def read_by_gmsh(file):
    """What gmsh reads: signed volume of all tetrahedra, mm³, the least of them, names of the groups."""
    with session():
        gmsh.open(str(file))
        (kind,) = (kind for kind in gmsh.model.mesh.getElementTypes() if kind in {4, 11})
        places, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss4")
        _, determinants, _ = gmsh.model.mesh.getJacobians(kind, places)
        volumes = determinants.reshape(-1, len(weights)) @ weights
        groups = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
    return volumes.sum(), volumes.min(), groups


@pytest.mark.parametrize("suffix", [".med", ".msh", ".bdf"])
@pytest.mark.parametrize("order", [1, 2])
def test_gmsh_reads_solids_the_right_way_round(left, tmp_path, suffix, order):
    mesh = read_run(left[0]).mesh
    mesh = mesh if order == 2 else TetMesh(mesh.points, mesh.tets[:, :4])
    facets = boundary_facets(mesh.tets)
    file = tmp_path / f"rod{suffix}"
    write_mesh(file, replace(mesh, facets={Surface.FREE: facets}), {}, {})
    volume, least, groups = read_by_gmsh(file)
    exact = exact_volume(mesh)
    assert volume == pytest.approx(exact, rel=1e-9 if suffix != ".bdf" else 1e-7)
    assert least > 0
    assert groups == ({"free", "rod"} if suffix != ".bdf" else set())


def test_every_reader_finds_the_components_of_a_tensor(left, tmp_path):
    folder, _ = left
    known = read_run(folder).files["tension"].point["stress"]
    node = int(np.abs(known[:, 3:]).min(axis=1).argmax())  # all components count there
    xx, yy, zz, xy, yz, xz = known[node]
    whole = [xx, xy, xz, xy, yy, yz, xz, yz, zz]
    export_run(folder, tmp_path / "rod.xdmf")
    reader = vtkXdmfReader()
    reader.SetFileName(str(tmp_path / "rod.xdmf"))
    reader.Update()
    by_vtk = pv.wrap(reader.GetOutputDataObject(0))
    np.testing.assert_allclose(by_vtk.point_data["tension_stress"][node], whole, rtol=1e-6)
    export_run(folder, tmp_path / "rod.vtk")
    np.testing.assert_allclose(pv.read(tmp_path / "rod.vtk").point_data["tension_stress"][node], known[node])
    export_run(folder, tmp_path / "rod.msh")
    with session():
        gmsh.open(str(tmp_path / "rod.msh"))
        (view,) = (
            tag for tag in gmsh.view.getTags() if gmsh.view.option.getString(tag, "Name") == "tension_stress"
        )
        _, tags, values, *_ = gmsh.view.getModelData(view, 0)
    np.testing.assert_allclose(values[list(tags).index(node + 1)], whole, rtol=1e-6)
    export_run(folder, tmp_path / "rod.med")
    with h5py.File(tmp_path / "rod.med") as file:
        names, mesh = (file["CHA/tension_stress"].attrs[key] for key in ("NOM", "MAI"))
        # FreeCAD finds a mesh by the name of its file alone.
        assert [*file["ENS_MAA"]] == [*file["FAS"]] == [mesh.decode()] == ["rod"]
    assert names.decode().split() == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]


def test_nastran_reads_the_deck_as_a_whole_or_from_its_bulk_data_on(left, tmp_path):
    export_run(left[0], tmp_path / "rod.bdf")
    text = (tmp_path / "rod.bdf").read_text()
    assert re.search(r"^SOL 101\nCEND\nBEGIN BULK\nGRID", text, re.MULTILINE)
    assert text.rstrip().endswith("ENDDATA")


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_vtk_reads_a_closed_surface(left, tmp_path, suffix):
    folder, _ = left
    export_run(folder, tmp_path / f"rod{suffix}")
    surface = pv.read(tmp_path / f"rod{suffix}")
    assert surface.is_manifold
    flat = pv.read(folder / "tension.vtu").compute_cell_sizes()["Volume"].sum()  # VTK: with flat facets
    assert surface.volume == pytest.approx(flat, rel=1e-6)


def test_what_is_no_run_or_no_format_is_refused(left, tmp_path):
    folder, _ = left
    assert "must end in .inp or .vtu" in refused(folder, tmp_path / "rod.dwg")
    assert "is not a directory" in refused(tmp_path / "nowhere", tmp_path / "rod.inp")
    (tmp_path / "empty").mkdir()
    assert "has no readable summary.json" in refused(tmp_path / "empty", tmp_path / "rod.inp")
    assert "inside the folder of the run" in refused(folder, folder / "rod.inp")
    assert "directory that does not exist" in refused(folder, tmp_path / "nowhere" / "rod.inp")
    (tmp_path / "speeds" / "800rpm").mkdir(parents=True)
    shutil.copy(folder / "summary.json", tmp_path / "speeds" / "800rpm")
    assert "holds runs at several speeds: 800rpm" in refused(tmp_path / "speeds", tmp_path / "rod.inp")


def test_a_study_that_was_changed_since_the_run_is_refused(left, tmp_path):
    folder, _ = left
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    text = (other / "study.toml").read_text()
    (other / "study.toml").write_text(text.replace("piston_mass_kg = 1.3345", "piston_mass_kg = 1.2"))
    assert "but its study gives" in refused(other, tmp_path / "rod.inp")
    for case in json.loads((other / "summary.json").read_text())["results"]:
        (other / f"{case}.vtu").unlink()
    assert "has no fields of" in refused(other, tmp_path / "rod.msh")


def test_nothing_is_left_where_writing_fails(left, tmp_path, monkeypatch):
    folder, _ = left
    monkeypatch.setattr("meshio.gmsh.write", lambda *_, **__: (_ for _ in ()).throw(OSError(28, "No space")))
    with pytest.raises(Exception, match="could not be written"):
        export_run(folder, tmp_path / "rod.msh")
    assert list(tmp_path.iterdir()) == []


def test_a_mesh_from_a_file_takes_no_size_or_tolerance(left, tmp_path):
    folder, _ = left
    export_run(folder, tmp_path / "rod.inp")
    study = mesh_study_of(tmp_path / "rod.inp")
    for flags in ({"size": 5.0}, {"tolerance": 2.0}, {"symmetry": "half"}, {"element": "p1"}):
        with pytest.raises(InvalidValue, match="mesh"):
            analyse(study, **flags)
    assert load_study("leon-2001").tolerance_percent == 5.0
    assert study.tolerance_percent is None
