"""A manufactured solution: a displacement all but free of divergence, a pressure that is not constant.

In the unit cube u = curl (0, 0, φ) + (μ/λ) (B, B, B) with φ = Π sin² πx and B = Π sin πx: it vanishes on the
boundary, and p = λ ∇·u = μ (∂x + ∂y + ∂z) B whatever λ.
"""

from dataclasses import dataclass

import numpy as np

from fea.base.material import Material
from fea.solid.assembly import gauss_blocks, shape_functions, tabulate
from fea.solid.traction import body_forces
from fea.verify.body import LoadedBody
from fea.verify.stability.outcome import solved_by
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

PI = np.pi
DEGREE = 6


@dataclass(frozen=True)
class Exact:
    """Fields at places (n, 3)."""

    material: Material

    @property
    def _small(self):
        return self.material.shear_modulus / self.material.lame_lambda

    def displacement(self, places):
        s, ds, _, _ = squares(places)
        x, y, z = range(3)
        u = np.zeros_like(places)
        u[:, 0] = s[x] * ds[y] * s[z]
        u[:, 1] = -ds[x] * s[y] * s[z]
        return u + self._small * bubble(places)[:, None]

    def pressure(self, places):
        return self.material.shear_modulus * bubble_slopes(places).sum(axis=1)

    def body_force(self, places):
        """−∇·σ = −μ Δu − (λ + μ) ∇(∇·u)."""
        lam, mu = self.material.lame_lambda, self.material.shear_modulus
        s, d1, d2, d3 = squares(places)
        x, y, z = range(3)
        laplacian = np.zeros_like(places)
        laplacian[:, 0] = d2[x] * d1[y] * s[z] + s[x] * d3[y] * s[z] + s[x] * d1[y] * d2[z]
        laplacian[:, 1] = -(d3[x] * s[y] * s[z] + d1[x] * d2[y] * s[z] + d1[x] * s[y] * d2[z])
        laplacian += self._small * (-3 * PI**2 * bubble(places))[:, None]
        return -mu * laplacian - (lam + mu) * self._small * bubble_hessian(places).sum(axis=2)


def squares(places):
    """sin² πx of each coordinate with three derivatives, each (3, n)."""
    a = 2 * PI * places.T
    return np.sin(a / 2) ** 2, PI * np.sin(a), 2 * PI**2 * np.cos(a), -4 * PI**3 * np.sin(a)


def bubble(places):
    return np.sin(PI * places).prod(axis=1)


def bubble_slopes(places):
    sine, cosine = np.sin(PI * places), np.cos(PI * places)
    columns = [PI * cosine[:, i] * np.delete(sine, i, axis=1).prod(axis=1) for i in range(3)]
    return np.stack(columns, axis=1)


def bubble_hessian(places):
    sine, cosine = np.sin(PI * places), np.cos(PI * places)
    found = np.empty((len(places), 3, 3))
    for i in range(3):
        for j in range(3):
            other = 3 - i - j
            found[:, i, j] = PI**2 * (
                -sine.prod(axis=1) if i == j else cosine[:, i] * cosine[:, j] * sine[:, other]
            )
    return found


def errors(mesh: TetMesh, material: Material) -> tuple[float, float]:
    """L2 errors of displacement and pressure, relative to the exact fields."""
    exact = Exact(material)
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    fixed[mesh.facets[Surface.FREE].ravel()] = True
    pair = solved_by(
        "p2/p1", LoadedBody(mesh, material, body_forces(mesh, exact.body_force), fixed), material
    )
    table = tabulate(10, DEGREE)
    linear, _ = shape_functions(4, _places(table.values))
    off, whole = np.zeros(2), np.zeros(2)
    for part, gauss in gauss_blocks(mesh, DEGREE):
        tets, volumes = mesh.tets[part], gauss.volumes.ravel()
        places = (table.values @ mesh.points[tets]).reshape(-1, 3)
        u, p = exact.displacement(places), exact.pressure(places)
        found_u = (table.values @ pair.displacement[tets]).reshape(-1, 3)
        found_p = (linear @ pair.pressure[tets[:, :4]]).ravel()
        off += volumes @ np.stack([((found_u - u) ** 2).sum(axis=1), (found_p - p) ** 2], axis=1)
        whole += volumes @ np.stack([(u**2).sum(axis=1), p**2], axis=1)
    relative = np.sqrt(off / whole)
    return float(relative[0]), float(relative[1])


def _places(values):
    """Places (3, n) of a rule from the second-order shape functions (n, 10) there."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    edges = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
    return (values @ np.vstack([corners, corners[edges].mean(axis=1)])).T
