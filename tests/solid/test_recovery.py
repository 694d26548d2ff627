"""Recovered stress: exact where it must be, the same on a part as on the whole."""

from itertools import permutations

import numpy as np
import pytest

from fea.base.material import Material
from fea.solid.assembly import stress_from_gradient
from fea.solid.parity import Parity
from fea.solid.recovery import ElementStress, Recovery, SurfaceStress
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import EDGES, TetMesh, reflect, unmirrored

STEEL = Material(youngs_modulus=2.1e5, poissons_ratio=0.3, density=7.85e-9, yield_strength=400.0)
# The faces x = 0, x = 1, y = 0, z = 0 and y = 1 of a box, with their outward normals;
# z = 1 has no name.
FACES = {
    Surface.BIG_END_BORE: (0, 0, -1.0),
    Surface.SMALL_END_BORE: (0, 1, 1.0),
    Surface.SYMMETRY_Y: (1, 0, -1.0),
    Surface.SYMMETRY_Z: (2, 0, -1.0),
    Surface.FREE: (1, 1, 1.0),
}
GRADIENT = np.array([[1.0, 2, 3], [-4, 5, 0.5], [7, -2, 1]]) * 1e-3


def box(order, cells=3, moved=0.15, without=lambda corner: False):
    """The cube [0, 1]³ as straight tetrahedra, inner vertices `moved`; cells `without` are left out."""
    side = np.arange(cells + 1)
    points = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    number = {tuple(p): k for k, p in enumerate(points)}
    tets = np.array(
        [
            [number[tuple(p)] for p in np.vstack([corner, corner + np.cumsum(path, axis=0)])]
            for corner in points[(points < cells).all(axis=1)]
            if not without(corner / cells)
            for path in permutations(np.eye(3, dtype=int))
        ]
    )
    inside = (points > 0) & (points < cells)
    shift = np.random.default_rng(0).uniform(-moved, moved, points.shape)
    places = (points + np.where(inside, shift, 0)) / cells
    corners = places[tets]
    flipped = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    used, inverse = np.unique(tets, return_inverse=True)
    return finished(places[used], inverse.reshape(tets.shape), order)


