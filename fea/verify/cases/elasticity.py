"""Elasticity against exact solutions: Lamé, Goodier, the patch test, a manufactured solution."""

import math

import numpy as np
import numpy.typing as npt

from fea.base.material import Material
from fea.solid.assembly import gauss_blocks, stress_from_gradient, tabulate
from fea.solid.parity import Parity
from fea.solid.stress import matrices
from fea.solid.traction import body_forces, nodal_traction, traction_forces
from fea.solvers.static import displacement
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import (
    STEEL,
    LoadedBody,
    SolvedBody,
    eighth_ball,
    furthest,
    held,
    hoop_stress,
    nodes_of,
    pressure,
    quarter_ring,
    straightened,
)
from geometry.arrays import Floats
from geometry.bodies import Prism, Side, block
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh, refined

Complexes = npt.NDArray[np.complex128]

_AT_NODE = "the solution is exact; this is the error of the recovered stress at this size, at the worst node"
_FASTER = "the solution is exact, and displacements converge one order faster than stress"

# Lamé's thick cylinder under internal pressure in plane strain (Timoshenko & Goodier 1970, article 28).
INSIDE, OUTSIDE, THICKNESS, PRESSURE = 10.0, 20.0, 3.0, 100.0
HOOP = PRESSURE * (OUTSIDE**2 + INSIDE**2) / (OUTSIDE**2 - INSIDE**2)
LAME_HOOP = "hoop stress at the bore, worst node"


def lame_body(size: float, order: int = 2) -> LoadedBody:
    """A slice of a quarter, with elements of `size` at the outside and half of it at the bore."""
    body = Prism(quarter_ring(INSIDE, OUTSIDE), (0.0, THICKNESS), top=Surface.ROLLER)
    mesh = mesh_body(body, size, order=order, fine={Surface.INNER: LocalSize(size / 2)})
    forces = traction_forces(mesh, Surface.INNER, pressure(PRESSURE))
    radial = np.array([PRESSURE, PRESSURE, 0.0]) / INSIDE
    pressed = nodal_traction(mesh, Surface.INNER, lambda places: radial * places)
    known, fixed = (Surface.INNER, Surface.OUTER), held(mesh, {Surface.ROLLER: (2,)})
    return LoadedBody(mesh, STEEL, forces, fixed, known, {Surface.INNER: pressed})


def lame_exact(points: Floats, material: Material) -> tuple[Floats, Floats]:
    """Displacement (n, 3), mm, and stress (n, 6), MPa, at places (n, 3)."""
    x, y, _ = points.T
    r = np.hypot(x, y)
    c, s, none = x / r, y / r, np.zeros_like(r)
    a2, b2, nu = INSIDE**2, OUTSIDE**2, material.poissons_ratio
    unit = PRESSURE * a2 / (b2 - a2)
    radial, hoop = unit * (1 - b2 / r**2), unit * (1 + b2 / r**2)
    widening = (1 + nu) / material.youngs_modulus * unit * ((1 - 2 * nu) * r + b2 / r)
    stress = [
        radial * c * c + hoop * s * s,
        radial * s * s + hoop * c * c,
        nu * (radial + hoop),
        (radial - hoop) * c * s,
        none,
        none,
    ]
    return np.stack([widening * c, widening * s, none], axis=1), np.stack(stress, axis=1)


def lame_hoop(mesh: TetMesh, stress: Floats) -> Quantity:
    """Hoop stress at the bore that is furthest from the exact one, from nodal stress (n_nodes, 6)."""
    # At the mirror plane. On the opposite face, also a mirror plane of the problem, recovery uses one side
    # only.
    bore = nodes_of(mesh, Surface.INNER, Surface.SYMMETRY_Z)
    worst = furthest(hoop_stress(mesh.points[bore], stress[bore]), HOOP)
    return Quantity(LAME_HOOP, "MPa", HOOP, worst, 0.2, _AT_NODE)


@benchmark("Lamé 1852; Timoshenko & Goodier 1970, article 28", size=0.9, converges=True)
def lame(size: float) -> Quantities:
    """Lamé: thick cylinder under internal pressure, plane strain."""
    body = lame_body(size).solved()
    bore = nodes_of(body.mesh, Surface.INNER, Surface.SYMMETRY_Z)
    x, y, _ = body.mesh.points[bore].T / INSIDE
    widening = x * body.displacement[bore, 0, 0] + y * body.displacement[bore, 1, 0]
    target = float(lame_exact(np.array([[INSIDE, 0.0, 0.0]]), STEEL)[0][0, 0])
    name, worst = "radial displacement of the bore, worst node", furthest(widening, target)
    yield lame_hoop(body.mesh, body.stress)
    yield Quantity(name, "mm", target, worst, 0.02, _FASTER)
    return body.dofs


