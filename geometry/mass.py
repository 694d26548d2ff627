"""Mass properties as plain numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Vector, vector

Tensor = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class MassProperties:
    """Mass, centre of gravity and inertia tensor of a body in the rod frame."""

    mass: float  #: t
    center: Vector  #: centre of gravity (x, y, z), mm from the centre of the crank-pin bore
    inertia: Tensor  #: inertia tensor about the centre of gravity, 3×3, t·mm²

    @property
    def inertia_z(self) -> float:
        """Moment of inertia about the pin-parallel axis through the centre of gravity, t·mm²."""
        return self.inertia[2][2]

    def times(self, factor: float) -> "MassProperties":
        """Scale the mass: `factor` is the density (t/mm³) where the properties are for density 1."""
        return MassProperties(factor * self.mass, self.center, tensor(factor * np.array(self.inertia)))

    def reflected(self, axis: int) -> "MassProperties":
        """Join the body and its image about the plane through the origin normal to `axis` (0, 1, 2)."""
        sign = np.where(np.arange(3) == axis, -1.0, 1.0)
        inertia = tensor(np.outer(sign, sign) * self.inertia)
        return joined((self, MassProperties(self.mass, vector(sign * self.center), inertia)))


def joined(bodies: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several bodies as one (parallel-axis theorem)."""
    mass = sum(body.mass for body in bodies)
    # Products are summed, rather than a matrix product taken: those of a body and its image cancel exactly.
    center = np.sum([body.mass * np.array(body.center) for body in bodies], axis=0) / mass
    total = np.zeros((3, 3))
    for body in bodies:
        away = body.center - center
        total += body.inertia + body.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return MassProperties(mass, vector(center), tensor(total))


def tensor(rows: Floats) -> Tensor:
    """Return a tensor (3, 3) as plain numbers."""
    x, y, z = map(vector, rows)
    return x, y, z
