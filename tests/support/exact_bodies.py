"""Bodies with exact solutions, meshed and solved: what recovered stress is measured against.

Every body is a hollow cylinder or ball of inner radius 1 cut at its mirror planes, meshed by
irregular curved tetrahedra that grow with the distance from the axis or centre.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import gmsh
import numpy as np

from fea.solid.assembly import jacobians, pattern, stiffness, stress_from_gradient, tabulate
from fea.solid.recovery import Recovery
from fea.solvers.direct import factorise
from fea.verify.body import STEEL
from fea.verify.cases.elasticity import TENSION, goodier_displacement
from geometry.surfaces import Surface
from mesh.generate import mesh_of_model
from mesh.tetmesh import TetMesh, outward

MATERIAL = STEEL
HEIGHT = 1.0  # of the cylinders
# What the surfaces r = 1, z = HEIGHT and the outer one are called, for want of other names.
INNER, END, OUTER = Surface.BIG_END_BORE, Surface.SMALL_END_BORE, Surface.FREE
PLANES = (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)


@dataclass(frozen=True)
class Problem:
    """A body, its exact displacement (n, 3) → (n, 3), and how it is held and loaded.

    Attributes
    ----------
    build
        Draws the body with gmsh's OpenCASCADE kernel.
    outer
        Outer radius.
    exact
        Displacement of places (n, 3), analytic (it is differentiated by complex steps).
    prescribed
        Whether the outer surface carries the exact displacement (else it is free).
    pressure
        On the inner surface, MPa.
    cylinder
        Whether it is one, of height HEIGHT; else a ball.
    flat_end
        Whether the end z = HEIGHT of a cylinder is held flat (else it is free).
    """

    build: Callable[[], None]
    outer: float
    exact: Callable[[np.ndarray], np.ndarray]
    prescribed: bool
    pressure: float
    cylinder: bool
    flat_end: bool = False

    @property
    def known(self) -> tuple[Surface, ...]:
        """Surfaces of known traction."""
        free = (INNER, END) if self.cylinder and not self.flat_end else (INNER,)
        return free if self.prescribed else (*free, OUTER)

    def traction(self, mesh: TetMesh) -> dict[Surface, np.ndarray]:
        """Exact traction (n_points, 3, 1) on the inner surface."""
        radial = mesh.points * ([1, 1, 0] if self.cylinder else [1, 1, 1])
        radial = radial / np.maximum(np.linalg.norm(radial, axis=1), 0.5)[:, None]
        return {INNER: self.pressure * radial[:, :, None]}

    def stress(self, places: np.ndarray) -> np.ndarray:
        """Exact stress (n, 6)."""
        step = 1e-30
        gradient = [self.exact(places + 1j * step * np.eye(3)[j]).imag / step for j in range(3)]
        return stress_from_gradient(np.stack(gradient, axis=-1), MATERIAL)


def _half_tube(outer: float) -> None:
    occ = gmsh.model.occ
    whole = occ.addCylinder(0, 0, 0, 0, 0, HEIGHT, outer)
    hole = occ.addCylinder(0, 0, 0, 0, 0, HEIGHT, 1)
    ring = occ.cut([(3, whole)], [(3, hole)])[0]
    occ.intersect(ring, [(3, occ.addBox(-outer, 0, 0, 2 * outer, outer, HEIGHT))])


def _quarter_shell(outer: float) -> None:
    occ = gmsh.model.occ
    shell = occ.cut([(3, occ.addSphere(0, 0, 0, outer))], [(3, occ.addSphere(0, 0, 0, 1))])[0]
    occ.intersect(shell, [(3, occ.addBox(-outer, 0, 0, 2 * outer, outer, outer))])


def _lame(outer: float, *, flat_end: bool) -> Callable[[np.ndarray], np.ndarray]:
    """Thick cylinder under inner pressure 1, in plane strain or with free ends (Lamé 1852)."""
    E, mu, nu = MATERIAL.youngs_modulus, MATERIAL.shear_modulus, MATERIAL.poissons_ratio
    factor = 1 / (outer**2 - 1)
    around = (1 - 2 * nu) / (2 * mu) if flat_end else (1 - nu) / E
    along = 0 if flat_end else -2 * nu * factor / E

    def displacement(places: np.ndarray) -> np.ndarray:
        x, y, z = places.T
        radial = factor * (around + outer**2 / (2 * mu) / (x * x + y * y))
        return np.stack([x * radial, y * radial, along * z], axis=1)

    return displacement


def _kirsch(places: np.ndarray) -> np.ndarray:
    """Hole in an infinite body in plane strain under unit tension along x (Kirsch 1898)."""
    mu, kappa = MATERIAL.shear_modulus, 3 - 4 * MATERIAL.poissons_ratio
    x, y, z = places.T
    r = np.sqrt(x * x + y * y)
    cos2, sin2 = (x * x - y * y) / r**2, 2 * x * y / r**2
    radial = ((kappa - 1) / 2 * r + 1 / r + (r + (kappa + 1) / r - 1 / r**3) * cos2) / (4 * mu)
    around = -(r + (kappa - 1) / r + 1 / r**3) * sin2 / (4 * mu)
    return np.stack([(radial * x - around * y) / r, (radial * y + around * x) / r, 0 * z], axis=1)


def _goodier(places: np.ndarray) -> np.ndarray:
    """Spherical cavity in an infinite body under unit tension along x."""
    return goodier_displacement(places) / TENSION


PROBLEMS = {
    "lame": Problem(
        lambda: _half_tube(2),
        2,
        _lame(2, flat_end=True),
        prescribed=False,
        pressure=1.0,
        cylinder=True,
        flat_end=True,
    ),
    "lame-open": Problem(
        lambda: _half_tube(2),
        2,
        _lame(2, flat_end=False),
        prescribed=False,
        pressure=1.0,
        cylinder=True,
    ),
    "kirsch": Problem(
        lambda: _half_tube(4), 4, _kirsch, prescribed=True, pressure=0.0, cylinder=True, flat_end=True
    ),
    "goodier": Problem(lambda: _quarter_shell(4), 4, _goodier, prescribed=True, pressure=0.0, cylinder=False),
}


def tetrahedralise(problem: Problem, size: float, *, order: int = 2, seed: int = 1) -> TetMesh:
    """Mesh with elements of `size` at r = 1 that grow like r; `seed` varies gmsh's random perturbation."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.RandomSeed", seed)
        for source in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
            gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
        problem.build()
        gmsh.model.occ.synchronize()
        radius = "Sqrt(x^2+y^2)" if problem.cylinder else "Sqrt(x^2+y^2+z^2)"
        # A seed changes the sizes by up to 2 %: gmsh's own seed alone often leaves the mesh as it is.
        field = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(field, "F", f"{size * (1 + 0.02 * np.sin(seed))}*{radius}")
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        return _arrays(problem, order)
    finally:
        gmsh.finalize()


