"""The rules that the parts of an assembled rod must obey to go together."""

import math

from geometry.assembly import Assembly, BoltSeat
from geometry.bosses import Bosses
from geometry.dimensions import Dimensions
from geometry.invalid import InvalidValue, require, require_number
from geometry.outline import Outline

# Largest angle of the joint plane from the plane square to the rod, degrees: 0 to 60 on rods.
_MOST_OBLIQUE = 75.0
# Least angle between the joint plane and the fillet of the shank, seen from the bore, degrees.
_CLEAR_OF_SHANK = 2.0
# A shell has at least this part of the bore's diameter (a fortieth on engines), and at most this part of
# the ring.
_THINNEST, _THICKEST = 0.005, 0.5
# Seats reach out to this part of the room that they have, and are at least this much wider than the hole.
_ROOM, _WIDER = 0.98, 1.1
# Least distance of a bolt's hole from the bearing, over the bearing's radius; least length of a hole
# without engaged thread, at the joint or at the rod's seat, over the hole's diameter.
_WALL, _PLAIN = 0.02, 0.05
# Lengths that are meant to be equal differ by less, relatively.
_EQUAL = 1e-6


def check(rod: Dimensions, assembly: Assembly) -> None:
    """Raise `InvalidValue` for the first rule that an assembly of `rod` breaks; keys are those of a study."""
    _bushing(rod, assembly)
    _split(rod, assembly)
    _shell(rod, assembly)
    if assembly.bolt is not None:
        _bolts(rod, assembly, assembly.bolt)


def _bushing(rod: Dimensions, assembly: Assembly) -> None:
    rule = "needs a bushing in the small end, but the rod has none"
    fits = not assembly.bushing or rod.bushing > 0
    require(fits, "assembly.bushing_interference_mm", None, rule, "Give its thickness as rod.bushing_mm.")


def _split(rod: Dimensions, assembly: Assembly) -> None:
    if assembly.split is None:
        remedy = 'Add assembly.split = "straight".'
        for given, key in ((assembly.shell, "shell_thickness_mm"), (assembly.bolt, "bolt_head_mm")):
            require(
                not given, f"assembly.{key}", None, "needs a big end that is split into rod and cap", remedy
            )
        return
    split = require_number("assembly.split", assembly.split)
    rule = f"must lie between −{_MOST_OBLIQUE:g}° and {_MOST_OBLIQUE:g}°"
    require(abs(split) <= _MOST_OBLIQUE, "assembly.split", split, rule, "0 is a straight split.")
    fillet = math.degrees(_shank_angle(rod))
    most = 90 - fillet - _CLEAR_OF_SHANK
    require(
        abs(split) <= most,
        "assembly.split",
        split,
        f"the joint plane must clear the fillet between ring and shank, which begins {fillet:.3g}° from the "
        f"rod's axis: at most {most:.3g}°",
        "Turn the plane less, or reduce rod.big_end_fillet_mm or rod.shank_depth_big_end_mm.",
    )
    bosses = Outline(rod).bosses
    if split and bosses is not None:
        x, y = bosses.fillets()[1].end
        boss = math.degrees(math.atan2(y, x))
        most = boss - fillet - _CLEAR_OF_SHANK
        require(
            abs(split) <= most,
            "assembly.split",
            split,
            f"the bosses turn with the joint, and one would hit the shank: its fillet ends {boss:.3g}° from "
            f"the joint's normal, that of the shank begins at {fillet:.3g}°, so at most {max(most, 0):.3g}°",
            "Turn the joint less, shorten rod.cap_boss_length_mm, or reduce rod.big_end_fillet_mm or "
            "rod.shank_depth_big_end_mm.",
        )


def _shank_angle(rod: Dimensions) -> float:
    """Angle from the rod's axis at which the outline leaves the big end's ring for the shank, rad."""
    x, y = Outline(rod).fillets[0].start
    return math.atan2(y, x)


def _shell(rod: Dimensions, assembly: Assembly) -> None:
    key, shell = "assembly.shell_thickness_mm", require_number("assembly.shell_thickness_mm", assembly.shell)
    if shell == 0:
        return
    least, most = _THINNEST * rod.big_end_bore, _THICKEST * rod.big_end_ring
    rule = (
        f"must lie between {least:.3g} mm, {_THINNEST:g} of the big end's bore, and {most:.4g} mm, half of "
        "its ring: the shells lie inside rod.big_end_ring_mm"
    )
    require(least <= shell <= most, key, shell, rule, "Thicken the ring or reduce the shells.")
    rule = f"must be at least twice the chamfer of the bore, {rod.big_end_chamfer:g} mm"
    require(shell >= 2 * rod.big_end_chamfer, key, shell, rule, "Reduce rod.big_end_chamfer_mm.")


