"""Load cases: everything that acts on the rod at one crank angle."""

import math
from dataclasses import dataclass

from geometry.errors import require, require_number


@dataclass(frozen=True)
class RodMotion:
    """Rigid-body motion of the rod in its own frame.

    Attributes
    ----------
    acceleration
        (x, y) acceleration of the rod frame's origin (the crank-pin centre), mm/s², in rod axes.
    angular_velocity, angular_acceleration
        About rod +z, rad/s and rad/s² (those of the rod: minus the derivatives of β = asin(λ sin θ)).
    """

    acceleration: tuple[float, float]
    angular_velocity: float
    angular_acceleration: float


@dataclass(frozen=True)
class LoadCase:
    """What acts on the rod at one instant; forces on the rod in rod axes, N, tension positive.

    Attributes
    ----------
    name
        ``tension``, ``compression``, ``side``, ``bending``, ``gas``, ``given`` or ``assembly``.
    crank_angle
        rad, with firing TDC at 2π; None for a case that does not come from a crank cycle.
    pin_axial, crank_axial
        Positive pulls that end outwards (pin: along +x, crank: along −x).
    pin_transverse, crank_transverse
        Along rod +y.
    gas, wall
        Gas force on the piston (positive towards the crank); force of the wall on the piston (engine +y).
    torque
        On the crank, N·mm, positive drives it.
    motion
        The rod's motion, or None for a rod at rest.
    """

    name: str
    crank_angle: float | None
    pin_axial: float
    pin_transverse: float
    crank_axial: float
    crank_transverse: float
    gas: float | None = None
    wall: float | None = None
    torque: float | None = None
    motion: RodMotion | None = None

    @property
    def largest_force(self) -> float:
        """The larger of the forces at pin and crank, N."""
        pin = math.hypot(self.pin_axial, self.pin_transverse)
        return max(pin, math.hypot(self.crank_axial, self.crank_transverse))


# Nothing but bolts and fits.
ASSEMBLY = "assembly"


def assembled() -> LoadCase:
    """Make the case of a rod that is put together and at rest: nothing acts on it but its bolts and fits."""
    return LoadCase(
        name=ASSEMBLY,
        crank_angle=None,
        pin_axial=0.0,
        pin_transverse=0.0,
        crank_axial=0.0,
        crank_transverse=0.0,
    )


def given(pin_axial: float, pin_transverse: float = 0.0) -> LoadCase:
    """Make a case from a given pin force, N, without an engine: the crank end reacts it, the rod is at rest.

    The axial part is balanced at the crank end; a transverse part is not (its moment needs a clamped
    big end).

    Raises
    ------
    InvalidValue
        When a force is not a finite number, or there is none.
    """
    axial = require_number("forces.pin_N", pin_axial)
    transverse = require_number("forces.pin_N", pin_transverse)
    rule, remedy = "at least one component must not be zero", "Give [axial, transverse] in newtons."
    require(bool(axial or transverse), "forces.pin_N", [axial, transverse], rule, remedy)
    return LoadCase(
        name="given",
        crank_angle=None,
        pin_axial=axial,
        pin_transverse=transverse,
        crank_axial=axial,
        crank_transverse=-transverse,
    )
