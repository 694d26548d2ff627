"""A written run examined anew, with nothing of the program but its files: equilibrium and sections.

The stiffness is assembled from strain matrices, the loads are integrated from the figures of the summary,
and both are applied to the displacement of the VTU file. The quadrature rules have the program's degrees,
as the half cosine has a kink that no rule integrates exactly.
"""

import json
import math
from dataclasses import dataclass

import meshio
import numpy as np
import pyvista as pv
from scipy import sparse
from skfem import ElementTetP2, ElementTriP2, MeshTet, MeshTri
from skfem.quadrature import get_quadrature

STIFFNESS, VOLUME, FACET = 2, 5, 10
FACES = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]])


@dataclass(frozen=True)
class Told:
    """What was asked: mm, t, N, rad/s."""

    youngs: float
    poisson: float
    density: float
    big_radius: float
    small_radius: float
    length: float
    crank_radius: float
    speed: float


def rule(element, mesh, degree):
    """Weights, values (q, n) and slopes (q, n, dim) of a reference element."""
    points, weights = get_quadrature(mesh.elem.refdom, degree)
    tables = [element.lbasis(points, i) for i in range(10 if points.shape[0] == 3 else 6)]
    values = np.stack([np.broadcast_to(v, points.shape[1]) for v, _ in tables], axis=1)
    slopes = np.stack([np.broadcast_to(np.asarray(g), points.shape).T for _, g in tables], axis=1)
    return weights, values, slopes


def internal_forces(points, tets, u, told):
    """K u at the nodes (n, 3), with K from B^T C B."""
    weights, _, slopes = rule(ElementTetP2(), MeshTet, STIFFNESS)
    E, nu = told.youngs, told.poisson
    C = np.zeros((6, 6))
    C[:3, :3] = nu
    C[range(3), range(3)] = 1 - nu
    C[range(3, 6), range(3, 6)] = (1 - 2 * nu) / 2
    C *= E / ((1 + nu) * (1 - 2 * nu))
    n = len(tets)
    k = np.zeros((n, 30, 30))
    for weight, slope in zip(weights, slopes, strict=True):
        J = points[tets].transpose(0, 2, 1) @ slope
        g = slope @ np.linalg.inv(J)
        B = np.zeros((n, 6, 10, 3))
        for row, pairs in enumerate(
            [[(0, 0)], [(1, 1)], [(2, 2)], [(0, 1), (1, 0)], [(1, 2), (2, 1)], [(0, 2), (2, 0)]]
        ):
            for component, axis in pairs:
                B[:, row, :, component] = g[:, :, axis]
        B = B.reshape(n, 6, 30)
        k += weight * np.linalg.det(J)[:, None, None] * (B.transpose(0, 2, 1) @ C @ B)
    dofs = (3 * tets[:, :, None] + np.arange(3)).reshape(n, 30)
    rows, columns = np.repeat(dofs, 30, axis=1).ravel(), np.tile(dofs, (1, 30)).ravel()
    K = sparse.csr_array(sparse.coo_array((k.ravel(), (rows, columns)), shape=(u.size, u.size)))
    return (K @ u.ravel()).reshape(-1, 3)


