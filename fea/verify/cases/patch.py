"""Patch test: a linear displacement, prescribed on the boundary of an irregular mesh, is exact inside."""

import numpy as np

from fea.solid.element import stress_from_gradient
from fea.solvers.constrained import displacement
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, SolvedBody, furthest
from geometry.arrays import Floats
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import EDGES, TetMesh

# An arbitrary gradient without any symmetry, and a translation that keeps the displacement away from zero.
GRADIENT = 1e-3 * np.array([[1.0, 0.4, -0.3], [0.2, -0.7, 0.5], [-0.6, 0.1, 0.8]])
SHIFT = np.array([4e-3, -4e-3, 4e-3])
SHAKE = 0.05  # random displacement of inner vertices, relative to the element size
_WHY = "only rounding errors remain, on elements of any shape"
GOALS = tuple(
    Goal(f"{order} {what} / exact {what}, worst node", "1", 1.0, 1e-10, _WHY)
    for order in ("P1", "P2")
    for what in ("displacement", "stress")
)


def shaken(mesh: TetMesh, distance: float) -> TetMesh:
    """Move inner vertices at random but reproducibly; edges stay straight.

    With curved edges the stiffness would not be exact, because its quadrature is exact for straight edges
    only.
    """
    inside = np.ones(len(mesh.points), dtype=bool)
    for facets in mesh.facets.values():
        inside[facets] = False
    moves = np.random.default_rng(1).uniform(-distance, distance, mesh.points.shape)
    points = mesh.points + inside[:, None] * moves
    for middle, (a, b) in enumerate(EDGES[: mesh.tets.shape[1] - 4], start=4):
        points[mesh.tets[:, middle]] = points[mesh.tets[:, [a, b]]].mean(axis=1)
    return TetMesh(points, mesh.tets, mesh.facets)


def compute(size: float) -> Computed:
    """Solve a cube of edge 1 mm with elements of `size`, of both orders."""
    found: dict[str, float] = {}
    dofs = 0
    for order in (1, 2):
        mesh = shaken(mesh_body(block(1.0, 1.0, 1.0), size, order=order), SHAKE * size)
        exact = SHIFT + mesh.points @ GRADIENT.T
        boundary = np.zeros((len(mesh.points), 3), dtype=bool)
        boundary[mesh.facets[Surface.FREE].ravel()] = True
        u = displacement(mesh, STEEL, np.zeros_like(exact), boundary, exact)
        solved = SolvedBody(mesh, STEEL, u)
        found[f"P{order} displacement / exact displacement, worst node"] = _ratio(u[:, :, 0], exact)
        stress = stress_from_gradient(GRADIENT, STEEL)
        found[f"P{order} stress / exact stress, worst node"] = _ratio(solved.stress, stress)
        dofs = mesh.points.size
    return Computed(found, dofs)


def _ratio(computed: Floats, exact: Floats) -> float:
    """1 plus the signed error that is largest relative to the size of the exact field at the node."""
    scale = np.linalg.norm(exact, axis=-1, keepdims=True)
    return furthest((1 + (computed - exact) / scale).ravel(), 1.0)


BENCHMARK = Benchmark(
    title="Patch test on an irregular mesh",
    source="Taylor, Simo, Zienkiewicz & Chan 1986, Int. J. Numer. Meth. Eng. 22, 39-62",
    goals=GOALS,
    compute=compute,
    size=0.25,
    converges=False,
)
