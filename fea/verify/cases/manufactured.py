"""Manufactured solution: rates of convergence of displacement and its gradient.

The displacement is a sum of plane waves Σ c sin(k · x + φ); it requires the body force
Σ ((λ + μ) (c · k) k + μ |k|² c) sin(k · x + φ) and is prescribed on the whole boundary of a cube.
"""

import math

import numpy as np

from fea.solid.element import gauss_blocks, tabulate
from fea.solid.inertia import body_forces
from fea.solvers.constrained import displacement
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL
from geometry.arrays import Floats
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.refined import refined
from mesh.tetmesh import TetMesh

# Amplitude c, wave vector k and phase φ of each wave, without any symmetry.
WAVES = (
    (np.array([1.0, 0.5, -0.3]), np.array([2.0, 1.0, -1.0]), 0.3),
    (np.array([-0.4, 0.8, 0.6]), np.array([-1.0, 2.0, 1.5]), 1.1),
)
HALVINGS = 2
ERROR_DEGREE = 6

_EXACT = {"P1, displacement": 2.0, "P1, gradient": 1.0, "P2, displacement": 3.0, "P2, gradient": 2.0}
GOALS = tuple(
    Goal(
        f"L2 rate, {what}",
        "1",
        rate,
        100 * 0.1 / rate,
        "the rate must be within 0.1 of the theoretical order, which holds in the limit of small elements",
    )
    for what, rate in _EXACT.items()
)


def exact(places: Floats) -> Floats:
    """Displacement (n, 3), mm."""
    u = np.zeros_like(places)
    for c, k, phase in WAVES:
        u += c * np.sin(places @ k + phase)[:, None]
    return u


def exact_gradient(places: Floats) -> Floats:
    """∂u_i/∂x_j (n, 3, 3)."""
    gradient = np.zeros((len(places), 3, 3))
    for c, k, phase in WAVES:
        gradient += np.outer(c, k) * np.cos(places @ k + phase)[:, None, None]
    return gradient


def body_force(places: Floats) -> Floats:
    """Force per volume (n, 3), N/mm³, that the displacement requires."""
    lam, mu = STEEL.lame_lambda, STEEL.shear_modulus
    force = np.zeros_like(places)
    for c, k, phase in WAVES:
        force += ((lam + mu) * (c @ k) * k + mu * (k @ k) * c) * np.sin(places @ k + phase)[:, None]
    return force


def errors(mesh: TetMesh, u: Floats) -> tuple[float, float]:
    """L2 norms of the errors of displacement (n_nodes, 3) and of its gradient."""
    values = tabulate(mesh.tets.shape[1], ERROR_DEGREE).values
    squares = np.zeros(2)
    for part, gauss in gauss_blocks(mesh, ERROR_DEGREE):
        places = (values @ mesh.points[mesh.tets[part]]).reshape(-1, 3)
        nodal, volumes = u[mesh.tets[part]], gauss.volumes.ravel()
        found = (values @ nodal).reshape(-1, 3)
        slope = np.einsum("eai,eqaj->eqij", nodal, gauss.gradients, optimize=True).reshape(-1, 3, 3)
        squares[0] += volumes @ ((found - exact(places)) ** 2).sum(axis=1)
        squares[1] += volumes @ ((slope - exact_gradient(places)) ** 2).sum(axis=(1, 2))
    in_u, in_gradient = np.sqrt(squares)
    return float(in_u), float(in_gradient)


def compute(size: float) -> Computed:
    """Refine meshes of `size` (first-order: half of it); the rates are those of the last refinement."""
    found: dict[str, float] = {}
    dofs = 0
    for order in (1, 2):
        mesh = mesh_body(block(1.0, 1.0, 1.0), order / 2 * size, order=order)
        for _ in range(HALVINGS - 1):
            mesh = refined(mesh)
        coarse, mesh = errors(mesh, _solved(mesh)), refined(mesh)
        fine = errors(mesh, _solved(mesh))
        for what, before, after in zip(("displacement", "gradient"), coarse, fine, strict=True):
            found[f"L2 rate, P{order}, {what}"] = math.log2(before / after)
        dofs = max(dofs, mesh.points.size)
    return Computed(found, dofs)


def _solved(mesh: TetMesh) -> Floats:
    boundary = np.zeros((len(mesh.points), 3), dtype=bool)
    boundary[mesh.facets[Surface.FREE].ravel()] = True
    u = displacement(mesh, STEEL, body_forces(mesh, body_force), boundary, exact(mesh.points))
    return np.asarray(u[:, :, 0])


BENCHMARK = Benchmark(
    title="Manufactured solution: rates of convergence",
    source="Ciarlet, The Finite Element Method for Elliptic Problems (1978), section 3.2",
    goals=GOALS,
    compute=compute,
    size=0.5,
    converges=False,
)
