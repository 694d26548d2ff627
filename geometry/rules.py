"""The rules that the dimensions of a rod must obey; each message names the dimension to change."""

from geometry.dimensions import Dimensions, ShankSection, dimensions, options
from geometry.errors import InvalidValue, require, require_number
from geometry.outline import Bosses, Outline
from geometry.side_faces import Pocket, ring_steps, web_pocket


def check_options(rod: Dimensions) -> None:
    """Raise `InvalidValue` for the first rule that an option of `rod` breaks."""
    _small_end(rod)
    _chamfers(rod)
    if (bosses := Outline(rod).bosses) is not None:
        _bosses(rod, bosses)
        _bolts(rod, bosses)


def _small_end(rod: Dimensions) -> None:
    crown, least, most = rod.small_end_crown_width, 0.3 * rod.small_end_width, 0.98 * rod.small_end_width
    require(
        crown == 0 or least <= crown <= most,
        "rod.small_end_crown_width_mm",
        crown,
        f"must be 0 (no slant) or {least:.4g} to {most:.4g} mm, 0.3 to 0.98 of the small end's width",
    )
    most = 0.8 * rod.small_end_ring
    rule = f"must be at most {most:.4g} mm, 0.8 of the small end's ring"
    require(rod.bushing <= most, "rod.bushing_mm", rod.bushing, rule, "Thicken small_end_ring_mm.")
    most = 0.5 * min(crown or rod.small_end_width, rod.small_end_bore)
    rule = f"must be at most {most:.4g} mm: half of the small end's bore and of its width at the crown"
    require(rod.oil_hole <= most, "rod.oil_hole_mm", rod.oil_hole, rule, "Reduce it.")


def _chamfers(rod: Dimensions) -> None:
    for end in ("big_end", "small_end"):
        size, ring = getattr(rod, f"{end}_chamfer"), getattr(rod, f"{end}_ring")
        wall = rod.bushing if end == "small_end" and rod.bushing else ring
        most = min(0.5 * wall, 0.2 * getattr(rod, f"{end}_width"), 0.1 * getattr(rod, f"{end}_bore"))
        rule = (
            f"must be at most {most:.4g} mm: half of the wall, a fifth of the width, a tenth of the bore, "
            "whichever is least"
        )
        require(size <= most, f"rod.{end}_chamfer_mm", size, rule, "Reduce it.")
    rule = "cannot be combined with a slanted small end (small_end_crown_width_mm)"
    plain = rod.small_end_chamfer == 0 or rod.small_end_crown_width == 0
    require(plain, "rod.small_end_chamfer_mm", rod.small_end_chamfer, rule, "Remove one of them.")
    hole = rod.oil_hole / 2 + rod.small_end_chamfer
    room = (rod.small_end_crown_width or rod.small_end_width) / 2
    rule = f"must leave {room:.4g} mm, half of the small end's width, to the oil hole's radius"
    require(hole < room, "rod.small_end_chamfer_mm", rod.small_end_chamfer, rule, "Reduce it.")


def _bosses(rod: Dimensions, bosses: Bosses) -> None:
    for name in ("cap_bolt_spacing", "cap_boss_length", "cap_boss_fillet"):
        value = getattr(rod, name)
        require(value > 0, f"rod.{name}_mm", value, "must be positive if cap_bolt_mm is given")
    require(
        rod.big_end_width >= rod.small_end_width,
        "rod.big_end_width_mm",
        rod.big_end_width,
        f"must be at least the small end's width, {rod.small_end_width:g} mm, if the rod has cap bolts",
    )
    reach, most = bosses.half_length + bosses.fillet, 0.95 * bosses.ring
    require(
        reach <= most,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        f"half of it plus the fillet is {reach:.4g} mm; it must be at most {most:.4g} mm to end on the ring",
        "Shorten the bosses or reduce cap_boss_fillet_mm.",
    )
    gap = Outline(rod).fillets[0].start[0] - bosses.fillets()[1].end[0]
    require(
        gap >= 0.02 * bosses.ring,
        "rod.cap_boss_length_mm",
        rod.cap_boss_length,
        "the fillets of bosses and shank must leave a piece of the ring's outline between them",
        "Shorten the bosses, or reduce big_end_fillet_mm or the shank's depth.",
    )


