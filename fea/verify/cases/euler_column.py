"""Euler column: slender strut under axial load, with the end conditions of a rod on its pins.

The stress is uniform, so that only the geometric stiffness and the eigenvalue problem can be wrong. Shear
reduces the Euler load P_E to P_E/(1 + P_E/κGA) (Engesser), here by 0.2 % for two built-in ends.
"""

import math

import numpy as np

from fea.base.choices import Support
from fea.solid.bore_motion import SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z, Held
from fea.solid.parity import Parity
from fea.solvers.buckling import Buckling
from fea.solvers.static import Model
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import TetMesh

LENGTH, WIDTH, HEIGHT = 600.0, 12.0, 16.0  # along x, y and z
LOAD = 1000.0
_AREA = WIDTH * HEIGHT


def critical(inertia: float, length_factor: float) -> float:
    """Critical load with shear, N; κ of a rectangle by Cowper 1966."""
    nu = STEEL.poissons_ratio
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    euler = math.pi**2 * STEEL.youngs_modulus * inertia / (length_factor * LENGTH) ** 2
    return euler / (1 + euler / (kappa * STEEL.shear_modulus * _AREA))


IN_PLANE, SIDEWAYS = HEIGHT * WIDTH**3 / 12, WIDTH * HEIGHT**3 / 12
_WHY = (
    "the error of beam theory is of the order of (thickness / length)², about 1e-3; elements are as long as "
    "the strut is thick"
)
PINNED = Goal("pinned ends, bending in y", "N", critical(IN_PLANE, 1.0), 0.3, _WHY)
BUILT_IN = Goal("built-in ends, bending in z", "N", critical(SIDEWAYS, 0.5), 0.5, _WHY)
CANTILEVER = Goal("cantilever, bending in y", "N", critical(IN_PLANE, 2.0), 0.3, _WHY)

_NEAR, _FAR = Surface.CLAMPED, Surface.LOADED
_PINS = (
    Held(_NEAR, 0.0, (SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
    Held(_FAR, LENGTH, (SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y)),
)
_ONE_END = (Held(_NEAR, 0.0, (SLIDE_X, SLIDE_Y, SLIDE_Z, TURN_X, TURN_Y, TURN_Z)),)


def strut(size: float) -> TetMesh:
    """Mesh a quarter of the strut."""
    corners = (
        ((0.0, 0.0), Surface.SYMMETRY_Y),
        ((LENGTH, 0.0), _FAR),
        ((LENGTH, WIDTH / 2), Surface.FREE),
        ((0.0, WIDTH / 2), _NEAR),
    )
    return mesh_body(Prism(polygon(*corners), (0.0, HEIGHT / 2)), size)


def loads(mesh: TetMesh, ends: tuple[Held, ...], count: int) -> list[tuple[float, Parity]]:
    """Critical loads, N, in increasing order, each with its parity about z = 0."""
    nu, strain = STEEL.poissons_ratio, LOAD / _AREA / STEEL.youngs_modulus
    pressed = {Parity.SYMMETRIC: (mesh.points * strain * np.array([-1.0, nu, nu]))[..., None]}
    (modes,) = Buckling(Model(mesh, STEEL, Support.INERTIA_RELIEF), ends).modes(pressed, count)
    return [(mode.factor * LOAD, mode.parity_z) for mode in modes]


def compute(size: float) -> Computed:
    """Solve the strut with elements of `size`."""
    mesh = strut(size)
    pinned, free = loads(mesh, _PINS, 3), loads(mesh, _ONE_END, 1)
    found = {
        PINNED.quantity: pinned[0][0],
        BUILT_IN.quantity: next(load for load, parity_z in pinned if parity_z is Parity.ANTISYMMETRIC),
        CANTILEVER.quantity: free[0][0],
    }
    return Computed(found, mesh.points.size)


BENCHMARK = Benchmark(
    title="Slender strut under axial load: linear buckling",
    source="Euler 1744; Timoshenko & Gere 1961, Theory of Elastic Stability, chapter 2",
    goals=(PINNED, BUILT_IN, CANTILEVER),
    compute=compute,
    size=8.0,
    converges=False,
)
