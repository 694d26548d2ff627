"""Recovered stress: exact where it must be, the same on a half as on the whole."""

import numpy as np
import pytest

from fea.material import Material
from fea.solid.elasticity import stress_from_gradient
from fea.solid.recovery import Parity, Recovery
from geometry.surfaces import Surface
from mesh.tetmesh import EDGES, TetMesh

STEEL = Material(youngs_modulus=2.1e5, poissons_ratio=0.3, density=7.85e-9, yield_strength=400.0)
AXIS = {Surface.SYMMETRY_Y: 1, Surface.SYMMETRY_Z: 2}


def box(order, seed=0, cells=3):
    """A cube [0, 1]³ of randomly moved Kuhn tetrahedra, the faces y = 0 and z = 0 named."""
    from itertools import permutations

    side = np.arange(cells + 1)
    points = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    number = {tuple(p): k for k, p in enumerate(points)}
    tets = []
    for corner in points[(points < cells).all(axis=1)]:
        for path in permutations(np.eye(3, dtype=int)):
            steps = np.vstack([corner, corner + np.cumsum(path, axis=0)])
            tets.append([number[tuple(p)] for p in steps])
    tets = np.array(tets)
    rng = np.random.default_rng(seed)
    inside = (points > 0) & (points < cells)
    points = (points + np.where(inside, rng.uniform(-0.2, 0.2, points.shape), 0)) / cells
    edge = points[tets]
    flipped = np.linalg.det(edge[:, 1:] - edge[:, :1]) < 0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    if order == 2:
        pairs = np.sort(tets[:, EDGES], axis=2)
        unique, inverse = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        middle = points[unique].mean(axis=1)
        tets = np.hstack([tets, len(points) + inverse.reshape(len(tets), 6)])
        points = np.vstack([points, middle])
    on = {plane: np.flatnonzero(points[:, axis] == 0)[None, :] for plane, axis in AXIS.items()}
    return TetMesh(points, tets, on)


def mirrored(mesh, plane):
    """The mesh and its image at `plane`, and for each of its nodes the original."""
    axis, n = AXIS[plane], len(mesh.points)
    apart = np.flatnonzero(mesh.points[:, axis] != 0)
    image = np.arange(n)
    image[apart] = n + np.arange(apart.size)
    flip = np.array([1 if k != axis else -1 for k in range(3)])
    order = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8][: mesh.tets.shape[1]]
    points = np.vstack([mesh.points, mesh.points[apart] * flip])
    tets = np.vstack([mesh.tets, image[mesh.tets][:, order]])
    facets = {
        other: np.hstack([nodes, image[nodes]])
        for other, nodes in mesh.facets.items() if other is not plane
    }
    return TetMesh(points, tets, facets), np.r_[np.arange(n), apart]


def continued(u, plane, origin, parity):
    """Displacement on the mirrored mesh."""
    n = len(u)
    flip = np.array([1 if k != AXIS[plane] else -1 for k in range(3)])
    return np.concatenate([u, parity * u[origin[n:]] * flip[:, None]])


@pytest.mark.parametrize("order", [1, 2])
def test_a_linear_displacement_gives_its_constant_stress(order):
    mesh = box(order)
    gradient = np.array([[1.0, 2, 3], [-4, 5, 0.5], [7, -2, 1]]) * 1e-3
    stress = Recovery(mesh).nodal_stress((mesh.points @ gradient.T)[:, :, None], STEEL)[:, :, 0]
    exact = stress_from_gradient(gradient, STEEL)
    np.testing.assert_allclose(stress, np.broadcast_to(exact, stress.shape), atol=1e-11 * abs(exact).max())


def test_a_quadratic_displacement_gives_its_linear_stress():
    mesh = box(2)
    x, y, z = mesh.points.T
    u = np.stack([x * x + y * z, x * y - z * z, x * z + 2 * y * y], axis=1)
    zero = np.zeros_like(x)
    gradient = np.array([[2 * x, z, y], [y, x, -2 * z], [z, 4 * y, x]]) + zero
    exact = stress_from_gradient(gradient.transpose(2, 0, 1), STEEL)
    stress = Recovery(mesh).nodal_stress(u[:, :, None], STEEL)[:, :, 0]
    np.testing.assert_allclose(stress, exact, atol=1e-11 * abs(exact).max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("parity", Parity)
@pytest.mark.parametrize(
    "planes", [(Surface.SYMMETRY_Z,), (Surface.SYMMETRY_Y,), (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)]
)
def test_a_part_gives_the_stress_of_the_whole(order, parity, planes):
    part = box(order)
    u = np.random.default_rng(1).normal(size=(*part.points.shape, 2))
    for plane in planes:  # what the parity holds on the plane
        sign = parity if plane is Surface.SYMMETRY_Y else 1
        held = [AXIS[plane]] if sign == 1 else [k for k in range(3) if k != AXIS[plane]]
        u[np.ix_(part.facets[plane].ravel(), held)] = 0
    whole, whole_u = part, u
    for plane in planes:
        whole, origin = mirrored(whole, plane)
        whole_u = continued(whole_u, plane, origin, parity if plane is Surface.SYMMETRY_Y else 1)
    expected = Recovery(whole).nodal_stress(whole_u, STEEL)[: len(part.points)]
    stress = Recovery(part, planes).nodal_stress(u, STEEL, parity)
    np.testing.assert_allclose(stress, expected, atol=1e-11 * abs(expected).max())


def test_cases_do_not_touch_each_other():
    mesh = box(2)
    u = np.random.default_rng(2).normal(size=(*mesh.points.shape, 3))
    recovery = Recovery(mesh)
    together = recovery.nodal_stress(u, STEEL)
    for case in range(3):
        alone = recovery.nodal_stress(u[:, :, case : case + 1], STEEL)[:, :, 0]
        np.testing.assert_allclose(together[:, :, case], alone, rtol=1e-12, atol=1e-12 * abs(alone).max())


def test_the_same_twice():
    u = np.random.default_rng(3).normal(size=(*box(2).points.shape, 1))
    first, second = (Recovery(box(2)).nodal_stress(u, STEEL) for _ in range(2))
    np.testing.assert_array_equal(first, second)