def _bolts(rod: Dimensions, bosses: Bosses) -> None:
    require(
        rod.cap_bolt <= 0.8 * rod.big_end_width,
        "rod.cap_bolt_mm",
        rod.cap_bolt,
        f"must be at most 0.8 of the big end's width, {rod.big_end_width:g} mm",
    )
    inner = max(1.02 * rod.big_end_bore / 2, bosses.seat, bosses.ring - 1.5 * rod.cap_bolt)
    least = 2 * inner + rod.cap_bolt
    require(
        rod.cap_bolt_spacing >= least,
        "rod.cap_bolt_spacing_mm",
        rod.cap_bolt_spacing,
        f"must be at least {least:.4g} mm, so that the holes clear the bore and the bolts have plane seats",
        "Increase it, or lengthen the bosses.",
    )


LEAST, MOST = 0.1, 10_000.0  # mm


def check(rod: Dimensions) -> None:
    """Raise `InvalidValue` for the first rule that `rod` breaks, from single values to the whole rod."""
    _sizes(rod)
    _rings(rod)
    _shank(rod)
    _fillets(rod)
    _steps(rod)
    check_options(rod)
    if rod.has_pockets:
        _web(rod)
        _pocket(rod, web_pocket(rod, Outline(rod).edge))


def _key(dimension: str) -> str:
    return f"rod.{dimension}_mm"


def _sizes(rod: Dimensions) -> None:
    for name in dimensions():
        value = require_number(_key(name), getattr(rod, name))
        object.__setattr__(rod, name, value)
        rule = f"must lie between {LEAST:g} and {MOST:g} mm"
        left_out = value == 0 and name in options()
        require(left_out or LEAST <= value <= MOST, _key(name), value, rule, "Lengths are in millimetres.")
    known = [str(section) for section in ShankSection]
    section = rod.shank_section
    rule = f"must be one of {', '.join(known)}"
    require(isinstance(section, str) and section in known, "rod.shank_section", section, rule)
    object.__setattr__(rod, "shank_section", ShankSection(section))


def _rings(rod: Dimensions) -> None:
    for end in ("big_end", "small_end"):
        ring, bore = getattr(rod, f"{end}_ring"), getattr(rod, f"{end}_bore")
        rule = f"must be at least {bore / 50:.4g} mm, a fiftieth of the bore ({bore:g} mm)"
        require(ring >= bore / 50, _key(f"{end}_ring"), ring, rule, "Thicken the ring or reduce the bore.")
    leave_a_shank(rod.length, rod.big_end_radius, rod.small_end_radius)


def leave_a_shank(length: float, big_end_radius: float, small_end_radius: float) -> None:
    """Refuse rings (outer radii, mm) that meet or nearly meet on a rod of this length (mm)."""
    reach = big_end_radius + small_end_radius
    require(
        reach < 0.95 * length,
        _key("length"),
        length,
        f"must leave a shank between the rings, whose outer radii are {big_end_radius:g} and "
        f"{small_end_radius:g} mm: at least a twentieth of the length",
        f"Lengthen the rod to more than {reach / 0.95:g} mm, or reduce the bores or rings.",
    )


