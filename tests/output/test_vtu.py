import itertools

import meshio
import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonDataModel import vtkQuadraticTetra

from fea.output.folder import StorageError
from fea.output.pictures.drawing import read_result
from fea.output.pictures.shown import chosen_field, point_arrays
from fea.output.stored_run import read_vtu
from fea.output.vtu import write_result, write_vtu
from mesh.tetmesh import EDGES, TetMesh

LENGTHS = np.array([3.0, 2.0, 1.0])


def box(n: int, order: int) -> TetMesh:
    """Each of n³ bricks as six tetrahedra along its diagonal."""
    grid = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    points = (
        np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        * LENGTHS
    )
    tets = []
    for corner in itertools.product(range(n), repeat=3):
        for permutation in itertools.permutations(range(3)):
            path = [np.array(corner)]
            for axis in permutation:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            tet = [grid[tuple(vertex)] for vertex in path]
            odd = np.linalg.det(np.diff(points[tet], axis=0)) < 0
            tets.append([tet[0], tet[2], tet[1], tet[3]] if odd else tet)
    tets = np.array(tets)
    if order == 1:
        return TetMesh(points, tets)
    ends = np.sort(tets[:, EDGES], axis=2)
    edges, number = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    return TetMesh(np.vstack([points, middles]), np.hstack([tets, len(points) + number.reshape(-1, 6)]))


def bent(mesh: TetMesh) -> TetMesh:
    """The box as a quarter of a ring of mean radius 4."""
    x, y, z = mesh.points.T
    angle, radius = x / 3.0 * np.pi / 2, 3.0 + y
    return TetMesh(np.stack([-radius * np.cos(angle), radius * np.sin(angle), z], axis=1), mesh.tets)


def curved_volume(grid: pyvista.UnstructuredGrid) -> float:
    """Volume by VTK's own shape functions and a rule exact for ten-node tetrahedra (det J is cubic)."""
    corners = grid.points[grid.cells_dict[pyvista.CellType.QUADRATIC_TETRA]].astype(float)
    total = 0.0
    for place, weight in [
        ((1 / 4, 1 / 4, 1 / 4), -4 / 5),
        *[(tuple(p), 9 / 20) for p in np.eye(4, 3) / 3 + 1 / 6],
    ]:
        derivatives = [0.0] * 30
        vtkQuadraticTetra().InterpolateDerivs(place, derivatives)
        jacobian = np.einsum("jn,eni->eij", np.reshape(derivatives, (3, 10)), corners)
        total += weight / 6 * np.linalg.det(jacobian).sum()
    return total


@pytest.fixture(scope="module")
def mesh() -> TetMesh:
    return bent(box(4, order=2))


def test_vtk_sees_the_volume_of_the_curved_mesh(mesh, tmp_path):
    write_vtu(tmp_path / "a.vtu", mesh, {})
    grid = pyvista.read(tmp_path / "a.vtu")
    exact = np.pi / 4 * (5**2 - 3**2)
    assert curved_volume(grid) == pytest.approx(exact, rel=1e-4)  # the parabolas miss the arcs by 5e-5
    # VTK's filter cuts each element into eight straight ones; swapped nodes would leave it a quarter.
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(exact, rel=1e-2)


@pytest.mark.parametrize("order", [1, 2])
def test_a_linear_displacement_and_its_gradient_are_exact_through_vtk(tmp_path, order):
    mesh = bent(box(2, order))
    slope = np.array([[1.0, 2.0, -3.0], [0.5, -1.0, 4.0], [7.0, 0.25, 2.0]])
    write_vtu(tmp_path / "a.vtu", mesh, {"displacement": mesh.points @ slope.T})
    grid = pyvista.read(tmp_path / "a.vtu")
    np.testing.assert_array_equal(grid["displacement"], mesh.points @ slope.T)
    gradient = grid.compute_derivative("displacement")["gradient"].reshape(-1, 3, 3)
    np.testing.assert_allclose(gradient, np.broadcast_to(slope, gradient.shape), rtol=1e-10)


def results(mesh: TetMesh) -> tuple[dict, dict]:
    numbers = np.random.default_rng(0)
    point_data = {name: numbers.normal(size=len(mesh.points)) for name in ("von_mises", "safety_factor")}
    point_data["stress"] = numbers.normal(size=(len(mesh.points), 6))
    cell_data = {"safety_factor": numbers.normal(size=len(mesh.tets))}
    return point_data, cell_data


def test_the_components_of_stress_have_names(mesh, tmp_path):
    write_vtu(tmp_path / "a.vtu", mesh, *results(mesh))
    array = pyvista.read(tmp_path / "a.vtu").GetPointData().GetArray("stress")
    assert [array.GetComponentName(k) for k in range(6)] == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]


