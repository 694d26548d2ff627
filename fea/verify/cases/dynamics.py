"""Inertia, vibration and buckling: an accelerated bar, a ring, a disc, a free beam, a column."""

import math

import numpy as np

from fea.base.choices import Support
from fea.base.material import Material
from fea.solid.inertia import inertia
from fea.solid.parity import Parity, ParityPair
from fea.solid.supports import SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z, ConstrainedSurface
from fea.solid.traction import nodal_traction, traction_forces
from fea.solvers.buckling import Buckling
from fea.solvers.static import Model
from fea.solvers.vibration import RIGID, free_modes
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, SolvedBody, furthest, half_ring, rectangle, relieved, uniform
from geometry.arrays import Floats
from geometry.bodies import Prism, Side, block
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh

_AT_POINT = "the solution is exact; the stress is the mean over the elements at a single node inside the body"
_FASTER = "the solution is exact, and displacements converge one order faster than stress"
_CUT, _FREE, _NEAR, _FAR = Surface.SYMMETRY_Y, Surface.FREE, Surface.CLAMPED, Surface.LOADED


@benchmark("Timoshenko & Goodier 1970, chapter 9 (bar stretched by its own weight)", size=6.0)
def accelerated_bar(size: float) -> Quantities:
    """Bar under uniform acceleration, pulled at one end.

    The body force of an acceleration, and inertia relief, on a quarter of the bar.
    σ = ρ a x grows from the free end x = 0 to the pulled end, and u = ρ a x²/2E plus quadratic lateral terms,
    so that second-order elements are exact.
    """
    length, acceleration = 100.0, 2e7  # mm, mm/s², of the order of a rod's at 6000 rpm
    stress = STEEL.density * acceleration * length
    sides = rectangle((0.0, length), (0.0, 8.0), (_CUT, _FAR, _FREE, _FREE))
    mesh = mesh_body(Prism(sides, (0.0, 5.0)), size)
    pull = uniform(stress, 0.0, 0.0)
    moving = inertia(mesh, STEEL.density).forces(in_motion((acceleration, 0.0), 0.0, 0.0))
    u = relieved(mesh, ParityPair(traction_forces(mesh, _FAR, pull) + moving.symmetric, None))
    body = SolvedBody(mesh, STEEL, u, (_FREE, _FAR), {_FAR: nodal_traction(mesh, _FAR, pull)})
    error = body.stress[:, 0] / stress - mesh.points[:, 0] / length
    far, near = body.node_at(length, 0.0, 0.0), body.node_at(0.0, 0.0, 0.0)
    elongation = stress * length / (2 * STEEL.youngs_modulus)
    why = "the displacement is quadratic, so that only rounding errors remain"
    yield Quantity("stress / exact stress, worst node", "1", 1.0, furthest(1 + error, 1.0), 1e-6, why)
    yield Quantity("elongation", "mm", elongation, float(u[far, 0, 0] - u[near, 0, 0]), 1e-6, why)
    return body.dofs


@benchmark(
    "closed form: equilibrium of the shear stress in rings, Timoshenko & Goodier 1970, article 27",
    size=3.0,
    converges=True,
)
def spun_up_ring(size: float) -> Quantities:
    """Ring accelerated by a torque at its bore.

    The body force of an angular acceleration, on y ≥ 0 and z ≥ 0, antisymmetric about y = 0.
    The shear stress |σ_rθ| = ρα (b⁴ − r⁴)/4r² follows from equilibrium alone, for any thickness; with
    σ_rθ = μ r (u_θ/r)′ the bore rotates by ρα (b² − a²)²/(8 μ a²) relative to the rim.
    """
    a, middle, b, half_thickness, alpha = 20.0, 30.0, 50.0, 3.0, 1e6
    inner, outer = Surface.INNER, Surface.OUTER

    def shear(r: float) -> float:
        return STEEL.density * alpha * (b**4 - r**4) / (4 * r**2)

    def tangents(places: Floats, _normals: Floats | None = None) -> Floats:
        x, y, _ = places.T
        return np.asarray(np.stack([-y, x, 0 * x], axis=1) / np.hypot(x, y)[:, None])

    ring = Prism(half_ring(a, b, middle), (0.0, half_thickness))
    mesh = mesh_body(ring, size, fine={inner: LocalSize(size / 2)})
    moving = inertia(mesh, STEEL.density).forces(in_motion((0.0, 0.0), 0.0, alpha))
    around = {surface: traction_forces(mesh, surface, tangents) for surface in (inner, outer)}
    driven = moving.part(Parity.ANTISYMMETRIC) + shear(a) * around[inner]
    u = relieved(mesh, ParityPair(moving.symmetric, driven), Parity.ANTISYMMETRIC)
    traction = {inner: nodal_traction(mesh, inner, lambda p: shear(a) * tangents(p))}
    body = SolvedBody(mesh, STEEL, u, (_FREE, inner, outer), traction, Parity.ANTISYMMETRIC)

    def rotation(surface: Surface, radius: float) -> float:
        area = 2 * math.pi * radius * half_thickness / 2
        return float((around[surface] * u[:, :, 0]).sum() / area / radius)

    twist = STEEL.density * alpha * (b**2 - a**2) ** 2 / (8 * STEEL.shear_modulus * a**2)
    stress = float(body.stress[body.node_at(middle, 0.0, 0.0), 3])
    turned = rotation(inner, a) - rotation(outer, b)
    yield Quantity(f"σxy at ({middle:g}, 0)", "MPa", -shear(middle), stress, 0.3, _AT_POINT)
    yield Quantity("rotation of the bore relative to the rim", "rad", twist, turned, 0.01, _FASTER)
    return body.dofs


