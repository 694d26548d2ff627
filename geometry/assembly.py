"""What a rod is assembled from: where its big end is split, its bolts, bushing and bearing shells."""

import math
from dataclasses import dataclass

from geometry.dimensions import Dimensions
from geometry.mirror import Mirror

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class BoltSeat:
    """Where each of the two cap bolts presses on cap and rod.

    It has either a nut or a thread in the rod, from where the grip ends. For a rod from a file, lengths of 0
    are taken from there.

    Attributes
    ----------
    head_diameter
        Outer diameter of the seat under the head, mm.
    grip
        Distance from the head's seat to the nut's, or to the first thread that engages, mm.
    nut_diameter
        Outer diameter of the nut's seat, mm; 0 for a screw.
    engaged
        Length over which the thread engages in the rod, mm; 0 for a bolt with a nut.
    """

    head_diameter: float
    grip: float
    nut_diameter: float = 0.0
    engaged: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Assembly:
    """What is separate in a rod; `geometry.assembly_rules.check` compares it with the rod's dimensions.

    Attributes
    ----------
    split
        Angle from +x of the joint plane's normal, degrees, in the plane of motion. The plane passes through
        the big end's centre: at 0 it is square to the rod. None: the big end is one piece.
    bushing
        Whether the rod's bushing only touches it, rather than being bonded to it.
    shell
        Thickness of the bearing shells in the big end, mm; 0 without shells. They lie inside the ring, and
        the big-end bore is theirs.
    bolt
        None without cap bolts.
    """

    split: float | None = 0.0
    bushing: bool = False
    shell: float = 0.0
    bolt: BoltSeat | None = None

    @property
    def normal(self) -> tuple[float, float]:
        """The joint plane's normal (x, y), from the cap towards the rod."""
        angle = math.radians(self.split or 0.0)
        return math.cos(angle), math.sin(angle)

    def smallest_cell(self, rod: Dimensions) -> Mirror:
        """Return the smallest mirror cell of a rod that is assembled in this way."""
        return rod.smallest_cell if not self.split else Mirror.HALF


@dataclass(frozen=True, kw_only=True)
class BoltAxis:
    """The axis of a bolt of the whole rod; positions along it count from the joint plane.

    Attributes
    ----------
    point
        Where the axis meets the joint plane (x, y, z), mm.
    direction
        Unit vector from the rod to the cap.
    hole_radius
        Of the hole in the cap, mm.
    head
        Position of the head's seat, mm; positive.
    grip_end
        Position of the nut's seat, or of the first thread that engages, mm; negative.
    engaged
        Length of the thread in the rod, away from the cap, mm; 0 for a bolt with a nut.
    head_radius, nut_radius
        Outer radii of the seats, mm; 0 where there is no nut.
    thread_radius
        Of the hole in the rod, mm, where it may be narrower than in the cap.
    """

    point: Vector
    direction: Vector
    hole_radius: float
    head: float
    grip_end: float
    engaged: float
    head_radius: float
    nut_radius: float
    thread_radius: float

    def at(self, position: float) -> Vector:
        """Return the point of the axis at a position, mm."""
        (x, y, z), (u, v, w) = self.point, self.direction
        return x + position * u, y + position * v, z + position * w

    @property
    def grip(self) -> float:
        """Distance from the head's seat to the nut's or to the first thread, mm."""
        return self.head - self.grip_end

    @property
    def thread_end(self) -> float:
        """Position of the last thread that engages, mm; that of the nut's seat for a bolt with a nut."""
        return self.grip_end - self.engaged


def bolt_axes(rod: Dimensions, assembly: Assembly) -> tuple[BoltAxis, ...]:
    """Return the two bolts of a rod given by dimensions, that at the end of larger y first."""
    seat = assembly.bolt
    if seat is None:
        return ()
    nx, ny = assembly.normal
    head, at = rod.cap_boss_length / 2, rod.cap_bolt_spacing / 2
    return tuple(
        BoltAxis(
            point=(-side * at * ny + 0.0, side * at * nx, 0.0),
            direction=(-nx, 0.0 - ny, 0.0),
            hole_radius=rod.cap_bolt / 2,
            head=head,
            grip_end=-head if seat.nut_diameter else head - seat.grip,
            engaged=seat.engaged,
            head_radius=seat.head_diameter / 2,
            nut_radius=seat.nut_diameter / 2,
            thread_radius=rod.cap_bolt / 2,
        )
        for side in (1, -1)
    )
