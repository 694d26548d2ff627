"""Displacement and pressure of nearly incompressible parts: rates, exact solutions, parities, runs."""

import json
from dataclasses import replace

import numpy as np
import pytest
from incompressible_cube import errors
from scipy import sparse
from strap import strap, tilted_load, without_rigid_motion

from fea import run
from fea.__main__ import call
from fea.base.choices import SolverName, Support
from fea.base.material import Material, Materials
from fea.solid.assembly import pattern, stiffness, stress_from_gradient
from fea.solid.errors import StagnationError
from fea.solid.parity import Parity
from fea.solid.recovery import Recovery
from fea.solid.supports import determinate_restraints
from fea.solid.traction import traction_forces
from fea.solvers import iterative
from fea.solvers.mixed import MixedModel, pressure_space
from fea.solvers.static import Model
from fea.verify.body import LoadedBody
from fea.verify.cases.elasticity import lame_body, lame_exact, shaken
from fea.verify.stability.outcome import solved_by
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import refined, reflect, unmirrored

pytestmark = pytest.mark.slow


RUBBER = Material(6.0, 0.4999, 1.1e-9, 10.0)
RELIEF = Support.INERTIA_RELIEF


def test_the_rates_of_the_pair():
    """Order three in displacement and two in pressure, L2 (Boffi, Brezzi & Fortin 2013, section 8.8)."""
    coarse = mesh_body(block(1.0, 1.0, 1.0), 0.22)
    (u0, p0), (u1, p1) = (errors(mesh, RUBBER) for mesh in (coarse, refined(coarse)))
    assert np.log2(u0 / u1) == pytest.approx(3, abs=0.1)
    assert np.log2(p0 / p1) > 1.9


def test_the_patch_test_at_0_4999():
    mesh = shaken(mesh_body(block(1.0, 1.0, 1.0), 0.4), 0.02)
    gradient = 1e-3 * np.array([[1.0, 0.4, -0.3], [0.2, -0.7, 0.5], [-0.6, 0.1, -0.3]])
    gradient += np.eye(3) * 0.5 * RUBBER.shear_modulus / RUBBER.lame_lambda * 1e-3
    stress = stress_from_gradient(gradient, RUBBER)
    xx, yy, zz, xy, yz, xz = stress
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    forces = traction_forces(mesh, Surface.FREE, lambda _, normals: normals @ tensor)
    held = LoadedBody(mesh, RUBBER, forces, determinate_restraints(mesh))
    pair = solved_by("p2/p1", held, RUBBER)
    linear = mesh.points @ gradient.T
    u = without_rigid_motion(mesh.points, pair.displacement)
    expected = without_rigid_motion(mesh.points, linear)
    assert u == pytest.approx(expected, abs=1e-10 * np.abs(linear).max())
    p = RUBBER.lame_lambda * np.trace(gradient)
    assert pair.pressure == pytest.approx(p, rel=1e-9)
    found = Recovery(mesh).nodal_stress(pair.displacement[:, :, None], RUBBER, pressure=pair.pressure)
    assert found[..., 0] == pytest.approx(np.tile(stress, (len(u), 1)), abs=1e-9 * np.abs(stress).max())


@pytest.mark.parametrize("nu", [0.3, 0.499999])
def test_lame_whatever_poissons_ratio(nu):
    """0.03 % of the widening and 1 % of the hoop stress, at the worst node: what size 1.2 leaves at any ν."""
    body = lame_body(1.2)
    material = replace(body.material, poissons_ratio=nu)
    pair = solved_by("p2/p1", body, material)
    u, stress = lame_exact(body.mesh.points, material)
    assert pair.displacement == pytest.approx(u, abs=3e-4 * np.abs(u).max())
    planes = (Surface.SYMMETRY_X, Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)
    found = Recovery(body.mesh, planes, body.known).nodal_stress(
        pair.displacement[:, :, None], material, traction=body.traction, pressure=pair.pressure
    )
    assert found[..., 0] == pytest.approx(stress, abs=1e-2 * np.abs(stress).max())


def test_nodal_pressure_is_linear_and_keeps_to_its_part():
    cube = mesh_body(block(1.0, 1.0, 1.0), 0.4)
    part = (cube.points[cube.tets[:, :4], 0].mean(axis=1) > 0.5).astype(np.int64)
    space = pressure_space(replace(cube, part=part), {1: RUBBER})
    x, y, z = cube.points.T
    linear = (1 + x - 2 * y + 3 * z)[:, None]
    own = np.unique(cube.tets[part == 1])
    expected = np.zeros_like(linear)
    expected[own] = linear[own]
    assert space.nodal(linear[space.vertex[0]])[1] == pytest.approx(expected, abs=1e-12)