# Weber's round shaft with a groove along it. The origin is at the centre of the groove, on the circumference.
SHAFT, GROOVE, LENGTH, SHEAR = 10.0, 2.0, 4.0, 100.0


@benchmark("Weber 1921; Timoshenko & Goodier 1970, chapter 10", size=1.0, converges=True)
def grooved_shaft(size: float) -> Quantities:
    """Torsion of a round shaft with a groove.

    Shear out of the plane is largest on a curved free surface. The half y ≥ 0 is antisymmetric about y = 0
    and, like the end z = 0, free to warp. Prandtl's stress function is μθ/2 (b² − r² + 2a x (1 − b²/r²)) for
    the radii a and b of shaft and groove, so that the shear at the bottom of the groove is μθ (2a − b),
    nearly twice that of a shaft without one.
    """
    cut, twist = Surface.SYMMETRY_Y, SHEAR / (2 * SHAFT - GROOVE)  # μθ, MPa/mm
    meet = math.acos(GROOVE / (2 * SHAFT))  # angle at the groove's centre to where it meets the circumference
    sides = (
        Side(Line((GROOVE, 0.0), (2 * SHAFT, 0.0)), cut),
        Side(Arc((SHAFT, 0.0), SHAFT, 0.0, 2 * meet), Surface.OUTER),
        Side(Arc((0.0, 0.0), GROOVE, meet, -meet), Surface.INNER),
    )
    body = Prism(sides, (0.0, LENGTH), Surface.ROLLER, Surface.LOADED)
    mesh = mesh_body(body, size, fine={Surface.INNER: LocalSize(size / 5)})

    def shear(places: Floats, _normals: Floats) -> Floats:
        x, y, _ = places.T
        flow = SHAFT * (1 + (GROOVE / (x + 1j * y)) ** 2) - (x - 1j * y)
        return np.asarray(-twist * np.stack([flow.imag, flow.real, 0 * x], axis=1))

    fixed = held(mesh, {cut: (0, 2), Surface.ROLLER: (0, 1)})
    fixed[nodes_of(mesh, cut, Surface.OUTER, Surface.LOADED), 1] = True  # or it would turn about the axis x
    u = LoadedBody(mesh, STEEL, traction_forces(mesh, Surface.LOADED, shear), fixed).solved().displacement
    known = (Surface.INNER, Surface.OUTER)
    solved = SolvedBody(mesh, STEEL, u, known, parity=Parity.ANTISYMMETRIC)
    # Surfaces of known traction need not hold an edge's nodes: at the ends, stress is that of one side only.
    inside = (mesh.points[:, 2] > 0.0) & (mesh.points[:, 2] < LENGTH)
    bottom, end = nodes_of(mesh, cut, Surface.INNER), solved.node_at(GROOVE, 0.0, LENGTH)
    worst = furthest(solved.stress[bottom[inside[bottom]], 4], -SHEAR)
    moved = -twist / STEEL.shear_modulus * LENGTH * (2 * SHAFT - GROOVE)
    yield Quantity("σyz at the bottom of the groove, worst node", "MPa", -SHEAR, worst, 0.5, _AT_NODE)
    yield Quantity("u_y of its end", "mm", moved, float(u[end, 1, 0]), 0.01, _FASTER)
    return solved.dofs


# Goodier's spherical cavity in an infinite body under tension. The model is an eighth of a ball around the
# cavity, with the exact tractions on its outside, so that the size of the ball does not matter.
CAVITY, BALL, TENSION = 1.0, 4.0, 100.0
_PIECES = 8
EQUATOR = TENSION * (27 - 15 * STEEL.poissons_ratio) / (2 * (7 - 5 * STEEL.poissons_ratio))
GOODIER_EQUATOR = "σxx at the equator, worst node"


def goodier_displacement(places: Complexes) -> Complexes:
    """Displacement (n, 3), mm, under tension along x (Goodier 1933), analytic in the places (n, 3)."""
    mu, nu, E = STEEL.shear_modulus, STEEL.poissons_ratio, STEEL.youngs_modulus
    b = TENSION / (8 * mu * (7 - 5 * nu))
    a, c = -(13 - 10 * nu) * b, 5 * (1 - 2 * nu) * b
    x, y, z = places.T / CAVITY
    s2 = y * y + z * z
    r = np.sqrt(x * x + s2)
    cos2 = (x * x - s2) / r**2
    radial = -a / r**2 - 3 * b / r**4 + ((5 - 4 * nu) / (1 - 2 * nu) * c / r**2 - 9 * b / r**4) * cos2
    # u_θ = −(2C/r² + 6B/r⁴) sin 2θ, divided by sin θ cos θ to stay analytic on the axis.
    around = -2 * (2 * c / r**2 + 6 * b / r**4)
    along = radial * x / r - around * s2 / r**2 * x / r
    across = radial / r + around * (x / r) ** 2 / r
    far = TENSION / E * np.stack([x, -nu * y, -nu * z], axis=1)
    return np.asarray(CAVITY * (far + np.stack([along, across * y, across * z], axis=1)))