def bore_forces(points, tets, center, radius, force):
    """Half-cosine pressure on a bore with the resultant `force` (x, y), as nodal forces (n, 3)."""
    out = np.zeros_like(points)
    magnitude, direction = math.hypot(*force), math.atan2(force[1], force[0])
    if not magnitude:
        return out
    faces = tets[:, FACES].reshape(-1, 6)
    _, first, counts = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[first[counts == 1]]
    away = np.hypot(points[:, 0] - center, points[:, 1])
    faces = faces[(np.abs(away - radius) < 1e-6 * radius)[faces[:, :3]].all(axis=1)]
    weights, values, slopes = rule(ElementTriP2(), MeshTri, FACET)
    tangents = np.einsum("fni,qnk->fqik", points[faces], slopes)
    area = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) * weights
    places = np.einsum("qn,fni->fqi", values, points[faces])
    angle = np.arctan2(places[..., 1], places[..., 0] - center)
    psi = np.mod(angle - direction + math.pi, 2 * math.pi) - math.pi
    shape = np.where(np.abs(psi) <= math.pi / 2, np.cos(psi), 0.0)
    basis = [shape, shape * np.sin(psi)]
    system = [[(area * b * trig(psi)).sum() for b in basis] for trig in (np.cos, np.sin)]
    a, b = np.linalg.solve(system, [magnitude, 0.0])
    pressure = area * (a * basis[0] + b * basis[1])
    for axis, part in enumerate((np.cos(angle), np.sin(angle))):
        np.add.at(out[:, axis], faces.ravel(), ((pressure * part) @ values).ravel())
    return out


def inertia_forces(points, tets, told, crank_deg, cut):
    """D'Alembert forces at the nodes (n, 3), and their resultant beyond x = `cut`."""
    theta, ratio, w = math.radians(crank_deg), told.crank_radius / told.length, told.speed
    sin_b = ratio * math.sin(theta)
    cos_b = math.sqrt(1 - sin_b**2)
    rate = ratio * w * math.cos(theta) / cos_b
    growth = (-ratio * w * w * math.sin(theta) + rate**2 * sin_b) / cos_b
    inward = -told.crank_radius * w * w * np.array([math.cos(theta), math.sin(theta)])
    a_x, a_y = inward @ [cos_b, -sin_b], inward @ [sin_b, cos_b]
    weights, values, slopes = rule(ElementTetP2(), MeshTet, VOLUME)
    out, beyond = np.zeros_like(points), np.zeros(3)
    for weight, value, slope in zip(weights, values, slopes, strict=True):
        mass = told.density * weight * np.linalg.det(points[tets].transpose(0, 2, 1) @ slope)
        x, y, _ = (value @ points[tets]).T
        force = -mass * np.stack([a_x + growth * y - rate**2 * x, a_y - growth * x - rate**2 * y, 0 * x])
        beyond += force[:, x > cut].sum(axis=1)
        for axis in range(3):
            np.add.at(out[:, axis], tets.ravel(), (force[axis][:, None] * value).ravel())
    return out, beyond


def recheck(folder, figures, told):
    """Largest errors over the cases of a run: of equilibrium, and of the section amid the shank.

    Both are relative: to the largest nodal force, and to the largest force on the rod.
    """
    assert json.loads((folder / "summary.json").read_text())["schema"] == figures["schema"]
    equilibrium, section = 0.0, 0.0
    for name, load in figures["loads"].items():
        written = meshio.read(folder / f"{name}.vtu")
        points, tets = written.points.astype(float), written.cells_dict["tetra10"]
        pin = load["pin_axial_N"], load["pin_transverse_N"]
        crank = -load["crank_axial_N"], load["crank_transverse_N"]
        cut = 0.5 * told.length + 1e-3
        f = bore_forces(points, tets, told.length, told.small_radius, pin)
        f += bore_forces(points, tets, 0.0, told.big_radius, crank)
        beyond = np.zeros(3)
        if name != "gas":
            inertia, beyond = inertia_forces(points, tets, told, load["crank_deg"], cut)
            f += inertia
        inside = internal_forces(points, tets, written.point_data["displacement"].astype(float), told)
        equilibrium = max(equilibrium, float(np.abs(inside - f).max() / np.abs(f).max()))
        plane = pv.read(folder / f"{name}.vtu").slice(normal="x", origin=(cut, 0, 0))
        stress = plane.integrate_data()["stress"][0]
        carried = np.array([stress[0], stress[3]])
        largest = max(math.hypot(*pin), math.hypot(*crank))
        section = max(section, float(np.abs(carried - (pin + beyond[:2])).max() / largest))
    return equilibrium, section