def test_the_pair_agrees_with_plain_elements_where_these_are_good():
    steel = replace(RUBBER, poissons_ratio=0.3)
    mesh = strap()
    load = [tilted_load(mesh)]
    plain, mixed = Model(mesh, steel, RELIEF).solve(load), MixedModel(mesh, [steel], [0], RELIEF).solve(load)
    for parity, u in plain.displacement.items():
        off = np.abs(mixed.displacement[parity] - u).max() / np.abs(u).max()
        assert 1e-6 < off < 5e-3  # another discretisation of the same body


def test_the_steps_solve_the_indefinite_equations():
    mesh = strap()
    load = tilted_load(mesh)
    solution = MixedModel(mesh, [RUBBER], [0], Support.CLAMPED).solve([load])
    fixed = _fixed(mesh)
    A = stiffness(mesh, RUBBER.without_lambda(), pattern(mesh.tets, len(mesh.points))).constrained(fixed)
    space = pressure_space(mesh, {0: RUBBER})
    D = space.divergence @ sparse.diags_array((~fixed).astype(float))
    C = space.mass / RUBBER.lame_lambda
    whole = sparse.csc_array(sparse.block_array([[A.full(), D.T], [D, -C]]))
    right = np.r_[np.where(fixed, 0.0, load.symmetric.ravel()), np.zeros(C.shape[0])]
    direct = sparse.linalg.splu(whole).solve(right)
    u = solution.displacement[Parity.SYMMETRIC].ravel()
    assert u == pytest.approx(direct[: u.size], abs=1e-10 * np.abs(u).max())
    p = solution.pressure[Parity.SYMMETRIC][0][space.vertex[0], 0]
    assert p == pytest.approx(direct[u.size :], abs=1e-9 * np.abs(p).max())
    assert solution.residuals[Parity.SYMMETRIC].backward_error < 1e-13
    assert solution.residuals[Parity.SYMMETRIC].energy < 1e-9


def _fixed(mesh):
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    fixed[mesh.facets[Surface.BIG_END_BORE].ravel()] = True
    fixed[mesh.facets[Surface.SYMMETRY_Y].ravel(), 1] = True
    fixed[mesh.facets[Surface.SYMMETRY_Z].ravel(), 2] = True
    return fixed.ravel()


@pytest.mark.parametrize("support", list(Support))
def test_the_quarter_equals_the_whole(support):
    quarter = unmirrored(strap())
    half = reflect(quarter, Surface.SYMMETRY_Y)
    whole = reflect(half, Surface.SYMMETRY_Z)
    some = MixedModel(quarter.mesh, [RUBBER], [0], support).solve([tilted_load(quarter.mesh)])
    every = MixedModel(whole.mesh, [RUBBER], [0], support).solve([tilted_load(whole.mesh)])
    u = [
        without_rigid_motion(whole.mesh.points, field)
        for field in (
            whole.vector(*(some.displacement[parity] for parity in Parity)),
            every.displacement[Parity.SYMMETRIC],
        )
    ]
    assert u[0] == pytest.approx(u[1], abs=1e-9 * np.abs(u[1]).max())
    even, odd = (some.pressure[parity][0][whole.source] for parity in Parity)
    p = every.pressure[Parity.SYMMETRIC][0]
    assert even + whole.sign[:, 1, None] * odd == pytest.approx(p, abs=1e-8 * np.abs(p).max())
    assert max(found.reaction for found in some.residuals.values()) < (1e-4 if support is RELIEF else np.inf)


def test_a_pressure_where_it_is_needed_is_as_good_as_one_everywhere():
    cell = strap()
    part = (cell.points[cell.tets[:, :4], 0].mean(axis=1) > 55).astype(np.int64)
    mesh = replace(cell, part=part)
    materials = [Material(207e3, 0.3, 7.7e-9, 600.0), replace(RUBBER, youngs_modulus=2e3)]
    load = [tilted_load(mesh)]
    one, both = (MixedModel(mesh, materials, soft, RELIEF).solve(load) for soft in ([1], [0, 1]))
    assert set(one.pressure[Parity.SYMMETRIC]) == {1}
    for parity in Parity:
        p, q = (found.pressure[parity][1] for found in (one, both))
        away = np.setdiff1d(np.arange(len(mesh.points)), mesh.tets[part == 1])
        assert not p[away].any()
        assert p == pytest.approx(q, abs=0.05 * np.abs(q).max())


