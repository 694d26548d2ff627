"""The engine as the rod sees it."""

from dataclasses import dataclass

from geometry.invalid import require, require_number, require_positive


@dataclass(frozen=True)
class Engine:
    """Crank, rod and piston of one cylinder, and how the cylinders are phased.

    Attributes
    ----------
    crank_radius, rod_length, bore
        mm; the rod is longer than the crank radius plus the pin offset.
    piston_mass
        Piston with pin and rings, t.
    pin_offset
        Distance of the cylinder axis from the crank axis along engine +y (désaxé), mm.
    friction
        Coulomb coefficient between piston and wall.
    cylinders
        How many; cylinder k fires `phase`·k after the first.
    phase
        Crank angle between consecutive cylinders, rad.
    """

    crank_radius: float
    rod_length: float
    bore: float
    piston_mass: float
    pin_offset: float = 0.0
    friction: float = 0.0
    cylinders: int = 1
    phase: float = 0.0
