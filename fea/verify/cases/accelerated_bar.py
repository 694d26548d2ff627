"""Bar accelerated by a pull at one end: the body force of an acceleration, and inertia relief.

σ = ρ a x grows from the free end x = 0 to the pulled end, and u = ρ a x²/2E plus quadratic lateral terms, so
that second-order elements are exact. Boundary conditions and solution are those of a rod.
"""

import numpy as np

from fea.base.choices import Support
from fea.solid.inertia import inertia
from fea.solid.parity import Parity, Split
from fea.solid.traction import nodal_traction, traction_forces
from fea.solvers.static import Model
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, SolvedBody
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.generate import mesh_body

LENGTH, HALF_WIDTH, HALF_HEIGHT = 100.0, 8.0, 5.0
ACCELERATION = 2e7  # mm/s², of the order of a rod's at 6000 rpm
_STRESS = STEEL.density * ACCELERATION * LENGTH

_WHY = "the displacement is quadratic, so that only rounding errors remain"
STRESS = Goal("stress / exact stress, worst node", "1", 1.0, 1e-6, _WHY)
ELONGATION = Goal("elongation", "mm", _STRESS * LENGTH / (2 * STEEL.youngs_modulus), 1e-6, _WHY)


def compute(size: float) -> Computed:
    """Solve a quarter of the bar with elements of `size`."""
    corners = (
        ((0.0, 0.0), Surface.SYMMETRY_Y),
        ((LENGTH, 0.0), Surface.LOADED),
        ((LENGTH, HALF_WIDTH), Surface.FREE),
        ((0.0, HALF_WIDTH), Surface.FREE),
    )
    mesh = mesh_body(Prism(polygon(*corners), (0.0, HALF_HEIGHT)), size)
    pull = np.array([_STRESS, 0.0, 0.0])
    pulled = traction_forces(mesh, Surface.LOADED, lambda places, _: np.broadcast_to(pull, places.shape))
    moving = inertia(mesh, STEEL.density).forces(in_motion((ACCELERATION, 0.0), 0.0, 0.0))
    model = Model(mesh, STEEL, Support.INERTIA_RELIEF)
    u = model.solve([Split(pulled + moving.symmetric, None)]).displacement[Parity.SYMMETRIC]
    traction = nodal_traction(mesh, Surface.LOADED, lambda places: np.broadcast_to(pull, places.shape))
    solved = SolvedBody(mesh, STEEL, u, (Surface.FREE, Surface.LOADED), {Surface.LOADED: traction})
    x = mesh.points[:, 0]
    error = solved.stress[:, 0] / _STRESS - x / LENGTH
    far, near = solved.node_at(LENGTH, 0.0, 0.0), solved.node_at(0.0, 0.0, 0.0)
    found = {
        STRESS.quantity: float(1 + error[np.abs(error).argmax()]),
        ELONGATION.quantity: float(u[far, 0, 0] - u[near, 0, 0]),
    }
    return Computed(found, solved.dofs)


BENCHMARK = Benchmark(
    title="Bar under uniform acceleration, pulled at one end",
    source="Timoshenko & Goodier 1970, chapter 9 (bar stretched by its own weight)",
    goals=(STRESS, ELONGATION),
    compute=compute,
    size=6.0,
    converges=False,
)