def _arrays(problem: Problem, order: int) -> TetMesh:
    surfaces: dict[Surface, list[int]] = {}
    for _, face in gmsh.model.getEntities(2):
        _, places, _ = gmsh.model.mesh.getNodes(2, face, includeBoundary=True)
        surface = _surface(_rounded(places.reshape(-1, 3)), cylinder=problem.cylinder)
        surfaces.setdefault(surface, []).append(face)
    mesh = mesh_of_model(surfaces, order)
    return outward(replace(mesh, points=_rounded(mesh.points)))


def _rounded(points: np.ndarray) -> np.ndarray:
    return np.where(np.abs(points) < 1e-12, 0.0, points)


def _surface(corners: np.ndarray, *, cylinder: bool) -> Surface:
    if (corners[..., 1] == 0).all():
        return Surface.SYMMETRY_Y
    if (corners[..., 2] == 0).all():
        return Surface.SYMMETRY_Z
    if cylinder and np.allclose(corners[..., 2], HEIGHT):
        return END
    radius = np.linalg.norm(corners[..., : 2 if cylinder else 3], axis=-1)
    return INNER if np.allclose(radius, 1) else OUTER


def solve(problem: Problem, mesh: TetMesh) -> np.ndarray:
    """Displacement (n_points, 3, 1), mm."""
    n = len(mesh.points)
    f = np.zeros((n, 3))
    if problem.pressure:
        facets = mesh.facets[INNER]
        table = tabulate(facets.shape[1], 4)
        tangent = jacobians(mesh.points[facets], table.gradients)
        area = np.cross(tangent[..., 0], tangent[..., 1]) * table.weights[:, None]
        np.add.at(f, facets, -problem.pressure * np.einsum("eqi,qa->eai", area, table.values))
    fixed = np.zeros((n, 3), dtype=bool)
    u = np.zeros((n, 3))
    for plane, axis in ((Surface.SYMMETRY_Y, 1), (Surface.SYMMETRY_Z, 2)):
        fixed[mesh.facets[plane].ravel(), axis] = True
    if problem.flat_end:
        fixed[np.isclose(mesh.points[:, 2], HEIGHT), 2] = True
    if problem.prescribed:
        radius = np.linalg.norm(mesh.points[:, : 2 if problem.cylinder else 3], axis=1)
        vertices = np.unique(mesh.tets[:, :4])
        outer = np.isclose(radius, problem.outer, rtol=1e-6)
        fixed[outer] = True
        u[outer] = problem.exact(mesh.points[outer])
        assert outer[vertices].any()
    else:  # stop the slide along x where the exact displacement is known
        held = np.argmin(np.linalg.norm(mesh.points - [0, problem.outer, 0], axis=1))
        fixed[held, 0] = True
        u[held] = problem.exact(mesh.points[held : held + 1])[0] * [1, 0, 0]
    K = stiffness(mesh, MATERIAL, pattern(mesh.tets, n))
    free = ~fixed.ravel()
    u[~fixed] = 0.0
    right = np.where(free, f.ravel() - K @ u.ravel(), u.ravel() * K.diagonal())
    factor = factorise(K.constrained(~free))
    return factor(right[:, None]).reshape(n, 3, 1)


