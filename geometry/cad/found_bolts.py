"""The bolts of an imported assembly: from its holes, its own bolts and nuts, and what the user says."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry.assembly import BoltAxis, BoltSeat
from geometry.cad.bolt_holes import BoltHole
from geometry.cad.fasteners import Fastener
from geometry.cad.holes import place_text
from geometry.cad.seats import Seat
from geometry.cad.spot_face import USUAL
from geometry.errors import GeometryError
from geometry.invalid import InvalidValue, require

# Largest and least part of the room for a seat that is used.
_ROOM, _WIDER = 0.98, 1.1
# A round seat that a head covers to this part of its radius counts as covered.
_WHOLE = 0.9
# Length of an engaged thread over the hole's diameter, where nothing tells it; distance of the first thread
# from the joint, over the hole's diameter.
_ENGAGED, _PLAIN = 1.5, 0.05
# The hole in the rod is that of a nut's bolt, rather than a thread's, if it is not narrower than this part of
# the cap's.
_ALIKE = 0.97

# Of coordinates, which the kernel turned and moved.
_DIGITS = 12


@dataclass(frozen=True)
class FoundSeats:
    """What a bolt presses on, and what was assumed about it, in words.

    Attributes
    ----------
    head_radius, nut_radius
        mm; 0 without a nut.
    grip_end, engaged
        As of `BoltAxis`.
    assumed
        In words.
    """

    head_radius: float
    nut_radius: float
    grip_end: float
    engaged: float
    assumed: tuple[str, ...] = ()


def found_bolts(
    holes: Sequence[BoltHole], fasteners: Sequence[Fastener], given: BoltSeat | None
) -> tuple[tuple[BoltAxis, ...], tuple[str, ...]]:
    """Return the bolts and what was assumed about them.

    Parameters
    ----------
    holes
        Through the joint.
    fasteners
        Of the file; those of one hole stand for all.
    given
        What the user says of the bolts; None for what the file says.

    Raises
    ------
    GeometryError
        No hole runs through the joint, or one has no plane seat for the head.
    InvalidValue
        What is given does not fit the holes.
    """
    if not holes:
        raise GeometryError(
            "no hole for a bolt runs through the joint of rod and cap: a round hole square to the joint must "
            "lead through the cap and go on in the rod. Correct the CAD file"
        )
    pattern = next((hole for hole in holes if any(one.is_in(hole) for one in fasteners)), holes[0])
    own = [one for one in fasteners if one.is_in(pattern)]
    assumed: dict[str, None] = {}
    bolts = []
    for hole in holes:
        head = _required(hole)
        found = _given(hole, given) if given is not None else _told(hole, pattern, own)
        assumed |= dict.fromkeys(found.assumed)
        x, y, z = (hole.point.round(_DIGITS) + 0.0).tolist()
        u, v, w = (hole.direction.round(_DIGITS) + 0.0).tolist()
        bolts.append(
            BoltAxis(
                point=(x, y, z),
                direction=(u, v, w),
                hole_radius=hole.radius,
                head=head.level,
                grip_end=found.grip_end,
                engaged=found.engaged,
                head_radius=found.head_radius,
                nut_radius=found.nut_radius,
                thread_radius=hole.rod_radius,
            )
        )
    return tuple(bolts), tuple(assumed)


def _required(hole: BoltHole) -> Seat:
    if hole.head is None:
        raise GeometryError(
            f"the hole of diameter {2 * hole.radius:.4g} mm through the joint at {place_text(hole.point)} "
            "has no plane seat around it for the head of its bolt, square to the hole. Add one to the cap "
            "in the CAD program"
        )
    return hole.head


def _given(hole: BoltHole, seat: BoltSeat) -> FoundSeats:
    head = _required(hole)
    _require_room("assembly.bolt_head_mm", seat.head_diameter, head, "head")
    end = head.level - seat.grip
    low, high = hole.rod_wall
    if seat.nut_diameter:
        key = "assembly.bolt_nut_mm"
        if hole.nut is None:
            rule = "the rod's holes have no plane seats around their ends for nuts"
            raise InvalidValue(key, seat.nut_diameter, rule, "Give assembly.bolt_engaged_mm.")
        _require_room(key, seat.nut_diameter, hole.nut, "nut")
        level = -hole.nut.level
        rule = f"the seats of head and nut are {head.level - level:.5g} mm apart in the file"
        fits = abs(end - level) < 1e-3 * seat.grip
        require(fits, "assembly.bolt_grip_mm", seat.grip, rule, "Leave it out, or correct it.")
        return FoundSeats(seat.head_diameter / 2, seat.nut_diameter / 2, level, 0.0)
    first = min(high, 0.0)
    rule = (
        f"the thread must begin in the rod's hole, {head.level - first:.5g} to {head.level - low:.5g} mm "
        "from the head's seat"
    )
    slack = 1e-6 * hole.radius
    require(low < end <= first + slack, "assembly.bolt_grip_mm", seat.grip, rule)
    rule = f"the thread must end in the rod's hole, {end - low:.4g} mm beyond the grip"
    require(seat.engaged <= end - low + slack, "assembly.bolt_engaged_mm", seat.engaged, rule)
    return FoundSeats(seat.head_diameter / 2, 0.0, end, min(seat.engaged, end - low))


def _require_room(key: str, diameter: float, seat: Seat, what: str) -> None:
    least, most = 2 * seat.inner, 2 * seat.outer
    rule = f"the plane seat of the {what} in the file reaches from {least:.4g} to {most:.4g} mm in diameter"
    require(least < diameter <= most, key, diameter, rule)


def _told(hole: BoltHole, pattern: BoltHole, fasteners: Sequence[Fastener]) -> FoundSeats:
    """What the file's fasteners tell, or usual proportions."""
    head, assumed = _required(hole), []
    radius = next((r for one in fasteners if (r := one.contact(pattern, _required(pattern).level))), None)
    if radius is None:
        radius = USUAL * hole.radius
        assumed.append(
            f"the bolts' heads, which the file does not show, press on {2 * _fitted(radius, head):.4g} mm in "
            "diameter (assembly.bolt_head_mm)"
        )
    radius = _fitted(radius, head)
    if hole.nut is not None and pattern.nut is not None:
        level = -pattern.nut.level
        nut = next((r for one in fasteners if (r := one.contact(pattern, level))), None)
        if nut is not None:
            return FoundSeats(radius, _fitted(nut, hole.nut), -hole.nut.level, 0.0, tuple(assumed))
        if not fasteners and hole.rod_radius > _ALIKE * hole.radius:
            nut = _fitted(USUAL * hole.radius, hole.nut)
            assumed.append(f"nuts on seats of {2 * nut:.4g} mm, because the rod's holes have seats for them")
            return FoundSeats(radius, nut, -hole.nut.level, 0.0, tuple(assumed))
    low, high = hole.rod_wall
    first = min(high, -2 * _PLAIN * hole.radius)
    if fasteners:
        last = max(low, min(one.end(pattern) for one in fasteners))
    else:
        last = max(low, first - 2 * _ENGAGED * hole.radius)
        assumed.append(
            f"the bolts' threads engage over {first - last:.4g} mm from {-first:.3g} mm behind the joint "
            "(assembly.bolt_engaged_mm)"
        )
    if last >= first:
        raise GeometryError(
            f"the bolt in the hole at {place_text(hole.point)} does not reach into the rod and has no nut. "
            "Correct the CAD file, or give assembly.bolt_head_mm, bolt_grip_mm and bolt_engaged_mm"
        )
    return FoundSeats(radius, 0.0, first, first - last, tuple(assumed))


def _fitted(radius: float, seat: Seat) -> float:
    """Reduce a radius to the room on a seat."""
    if seat.round and radius > _WHOLE * seat.outer:
        return seat.outer  # rather than a thin rim around the head
    fitted = min(radius, _ROOM * seat.outer)
    if fitted < _WIDER * seat.inner:
        raise GeometryError(
            f"a bolt's seat of {2 * seat.inner:.4g} to {2 * seat.outer:.4g} mm in diameter is too narrow to "
            "press on. Correct the CAD file"
        )
    return fitted
