"""Thread, grip and seats of the bolts of a study, in the room that a rod has for them."""

import math
from dataclasses import dataclass

from fea.base.note import Assumed
from fea.study.assembly_table import AssemblyTable
from fea.study.bolts import Thread, thread_in_hole
from geometry.errors import InvalidValue, require
from geometry.outline import bosses
from geometry.rod import Rod

# Of the room on the end of a boss, what a seat may take, as in `geometry.assembly`.
_ROOM = 0.98


@dataclass(frozen=True)
class BoltSeats:
    """A hole through cap and rod, with plane seats around it."""

    hole: float  #: diameter, mm
    #: From the head's seat to the far seat, or to the end of a hole that does not go through, mm
    length: float
    cap: float  #: from the head's seat to the joint, mm
    room: float  #: largest radius of a seat around the axis, mm
    outer: float  #: diameter of a cylinder around the axis that the clamped parts fill, mm
    through: bool = True  #: whether there is a far seat for a nut


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


# Height of a nut over d (ISO 4032: 0.84 to 0.9), beyond which a bolt stands out by two pitches.
_NUT_HEIGHT = 0.9
# Engaged thread over d in steel: usual, and least (suppliers' tables for property class 10.9: 0.8 to 1.25).
_ENGAGED, _LEAST_ENGAGED = 1.25, 0.8
# Least seat over the hole, and least shank, of waisted bolts, over d.
_LEAST_SEAT, _LEAST_SHANK = 1.1, 0.6
_ALIKE = 1e-6
# Least length of hole behind the thread over its diameter, as in `geometry.assembly`.
_PLAIN = 0.05


@dataclass(frozen=True, kw_only=True)
class BoltShape:
    """A bolt in its seats; lengths in mm."""

    thread: Thread
    grip: float  #: from the seat of the head to that of the nut, or to the first thread that carries
    engaged: float  #: length of thread in the rod from the end of the grip; 0 with a nut
    #: Outer diameters of the seats; that of the nut is 0 for a screw in a threaded hole
    head_diameter: float
    nut_diameter: float
    shank_diameter: float
    free_thread: float  #: length of thread in the grip; the rest is shank
    hole: float  #: its diameter

    @property
    def least_diameter(self) -> float:
        """d₀: the stress diameter of the thread, or the diameter of a thinner shank, mm."""
        return min(self.thread.stress_diameter, self.shank_diameter)

    @property
    def least_area(self) -> float:
        """A₀ = π/4 d₀², mm²."""
        return math.pi / 4 * self.least_diameter**2

    @property
    def least_seat_area(self) -> float:
        """A_p: area of the smaller seat, mm²."""
        seat = min(self.head_diameter, self.nut_diameter or self.head_diameter)
        return math.pi / 4 * (seat**2 - self.hole**2)


def bolt_shape(table: AssemblyTable, seats: BoltSeats, assumed: Assumed) -> BoltShape:
    """Complete what a study says of the shape of its bolts.

    Raises `InvalidValue`: they do not fit the rod.
    """
    thread = _thread(table, seats, assumed)
    d, (grip, engaged) = thread.diameter, _grip(table, seats, thread, assumed)
    head = _seat(table, "head", seats, thread, assumed)
    nut = _seat(table, "nut", seats, thread, assumed) if engaged == 0 else 0.0
    shank = assumed.or_else(table.bolt_shank_mm, d, "shank {:g} mm (assembly.bolt_shank_mm)")
    least = _LEAST_SHANK * d
    rule = f"must be at least {least:.3g} mm and at most the hole's diameter, {seats.hole:g} mm"
    require(least <= shank <= seats.hole * (1 + _ALIKE), "assembly.bolt_shank_mm", shank, rule)
    # Of bolts of up to 125 mm, 2 d + 6 mm are threaded (ISO 4014).
    usual = 2 * d + 6 - (_NUT_HEIGHT * d + 2 * thread.pitch if engaged == 0 else engaged)
    key = "assembly.bolt_free_thread_mm"
    usual = min(max(usual, 0.0), grip)
    free = assumed.or_else(table.bolt_free_thread_mm, usual, f"{{:.3g}} mm of thread in the grip ({key})")
    require(free <= grip, key, free, f"must be at most the grip, {grip:g} mm")
    return BoltShape(
        thread=thread,
        grip=grip,
        engaged=engaged,
        head_diameter=head,
        nut_diameter=nut,
        shank_diameter=shank,
        free_thread=free,
        hole=seats.hole,
    )


