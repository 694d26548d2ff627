"""A rod: its dimensions, the rules that they obey, and those that follow from a few in usual proportions."""

import math
from dataclasses import dataclass
from typing import Any

from geometry.dimensions import Dimensions, ShankSection, dimensions, key, options
from geometry.errors import InvalidValue, require, require_number, require_positive
from geometry.outline import Bosses, Outline, Pocket, web_pocket
from geometry.steps import LEAST, highest, rib, ring_steps

_LEAST, _MOST = 0.1, 10_000.0  # mm
_ENDS = ("big_end", "small_end")


def _check(rod: Dimensions) -> None:
    """Raise `InvalidValue` for the first rule that `rod` breaks, from single values to the whole rod."""
    optional, rule = options(), f"must lie between {_LEAST:g} and {_MOST:g} mm"
    given = {name: require_number(f"rod.{name}_mm", getattr(rod, name)) for name in dimensions()}
    for name, value in given.items():
        object.__setattr__(rod, name, value)
        allowed = _LEAST <= value <= _MOST or (value == 0 and name in optional)
        require_of(rod, name, allowed, rule, "Lengths are in millimetres.")
    section, sections = rod.shank_section, [str(section) for section in ShankSection]
    valid = isinstance(section, str) and section in sections
    require_of(rod, "shank_section", valid, f"must be one of {', '.join(sections)}")
    object.__setattr__(rod, "shank_section", ShankSection(section))
    _rings(rod)
    _shank(rod)
    _small_end(rod)
    _chamfers(rod)
    bosses = Outline(rod).bosses
    for name in ("cap_boss_round", "cap_rib"):
        rule = "needs bolts that hold the cap"
        require_of(rod, name, bosses is not None or not getattr(rod, name), rule, "Give cap_bolt_mm.")
    for name in ("cap_rib_width", "cap_rib_groove"):
        rule = "belongs to a rib over the cap"
        require_of(rod, name, rod.cap_rib > 0 or not getattr(rod, name), rule, "Give cap_rib_mm.")
    if bosses is not None:
        _bosses(rod, bosses)
        if rod.cap_rib:
            _rib(rod, bosses)
    if rod.has_pockets:
        remedy = 'Reduce it, or choose shank_section = "rectangular".'
        across, what = (rod.least_depth, "depth") if rod.has_side_pockets else (rod.shank_width, "width")
        _at_most(rod, "web_thickness", 0.95 * across, f", 0.95 of the shank's {what}", remedy)
        depth = (across - rod.web_thickness) / 2
        for limit, what in ((depth, "pocket's depth"), (rod.pocket_corner_radius, "pocket's corner radius")):
            _at_most(rod, "pocket_floor_radius", 0.9 * limit, f", 0.9 of the {what}", "Reduce it.")
        _pocket(rod, web_pocket(rod, Outline(rod).edge))
    _drilled(rod)


def require_of(rod: Dimensions, name: str, holds: bool, rule: str, remedy: str = "") -> None:  # noqa: FBT001
    """Raise `InvalidValue` for a dimension of a rod unless `holds`."""
    if not holds:
        raise InvalidValue(f"rod.{key(name)}", getattr(rod, name), rule, remedy)


def _at_most(rod: Dimensions, name: str, most: float, what: str, remedy: str = "") -> None:
    require_of(rod, name, getattr(rod, name) <= most, f"must be at most {most:.4g} mm{what}", remedy)


def _at_least(rod: Dimensions, name: str, least: float, what: str, remedy: str = "") -> None:
    require_of(rod, name, getattr(rod, name) >= least, f"must be at least {least:.4g} mm{what}", remedy)


def _rings(rod: Dimensions) -> None:
    for end in _ENDS:
        bore, what = getattr(rod, f"{end}_bore"), ", a fiftieth of the bore"
        _at_least(rod, f"{end}_ring", bore / 50, what, "Thicken the ring or reduce the bore.")
    _leave_a_shank(rod.length, rod.big_end_radius, rod.small_end_radius)


def _leave_a_shank(length: float, big_end_radius: float, small_end_radius: float) -> None:
    """Refuse rings (outer radii, mm) that meet or nearly meet on a rod of this length (mm)."""
    reach = big_end_radius + small_end_radius
    rule = (
        f"must leave a shank between the rings, whose outer radii are {big_end_radius:g} and "
        f"{small_end_radius:g} mm: at least a twentieth of the length"
    )
    remedy = f"Lengthen the rod to more than {reach / 0.95:g} mm, or reduce the bores or rings."
    require(reach < 0.95 * length, "rod.length_mm", length, rule, remedy)


