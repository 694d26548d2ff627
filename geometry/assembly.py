"""The assembly specification of a rod: joint plane, bolts, bushing and bearing shells, with their rules."""

import math
from dataclasses import dataclass

from geometry.arrays import Vector
from geometry.dimensions import Dimensions
from geometry.errors import InvalidValue, require, require_number
from geometry.outline import Bosses, Outline, web_pocket
from geometry.rod import require_of


@dataclass(frozen=True, kw_only=True)
class BoltSeat:
    """Seats of bolts with a nut, or a thread from the end of the grip; lengths of 0 are taken from a file."""

    head_diameter: float  #: outer diameter of the seat under the head, mm
    grip: float  #: distance from the head's seat to the nut's, or to the first thread that engages, mm
    nut_diameter: float = 0.0  #: outer diameter of the nut's seat, mm; 0 for a screw
    engaged: float = 0.0  #: length over which the thread engages in the rod, mm; 0 for a bolt with a nut


@dataclass(frozen=True, kw_only=True)
class Assembly:
    """Parts of a rod that are separate; `geometry.assembly.check` compares them with its dimensions."""

    #: Angle from +x of the joint plane's normal, degrees, in the plane of motion. The plane passes through
    #: the big end's centre: at 0 it is square to the rod. None: the big end is one piece.
    split: float | None = 0.0
    bushing: bool = False  #: whether the rod's bushing only touches it, rather than being bonded to it
    #: Thickness of the bearing shells in the big end, mm; 0 without shells. They lie inside the ring, and the
    #: big-end bore is theirs.
    shell: float = 0.0
    bolt: BoltSeat | None = None  #: none without cap bolts

    @property
    def normal(self) -> tuple[float, float]:
        """The joint plane's normal (x, y), from the cap towards the rod."""
        angle = math.radians(self.split or 0.0)
        return math.cos(angle), math.sin(angle)


@dataclass(frozen=True, kw_only=True)
class BoltAxis:
    """The axis of a bolt of the whole rod; positions along it count from the joint plane."""

    point: Vector  #: where the axis meets the joint plane (x, y, z), mm
    direction: Vector  #: unit vector from the rod to the cap
    hole_radius: float  #: of the hole in the cap, mm
    head: float  #: position of the head's seat, mm; positive
    grip_end: float  #: position of the nut's seat, or of the first thread that engages, mm; negative
    engaged: float  #: length of the thread in the rod, away from the cap, mm; 0 for a bolt with a nut
    #: head_radius, nut_radius: outer radii of the seats, mm; 0 where there is no nut
    head_radius: float
    nut_radius: float
    thread_radius: float  #: of the hole in the rod, mm, where it may be narrower than in the cap

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


# Least angle between the joint plane and the fillet of the shank, seen from the bore, degrees.
_CLEAR_OF_SHANK = 2.0
# Part of the bore's diameter that a shell has at least (a fortieth on engines), and of the ring at most.
_THINNEST, _THICKEST = 0.005, 0.5
# Seats reach out to this part of the room that they have, and are at least this much wider than the hole.
ROOM, WIDER = 0.98, 1.1
# Least distance of a bolt's hole from the bearing, over the bearing's radius; least length of a hole
# without engaged thread, at the joint or at the rod's seat, over the hole's diameter.
_WALL, PLAIN = 0.02, 0.05
# Lengths that are meant to be equal differ by less, relatively.
_EQUAL = 1e-6


def check(rod: Dimensions, assembly: Assembly) -> None:
    """Raise `InvalidValue` for the first rule that an assembly of `rod` breaks; keys are those of a study."""
    fits = not assembly.bushing or rod.bushing > 0
    rule = "needs a bushing in the small end, but the rod has none"
    _require(fits, "bushing_interference_mm", None, rule, "Give its thickness as rod.bushing_mm.")
    if assembly.split is None:
        for given, key in ((assembly.shell, "shell_thickness_mm"), (assembly.bolt, "bolt_head_mm")):
            rule = "needs a big end that is split into rod and cap"
            _require(not given, key, None, rule, 'Add assembly.split = "straight".')
    else:
        _split(rod, require_number("assembly.split", assembly.split))
    _shell(rod, require_number("assembly.shell_thickness_mm", assembly.shell))
    if assembly.bolt is not None:
        _bolts(rod, assembly, assembly.bolt)


def _require(holds: bool, key: str, value: object, rule: str, remedy: str = "") -> None:  # noqa: FBT001
    require(holds, f"assembly.{key}", value, rule, remedy)


def _split(rod: Dimensions, split: float) -> None:
    outline = Outline(rod)
    x, y = outline.fillets[0].start
    fillet = math.degrees(math.atan2(y, x))  # where the outline leaves the big end's ring for the shank
    most = 90 - fillet - _CLEAR_OF_SHANK
    rule = (
        f"the joint plane must clear the fillet between ring and shank, which begins {fillet:.3g}° from the "
        f"rod's axis: at most {most:.3g}°"
    )
    remedy = "Turn the plane less, or reduce rod.big_end_fillet_mm or rod.shank_depth_big_end_mm."
    _require(abs(split) <= most, "split", split, rule, remedy)
    if not split or outline.bosses is None:
        return
    x, y = outline.bosses.fillets()[1].end
    boss = math.degrees(math.atan2(y, x))
    most = boss - fillet - _CLEAR_OF_SHANK
    rule = (
        f"the bosses turn with the joint, and one would hit the shank: its fillet ends {boss:.3g}° from "
        f"the joint's normal, that of the shank begins at {fillet:.3g}°, so at most {max(most, 0):.3g}°"
    )
    remedy = (
        "Turn the joint less, shorten rod.cap_boss_length_mm, or reduce rod.big_end_fillet_mm or "
        "rod.shank_depth_big_end_mm."
    )
    _require(abs(split) <= most, "split", split, rule, remedy)
    if rod.has_side_pockets:
        angle, begins = math.radians(abs(split)), web_pocket(rod, outline.edge).big_end
        reach = outline.bosses.half_length * math.cos(angle) + outline.bosses.top * math.sin(angle)
        rule = f"a turned boss would reach to {reach:.4g} mm, but the pockets begin at {begins:.4g} mm"
        remedy = "Turn the joint less, or increase rod.pocket_setback_mm."
        _require(reach <= begins, "split", split, rule, remedy)