def finished(points, tets, order):
    """Raise the order and name the outer facets."""
    faces = np.concatenate([tets[:, f] for f in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    facets = faces[first[count == 1]]
    if order == 2:
        pairs = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)
        unique, inverse = np.unique(pairs, axis=0, return_inverse=True)
        number = {tuple(pair): len(points) + k for k, pair in enumerate(unique)}
        tets = np.hstack([tets, len(points) + inverse.reshape(len(tets), 6)])
        edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
        facets = np.hstack([facets, [[number[tuple(pair)] for pair in row] for row in edges]])
        points = np.vstack([points, points[unique].mean(axis=1)])
    on = {s: (points[facets][..., axis] == at).all(axis=1) for s, (axis, at, _) in FACES.items()}
    top = (points[facets][..., 2] == 1).all(axis=1)
    on[Surface.FREE] |= ~np.any([*on.values(), top], axis=0)  # the faces of a notch
    return TetMesh(points, tets, {surface: facets[mine] for surface, mine in on.items()})


def exact_traction(mesh, stress):
    tensor = stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    return {s: side * tensor[:, axis][:, :, None] for s, (axis, _, side) in FACES.items()}


def bent(mesh):
    """The mesh with curved faces and edges, its mirror planes still plane and met at right angles."""
    x, y, z = mesh.points.T
    moved = [x + 0.2 * y * y + 0.1 * z * z * x, y * (1 + 0.2 * x), z * (1 - 0.1 * x * x + 0.2 * y * y)]
    return TetMesh(np.stack(moved, axis=1), mesh.tets, mesh.facets)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("surfaces", [(), tuple(FACES)])
def test_a_linear_displacement_gives_its_constant_stress(order, surfaces):
    mesh = bent(box(order)) if not surfaces else box(order)
    exact = np.tile(stress_from_gradient(GRADIENT, STEEL), (len(mesh.points), 1))
    traction = exact_traction(mesh, exact) if surfaces else None
    u = (mesh.points @ GRADIENT.T)[:, :, None]
    stress = Recovery(mesh, (), surfaces).nodal_stress(u, STEEL, traction=traction)[:, :, 0]
    np.testing.assert_allclose(stress, exact, atol=1e-11 * abs(exact).max())


@pytest.mark.parametrize("surfaces", [(), tuple(FACES)])
def test_a_quadratic_displacement_gives_its_linear_stress(surfaces):
    mesh = box(2)
    x, y, z = mesh.points.T
    u = np.stack([x * x + y * z, x * y - z * z, x * z + 2 * y * y], axis=1)
    gradient = np.array([[2 * x, z, y], [y, x, -2 * z], [z, 4 * y, x]])
    exact = stress_from_gradient(gradient.transpose(2, 0, 1), STEEL)
    traction = exact_traction(mesh, exact) if surfaces else None
    stress = Recovery(mesh, (), surfaces).nodal_stress(u[:, :, None], STEEL, traction=traction)[:, :, 0]
    np.testing.assert_allclose(stress, exact, atol=1e-11 * abs(exact).max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("parity", Parity)
@pytest.mark.parametrize(
    "planes", [(Surface.SYMMETRY_Z,), (Surface.SYMMETRY_Y,), (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)]
)
def test_a_part_gives_the_stress_of_the_whole(order, parity, planes):
    part = bent(box(order))
    surfaces = tuple(set(FACES) - set(PLANE_AXIS))
    rng = np.random.default_rng(1)
    u, load = rng.normal(size=(2, *part.points.shape, 2))
    whole = unmirrored(part)
    for plane in planes:
        even = parity is Parity.SYMMETRIC or plane is Surface.SYMMETRY_Z
        axis = PLANE_AXIS[plane]
        held = [axis] if even else [k for k in range(3) if k != axis]
        for field in (u, load):  # what the parity holds on the plane
            field[np.ix_(np.unique(part.facets[plane]), held)] = 0
        whole = reflect(whole, plane)

    def carried(carry, field):
        even = parity is Parity.SYMMETRIC or Surface.SYMMETRY_Y not in planes
        return carry(field) if even else carry(0 * field, field)

    expected = Recovery(whole.mesh, (), surfaces).nodal_stress(
        carried(whole.vector, u), STEEL, traction={Surface.BIG_END_BORE: carried(whole.vector, load)}
    )
    stress = Recovery(part, planes, surfaces).nodal_stress(u, STEEL, parity, {Surface.BIG_END_BORE: load})
    np.testing.assert_allclose(carried(whole.tensor, stress), expected, atol=1e-10 * abs(expected).max())


def test_the_traction_stands_on_its_surface_and_nothing_on_a_free_one():
    mesh = box(2)
    u, load = np.random.default_rng(4).normal(size=(2, *mesh.points.shape, 1))
    surfaces = (Surface.SMALL_END_BORE, Surface.FREE)
    recovery = Recovery(mesh, (), surfaces)
    stress = recovery.nodal_stress(u * 1e-3, STEEL, traction={Surface.SMALL_END_BORE: load})[:, :, 0]
    on_faces = ((mesh.points == 0) | (mesh.points == 1)).sum(axis=1)
    x, y, _ = mesh.points.T
    loaded, free = (on_faces == 1) & (x == 1), (on_faces == 1) & (y == 1)
    assert loaded.sum() > 10
    assert free.sum() > 10
    np.testing.assert_allclose(stress[loaded][:, [0, 3, 5]], load[loaded, :, 0], atol=1e-10)
    np.testing.assert_allclose(stress[free][:, [3, 1, 4]], 0, atol=1e-10)


def test_a_free_outer_edge_carries_stress_along_itself_only():
    mesh = box(2)
    stress = Recovery(mesh, (), (Surface.SMALL_END_BORE, Surface.FREE)).nodal_stress(
        (mesh.points @ np.diag([-0.3, -0.3, 1.0]) * 1e-3)[:, :, None], STEEL
    )[:, :, 0]
    x, y, z = mesh.points.T
    edge = (x == 1) & (y == 1) & (z > 0) & (z < 1)
    assert edge.any()
    expected = [0, 0, STEEL.youngs_modulus * 1e-3, 0, 0, 0]
    np.testing.assert_allclose(stress[edge], np.tile(expected, (edge.sum(), 1)), atol=1e-9)


def test_an_inner_edge_keeps_the_mean():
    notched = box(2, moved=0, without=lambda corner: corner[0] > 0.3 and corner[1] > 0.3)
    u = np.random.default_rng(5).normal(size=(*notched.points.shape, 1))
    change = Recovery(notched, (), tuple(FACES)).nodal_stress(u, STEEL) - Recovery(notched).nodal_stress(
        u, STEEL
    )
    changed = abs(change).max(axis=(1, 2)) > 0
    x, y, z = notched.points.T
    on_notch = ((x > 0.3) & (y > 0.3)) & (z > 0) & (z < 1)
    inner = on_notch & np.isclose(x, 1 / 3) & np.isclose(y, 1 / 3)
    assert inner.any()
    assert not changed[inner].any()
    assert changed[on_notch & ~inner & (x < 1) & (y < 1)].all()


def test_a_surface_of_unknown_traction_keeps_the_mean():
    mesh = box(2)
    u = np.random.default_rng(6).normal(size=(*mesh.points.shape, 1))
    change = Recovery(mesh, (), (Surface.FREE,)).nodal_stress(u, STEEL) - Recovery(mesh).nodal_stress(
        u, STEEL
    )
    changed = np.flatnonzero(abs(change).max(axis=(1, 2)))
    held = np.concatenate(
        [facets.ravel() for surface, facets in mesh.facets.items() if surface is not Surface.FREE]
    )
    np.testing.assert_array_equal(changed, np.setdiff1d(mesh.facets[Surface.FREE], held))


def turned(mesh, angle):
    """The box rolled about an axis beyond its face y = 0, so that its faces y turn by `angle`."""
    x, y, z = mesh.points.T
    rolled = [(0.5 + y) * np.sin(angle * x), (0.5 + y) * np.cos(angle * x), z]
    return TetMesh(np.stack(rolled, axis=1), mesh.tets, mesh.facets)


@pytest.mark.parametrize(("degrees", "fitted"), [(60, True), (250, False)])
def test_a_surface_that_turns_too_far_between_nodes_keeps_the_mean(degrees, fitted):
    mesh = turned(box(2), np.radians(degrees))
    inside = np.setdiff1d(
        mesh.facets[Surface.FREE],
        np.concatenate([facets.ravel() for s, facets in mesh.facets.items() if s is not Surface.FREE]),
    )
    served = np.isin(inside, SurfaceStress(mesh, (Surface.FREE,), ()).nodes)
    assert served.all() if fitted else not served.all()


def test_gauss_stress_is_the_elements_own():
    mesh = box(2)
    u = (mesh.points @ GRADIENT.T)[:, :, None]
    stress = ElementStress(mesh)(u, STEEL)
    assert stress.shape == (len(mesh.tets), 4, 6, 1)
    exact = stress_from_gradient(GRADIENT, STEEL)
    np.testing.assert_allclose(stress[..., 0], np.broadcast_to(exact, stress.shape[:3]), atol=1e-9)


def test_cases_do_not_touch_each_other():
    mesh = bent(box(2))
    u, load = np.random.default_rng(2).normal(size=(2, *mesh.points.shape, 3))
    recovery = Recovery(mesh, (), (Surface.FREE, Surface.BIG_END_BORE))
    together = recovery.nodal_stress(u, STEEL, traction={Surface.FREE: load})
    for case in range(3):
        one = slice(case, case + 1)
        alone = recovery.nodal_stress(u[:, :, one], STEEL, traction={Surface.FREE: load[:, :, one]})
        np.testing.assert_allclose(together[:, :, one], alone, atol=1e-12 * abs(alone).max())


def test_the_same_twice():
    mesh = bent(box(2))
    u = np.random.default_rng(3).normal(size=(*mesh.points.shape, 1))
    first, second = (Recovery(mesh, (), (Surface.FREE,)).nodal_stress(u, STEEL) for _ in range(2))
    np.testing.assert_array_equal(first, second)