@pytest.mark.parametrize(("order", "kind"), [(1, "tetra"), (2, "tetra10")])
def test_meshio_and_pyvista_read_everything_back(tmp_path, order, kind):
    mesh = box(2, order)
    point_data, cell_data = results(mesh)
    write_vtu(tmp_path / "a.vtu", mesh, point_data, cell_data)
    by_meshio, by_pyvista = meshio.read(tmp_path / "a.vtu"), pyvista.read(tmp_path / "a.vtu")
    assert by_meshio.cells[0].type == kind
    np.testing.assert_array_equal(by_meshio.cells[0].data, mesh.tets)
    np.testing.assert_array_equal(by_meshio.points, mesh.points)
    np.testing.assert_array_equal(by_pyvista.points, mesh.points)
    for name, values in point_data.items():
        np.testing.assert_array_equal(by_meshio.point_data[name], values)
        np.testing.assert_array_equal(by_pyvista.point_data[name], values)
    np.testing.assert_array_equal(by_meshio.cell_data["safety_factor"][0], cell_data["safety_factor"])
    np.testing.assert_array_equal(by_pyvista.cell_data["safety_factor"], cell_data["safety_factor"])


@pytest.mark.parametrize(("exact", "most"), [(True, 1e-9), (False, 6.2e-5)])
def test_a_result_is_a_third_as_large_and_right_within_its_error_bars(tmp_path, exact, most):
    mesh = bent(box(8, order=2))
    points, cells = results(mesh)
    points["von_mises"] = np.linalg.norm(points["stress"], axis=1)
    points["principal_1"] = points["stress"].max(axis=1)
    points["displacement"] = mesh.points @ np.array([[1e-4, 2e-4, -3e-4], [0.0, 1e-4, 0.0], [1e-5, 0, 2e-4]])
    write_result(tmp_path / "small.vtu", mesh, points, cells, exact=exact)
    read, grid = meshio.read(tmp_path / "small.vtu"), pyvista.read(tmp_path / "small.vtu")
    raw = sum(array.nbytes for array in (mesh.points, *points.values(), *cells.values())) + mesh.tets.size * 4
    assert (tmp_path / "small.vtu").stat().st_size < (0.47 if exact else 0.39) * raw  # of random stresses
    np.testing.assert_allclose(read.points, mesh.points, rtol=0, atol=most)
    np.testing.assert_array_equal(read.points, grid.points)
    order = np.argsort(mesh.tets.min(axis=1), kind="stable")
    np.testing.assert_array_equal(read.cells[0].data, mesh.tets[order])
    np.testing.assert_allclose(
        read.point_data["displacement"], points["displacement"], rtol=1.1e-6, atol=1e-18
    )
    np.testing.assert_allclose(read.point_data["von_mises"], points["von_mises"], rtol=1e-7)
    for name in ("stress", "von_mises", "principal_1"):
        wrong = abs(read.point_data[name] - points[name]).reshape(len(mesh.points), -1).max(axis=1)
        assert (wrong / points["von_mises"]).max() < 2.5e-4
        np.testing.assert_array_equal(read.point_data[name], grid.point_data[name])
    np.testing.assert_allclose(read.cell_data["safety_factor"][0], cells["safety_factor"][order], rtol=2.5e-4)


def test_the_same_results_give_the_same_bytes(mesh, tmp_path):
    for name in ("a.vtu", "b.vtu"):
        write_vtu(tmp_path / name, mesh, *results(mesh))
    assert (tmp_path / "a.vtu").read_bytes() == (tmp_path / "b.vtu").read_bytes()


def test_the_sign_of_a_zero_does_not_change_the_bytes(mesh, tmp_path):
    """It is that of rounding errors, which differ between one thread and two."""
    ones, zeros = np.ones(len(mesh.points)), np.zeros(len(mesh.points))
    for name, zero in (("plus", zeros), ("minus", -zeros)):
        moved = np.stack([ones, zero, zero], axis=1)
        points = {"displacement": moved, "von_mises": ones, "principal_2": zero}
        write_result(tmp_path / name, mesh, points, exact=True)
    assert (tmp_path / "plus").read_bytes() == (tmp_path / "minus").read_bytes()


def test_an_array_of_the_wrong_shape_is_an_error(mesh, tmp_path):
    with pytest.raises(ValueError, match=r"von_mises has shape \(3,\): it must have \d+ rows"):
        write_vtu(tmp_path / "a.vtu", mesh, {"von_mises": np.zeros(3)})
    with pytest.raises(ValueError, match="its components are XX YY ZZ XY YZ XZ"):
        write_vtu(tmp_path / "a.vtu", mesh, {"stress": np.zeros((len(mesh.points), 3))})


def test_a_disk_that_refuses_is_an_error_without_noise(mesh, tmp_path, capfd):
    with pytest.raises(StorageError, match="could not be written"):
        write_vtu(tmp_path / "missing" / "a.vtu", mesh, {})
    assert capfd.readouterr() == ("", "")


def test_files_of_older_versions_are_read_by_the_names_of_today(mesh, tmp_path):
    points = {name: np.full(len(mesh.points), k) for k, name in enumerate(("von_mises", "safety_factor"), 1)}
    cells = {name: np.full(len(mesh.tets), k) for k, name in enumerate(("von_mises", "safety_factor"), 3)}
    file = tmp_path / "old.vtu"
    write_vtu(file, mesh, points, cells)
    read = read_vtu(file)
    assert {name: values[0] for name, values in read.point.items()} == {
        "von_mises": 1,
        "safety_factor_node": 2,
    }
    assert {name: values[0] for name, values in read.cell.items()} == {"von_mises_max": 3, "safety_factor": 4}
    assert chosen_field("safety_factor", point_arrays(file), file.name) == "safety_factor_node"
    assert read_result(file)[2].keys() == {"von_mises", "safety_factor_node"}