def _shell(rod: Dimensions, shell: float) -> None:
    if shell == 0:
        return
    key, least, most = "shell_thickness_mm", _THINNEST * rod.big_end_bore, _THICKEST * rod.big_end_ring
    rule = (
        f"must lie between {least:.3g} mm, {_THINNEST:g} of the big end's bore, and {most:.4g} mm, half of "
        "its ring: the shells lie inside rod.big_end_ring_mm"
    )
    _require(least <= shell <= most, key, shell, rule, "Thicken the ring or reduce the shells.")
    rule = f"must be at least twice the chamfer of the bore, {rod.big_end_chamfer:g} mm"
    _require(shell >= 2 * rod.big_end_chamfer, key, shell, rule, "Reduce rod.big_end_chamfer_mm.")


def _bolts(rod: Dimensions, assembly: Assembly, seat: BoltSeat) -> None:
    bosses = Outline(rod).bosses
    if bosses is None:
        rule = "needs holes for the cap bolts, but the rod has none"
        raise InvalidValue("assembly.bolt_head_mm", seat.head_diameter, rule, "Give rod.cap_bolt_mm.")
    _clear_of_bearing(rod, assembly, bosses)
    _seat_fits(rod, bosses, "head", seat.head_diameter)
    grip = require_number("assembly.bolt_grip_mm", seat.grip)
    rule = "a bolt has either a nut or a thread that engages in the rod"
    either = bool(seat.nut_diameter) != bool(seat.engaged)
    _require(either, "bolt_nut_mm", seat.nut_diameter, rule, "Give one of the two.")
    if seat.nut_diameter:
        _seat_fits(rod, bosses, "nut", seat.nut_diameter)
        length = rod.cap_boss_length
        rule = (
            f"with nuts, the grip is the length of the bosses, {length:g} mm, between whose ends the bolts "
            "clamp"
        )
        equal = abs(grip - length) <= _EQUAL * length
        _require(equal, "bolt_grip_mm", grip, rule, "Leave it out, or change rod.cap_boss_length_mm.")
    else:
        _thread(rod, bosses, grip, require_number("assembly.bolt_engaged_mm", seat.engaged))


def _clear_of_bearing(rod: Dimensions, assembly: Assembly, bosses: Bosses) -> None:
    bearing = rod.big_end_bore / 2 + assembly.shell
    least = 2 * ((1 + _WALL) * bearing + bosses.bolt_radius)
    what = "the back of the shells" if assembly.shell else "the bore"
    rule = (
        f"the bolts would run through the bearing: their holes must clear {what}, {2 * bearing:g} mm in "
        f"diameter, so the spacing must be at least {least:.4g} mm"
    )
    remedy = "Increase it, or take thinner bolts or shells."
    require_of(rod, "cap_bolt_spacing", rod.cap_bolt_spacing >= least, rule, remedy)


def _seat_fits(rod: Dimensions, bosses: Bosses, what: str, diameter: float) -> None:
    key = f"bolt_{what}_mm"
    diameter = require_number(f"assembly.{key}", diameter)
    inwards, outwards = bosses.bolt_at - bosses.seat, bosses.top - bosses.bolt_at
    most = 2 * ROOM * min(inwards, outwards, rod.big_end_width / 2)
    remedy = "Take a smaller one."
    if inwards <= min(outwards, rod.big_end_width / 2):
        spacing = 2 * (bosses.seat + diameter / 2 / ROOM)
        remedy = (
            f"Increase rod.cap_bolt_spacing_mm to {spacing + 0.01:.2f} mm, or lengthen the bosses "
            "(rod.cap_boss_length_mm) to widen their plane ends."
        )
    rule = f"the seat of the {what} must fit on the plane end of the boss: at most {most:.4g} mm"
    _require(diameter <= most, key, diameter, rule, remedy)
    least = WIDER * rod.cap_bolt
    rule = f"must be at least {least:.4g} mm, {WIDER:g} times the hole's diameter, to have a seat"
    _require(diameter >= least, key, diameter, rule, "Take a larger one.")


def _thread(rod: Dimensions, bosses: Bosses, grip: float, engaged: float) -> None:
    length, plain = rod.cap_boss_length, PLAIN * rod.cap_bolt
    least, room = bosses.half_length + plain, length - grip
    rule = (
        f"the thread must begin in the rod's half of the boss: {least:.4g} mm to less than "
        f"{length:g} mm from the head's seat"
    )
    _require(least <= grip < length, "bolt_grip_mm", grip, rule, "Change it, or rod.cap_boss_length_mm.")
    rule = f"the thread must end in the rod's boss, {room:.4g} mm beyond the grip"
    remedy = "Shorten the thread or the grip, or lengthen rod.cap_boss_length_mm."
    _require(0 < engaged <= room * (1 + _EQUAL), "bolt_engaged_mm", engaged, rule, remedy)
    rest = room - engaged
    rule = f"must end with the boss ({room:.4g} mm) or at least {plain:.3g} mm before its end"
    _require(rest <= _EQUAL * room or rest >= plain, "bolt_engaged_mm", engaged, rule)
