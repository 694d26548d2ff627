"""The bridge to scikit-fem, and the kernels against the weak forms on the same quadrature."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from skfem import BilinearForm, CellBasis, MeshTet, MeshTet2
from skfem.helpers import ddot, dot, eye, grad, sym_grad, trace
from strap import LENGTH, strap, tilted_load
from studies import plain_study

import fea
from fea.analysis.pipeline import prepare, solve_speed
from fea.base.choices import MatrixAssembly, SolverName, Support
from fea.base.material import Material, Materials
from fea.solid import scikit_fem as forms
from fea.solid.assembly import GeometricStiffness, pattern, stiffness
from fea.solid.inertia import inertia, mass_matrix
from fea.solid.parity import Parity
from fea.solid.scikit_fem import assembled_stiffness, basis, stiffness_coo, to_skfem
from fea.solid.traction import body_forces, thermal_forces, traction_forces
from fea.solvers.mixed import MixedModel
from fea.solvers.static import Model
from fea.study.flags import Flags
from fea.study.study import load_study, parse_study
from geometry.errors import InvalidValue
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

STEEL, BRONZE = Material(207e3, 0.28, 7.7e-9, 620.4), Material(110e3, 0.34, 8.8e-9, 250.0)
VOLUME_DEGREE, TRACTION_DEGREE = 5, 6
GEOMETRIC_DEGREE = {1: 0, 2: 3}


def two_parts(mesh: TetMesh) -> TetMesh:
    return replace(mesh, part=(mesh.points[mesh.tets, 0].mean(axis=1) > LENGTH / 2).astype(int))


def shuffled(mesh: TetMesh) -> TetMesh:
    """The mesh with its nodes in any order."""
    order = np.random.default_rng(0).permutation(len(mesh.points))
    number = np.argsort(order)
    facets = {surface: number[nodes] for surface, nodes in mesh.facets.items()}
    return replace(mesh, points=mesh.points[order], tets=number[mesh.tets], facets=facets)


@pytest.fixture(scope="module", params=[1, 2])
def mesh(request):
    return two_parts(strap(size=6.0, order=request.param))


@pytest.fixture(scope="module")
def materials(mesh):
    return Materials((STEEL, BRONZE), mesh.part)


@pytest.fixture
def without_kernel(monkeypatch):
    """A context without the kernel of the stiffness."""

    @contextmanager
    def context():
        with monkeypatch.context() as patch:
            patch.delattr("fea.solvers.static.stiffness")
            yield

    return context


def close(found, expected, rel=1e-12):
    assert np.abs(found - expected).max() <= rel * np.abs(expected).max()


# -- the mesh --


def test_numbers_are_the_same_and_curved_edges_stay(mesh):
    theirs, nodes = to_skfem(mesh)
    assert type(theirs) is (MeshTet if mesh.order == 1 else MeshTet2)
    np.testing.assert_array_equal(nodes, np.arange(len(mesh.points)))
    np.testing.assert_array_equal(theirs.doflocs.T, mesh.points)
    np.testing.assert_array_equal(theirs.dofs.element_dofs.T, mesh.tets)


def test_a_mesh_numbered_otherwise_is_told_apart(mesh):
    other = shuffled(mesh)
    theirs, nodes = to_skfem(other)
    np.testing.assert_array_equal(theirs.doflocs.T, other.points[nodes])
    np.testing.assert_array_equal(nodes[theirs.dofs.element_dofs.T], other.tets)


@pytest.mark.parametrize("kind", [lambda mesh: mesh, shuffled])
def test_surfaces_and_parts_keep_their_names(mesh, kind):
    mesh = kind(mesh)
    theirs, nodes = to_skfem(mesh, ("rod", "bushing"))
    assert set(theirs.boundaries) == {str(surface) for surface in mesh.facets}
    for surface, facets in mesh.facets.items():
        found = np.sort(nodes[theirs.facets[:, theirs.boundaries[str(surface)]].T], axis=1)
        np.testing.assert_array_equal(found, np.sort(facets[:, :3], axis=1))
    for name, part in (("rod", 0), ("bushing", 1)):
        np.testing.assert_array_equal(theirs.subdomains[name], np.flatnonzero(mesh.part == part))
    assert list(to_skfem(mesh).mesh.subdomains) == ["part 0", "part 1"]
    assert list(to_skfem(replace(mesh, part=None)).mesh.subdomains) == ["part 0"]


def test_what_scikit_fem_cannot_hold_is_refused(mesh):
    with pytest.raises(InvalidValue, match="must name each of the 2 parts"):
        to_skfem(mesh, ("rod",))
    astray = {Surface.FREE: mesh.tets[:1, [0, 1, 1]]}
    with pytest.raises(ValueError, match="no element has"):
        to_skfem(replace(mesh, facets=astray))


def test_two_edges_between_the_same_vertices_are_refused():
    mesh = strap(size=8.0)
    (first, *_), middle = np.nonzero(mesh.tets == mesh.tets.max()), len(mesh.points)
    tets = mesh.tets.copy()
    tets[first[0]][tets[first[0]] == tets.max()] = middle  # one element has a node of its own amid an edge
    with pytest.raises(ValueError, match="one edge per pair"):
        to_skfem(TetMesh(np.vstack([mesh.points, mesh.points[-1:]]), tets))


def test_facets_find_their_points_far_from_the_origin():
    mesh = strap()
    away = replace(mesh, points=mesh.points + np.array([1e5, 0.0, 0.0]))
    bore = basis(away).boundary("small_end_bore")
    area = forms.traction(lambda _, n: n).assemble(bore).reshape(-1, 3)
    close(area, traction_forces(mesh, Surface.SMALL_END_BORE, lambda _, n: n), rel=1e-9)


# -- kernels against forms --


def test_stiffness(mesh, materials):
    K = stiffness(mesh, materials, pattern(mesh.tets, len(mesh.points))).full()
    close(K, forms.elasticity(materials).assemble(basis(mesh)))
    close(stiffness_coo(mesh, materials).tocsr(), K)


def test_elements(mesh, materials):
    ours, theirs = stiffness_coo(mesh, materials), forms.elasticity(materials).coo_data(basis(mesh))
    np.testing.assert_array_equal(ours.indices, theirs.indices)
    assert ours.shape == theirs.shape
    close(ours.tolocal(), theirs.tolocal())


def test_traction(mesh):
    bore = basis(mesh).boundary("big_end_bore", intorder=TRACTION_DEGREE)
    form = forms.traction(lambda x, n: np.stack([x[1] * n[0], n[1], x[0] + n[2]]))
    found = traction_forces(
        mesh,
        Surface.BIG_END_BORE,
        lambda p, n: np.stack([p[:, 1] * n[:, 0], n[:, 1], p[:, 0] + n[:, 2]], axis=1),
    )
    close(found, form.assemble(bore).reshape(-1, 3))


def test_body_force(mesh):
    expected = forms.body_force(lambda x: x**2).assemble(basis(mesh, VOLUME_DEGREE)).reshape(-1, 3)
    close(body_forces(mesh, lambda places: places**2), expected)
    other = shuffled(mesh)
    there = np.lexsort(other.points.T)[np.argsort(np.lexsort(mesh.points.T))]
    close(body_forces(other, lambda places: places**2)[there], expected)


def test_mass(mesh, materials):
    expected = forms.mass(materials.density).assemble(basis(mesh, VOLUME_DEGREE))
    close(mass_matrix(mesh, materials.density).full(), expected)


def test_thermal_strain(mesh):
    form = forms.thermal_strain(STEEL, 1.2e-5, lambda x: 20.0 + x[0])
    expected = form.assemble(basis(mesh, VOLUME_DEGREE)).reshape(-1, 3)
    close(thermal_forces(mesh, STEEL, 1.2e-5, lambda places: 20.0 + places[:, 0]), expected)


def test_geometric_stiffness(mesh, materials):
    u = np.random.default_rng(0).standard_normal(mesh.points.shape) * 1e-3
    (found,) = GeometricStiffness(mesh, materials)(u[..., None])
    bases = basis(mesh, GEOMETRIC_DEGREE[mesh.order])
    constants = materials.of(slice(None))
    lam, mu = (np.reshape(value, (-1, 1)) for value in (constants.lame_lambda, constants.shear_modulus))

    def form(u, v, w):  # ∫ ∇u σ₀ : ∇v dV with σ₀ = σ(u₀)
        strain = sym_grad(w.initial)
        stress = lam * eye(trace(strain), 3) + 2 * mu * strain
        return ddot(np.einsum("ij...,jk...->ik...", grad(u), stress), grad(v))

    expected = BilinearForm(form).assemble(bases, initial=u.ravel())
    close(sparse.kron(found, np.eye(3)), expected)


def test_weights_of_inertia(mesh, materials):
    ours, (bridged, nodes) = inertia(mesh, materials.density), to_skfem(mesh)
    scalars = CellBasis(bridged, bridged.elem(), intorder=VOLUME_DEGREE)
    fields = [lambda x: np.ones_like(x[0]), *((lambda x, axis=axis: x[axis]) for axis in range(3))]
    expected = np.stack(
        [forms.moment(materials.density, field).assemble(scalars) for field in fields], axis=1
    )
    close(np.column_stack([ours.weight, ours.moments])[nodes], expected)


# -- a form of one's own --


def test_a_foundation_adds_to_the_stiffness(mesh, materials):
    cells = basis(mesh)
    foundation = BilinearForm(lambda u, v, _: 50.0 * dot(u, v)).coo_data(cells.boundary("small_end_bore"))
    both = (stiffness_coo(mesh, materials) + foundation).tocsr()
    everything = forms.elasticity(materials).assemble(cells) + foundation.tocsr()
    close(both, everything)
    bore = mesh.facets[Surface.SMALL_END_BORE]
    on = np.isin(np.arange(3 * len(mesh.points)) // 3, bore)
    added = np.abs(both - stiffness_coo(mesh, materials).tocsr()).sum(axis=1)
    np.testing.assert_array_equal(np.asarray(added).ravel() > 1e-9 * added.max(), on)


def test_the_package_offers_it_all():
    offered = fea.to_skfem, fea.basis, fea.stiffness_coo
    assert [each.__wrapped__ for each in offered] == [to_skfem, basis, stiffness_coo]
    with pytest.raises(AttributeError, match="no attribute 'bases'"):
        _ = fea.bases


# -- everything by scikit-fem --


@pytest.mark.parametrize("kind", [lambda mesh: mesh, shuffled])
def test_the_matrix_that_is_solved(mesh, kind):
    mesh = kind(mesh)
    expected = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    close(assembled_stiffness(mesh, STEEL).full(), expected.full())


@pytest.mark.parametrize("solver", [SolverName.AUTO, SolverName.AMG])
def test_every_solver_takes_it(solver, without_kernel):
    mesh = strap(size=6.0)
    load = [tilted_load(mesh)]
    ours = Model(mesh, STEEL, Support.CLAMPED, solver).solve(load)
    with without_kernel():
        theirs = Model(mesh, STEEL, Support.CLAMPED, solver, assembly=MatrixAssembly.SCIKIT_FEM).solve(load)
    for parity in Parity:
        close(theirs.displacement[parity], ours.displacement[parity], rel=1e-9)


def test_parts_with_a_pressure_take_it(without_kernel):
    mesh = two_parts(strap(size=6.0))
    materials = [STEEL, replace(BRONZE, poissons_ratio=0.49)]
    load = [tilted_load(mesh)]
    ours = MixedModel(mesh, materials, [1], Support.CLAMPED).solve(load)
    with without_kernel():
        model = MixedModel(mesh, materials, [1], Support.CLAMPED, assembly=MatrixAssembly.SCIKIT_FEM)
    theirs = model.solve(load)
    for parity in Parity:
        close(theirs.displacement[parity], ours.displacement[parity], rel=1e-9)


def test_a_study_may_ask_for_it():
    asked = Flags(assembly=MatrixAssembly.SCIKIT_FEM).applied(load_study())
    again = parse_study(asked.text(), "again", asked.folder)
    assert asked.analysis.matrix_assembly is again.analysis.matrix_assembly is MatrixAssembly.SCIKIT_FEM
    with pytest.raises(InvalidValue, match=r"analysis.matrix_assembly.*Choose from batched, scikit-fem"):
        parse_study(asked.text().replace("scikit-fem", "by-hand"), "again", asked.folder)


def test_a_run_finds_the_same_stress(without_kernel):
    study = plain_study()
    study = replace(study, mesh=replace(study.mesh, size_mm=14.0))
    ours = solve_speed(prepare(study), 6000.0)
    with without_kernel():
        asked = Flags(assembly=MatrixAssembly.SCIKIT_FEM).applied(study)
        theirs = solve_speed(prepare(asked), 6000.0)
    for one, other in zip(ours.cases.values(), theirs.cases.values(), strict=True):
        close(other.stress, one.stress, rel=1e-10)
        close(other.displacement, one.displacement, rel=1e-10)
    assert theirs.trusted == ours.trusted
