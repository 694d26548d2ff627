"""NAFEMS R0094, benchmark 1: a steel roller pressed onto an aluminium block, plane strain, no friction.

The targets are those of Hertz for a cylinder and a half-space. The roller is the elastic pin of
`fea.contact`, whose surface curves away from the flat side of the block.
"""

import math

import numpy as np

from fea.base.material import Material
from fea.contact.elastic_pin import Pin
from fea.contact.interfaces import PinInBore
from fea.contact.multipliers import Multipliers, radial
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import held
from fea.verify.contact_body import TouchedBody, contact_end
from geometry.arrays import Floats
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body

RADIUS, FORCE, DEPTH, HALF_WIDTH, NEAR = 50.0, 35e3, 200.0, 100.0, 12.0  # mm, N/mm
ROLLER, BLOCK = (210e3, 0.3), Material(70e3, 0.3, 2.7e-9, 400.0)
_COMPLIANCE = sum((1 - nu**2) / E for E, nu in (ROLLER, (BLOCK.youngs_modulus, BLOCK.poissons_ratio)))
_HALF_ARC = math.sqrt(4 * FORCE * RADIUS * _COMPLIANCE / math.pi)

_SPACE = "Hertz's half-space is sixteen times as wide as the contact here, and his cylinder is a parabola"
WIDTH = Goal("half the width of contact", "mm", _HALF_ARC, 2.0, _SPACE)
PRESSURE = Goal("largest pressure", "MPa", 2 * FORCE / (math.pi * _HALF_ARC), 2.0, _SPACE)


class RollerOnBlock(PinInBore):
    """A roller beside a body instead of in a bore: the gap is that of their shapes."""

    def initial(self) -> Floats:
        """Moments (n,) of the distance from the roller, which touches the side of the block."""
        away = self.multipliers.places[..., :2] - [self.center[0], 0.0]
        return self.multipliers.moments(np.linalg.norm(away, axis=-1) - RADIUS)


def compute(size: float) -> Computed:
    """Solve with elements of `size` at the contact."""
    corners = (
        ((0.0, 0.0), Surface.SYMMETRY_Y),
        ((DEPTH, 0.0), Surface.OUTER),
        ((DEPTH, HALF_WIDTH), Surface.FREE),
        ((0.0, HALF_WIDTH), Surface.FREE),
        ((0.0, NEAR), Surface.INNER),
    )
    mesh = mesh_body(Prism(polygon(*corners), (0.0, size)), 20.0, fine={Surface.INNER: Fine(size, NEAR)})
    fixed = held(mesh, {Surface.OUTER: (0, 1)})
    fixed[mesh.points[:, 2] > size * (1 - 1e-9), 2] = True
    pin = Pin(RADIUS, 0.0, size, None, *ROLLER)
    multipliers = Multipliers.of(mesh, Surface.INNER, radial(-RADIUS))
    touching = RollerOnBlock(multipliers, (-RADIUS, 0.0), 0.0, pin, cut_y=True, cut_z=True, harmonics=512)
    body = TouchedBody(mesh, BLOCK, fixed, touching)
    p = body.touched(0.0, FORCE * 2 * size).pressure
    y = mesh.points[np.unique(mesh.facets[Surface.INNER][:, :3]), 1]
    found = {WIDTH.quantity: contact_end(y, p), PRESSURE.quantity: float(p.max())}
    return Computed(found, mesh.points.size)


BENCHMARK = Benchmark(
    title="NAFEMS R0094-1: steel roller on an aluminium block",
    source="Konter 2006 (NAFEMS R0094), benchmark 1; Hertz 1881",
    goals=(WIDTH, PRESSURE),
    compute=compute,
    size=0.3,
    converges=False,
)