def _thread(table: AssemblyTable, seats: BoltSeats, assumed: Assumed) -> Thread:
    thread, key = table.thread, "assembly.bolt_thread"
    if thread is not None:
        rule = f"must not be thicker than its hole, {seats.hole:g} mm"
        fits = thread.diameter <= seats.hole * (1 + _ALIKE)
        require(fits, key, table.bolt_thread, rule, "Enlarge the hole (rod.cap_bolt_mm).")
        return thread
    standard = thread_in_hole(seats.hole)
    if standard is None:
        rule = f"is missing, and no standard bolt goes through a hole of {seats.hole:g} mm"
        raise InvalidValue(key, None, rule, 'Give it, as "M2.5x0.45".')
    assumed.append(f"thread {standard.name} ({key})")
    return standard


def _grip(table: AssemblyTable, seats: BoltSeats, thread: Thread, assumed: Assumed) -> tuple[float, float]:
    """Grip and engaged length, mm."""
    given, length = table.bolt_grip_mm, seats.length
    shorter = given is not None and given < length * (1 - 1e-3)
    if table.bolt_nut_mm is None and (table.bolt_engaged_mm is not None or shorter or not seats.through):
        return _screwed(table, seats, thread, assumed)
    rule = "has no seat: the hole does not go through"
    require(seats.through, "assembly.bolt_nut_mm", table.bolt_nut_mm, rule, "Leave it out.")
    rule = f"of a bolt with a nut must be the distance of the seats, {length:g} mm"
    remedy = "Leave it out, or leave out bolt_nut_mm for a screw in a threaded hole."
    alike = given is None or math.isclose(given, length, rel_tol=1e-3)
    require(alike, "assembly.bolt_grip_mm", given, rule, remedy)
    if given is None:
        assumed.append(f"a nut, and thus a grip of {length:.4g} mm (assembly.bolt_grip_mm)")
    return length, 0.0


def _screwed(table: AssemblyTable, seats: BoltSeats, thread: Thread, assumed: Assumed) -> tuple[float, float]:
    given, key = table.bolt_grip_mm, "assembly.bolt_grip_mm"
    wanted = table.bolt_engaged_mm or _ENGAGED * thread.diameter
    grip = seats.length - wanted if given is None else given
    left = seats.length - grip
    rule = f"must reach beyond the joint, {seats.cap:.4g} mm from the head's seat, to clamp the cap"
    remedy = "Lengthen the grip, the bosses (rod.cap_boss_length_mm) or the hole, or engage less thread."
    require(grip >= seats.cap, key, grip, rule, remedy)
    if given is None:
        assumed.append(f"grip {grip:.4g} mm ({key})")
    if table.bolt_engaged_mm is not None:
        rule = f"must be at most {left:.4g} mm, what the grip of {grip:.4g} mm leaves of the hole"
        require(wanted <= left * (1 + _ALIKE), "assembly.bolt_engaged_mm", wanted, rule, remedy)
    # A thread that nearly reaches the end of the hole reaches it.
    near = table.bolt_engaged_mm is None and left - wanted < _PLAIN * seats.hole
    engaged, least = left if near else wanted, _LEAST_ENGAGED * thread.diameter
    rule = f"leaves {engaged:.4g} mm of engaged thread, less than {_LEAST_ENGAGED:g} d: it would strip"
    remedy = f"Engage at least {least:.4g} mm."
    require(engaged >= least * (1 - _ALIKE), key, grip, rule, remedy)
    if table.bolt_engaged_mm is None:
        assumed.append(f"{engaged:.4g} mm of engaged thread (assembly.bolt_engaged_mm)")
    return grip, engaged


def _seat(table: AssemblyTable, what: str, seats: BoltSeats, thread: Thread, assumed: Assumed) -> float:
    """Outer diameter of the seat of head or nut."""
    key, least, most = f"bolt_{what}_mm", _LEAST_SEAT * seats.hole, 2 * seats.room
    name, given = f"assembly.{key}", getattr(table, key)
    rule = (
        f"needs at least {least:.4g} mm, {_LEAST_SEAT:g} of the hole, and the rod has a seat of {most:.4g} mm"
    )
    remedy = "Increase rod.cap_bolt_spacing_mm, or rod.cap_boss_length_mm."
    require(most >= least, name, given, rule, remedy)
    usual = min(max(thread.usual_seat, least), most)
    seat: float = assumed.or_else(given, usual, f"a seat of {{:.3g}} mm under the {what} ({name})")
    rule = f"must be {least:.4g} to {most:.4g} mm: wider than the hole, and on the plane seat"
    require(least * (1 - _ALIKE) <= seat <= most * (1 + _ALIKE), name, seat, rule)
    return seat