# A thin disc, mm and rad/s. The stress is that of plane stress plus ν (1 + ν)/(6 (1 − ν)) ρω² (c² − 3z²),
# with c half the thickness, which is exact away from the rim (the edge effect decays within a thickness).
_DISC, _HALF_THICKNESS, _OMEGA = 100.0, 5.0, 1000.0
_NU, _SQUARE = STEEL.poissons_ratio, STEEL.density * _OMEGA**2
_THICK = _NU * (1 + _NU) / (6 * (1 - _NU)) * _HALF_THICKNESS**2
DISC_CENTRE = _SQUARE * ((3 + _NU) / 8 * _DISC**2 + _THICK)


def disc_mesh(size: float) -> TetMesh:
    """Mesh y ≥ 0 and z ≥ 0 with elements of `size`."""
    sides = (
        Side(Line((-_DISC, 0.0), (0.0, 0.0)), _CUT),
        Side(Line((0.0, 0.0), (_DISC, 0.0)), _CUT),
        Side(Arc((0.0, 0.0), _DISC, 0.0, math.pi), Surface.OUTER),
    )
    return mesh_body(Prism(sides, (0.0, _HALF_THICKNESS)), size)


def spun_disc(mesh: TetMesh) -> SolvedBody:
    """Solve the rotating disc on a mesh."""
    spinning = inertia(mesh, STEEL.density).forces(in_motion((0.0, 0.0), _OMEGA, 0.0))
    return SolvedBody(mesh, STEEL, relieved(mesh, spinning), (_FREE, Surface.OUTER))


@benchmark("Timoshenko & Goodier 1970, chapters 4 and 12", size=5.0, converges=True)
def rotating_disc(size: float) -> Quantities:
    """Rotating disc."""
    body = spun_disc(disc_mesh(size))
    stress = body.stress[body.node_at(0.0, 0.0, 0.0), 0]
    outward = traction_forces(body.mesh, Surface.OUTER, lambda _, normals: normals)  # ∫ N_a n dA
    area = (outward * body.mesh.points).sum() / _DISC
    # The mean displacement of the rim is that of plane stress, by reciprocity. A translation along x, which
    # depends on the restraints, does not contribute to ∫ u · n dA.
    widened = float((outward * body.displacement[:, :, 0]).sum() / area)
    rim = _SQUARE * (1 - _NU) * _DISC**3 / (4 * STEEL.youngs_modulus)
    yield Quantity("σxx at the centre, mid-plane", "MPa", DISC_CENTRE, float(stress), 0.1, _AT_POINT)
    yield Quantity("mean radial displacement of the rim", "mm", rim, widened, 0.01, _FASTER)
    return body.dofs


BEAM_STEEL = Material(youngs_modulus=207e3, poissons_ratio=0.3, density=7.8e-9, yield_strength=400.0)
BEAM = (1000.0, 20.0, 30.0)  # mm


def bending_frequency(height: float, root: float) -> float:
    """Frequency, Hz, of the mode with the root βL in the plane in which the beam is `height` thick, mm.

    (f_EB/f)² = 1 + (r/L)² (F² + 6F + (E/κG)(F² − 2F)) to first order in (r/L)², with the Euler–Bernoulli
    frequency f_EB = (βL)²/2πL² r √(E/ρ), F = βL (cosh βL − cos βL)/(sinh βL − sin βL) and κ = 10(1 + ν)/(12 +
    11ν) (Cowper 1966). Without shear and rotary inertia the third mode in the thick plane is 1.8 % off.
    """
    steel, length = BEAM_STEEL, BEAM[0]
    nu, radius = steel.poissons_ratio, height / math.sqrt(12)
    plain = root**2 / (2 * math.pi * length**2) * math.sqrt(steel.youngs_modulus / steel.density) * radius
    F = root * (math.cosh(root) - math.cos(root)) / (math.sinh(root) - math.sin(root))
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    more = F**2 + 6 * F + 2 * (1 + nu) / kappa * (F**2 - 2 * F)
    return plain / math.sqrt(1 + (radius / length) ** 2 * more)


