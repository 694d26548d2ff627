"""A rod: its dimensions, checked, and completed from a few in usual proportions."""

import math
from dataclasses import dataclass
from typing import Any

from geometry import rules
from geometry.dimensions import Dimensions, ShankSection, key, options
from geometry.errors import require_number, require_positive


@dataclass(frozen=True, kw_only=True)
class Rod(Dimensions):
    """A connecting rod whose dimensions obey every rule; `proportioned` derives missing ones.

    Raises `InvalidValue`: a dimension breaks a rule; the message names it by its key in a study
    (``rod.web_thickness_mm``).
    """

    def __post_init__(self) -> None:
        rules.check(self)


def proportioned(length: float, big_end_bore: float, small_end_bore: float, **given: Any) -> Rod:
    """Complete a rod from the distance of its bores and their diameters, mm.

    Any other field of `Rod` may be given; the rest follows from these, in usual proportions of forged
    automotive rods (ours: no published rule). Raises `InvalidValue`: a given or derived dimension breaks a
    rule.
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
    rules.leave_a_shank(rod["length"], big_radius, small_radius)  # before a derived dimension is blamed
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
    if bolt := rod.get("cap_bolt", 0.0):
        _default_bosses(rod, bolt, big_radius)
    return Rod(**rod)


def _default_bosses(rod: dict[str, Any], bolt: float, ring: float) -> None:
    """Complete the bosses: the holes are as close to the bore as plane seats allow."""
    half = (rod.get("cap_boss_length") or 1.3 * ring) / 2
    fillet = rod.get("cap_boss_fillet") or 0.12 * ring
    seat = math.sqrt(max((ring + fillet) ** 2 - (half + fillet) ** 2, 0.0))
    inner = max(seat, 0.53 * rod["big_end_bore"], ring - 1.5 * bolt)
    spacing = rod.get("cap_bolt_spacing") or 2 * inner + 1.05 * bolt
    rod |= {"cap_boss_length": 2 * half, "cap_boss_fillet": fillet, "cap_bolt_spacing": spacing}