def _shank(rod: Dimensions) -> None:
    for end in ("big_end", "small_end"):
        step = getattr(rod, f"{end}_width") - rod.shank_width
        rule = f"must not exceed the width of the {end.replace('_', ' ')}, {rod.shank_width + step:g} mm"
        require(step >= 0, _key("shank_width"), rod.shank_width, rule, "Narrow the shank or widen the end.")
        least = (rod.shank_width + step) / 50
        what = f"{end.replace('_', ' ')}'s width"
        rule = f"must equal the {what} or be at least {least:.4g} mm smaller"
        require(step == 0 or step >= least, _key("shank_width"), rod.shank_width, rule, "Make them equal.")
    edge = Outline(rod).edge
    slope = abs(edge.along[1])
    require(
        slope <= 0.5,
        _key("shank_depth_big_end"),
        rod.shank_depth_big_end,
        f"the shank may taper by at most 30° per side; its depth at the small end is "
        f"{rod.shank_depth_small_end:g} mm",
        "Make the two depths less different.",
    )
    for end, x in (("big_end", 0.0), ("small_end", rod.length)):
        most = 0.92 * getattr(rod, f"{end}_radius")
        distance = edge.distance((x, 0.0))
        rule = f"the shank's edge must pass within {most:.4g} mm of the bore's centre, not {distance:.4g} mm"
        name = f"shank_depth_{end}"
        require(distance <= most, _key(name), getattr(rod, name), rule, "Reduce it or thicken the ring.")


def _fillets(rod: Dimensions) -> None:
    big, small = Outline(rod).fillets
    larger = "big_end_fillet" if rod.big_end_fillet >= rod.small_end_fillet else "small_end_fillet"
    require(
        small.start[0] - big.end[0] >= 0.01 * rod.length,
        _key(larger),
        getattr(rod, larger),
        "the two fillets must leave a straight edge between them, at least a hundredth of the rod's length",
        "Reduce this radius, or lengthen the rod.",
    )


def _steps(rod: Dimensions) -> None:
    big, small = ring_steps(rod)
    for step in (big, small):
        if step.height == 0:
            continue
        rule = f"must not exceed {step.rim:g} mm, the distance of the step from the bore's centre"
        require(rod.ring_step_radius <= step.rim, _key("ring_step_radius"), rod.ring_step_radius, rule)
    require(
        big.foot + small.foot <= 0.99 * rod.length,
        _key("ring_step_radius"),
        rod.ring_step_radius,
        f"the ring steps must not meet, but end {big.foot:.4g} and {small.foot:.4g} mm from the bores",
        "Reduce this radius, widen the shank or lengthen the rod.",
    )


def _web(rod: Dimensions) -> None:
    require(
        rod.web_thickness <= 0.95 * rod.shank_width,
        _key("web_thickness"),
        rod.web_thickness,
        f"must be at most {0.95 * rod.shank_width:.4g} mm, 0.95 of the shank's width",
        'Reduce it, or choose shank_section = "rectangular".',
    )
    depth = (rod.shank_width - rod.web_thickness) / 2
    for limit, what in ((depth, "pocket's depth"), (rod.pocket_corner_radius, "pocket's corner radius")):
        rule = f"must be at most {0.9 * limit:.4g} mm, 0.9 of the {what}"
        radius = rod.pocket_floor_radius
        require(radius <= 0.9 * limit, _key("pocket_floor_radius"), radius, rule, "Reduce it.")


def _pocket(rod: Dimensions, pocket: Pocket) -> None:
    length = pocket.small_end - pocket.big_end
    tangents = sum(pocket.tangents)
    if length <= 0.01 * rod.length:
        rule = f"leaves a pocket {length:.4g} mm long; at least {0.01 * rod.length:.4g} mm are needed"
        remedy = 'Reduce it, or choose shank_section = "rectangular".'
        raise InvalidValue(_key("pocket_setback"), rod.pocket_setback, rule, remedy)
    half = min(pocket.edge.height(pocket.big_end), pocket.edge.height(pocket.small_end))
    require(
        half > 0.02 * rod.flange_thickness,
        _key("flange_thickness"),
        rod.flange_thickness,
        "the two flanges must leave a pocket between them along the whole shank",
        "Reduce the flange thickness or increase the shank's depth.",
    )
    (_, y0), (_, y1) = pocket.corner_centers()
    radius = rod.pocket_corner_radius
    require(
        min(y0, y1) >= 0.05 * radius and length - tangents >= 0.05 * radius,
        _key("pocket_corner_radius"),
        radius,
        f"the corners must fit into a pocket {length:.4g} mm long and {2 * half:.4g} mm wide (narrow end)",
        "Reduce it.",
    )