def _shank(rod: Dimensions) -> None:
    for end in _ENDS:
        width, name = getattr(rod, f"{end}_width"), end.replace("_", " ")
        step, least = width - rod.shank_width, width / 50
        rule = f"must not exceed the width of the {name}, {width:g} mm"
        require_of(rod, "shank_width", step >= 0, rule, "Narrow the shank or widen the end.")
        rule = f"must equal the {name}'s width or be at least {least:.4g} mm smaller"
        require_of(rod, "shank_width", step == 0 or step >= least, rule, "Make them equal.")
    edge = Outline(rod).edge
    rule = (
        f"the shank may taper by at most 30° per side; its depth at the small end is "
        f"{rod.shank_depth_small_end:g} mm"
    )
    straight = abs(edge.along[1]) <= 0.5
    require_of(rod, "shank_depth_big_end", straight, rule, "Make the two depths less different.")
    for end, x in zip(_ENDS, (0.0, rod.length), strict=True):
        most, distance = 0.92 * getattr(rod, f"{end}_radius"), edge.distance((x, 0.0))
        rule = f"the shank's edge must pass within {most:.4g} mm of the bore's centre, not {distance:.4g} mm"
        require_of(rod, f"shank_depth_{end}", distance <= most, rule, "Reduce it or thicken the ring.")
    first, last = Outline(rod).fillets
    larger = "big_end_fillet" if rod.big_end_fillet >= rod.small_end_fillet else "small_end_fillet"
    rule = "the two fillets must leave a straight edge between them, at least a hundredth of the rod's length"
    apart = last.start[0] - first.end[0] >= 0.01 * rod.length
    require_of(rod, larger, apart, rule, "Reduce this radius, or lengthen the rod.")
    big, small = ring_steps(rod)
    for step in (big, small):
        rule = f"must not exceed {step.rim:g} mm, the distance of the step from the bore's centre"
        require_of(rod, "ring_step_radius", step.height == 0 or rod.ring_step_radius <= step.rim, rule)
    rule = f"the ring steps must not meet, but end {big.foot:.4g} and {small.foot:.4g} mm from the bores"
    remedy = "Reduce this radius, widen the shank or lengthen the rod."
    require_of(rod, "ring_step_radius", big.foot + small.foot <= 0.99 * rod.length, rule, remedy)


def _small_end(rod: Dimensions) -> None:
    crown, least, most = rod.small_end_crown_width, 0.3 * rod.small_end_width, 0.98 * rod.small_end_width
    rule = f"must be 0 (no slant) or {least:.4g} to {most:.4g} mm, 0.3 to 0.98 of the small end's width"
    require_of(rod, "small_end_crown_width", crown == 0 or least <= crown <= most, rule)
    ring = ", 0.8 of the small end's ring"
    _at_most(rod, "bushing", 0.8 * rod.small_end_ring, ring, "Thicken small_end_ring_mm.")
    room = 0.5 * min(crown or rod.small_end_width, rod.small_end_bore)
    what = ": half of the small end's bore and of its width at the crown"
    _at_most(rod, "oil_hole", room, what, "Reduce it.")


def _chamfers(rod: Dimensions) -> None:
    for end in _ENDS:
        wall = rod.bushing if end == "small_end" and rod.bushing else getattr(rod, f"{end}_ring")
        most = min(0.5 * wall, 0.2 * getattr(rod, f"{end}_width"), 0.1 * getattr(rod, f"{end}_bore"))
        what = ": half of the wall, a fifth of the width, a tenth of the bore, whichever is least"
        _at_most(rod, f"{end}_chamfer", most, what, "Reduce it.")
    name, size = "small_end_chamfer", rod.small_end_chamfer
    rule = "cannot be combined with a slanted small end (small_end_crown_width_mm)"
    require_of(rod, name, size == 0 or rod.small_end_crown_width == 0, rule, "Remove one of them.")
    room = (rod.small_end_crown_width or rod.small_end_width) / 2
    rule = f"must leave {room:.4g} mm, half of the small end's width, to the oil hole's radius"
    require_of(rod, name, rod.oil_hole / 2 + size < room, rule, "Reduce it.")


