import numpy as np
import pytest

from fea.base.material import Material
from fea.solid.assembly import stress_from_gradient
from fea.solid.errors import UnderconstrainedError
from fea.solid.recovery import Recovery
from fea.solid.traction import body_forces, nodal_traction, thermal_forces, thermal_modulus, traction_forces
from fea.solvers.static import displacement
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body

STEEL = Material(210e3, 0.3, 7.85e-9, 400.0)
CORNERS = (
    ((0.0, 0.0), Surface.SYMMETRY_Y),
    ((4.0, 0.0), Surface.LOADED),
    ((4.0, 2.0), Surface.FREE),
    ((0.0, 2.0), Surface.SYMMETRY_X),
)


@pytest.fixture(scope="module", params=[1, 2])
def box(request):
    return mesh_body(Prism(polygon(*CORNERS), (0.0, 3.0)), 1.0, order=request.param)


def held(mesh):
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    for axis, plane in enumerate((Surface.SYMMETRY_X, Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)):
        fixed[mesh.facets[plane].ravel(), axis] = True
    return fixed


def test_a_traction_has_its_resultant_and_moment(box):
    # t = (y, 1, z) on the face x = 4 of 2 by 3, and the normal is +x.
    forces = traction_forces(
        box, Surface.LOADED, lambda p, n: np.stack([p[:, 1] * n[:, 0], n[:, 0], p[:, 2]], axis=1)
    )
    np.testing.assert_allclose(forces.sum(axis=0), [6, 6, 13.5 - 4.5], rtol=1e-12)
    assert (forces[:, 1] * box.points[:, 0]).sum() == pytest.approx(24, rel=1e-12)
    inside = np.setdiff1d(np.arange(len(box.points)), box.facets[Surface.LOADED])
    assert not forces[inside].any()


def test_a_body_force_has_its_resultant_and_moment(box):
    forces = body_forces(box, lambda p: p)
    np.testing.assert_allclose(forces.sum(axis=0), [48, 24, 36], rtol=1e-12)
    # ∫ x · x dV
    assert (forces[:, 0] * box.points[:, 0]).sum() == pytest.approx(4**3 / 3 * 6, rel=1e-12)


def test_free_expansion_has_no_stress(box):
    alpha, rise = 1.2e-5, 80.0
    forces = thermal_forces(box, STEEL, alpha, lambda p: np.full(len(p), rise))
    u = displacement(box, STEEL, forces, held(box))
    np.testing.assert_allclose(u[:, :, 0], alpha * rise * box.points, atol=1e-15)
    total = Recovery(box).nodal_stress(u, STEEL)[:, :3, 0]
    np.testing.assert_allclose(total - thermal_modulus(STEEL, alpha) * rise, 0, atol=1e-9)


def test_hindered_expansion_is_a_pressure(box):
    # Nothing moves: σ = −β ΔT I, and the forces are those of that pressure on the faces.
    everything = np.ones((len(box.points), 3), dtype=bool)
    forces = thermal_forces(box, STEEL, 1e-5, lambda p: p[:, 0])
    assert not displacement(box, STEEL, forces, everything).any()
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-9)
    beta = thermal_modulus(STEEL, 1e-5)
    assert beta == pytest.approx(210e3 / 0.4 * 1e-5)
    # ∫ β x ∂x/∂x dV
    assert (forces[:, 0] * box.points[:, 0]).sum() == pytest.approx(beta * 8 * 6, rel=1e-12)


def test_a_moved_face_stretches_the_body(box):
    fixed = held(box)
    end = np.unique(box.facets[Surface.LOADED])
    fixed[end, 0] = True
    moved = np.full((len(box.points), 3), np.nan)
    moved[fixed] = 0.0
    moved[end, 0] = 0.004
    u = displacement(box, STEEL, np.zeros_like(moved), fixed, moved)[:, :, 0]
    np.testing.assert_allclose(u, box.points * [1e-3, -0.3e-3, -0.3e-3], atol=1e-14)
    stress = stress_from_gradient(np.diag([1e-3, -0.3e-3, -0.3e-3]), STEEL)
    assert stress[0] == pytest.approx(210.0)


def test_a_loose_body_is_refused(box):
    fixed = held(box)
    fixed[:, 2] = False
    with pytest.raises(UnderconstrainedError, match="translation along z"):
        displacement(box, STEEL, np.zeros(box.points.shape), fixed)


def test_nodal_traction_is_on_its_surface_only(box):
    given = nodal_traction(box, Surface.LOADED, lambda p: p)
    nodes = np.unique(box.facets[Surface.LOADED])
    np.testing.assert_array_equal(given[nodes, :, 0], box.points[nodes])
    assert np.count_nonzero(given.any(axis=(1, 2))) == nodes.size
