"""Patch test of contact: a rigid plate that presses on the end of a block transmits a constant pressure."""

import numpy as np

from fea.contact.interfaces import PinInBore
from fea.contact.multipliers import Multipliers
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, furthest, held
from fea.verify.cases.patch import SHAKE, shaken
from fea.verify.contact_body import TouchedBody
from geometry.arrays import Floats
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body

LENGTH, WIDTH, HEIGHT, FORCE = 1.0, 0.6, 0.5, 100.0
_WHY = "only rounding errors remain, on elements of any shape"
GOALS = tuple(
    Goal(f"P{order} {what}, worst node", "1", 1.0, 1e-8, _WHY)
    for order in (1, 2)
    for what in ("contact pressure / F/A", "axial stress / F/A")
)


class PlateOnBlock(PinInBore):
    """A flat rigid plate instead of a pin."""

    def shifted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of a unit shift along x, and of none."""
        return self.multipliers.weights, np.zeros(self.multipliers.size)


def along_x(places: Floats) -> Floats:
    """Direction of the force at places (…, 3)."""
    return np.broadcast_to([1.0, 0.0, 0.0], places.shape)


def compute(size: float) -> Computed:
    """Press a block on rollers with elements of `size`, of both orders."""
    corners = (
        ((0.0, 0.0), Surface.SYMMETRY_Y),
        ((LENGTH, 0.0), Surface.OUTER),
        ((LENGTH, WIDTH), Surface.FREE),
        ((0.0, WIDTH), Surface.INNER),
    )
    found: dict[str, float] = {}
    dofs = 0
    for order in (1, 2):
        drawn = mesh_body(Prism(polygon(*corners), (0.0, HEIGHT)), size, order=order)
        mesh = shaken(drawn, SHAKE * size)
        fixed = held(mesh, {Surface.OUTER: (0,)})
        multipliers = Multipliers.of(mesh, Surface.INNER, along_x)
        plate = PlateOnBlock(multipliers, (0.0, 0.0), 0.0, None, cut_y=True, cut_z=True)
        body = TouchedBody(mesh, STEEL, fixed, plate)
        exact = FORCE / (4 * WIDTH * HEIGHT)
        pressure = body.touched(0.0, FORCE).pressure
        on_pressure, on_stress = (goal.quantity for goal in GOALS[2 * order - 2 : 2 * order])
        found[on_pressure] = furthest(pressure / exact, 1.0)
        found[on_stress] = furthest(-body.stress(pressure)[:, 0] / exact, 1.0)
        dofs = mesh.points.size
    return Computed(found, dofs)


BENCHMARK = Benchmark(
    title="Contact patch test on an irregular mesh",
    source="Taylor & Papadopoulos 1991, On a patch test for contact problems in two dimensions",
    goals=GOALS,
    compute=compute,
    size=0.2,
    converges=False,
)