@benchmark("Goens 1931, Annalen der Physik 403, 649-678 (Timoshenko beam, first order)", size=25.0)
def free_beam(size: float) -> Quantities:
    """Free–free beam: bending frequencies."""
    roots = (4.730041, 7.853205, 10.995608)  # of cos βL cosh βL = 1
    exact = sorted(
        (bending_frequency(height, root), f"bending mode {number}, {height:g} mm thick")
        for height in BEAM[1:]
        for number, root in enumerate(roots, start=1)
    )
    mesh = mesh_body(block(*BEAM), size)
    modes = free_modes(mesh, BEAM_STEEL, BEAM_STEEL.density, len(exact)).frequencies[RIGID:]
    why = (
        "the error of the theory is 1e-4 for such slender modes; elements longer than the beam is thick add "
        "up to 1.3e-3"
    )
    for (target, name), hertz in zip(exact, modes, strict=True):
        yield Quantity(name, "Hz", target, float(hertz), 0.2, why)
    return mesh.points.size


# A strut along x, of a width along y and a height along z, mm, and its load, N. The stress is uniform, so
# that only the geometric stiffness and the eigenvalue problem can be wrong.
STRUT, WIDTH, HEIGHT, LOAD = 600.0, 12.0, 16.0, 1000.0


def critical_load(second_moment: float, length_factor: float) -> float:
    """Euler's load with shear, P_E/(1 + P_E/κGA) (Engesser), N; κ of a rectangle by Cowper 1966."""
    nu = STEEL.poissons_ratio
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    euler = math.pi**2 * STEEL.youngs_modulus * second_moment / (length_factor * STRUT) ** 2
    return euler / (1 + euler / (kappa * STEEL.shear_modulus * WIDTH * HEIGHT))


def strut(size: float) -> TetMesh:
    """Mesh a quarter of the strut."""
    sides = rectangle((0.0, STRUT), (0.0, WIDTH / 2), (_CUT, _FAR, _FREE, _NEAR))
    return mesh_body(Prism(sides, (0.0, HEIGHT / 2)), size)


def _buckling_loads(
    mesh: TetMesh, ends: tuple[ConstrainedSurface, ...], count: int
) -> list[tuple[float, Parity]]:
    """Critical loads, N, in increasing order, each with its parity about z = 0."""
    nu, strain = STEEL.poissons_ratio, LOAD / (WIDTH * HEIGHT) / STEEL.youngs_modulus
    pressed = {Parity.SYMMETRIC: (mesh.points * strain * np.array([-1.0, nu, nu]))[..., None]}
    (modes,) = Buckling(Model(mesh, STEEL, Support.INERTIA_RELIEF), ends).modes(pressed, count)
    return [(mode.factor * LOAD, mode.parity_z) for mode in modes]


@benchmark("Euler 1744; Timoshenko & Gere 1961, Theory of Elastic Stability, chapter 2", size=8.0)
def euler_column(size: float) -> Quantities:
    """Slender strut under axial load: linear buckling."""
    mesh = strut(size)
    pins = (
        ConstrainedSurface(_NEAR, 0.0, (SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
        ConstrainedSurface(_FAR, STRUT, (SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
    )
    clamp = (ConstrainedSurface(_NEAR, 0.0, (SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z)),)
    pinned, clamped = _buckling_loads(mesh, pins, 3), _buckling_loads(mesh, clamp, 1)
    sideways = next(load for load, parity_z in pinned if parity_z is Parity.ANTISYMMETRIC)
    in_y, in_z = HEIGHT * WIDTH**3 / 12, WIDTH * HEIGHT**3 / 12
    why = (
        "the error of beam theory is of the order of (thickness / length)², about 1e-3; elements are as long "
        "as the strut is thick"
    )
    yield Quantity("pinned ends, bending in y", "N", critical_load(in_y, 1.0), pinned[0][0], 0.3, why)
    yield Quantity("built-in ends, bending in z", "N", critical_load(in_z, 0.5), sideways, 0.5, why)
    yield Quantity("cantilever, bending in y", "N", critical_load(in_y, 2.0), clamped[0][0], 0.3, why)
    return mesh.points.size
