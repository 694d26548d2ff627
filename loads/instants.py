"""What acts on the rod at instants: load cases, of a rod at rest too, or a whole cycle."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Self, cast

import numpy as np
import numpy.typing as npt

from geometry.arrays import Floats, Ints, Mask
from geometry.errors import require, require_number

Names = npt.NDArray[np.str_]
_ZERO, _UNKNOWN = cast("tuple[Floats, Floats]", (np.float64(0.0), np.float64(math.nan)))
_NO_NAME = cast("Names", np.str_(""))


@dataclass(frozen=True, kw_only=True, eq=False)
class Instants:
    """What acts on the rod at instants; indexing and iteration give single ones, without the last axis.

    Forces and motion are in rod axes (+x from crank to piston pin). A scalar stands for every instant.
    """

    #: pin, crank: (2, n) forces on the rod along x and y, N
    pin: Floats
    crank: Floats
    #: (2, n) of the rod frame's origin (the crank-pin centre), mm/s²; 0 for a rod at rest
    acceleration: Floats = _ZERO
    #: angular_velocity, angular_acceleration: (n,) of the rod about +z, rad/s and rad/s²; 0 for a rod at rest
    angular_velocity: Floats = _ZERO
    angular_acceleration: Floats = _ZERO
    crank_angle: Floats = _UNKNOWN  #: (n,) rad, with firing TDC at 2π; NaN where none belongs to the instant
    speed: Floats = _UNKNOWN  #: (n,) of the crank, rad/s; NaN where the instant is none of a crank cycle
    #: gas, wall, torque: (n,) gas force on the piston (positive towards the crank) and force of the wall on
    #: the piston (along engine +y), N; torque on the crank (positive drives it), N·mm; NaN without an engine
    gas: Floats = _UNKNOWN
    wall: Floats = _UNKNOWN
    torque: Floats = _UNKNOWN
    #: (n,) ``tension``, ``compression``, ``side``, ``bending``, ``gas``, ``given`` or ``assembly``; empty for
    #: the instants of a cycle
    names: Names = _NO_NAME

    def __post_init__(self) -> None:
        shape = np.shape(self.pin)[1:]
        for item in fields(Instants):
            value = np.asarray(getattr(self, item.name))
            vector = item.name in {"pin", "crank", "acceleration"}
            object.__setattr__(self, item.name, np.broadcast_to(value, (2, *shape) if vector else shape))

    def __len__(self) -> int:
        return len(self.speed)

    def __getitem__(self, which: int | slice | Ints | Mask | None) -> "Instants":
        return Instants(**{item.name: getattr(self, item.name)[..., which] for item in fields(Instants)})

    def __iter__(self) -> Iterator["Instants"]:
        return (self[number] for number in range(len(self)))

    def named(self, name: str) -> Self:
        """Return the same with a name."""
        return replace(self, names=np.array(name))

    def times(self, factor: float) -> Self:
        """Return the same with a multiple of everything that acts."""
        return replace(
            self,
            pin=factor * self.pin,
            crank=factor * self.crank,
            acceleration=factor * self.acceleration,
            angular_velocity=np.sqrt(factor) * self.angular_velocity,
            angular_acceleration=factor * self.angular_acceleration,
        )

    @property
    def name(self) -> str:
        """The name of a single instant."""
        return str(self.names)

    @property
    def pin_axial(self) -> Floats:
        """Force along the rod at the piston pin, N, positive where it pulls that end outwards."""
        return np.asarray(self.pin[0])[()]

    @property
    def pin_transverse(self) -> Floats:
        """Force along +y at the piston pin, N."""
        return np.asarray(self.pin[1])[()]

    @property
    def crank_axial(self) -> Floats:
        """Force along the rod at the crank pin, N, positive where it pulls that end outwards (along −x)."""
        return np.asarray(0.0 - self.crank[0])[()]

    @property
    def crank_transverse(self) -> Floats:
        """Force along +y at the crank pin, N."""
        return np.asarray(self.crank[1])[()]

    @property
    def largest_force(self) -> Floats:
        """The larger of the forces at pin and crank, N."""
        return np.asarray(np.maximum(np.hypot(*self.pin), np.hypot(*self.crank)))[()]

    @property
    def motions(self) -> Floats:
        """Weights (4, n) of the unit motions a_x, ω² (even about y = 0), a_y and α (odd)."""
        along, across = self.acceleration
        return np.stack([along, self.angular_velocity**2, across, self.angular_acceleration])

    @property
    def in_cycle(self) -> Mask:
        """Whether each is an instant of a crank cycle: gas alone, given forces and an assembly are none."""
        return np.asarray(~np.isnan(self.speed))


_NOTHING = Instants(pin=np.zeros((2, 0)), crank=np.zeros((2, 0)))


def joined(parts: Sequence[Instants]) -> Instants:
    """Return instants, single ones or several each, one after another."""
    rows = [part if part.speed.ndim else part[None] for part in (_NOTHING, *parts)]
    return Instants(
        **{
            item.name: np.concatenate([getattr(row, item.name) for row in rows], axis=-1)
            for item in fields(Instants)
        }
    )


def in_motion(
    acceleration: tuple[float, float], angular_velocity: float = 0.0, angular_acceleration: float = 0.0
) -> Instants:
    """Return a rod in motion on which no forces act; units as in `Instants`."""
    return Instants(
        pin=np.zeros(2),
        crank=np.zeros(2),
        acceleration=np.array(acceleration),
        angular_velocity=np.array(angular_velocity),
        angular_acceleration=np.array(angular_acceleration),
    )


# Nothing but bolts and fits.
ASSEMBLY = "assembly"


def assembled() -> Instants:
    """Return the case of an assembled rod at rest: nothing acts on it but its bolts and fits."""
    return Instants(names=np.array(ASSEMBLY), pin=np.zeros(2), crank=np.zeros(2))


def given(pin_axial: float, pin_transverse: float = 0.0) -> Instants:
    """Return the case of a given pin force, N, on a rod at rest, which the crank end reacts.

    The axial part is balanced at the crank end; a transverse part is not (its moment needs a clamped big
    end). Raises `InvalidValue`: a force is not a finite number, or there is none.
    """
    force = [require_number("forces.pin_N", pin_axial), require_number("forces.pin_N", pin_transverse)]
    rule, remedy = "at least one component must not be zero", "Give [axial, transverse] in newtons."
    require(any(force), "forces.pin_N", force, rule, remedy)
    return Instants(names=np.array("given"), pin=np.array(force), crank=-np.array(force))
