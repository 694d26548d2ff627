"""Mass properties as plain numbers."""

from dataclasses import dataclass

Vector = tuple[float, float, float]
Tensor = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class MassProperties:
    """Mass, centre of gravity and inertia tensor of a body in the rod frame.

    Attributes
    ----------
    mass
        t.
    center
        Centre of gravity (x, y, z), mm from the centre of the crank-pin bore.
    inertia
        Inertia tensor about the centre of gravity, 3×3, t·mm².
    """

    mass: float
    center: Vector
    inertia: Tensor

    @property
    def inertia_z(self) -> float:
        """Moment of inertia about the pin-parallel axis through the centre of gravity, t·mm²."""
        return self.inertia[2][2]