def _bosses(rod: Dimensions, bosses: Bosses) -> None:
    for name in ("cap_bolt_spacing", "cap_boss_length", "cap_boss_fillet"):
        require_of(rod, name, getattr(rod, name) > 0, "must be positive if cap_bolt_mm is given")
    what = ", the small end's width, if the rod has cap bolts"
    _at_least(rod, "big_end_width", rod.small_end_width, what)
    reach, most = bosses.half_length + bosses.fillet, 0.95 * bosses.ring
    rule = f"half of it plus the fillet is {reach:.4g} mm; at most {most:.4g} mm end on the ring"
    remedy = "Shorten the bosses or reduce cap_boss_fillet_mm."
    require_of(rod, "cap_boss_length", reach <= most, rule, remedy)
    gap = Outline(rod).fillets[0].start[0] - bosses.fillets()[1].end[0]
    rule = "the fillets of bosses and shank must leave a piece of the ring's outline between them"
    remedy = "Shorten the bosses, or reduce big_end_fillet_mm or the shank's depth."
    require_of(rod, "cap_boss_length", gap >= 0.02 * bosses.ring, rule, remedy)
    _at_most(rod, "cap_bolt", 0.8 * rod.big_end_width, ", 0.8 of the big end's width")
    inner = max(1.02 * rod.big_end_bore / 2, bosses.seat, bosses.ring - 1.5 * rod.cap_bolt)
    what = ", so that the holes clear the bore and the bolts have plane seats"
    least, remedy = 2 * inner + rod.cap_bolt, "Increase it, or lengthen the bosses."
    _at_least(rod, "cap_bolt_spacing", least, what, remedy)
    most = max(min(0.9 * bosses.width, bosses.top - bosses.ring), 0.0)
    what = ": 0.9 of half the big end's width, and what the bosses stand out from the ring"
    _at_most(rod, "cap_boss_round", most, what, "Reduce it.")


def _rib(rod: Dimensions, bosses: Bosses) -> None:
    least, most = LEAST * bosses.ring, highest(bosses.ring, bosses.from_middle)
    rule = f"must be {least:.4g} to {most:.4g} mm, to run out on the ring between the bosses"
    require_of(rod, "cap_rib", least <= rod.cap_rib <= most, rule, "Change it, or shorten the bosses.")
    foot, width, groove = rib(rod, bosses.from_middle).side.radius, rod.cap_rib_width, rod.cap_rib_groove
    full, least, most = rod.big_end_width, 0.1 * rod.big_end_width, rod.big_end_width - 2.1 * foot
    rule = f"must be the big end's, {full:g} mm, or {least:.4g} to {most:.4g} mm, with arcs at its foot"
    require_of(rod, "cap_rib_width", width == full or least <= width <= most, rule, "Or lower the rib.")
    least, most = 2.1 * foot, 0.8 * width
    rule = f"must be 0 (one rib) or {least:.4g} to {most:.4g} mm, with arcs at its floor between two ribs"
    require_of(rod, "cap_rib_groove", groove == 0 or least <= groove <= most, rule, "Lower or widen the rib.")


def _pocket(rod: Dimensions, pocket: Pocket) -> None:
    length, least = pocket.small_end - pocket.big_end, 0.01 * rod.length
    rule = f"leaves a pocket {length:.4g} mm long; at least {least:.4g} mm are needed"
    remedy = 'Reduce it, or choose shank_section = "rectangular".'
    require_of(rod, "pocket_setback", length > least, rule, remedy)
    half = min(pocket.edge.height(pocket.big_end), pocket.edge.height(pocket.small_end))
    rule = "the two flanges must leave a pocket between them along the whole shank"
    size = "width" if pocket.in_sides else "depth"
    remedy = f"Reduce the flange thickness or increase the shank's {size}."
    require_of(rod, "flange_thickness", half > 0.02 * rod.flange_thickness, rule, remedy)
    (_, y0), (_, y1) = pocket.corner_centers()
    least = 0.05 * rod.pocket_corner_radius
    rule = f"the corners must fit into a pocket {length:.4g} mm long and {2 * half:.4g} mm wide (narrow end)"
    fits = min(y0, y1) >= least and length - sum(pocket.tangents) >= least
    require_of(rod, "pocket_corner_radius", fits, rule, "Reduce it.")


# A hole along the rod takes at most this part of the web, or of the shank, that it runs through.
_DRILLED = 0.75