@dataclass(frozen=True)
class Solved:
    """A solved body and its recovered stress."""

    problem: Problem
    mesh: TetMesh
    displacement: np.ndarray
    stress: np.ndarray

    @property
    def length(self) -> float:
        """Mean element length up to a factor: dofs^(−1/3)."""
        return self.mesh.points.size ** (-1 / 3)

    @property
    def error(self) -> np.ndarray:
        """Recovered minus exact stress (n_points, 6)."""
        return self.stress - self.problem.stress(self.mesh.points)

    def inner(self) -> np.ndarray:
        """Nodes on the surface r = 1, away from an end that is only held flat."""
        nodes = np.unique(self.mesh.facets[INNER])
        return nodes[self.mesh.points[nodes, 2] < 0.6 * HEIGHT] if self.problem.flat_end else nodes

    def rms(self) -> float:
        """Root-mean-square error over the inner surface, MPa."""
        return float(np.sqrt((self.error[self.inner()] ** 2).sum(axis=1).mean()))


@cache
def solved(name: str, size: float, *, order: int = 2, by_mean: bool = False) -> Solved:
    """Solve a body and recover its stress as `fea` does, or (`by_mean`) without regard to tractions."""
    problem = PROBLEMS[name]
    mesh, u = _displacement(name, size, order)
    recovery = Recovery(mesh, PLANES, () if by_mean else problem.known)
    traction = None if by_mean else problem.traction(mesh)
    return Solved(problem, mesh, u, recovery.nodal_stress(u, MATERIAL, traction=traction)[:, :, 0])


@cache
def _displacement(name: str, size: float, order: int) -> tuple[TetMesh, np.ndarray]:
    mesh = tetrahedralise(PROBLEMS[name], size, order=order)
    return mesh, solve(PROBLEMS[name], mesh)


def rate(values: list[float], lengths: list[float]) -> float:
    """Exponent of the power law through errors against element length."""
    return float(np.polyfit(np.log(lengths), np.log(values), 1)[0])