def goodier_stress(places: Floats) -> Floats:
    """Stress (n, 6), MPa, by complex steps (Squire & Trapp 1998)."""
    step = 1e-30
    columns = [goodier_displacement(places + 1j * step * axis).imag / step for axis in np.eye(3)]
    return stress_from_gradient(np.stack(columns, axis=-1), STEEL)


def goodier_body(size: float, order: int = 2) -> LoadedBody:
    """The eighth of a ball, with elements of `size` at the cavity."""
    # In pieces, because element sizes depend on the distance to the edges of faces.
    ball = eighth_ball(CAVITY, BALL, _PIECES)
    fine = {Surface.INNER: LocalSize(size, math.pi / 2 * CAVITY / _PIECES / 2)}
    mesh = mesh_body(ball, 18 * size, order=order, fine=fine, growth=0.35)

    def traction(places: Floats, normals: Floats) -> Floats:
        return np.asarray((matrices(goodier_stress(places)) @ normals[:, :, None])[:, :, 0])

    forces = traction_forces(mesh, Surface.OUTER, traction)
    return LoadedBody(mesh, STEEL, forces, held(mesh, {}), (Surface.INNER,))


def goodier_equator(mesh: TetMesh, stress: Floats) -> Quantity:
    """The σxx at the equator that is furthest from the exact one, from nodal stress (n_nodes, 6)."""
    nodes = nodes_of(mesh, Surface.INNER, Surface.SYMMETRY_X)
    return Quantity(GOODIER_EQUATOR, "MPa", EQUATOR, furthest(stress[nodes, 0], EQUATOR), 0.2, _AT_NODE)


@benchmark(
    "Goodier 1933, Trans. ASME 55, 39-44; Timoshenko & Goodier 1970, chapter 12", size=0.04, converges=True
)
def goodier(size: float) -> Quantities:
    """Goodier: spherical cavity under remote tension."""
    body, nu = goodier_body(size).solved(), STEEL.poissons_ratio
    target, stress = (
        -TENSION * (3 + 15 * nu) / (2 * (7 - 5 * nu)),
        float(body.stress[body.node_at(CAVITY, 0.0, 0.0), 1]),
    )
    why = (
        "the solution is exact; the stress at the pole is a third of that at the equator, so that the same "
        "error counts three times as much"
    )
    yield goodier_equator(body.mesh, body.stress)
    yield Quantity("σyy at the pole", "MPa", target, stress, 0.2, why)
    return body.dofs


# Random displacement of inner vertices in patch tests, relative to the element size.
SHAKE = 0.05
ROUNDING = "only rounding errors remain, on elements of any shape"


def shaken(mesh: TetMesh, distance: float) -> TetMesh:
    """Move inner vertices at random but reproducibly; edges stay straight.

    With curved edges the stiffness would not be exact, because its quadrature is exact for straight edges
    only.
    """
    inside = np.ones(len(mesh.points), dtype=bool)
    for facets in mesh.facets.values():
        inside[facets] = False
    moves = np.random.default_rng(1).uniform(-distance, distance, mesh.points.shape)
    return TetMesh(straightened(mesh.points + inside[:, None] * moves, mesh.tets), mesh.tets, mesh.facets)


@benchmark("Taylor, Simo, Zienkiewicz & Chan 1986, Int. J. Numer. Meth. Eng. 22, 39-62", size=0.25)
def patch(size: float) -> Quantities:
    """Patch test on an irregular mesh."""
    # A linear displacement, prescribed on the boundary of a cube of 1 mm, is exact inside. Its gradient has
    # no symmetry, and a shift keeps it away from zero.
    gradient = 1e-3 * np.array([[1.0, 0.4, -0.3], [0.2, -0.7, 0.5], [-0.6, 0.1, 0.8]])
    shift = np.array([4e-3, -4e-3, 4e-3])
    for order in (1, 2):
        mesh = shaken(mesh_body(block(1.0, 1.0, 1.0), size, order=order), SHAKE * size)
        exact = shift + mesh.points @ gradient.T
        boundary = held(mesh, {Surface.FREE: (0, 1, 2)})
        u = displacement(mesh, STEEL, np.zeros_like(exact), boundary, exact)
        stress = SolvedBody(mesh, STEEL, u).stress
        exact_stress = stress_from_gradient(gradient, STEEL)
        fields = {"displacement": (u[:, :, 0], exact), "stress": (stress, exact_stress)}
        for what, (computed, known) in fields.items():
            # 1 plus the signed error that is largest relative to the size of the exact field at the node.
            errors = (computed - known) / np.linalg.norm(known, axis=-1, keepdims=True)
            name, worst = f"P{order} {what} / exact {what}, worst node", furthest(1 + errors.ravel(), 1.0)
            yield Quantity(name, "1", 1.0, worst, 1e-10, ROUNDING)
    return mesh.points.size


