"""Mass properties as plain numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry.arrays import Vector

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
        rows = [[factor * value for value in row] for row in self.inertia]
        return MassProperties(factor * self.mass, self.center, _tensor(rows))

    def reflected(self, axis: int) -> "MassProperties":
        """Join the body and its image about the plane through the origin normal to `axis` (0, 1, 2)."""
        sign = [-1.0 if i == axis else 1.0 for i in range(3)]
        center = [s * value for s, value in zip(sign, self.center, strict=True)]
        rows = [[sign[i] * sign[j] * self.inertia[i][j] for j in range(3)] for i in range(3)]
        image = MassProperties(self.mass, (center[0], center[1], center[2]), _tensor(rows))
        return joined((self, image))


def joined(bodies: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several bodies as one (parallel-axis theorem)."""
    mass = sum(body.mass for body in bodies)
    center = [sum(body.mass * body.center[i] for body in bodies) / mass for i in range(3)]
    total = [[0.0] * 3 for _ in range(3)]
    for body in bodies:
        d = [body.center[i] - center[i] for i in range(3)]
        square = sum(value * value for value in d)
        for i in range(3):
            for j in range(3):
                shift = (square if i == j else 0.0) - d[i] * d[j]
                total[i][j] += body.inertia[i][j] + body.mass * shift
    return MassProperties(mass, (center[0], center[1], center[2]), _tensor(total))


def _tensor(rows: Sequence[Sequence[float]]) -> Tensor:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (a, b, c), (d, e, f), (g, h, i)