def _bolts(rod: Dimensions, assembly: Assembly, seat: BoltSeat) -> None:
    bosses = Outline(rod).bosses
    if bosses is None:
        rule = "needs holes for the cap bolts, but the rod has none"
        raise InvalidValue("assembly.bolt_head_mm", seat.head_diameter, rule, "Give rod.cap_bolt_mm.")
    _bearing(rod, assembly, bosses)
    _wide(rod, bosses, "assembly.bolt_head_mm", seat.head_diameter, "head")
    grip = require_number("assembly.bolt_grip_mm", seat.grip)
    if bool(seat.nut_diameter) == bool(seat.engaged):
        rule = "a bolt has either a nut or a thread that engages in the rod"
        raise InvalidValue("assembly.bolt_nut_mm", seat.nut_diameter, rule, "Give one of the two.")
    if seat.nut_diameter:
        _wide(rod, bosses, "assembly.bolt_nut_mm", seat.nut_diameter, "nut")
        _between_seats(rod, grip)
    else:
        _thread(rod, bosses, grip, require_number("assembly.bolt_engaged_mm", seat.engaged))


def _bearing(rod: Dimensions, assembly: Assembly, bosses: Bosses) -> None:
    bearing = rod.big_end_bore / 2 + assembly.shell
    least = 2 * ((1 + _WALL) * bearing + bosses.bolt_radius)
    what = "the back of the shells" if assembly.shell else "the bore"
    require(
        rod.cap_bolt_spacing >= least,
        "rod.cap_bolt_spacing_mm",
        rod.cap_bolt_spacing,
        f"the bolts would run through the bearing: their holes must clear {what}, {2 * bearing:g} mm in "
        f"diameter, so the spacing must be at least {least:.4g} mm",
        "Increase it, or take thinner bolts or shells.",
    )


def _wide(rod: Dimensions, bosses: Bosses, key: str, diameter: float, what: str) -> None:
    """Refuse a seat that is smaller than the hole or larger than the plane end of the boss."""
    diameter = require_number(key, diameter)
    inwards, outwards = bosses.bolt_at - bosses.seat, bosses.top - bosses.bolt_at
    most = 2 * _ROOM * min(inwards, outwards, rod.big_end_width / 2)
    remedy = "Take a smaller one."
    if inwards <= min(outwards, rod.big_end_width / 2):
        spacing = 2 * (bosses.seat + diameter / 2 / _ROOM)
        remedy = (
            f"Increase rod.cap_bolt_spacing_mm to {spacing + 0.01:.2f} mm, or lengthen the bosses "
            "(rod.cap_boss_length_mm) to widen their plane ends."
        )
    rule = f"the seat of the {what} must fit on the plane end of the boss: at most {most:.4g} mm"
    require(diameter <= most, key, diameter, rule, remedy)
    least = _WIDER * rod.cap_bolt
    rule = f"must be at least {least:.4g} mm, {_WIDER:g} times the hole's diameter, to press on anything"
    require(diameter >= least, key, diameter, rule, "Take a larger one.")


def _between_seats(rod: Dimensions, grip: float) -> None:
    length = rod.cap_boss_length
    require(
        abs(grip - length) <= _EQUAL * length,
        "assembly.bolt_grip_mm",
        grip,
        f"with nuts, the grip is the length of the bosses, {length:g} mm, between whose ends the bolts clamp",
        "Leave it out, or change rod.cap_boss_length_mm.",
    )


def _thread(rod: Dimensions, bosses: Bosses, grip: float, engaged: float) -> None:
    half, length, plain = bosses.half_length, rod.cap_boss_length, _PLAIN * rod.cap_bolt
    require(
        half + plain <= grip < length,
        "assembly.bolt_grip_mm",
        grip,
        f"the thread must begin in the rod's half of the boss: {half + plain:.4g} mm to less than "
        f"{length:g} mm from the head's seat",
        "Change it, or rod.cap_boss_length_mm.",
    )
    room = length - grip
    require(
        0 < engaged <= room * (1 + _EQUAL),
        "assembly.bolt_engaged_mm",
        engaged,
        f"the thread must end in the rod's boss, {room:.4g} mm beyond the grip",
        "Shorten the thread or the grip, or lengthen rod.cap_boss_length_mm.",
    )
    rest = room - engaged
    rule = f"must end with the boss ({room:.4g} mm) or at least {plain:.3g} mm before its end"
    require(rest <= _EQUAL * room or rest >= plain, "assembly.bolt_engaged_mm", engaged, rule)