# The manufactured displacement is a sum of plane waves Σ c sin(k · x + φ); it requires the body force
# Σ ((λ + μ) (c · k) k + μ |k|² c) sin(k · x + φ) and is prescribed on the whole boundary of a cube. Amplitude
# c, wave vector k and phase φ of each wave have no symmetry.
_WAVES = (
    (np.array([1.0, 0.5, -0.3]), np.array([2.0, 1.0, -1.0]), 0.3),
    (np.array([-0.4, 0.8, 0.6]), np.array([-1.0, 2.0, 1.5]), 1.1),
)
ERROR_DEGREE = 6


def manufactured_displacement(places: Floats) -> Floats:
    """Displacement (n, 3), mm."""
    waves = (c * np.sin(places @ k + phase)[:, None] for c, k, phase in _WAVES)
    return np.asarray(sum(waves))


def manufactured_gradient(places: Floats) -> Floats:
    """∂u_i/∂x_j (n, 3, 3)."""
    waves = (np.outer(c, k) * np.cos(places @ k + phase)[:, None, None] for c, k, phase in _WAVES)
    return np.asarray(sum(waves))


def manufactured_force(places: Floats) -> Floats:
    """Force per volume (n, 3), N/mm³, that the displacement requires."""
    lam, mu = STEEL.lame_lambda, STEEL.shear_modulus
    waves = (
        ((lam + mu) * (c @ k) * k + mu * (k @ k) * c) * np.sin(places @ k + phase)[:, None]
        for c, k, phase in _WAVES
    )
    return np.asarray(sum(waves))


def manufactured_solution(mesh: TetMesh) -> Floats:
    """Displacement (n_nodes, 3), solved on a mesh."""
    exact, boundary = manufactured_displacement(mesh.points), held(mesh, {Surface.FREE: (0, 1, 2)})
    u = displacement(mesh, STEEL, body_forces(mesh, manufactured_force), boundary, exact)
    return np.asarray(u[:, :, 0])


def _l2_errors(mesh: TetMesh) -> tuple[float, float]:
    """L2 norms of the errors of displacement and gradient, solved on a mesh."""
    u = manufactured_solution(mesh)
    values = tabulate(mesh.tets.shape[1], ERROR_DEGREE).values
    squares = np.zeros(2)
    for part, gauss in gauss_blocks(mesh, ERROR_DEGREE):
        places = (values @ mesh.points[mesh.tets[part]]).reshape(-1, 3)
        nodal, volumes = u[mesh.tets[part]], gauss.volumes.ravel()
        moved = (values @ nodal).reshape(-1, 3)
        slope = np.einsum("eai,eqaj->eqij", nodal, gauss.gradients, optimize=True).reshape(-1, 3, 3)
        squares[0] += volumes @ ((moved - manufactured_displacement(places)) ** 2).sum(axis=1)
        squares[1] += volumes @ ((slope - manufactured_gradient(places)) ** 2).sum(axis=(1, 2))
    in_u, in_gradient = np.sqrt(squares)
    return float(in_u), float(in_gradient)


@benchmark("Ciarlet, The Finite Element Method for Elliptic Problems (1978), section 3.2", size=0.5)
def manufactured(size: float) -> Quantities:
    """Manufactured solution: rates of convergence."""
    why = "the rate must be within 0.1 of the theoretical order, which holds in the limit of small elements"
    dofs = 0
    for order in (1, 2):  # refined twice; first-order meshes begin with half the size
        coarse = refined(mesh_body(block(1.0, 1.0, 1.0), order / 2 * size, order=order))
        fine = refined(coarse)
        dofs = max(dofs, fine.points.size)
        before, after = _l2_errors(coarse), _l2_errors(fine)
        for number, what in enumerate(("displacement", "gradient")):
            theory, rate = order + 1.0 - number, math.log2(before[number] / after[number])
            yield Quantity(f"L2 rate, P{order}, {what}", "1", theory, rate, 100 * 0.1 / theory, why)
    return dofs
