import shutil
import subprocess

import meshio
import numpy as np
import pytest

from fea.base.material import Material
from fea.output.folder import StorageError
from fea.output.inp import write_inp
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, TetMesh

STEEL = Material(207e3, 0.28, 7.7e-9, 620.0)
CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 4]])


def tetrahedron(order: int) -> TetMesh:
    points = CORNERS
    if order == 2:
        points = np.vstack([points, [(CORNERS[a] + CORNERS[b]) / 2 for a, b in EDGES]])
        points[4, 1] += 0.1  # a curved edge
    base = np.array([[0, 2, 1]]) if order == 1 else np.array([[0, 2, 1, 6, 5, 4]])
    return TetMesh(points, np.arange(len(points))[None], {Surface.BIG_END_BORE: base})


def restrained(mesh: TetMesh) -> np.ndarray:
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[0] = fixed[1, 1:] = fixed[2, 2] = True
    return fixed


def written(tmp_path, mesh: TetMesh, forces: np.ndarray):
    write_inp(tmp_path / "a.inp", mesh, STEEL, forces, restrained(mesh))
    return (tmp_path / "a.inp").read_text().splitlines()


def block(lines: list[str], keyword: str) -> list[str]:
    start = next(k for k, line in enumerate(lines) if line.startswith(keyword)) + 1
    end = next(k for k, line in enumerate(lines) if k >= start and line.startswith("*"))
    return lines[start:end]


@pytest.mark.parametrize(("order", "kind"), [(1, "tetra"), (2, "tetra10")])
def test_another_program_reads_the_mesh_back(tmp_path, order, kind):
    mesh = tetrahedron(order)
    written(tmp_path, mesh, np.zeros_like(mesh.points))
    read = meshio.read(tmp_path / "a.inp")
    assert read.cells[0].type == kind
    np.testing.assert_allclose(read.points, mesh.points, rtol=1e-12)
    np.testing.assert_array_equal(read.cells[0].data, mesh.tets)
    np.testing.assert_array_equal(
        read.point_sets["BIG_END_BORE"], np.unique(mesh.facets[Surface.BIG_END_BORE])
    )


def test_forces_restraints_and_material_stand_in_the_deck(tmp_path):
    mesh = tetrahedron(2)
    forces = np.zeros_like(mesh.points)
    forces[5, 1], forces[9, 2] = -1 / 3, 1e-7
    lines = written(tmp_path, mesh, forces)
    assert block(lines, "*BOUNDARY") == ["1,1,1", "1,2,2", "1,3,3", "2,2,2", "2,3,3", "3,3,3"]
    assert block(lines, "*CLOAD") == ["6,2,-3.333333333333e-01", "10,3,1.000000000000e-07"]
    assert block(lines, "*ELASTIC") == ["207000,0.28"]
    assert block(lines, "*DENSITY") == ["7.7e-09"]
    assert block(lines, "*HEADING")[0] == "static load case"
    assert max(len(number) for line in lines if line[0] != "*" for number in line.split(",")) <= 20


def test_a_case_without_loads_or_supports_has_no_empty_blocks(tmp_path):
    mesh = tetrahedron(1)
    nothing = np.zeros_like(mesh.points)
    write_inp(tmp_path / "a.inp", mesh, STEEL, nothing, nothing.astype(bool))
    text = (tmp_path / "a.inp").read_text()
    assert "*CLOAD" not in text
    assert "*BOUNDARY" not in text


def test_arrays_of_another_mesh_are_refused(tmp_path):
    mesh = tetrahedron(1)
    with pytest.raises(ValueError, match=r"forces has shape \(3, 3\): it must have \(4, 3\)"):
        write_inp(tmp_path / "a.inp", mesh, STEEL, np.zeros((3, 3)), restrained(mesh))


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    mesh = tetrahedron(1)
    with pytest.raises(StorageError, match="nowhere"):
        write_inp(tmp_path / "nowhere" / "a.inp", mesh, STEEL, np.zeros_like(mesh.points), restrained(mesh))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_stretches_a_tetrahedron_as_hooke_does(tmp_path):
    # Forces of a uniform stress σ_xx: each face's traction, shared by its nodes as the shape functions say.
    mesh, stress = tetrahedron(1), 100.0
    areas = {1: -3 * 4 / 2, 0: 3 * 4 / 2}  # x components of the faces opposite vertices 1 and 0
    forces = np.zeros_like(mesh.points)
    for opposite, area in areas.items():
        forces[np.arange(4) != opposite, 0] += stress * area / 3
    written(tmp_path, mesh, forces)
    subprocess.run(["ccx", "-i", "a"], cwd=tmp_path, check=True, capture_output=True)
    frd = (tmp_path / "a.frd").read_text().splitlines()
    start = next(k for k, line in enumerate(frd) if "DISP" in line)
    rows = [line for line in frd[start:] if line.startswith(" -1")][:4]
    found = np.array([[float(row[13 + 12 * k : 25 + 12 * k]) for k in range(3)] for row in rows])
    strain = stress / STEEL.youngs_modulus * np.array([1, -0.28, -0.28])
    np.testing.assert_allclose(found, mesh.points * strain, atol=1e-5 * np.abs(mesh.points * strain).max())
