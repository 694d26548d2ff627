"""Where the bolts of a cap sit: the room that a rod has for them."""

from dataclasses import dataclass

from geometry.bosses import bosses
from geometry.rod import Rod

# Of the room on the end of a boss, what a seat may take, as in `geometry.assembly_rules`.
_ROOM = 0.98


@dataclass(frozen=True)
class BoltSeats:
    """A hole through cap and rod, with plane seats around it.

    Attributes
    ----------
    hole
        Diameter, mm.
    length
        From the head's seat to the far seat, or to the end of a hole that does not go through, mm.
    cap
        From the head's seat to the joint, mm.
    room
        Largest radius of a seat around the axis, mm.
    outer
        Diameter of a cylinder around the axis that the clamped parts fill, mm.
    through
        Whether there is a far seat for a nut.
    """

    hole: float
    length: float
    cap: float
    room: float
    outer: float
    through: bool = True


def seats_of(rod: Rod) -> BoltSeats:
    """Return the seats of a parametric rod with cap bolts (`Rod.cap_bolt` is positive)."""
    boss = bosses(rod)
    if boss is None:
        raise ValueError("the rod has no cap bolts")
    outside, across = boss.top - boss.bolt_at, rod.big_end_width / 2
    return BoltSeats(
        hole=rod.cap_bolt,
        length=2 * boss.half_length,
        cap=boss.half_length,
        room=_ROOM * min(outside, across, boss.bolt_at - boss.seat),
        outer=2 * min(outside, across, boss.bolt_at - rod.big_end_bore / 2),
    )