def test_multigrid_solves_for_pressure_too():
    mesh = strap()
    load = [tilted_load(mesh)]
    direct, multigrid = (
        MixedModel(mesh, [RUBBER], [0], RELIEF, solver=solver).solve(load)
        for solver in (SolverName.AUTO, SolverName.AMG)
    )
    for parity, u in direct.displacement.items():
        assert multigrid.displacement[parity] == pytest.approx(u, abs=1e-7 * np.abs(u).max())
        assert multigrid.residuals[parity].backward_error < 1e-12


def test_a_pressure_that_does_not_settle_is_refused(monkeypatch):
    monkeypatch.setattr(iterative, "MOST_ITERATIONS", 3)
    mesh = strap()
    with pytest.raises(StagnationError, match=r"after 3 steps.*--size"):
        MixedModel(mesh, [RUBBER], [0], RELIEF).solve([tilted_load(mesh)])


STUDY = (
    '[rod]\npreset = "leon-2001"\nshank_section = "rectangular"\n'
    '[material]\npreset = "leon-2001"\nnu = {nu}\n[engine]\nstroke_mm = 94.0\n'
)
ENGINE = "bore_mm = 76.0\npiston_mass_kg = 1.3345\ngas = 'leon-2001'\n[speed]\nrpm = 6000\n"


def test_a_run_of_a_nearly_incompressible_rod(tmp_path, capsys):
    found = {}
    for nu in (0.4, 0.4999):
        (tmp_path / "s.toml").write_text(STUDY.format(nu=nu) + ENGINE)
        arguments = ["run", str(tmp_path / "s.toml"), "--size", "14", "--cycle", "--json"]
        arguments += ["--pressure", "cosine-180"]
        assert call([*arguments, "--out", str(tmp_path / "run")]) == 0
        found[nu] = json.loads(capsys.readouterr().out)
    plain, soft = found[0.4], found[0.4999]
    assert (plain["model"]["formulation"], soft["model"]["formulation"]) == (
        "displacement",
        "displacement-pressure",
    )
    assert soft["trusted"]
    assert soft["checks"]["superposition"]["pass"]
    assert soft["checks"]["backward_error"]["value"] < 1e-13
    conditions = [summary["checks"]["condition"]["value"] for summary in (plain, soft)]
    assert conditions[1] < 2 * conditions[0]
    assert soft["model"]["solved_dofs"] > plain["model"]["solved_dofs"]
    assert any("rod: solved with mixed" in note for note in soft["notes"])
    assert [item["what"] for item in plain["left_out"]].count("pressure unknowns") == 1
    # The stress of a slender body hardly depends on ν.
    for case, result in plain["results"].items():
        assert soft["results"][case]["max_von_mises_MPa"] == pytest.approx(
            result["max_von_mises_MPa"], rel=0.05
        )


def test_first_order_elements_are_marked_still(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(STUDY.format(nu=0.4999) + ENGINE)
    summary = run("s.toml", size=14, element="p1")
    assert not summary["trusted"]
    assert summary["model"]["formulation"] == "displacement"


@pytest.mark.parametrize(
    ("command", "nu", "rest"),
    [("modes", 0.499999, []), ("run", 0.45, ["--buckling"])],
)
def test_what_has_no_pressure_yet_refuses(tmp_path, capsys, command, nu, rest):
    (tmp_path / "s.toml").write_text(STUDY.format(nu=nu) + ENGINE)
    assert call([command, str(tmp_path / "s.toml"), "--size", "14", *rest]) == 2
    assert "material.nu" in capsys.readouterr().err


def test_the_pressure_is_that_of_the_displacement_where_a_stiff_part_hardly_strains():
    """λ ∇·u projected balances the load as well as p does, to what is checked in every run."""
    mesh = strap()
    part = (mesh.points[mesh.tets[:, :4], 0].mean(axis=1) > mesh.points[:, 0].mean()).astype(np.int64)
    mesh, load = replace(mesh, part=part), tilted_load(mesh)
    soft, stiff = Material(40.0, 0.3, 1e-9, 10.0), Material(8e5, 0.47, 9e-9, 200.0)
    model = MixedModel(mesh, [soft, stiff], [1], Support.CLAMPED)
    solution = model.solve([load])
    space = pressure_space(mesh, {1: stiff})
    u = solution.displacement[Parity.SYMMETRIC].ravel()
    p = sparse.linalg.spsolve(sparse.csc_array(space.mass), stiff.lame_lambda * (space.divergence @ u))
    shear = Materials((soft, stiff.without_lambda()), part)
    forces = stiffness(mesh, shear, pattern(mesh.tets, len(mesh.points))) @ u + space.divergence.T @ p
    left = (forces - load.symmetric.ravel())[~_fixed(mesh)]
    assert np.abs(left).max() < 1e-6 * np.abs(load.symmetric).max()
    assert solution.residuals[Parity.SYMMETRIC].imbalance < 1e-6