def _drilled(rod: Dimensions) -> None:
    tubular = rod.shank_section is ShankSection.TUBULAR
    rule = "is missing: a tubular shank has a bore" if tubular else "belongs to a tubular shank alone"
    remedy = "Give it, or choose" if tubular else "Remove it, or choose"
    remedy += f' shank_section = "{ShankSection.RECTANGULAR if tubular else ShankSection.TUBULAR}".'
    require_of(rod, "shank_bore", (rod.shank_bore > 0) == tubular, rule, remedy)
    begins = rod.shank_bore_end - rod.shank_bore_round
    rule = f"leaves no straight bore beyond the big end's ring: its end is round from x = {begins:.4g} mm on"
    deep = not tubular or begins > rod.big_end_radius
    require_of(rod, "shank_bore", deep, rule, "Reduce it, or pocket_setback_mm.")
    what, name = ("web", "web_thickness_mm") if rod.has_pockets else ("shank", "the shank")
    most, remedy = _DRILLED * rod.drilled_thickness, f"Reduce it, or thicken {name}."
    for hole, ends in (("shank_bore", _ENDS[:1]), ("oil_gallery", _ENDS)):
        _at_most(rod, hole, most, f", {_DRILLED:g} of the {what} that it runs through", remedy)
        for end in ends:
            bore, width = getattr(rod, f"{end}_bore"), getattr(rod, f"{end}_width")
            room = 0.5 * min(bore, width - 2 * getattr(rod, f"{end}_chamfer"))
            where = f": half of the {end.replace('_', ' ')}'s bore and of its width between chamfers"
            _at_most(rod, hole, room, where, "Reduce it.")
    if tubular:
        _at_most(rod, "oil_gallery", 0.9 * rod.shank_bore, ", 0.9 of the shank's bore", "Reduce it.")


@dataclass(frozen=True, kw_only=True)
class Rod(Dimensions):
    """A connecting rod whose dimensions obey every rule; `proportioned` derives missing ones.

    Raises `InvalidValue`: a dimension breaks a rule; the message names its key (``rod.web_thickness_mm``).
    """

    def __post_init__(self) -> None:
        _check(self)


def proportioned(length: float, big_end_bore: float, small_end_bore: float, **given: Any) -> Rod:
    """Complete a rod from the distance of its bores and their diameters, mm.

    Other fields of `Rod` may be given; the rest follows in usual proportions of forged automotive rods (ours:
    no published rule). Raises `InvalidValue`: a given or derived dimension breaks a rule.
    """
    rod: dict[str, Any] = {"length": length, "big_end_bore": big_end_bore, "small_end_bore": small_end_bore}
    rod |= {"shank_section": ShankSection.I} | given
    for name in [name for name in rod if name != "shank_section"]:
        check = require_number if name in options() else require_positive
        rod[name] = check(f"rod.{key(name)}", rod[name])

    def default(name: str, value: float) -> float:
        return float(rod.setdefault(name, value))

    big, small = rod["big_end_bore"], rod["small_end_bore"]
    big_radius = big / 2 + default("big_end_ring", 0.18 * big)
    small_radius = small / 2 + default("small_end_ring", 0.28 * small)
    _leave_a_shank(rod["length"], big_radius, small_radius)  # before a derived dimension is blamed
    gap = rod["length"] - big_radius - small_radius

    width = default("big_end_width", min(0.5 * big, rod.get("small_end_width", big)))
    width = min(width, default("small_end_width", width))
    shank = default("shank_width", 0.7 * width)
    step = (max(rod["big_end_width"], rod["small_end_width"]) - shank) / 2
    default("ring_step_radius", max(min(1.5 * step, 0.1 * gap), 0.1))

    lesser = default("shank_depth_small_end", min(1.1 * small_radius, 1.2 * big_radius))
    greater = default("shank_depth_big_end", min(1.25 * lesser, 1.48 * big_radius))
    default("big_end_fillet", max(min(0.5 * big, 0.3 * gap), 0.1))
    default("small_end_fillet", max(min(0.8 * small, 0.3 * gap), 0.1))

    depth = min(lesser, greater)
    over_flanges, along_web = (shank, depth) if rod["shank_section"] == ShankSection.H else (depth, shank)
    flange = default("flange_thickness", 0.18 * over_flanges)
    web = default("web_thickness", 0.35 * along_web)
    corner = default("pocket_corner_radius", max(min(0.6 * (over_flanges / 2 - flange), 0.1 * gap), 0.12))
    default("pocket_floor_radius", max(min(0.5 * corner, 0.3 * (along_web - web)), 0.1))
    default("pocket_setback", 0.05 * gap)
    if rod["shank_section"] == ShankSection.TUBULAR:
        default("shank_bore", 0.5 * min(depth, shank))
    if bolt := rod.get("cap_bolt", 0.0):  # as close to the bore as the seats of usual heads allow
        half = (rod.get("cap_boss_length") or 1.3 * big_radius) / 2
        fillet = rod.get("cap_boss_fillet") or 0.12 * big_radius
        seat = math.sqrt(max((big_radius + fillet) ** 2 - (half + fillet) ** 2, 0.0))
        inner = max(seat, 0.53 * rod["big_end_bore"], big_radius - 1.5 * bolt)
        spacing = rod.get("cap_bolt_spacing") or 2 * inner + 1.5 * bolt
        rod |= {"cap_boss_length": 2 * half, "cap_boss_fillet": fillet, "cap_bolt_spacing": spacing}
    return Rod(**rod)
