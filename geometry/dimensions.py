"""The dimensions of a rod, and quantities that follow directly from them."""

from dataclasses import dataclass, fields
from enum import StrEnum
from functools import cache

from geometry.surfaces import Mirror


class ShankSection(StrEnum):
    """Cross-section of the shank."""

    I = "I"
    RECTANGULAR = "rectangular"


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """Dimensions of a connecting rod in its own frame, in mm, unchecked (`geometry.rod.Rod` checks them).

    The crank-pin bore is at the origin, +x leads to the small end, z runs along the pins.

    Attributes
    ----------
    length
        Distance of the bores' centres.
    big_end_bore, small_end_bore
        Bore diameters.
    big_end_ring, small_end_ring
        Radial thickness of the rings.
    big_end_width, small_end_width
        Widths of the rings along the pins (z).
    shank_depth_big_end, shank_depth_small_end
        Depth of the shank in the plane of motion (y), extended straight to where the axis meets each
        ring's outer circle; linear between.
    shank_width
        Width of the shank along the pins (z), over the flanges.
    shank_section
        I: with a web pocket in each face; rectangular: without.
    flange_thickness, web_thickness
        Of the I-section: along y (square to the shank's edge) and along z.
    big_end_fillet, small_end_fillet
        Radii in the plane of motion between the shank's edges and each ring.
    ring_step_radius
        At the foot of the step from a ring's side face to the shank's; no step where the widths agree.
    pocket_corner_radius, pocket_floor_radius
        Of the web pockets, in plan and along the edge of the floor.
    pocket_setback
        Distance of the pockets' ends from the feet of the ring steps (from the rings, without a step).
    small_end_crown_width
        Width of a slanted small end at its crown; it narrows from `small_end_width` where the ring begins.
    bushing
        Radial thickness of a bushing in the small end, a part of its own inside `small_end_ring`; the
        small-end bore is the bushing's.
    oil_hole
        Diameter of a hole along x through the crown of the small end.
    cap_bolt, cap_bolt_spacing, cap_boss_length, cap_boss_fillet
        Diameter of the cap bolts' holes, distance of their axes, length of the bosses along x (half of it
        on either side of the crank pin) and radius between bosses and ring.
    big_end_chamfer, small_end_chamfer
        Of the bores' ends, at 45°: its height along the axis, and how much it widens the bore's radius.
    """

    length: float
    big_end_bore: float
    small_end_bore: float
    big_end_ring: float
    big_end_width: float
    small_end_ring: float
    small_end_width: float
    shank_depth_big_end: float
    shank_depth_small_end: float
    shank_width: float
    shank_section: ShankSection
    flange_thickness: float
    web_thickness: float
    big_end_fillet: float
    small_end_fillet: float
    ring_step_radius: float
    pocket_corner_radius: float
    pocket_floor_radius: float
    pocket_setback: float
    # Options: 0 leaves them out.
    small_end_crown_width: float = 0.0
    bushing: float = 0.0
    oil_hole: float = 0.0
    cap_bolt: float = 0.0
    cap_bolt_spacing: float = 0.0
    cap_boss_length: float = 0.0
    cap_boss_fillet: float = 0.0
    big_end_chamfer: float = 0.0
    small_end_chamfer: float = 0.0

    @property
    def big_end_radius(self) -> float:
        """Outer radius of the big-end ring, mm."""
        return self.big_end_bore / 2 + self.big_end_ring

    @property
    def small_end_radius(self) -> float:
        """Outer radius of the small-end ring, mm."""
        return self.small_end_bore / 2 + self.small_end_ring

    @property
    def pin_bearing_width(self) -> float:
        """Length of the small-end bore, averaged round the bore if the end is slanted, mm."""
        mean = (self.small_end_width + (self.small_end_crown_width or self.small_end_width)) / 2
        return mean - 2 * self.small_end_chamfer

    @property
    def crank_bearing_width(self) -> float:
        """Length of the big-end bore, mm."""
        return self.big_end_width - 2 * self.big_end_chamfer

    @property
    def pin_bearing_taper(self) -> float:
        """How much longer than its mean the small-end bore is on its +x side (negative: shorter), mm."""
        narrower = self.small_end_width - (self.small_end_crown_width or self.small_end_width)
        return -narrower / 2 * (self.small_end_bore / 2) / self.small_end_radius

    @property
    def has_pockets(self) -> bool:
        """Whether the shank is an I-section."""
        return self.shank_section is ShankSection.I

    @property
    def smallest_cell(self) -> Mirror:
        """The smallest part whose reflections are the whole rod."""
        return Mirror.QUARTER


@cache
def dimensions() -> tuple[str, ...]:
    """Names of the fields that are lengths in mm."""
    return tuple(field.name for field in fields(Dimensions) if field.type is float)


@cache
def options() -> tuple[str, ...]:
    """Names of the dimensions that may be 0, which leaves out the feature that they describe."""
    return tuple(field.name for field in fields(Dimensions) if field.default == 0)
