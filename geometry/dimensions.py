"""The dimensions of a rod, each declared once with its unit and help, and what follows from them."""

from dataclasses import MISSING, dataclass, field, fields
from enum import StrEnum
from functools import cache
from typing import Any


class ShankSection(StrEnum):
    """Cross-section of the shank."""

    I = "I"  # channels in the faces, square to the pins
    H = "H"  # channels in the sides: the flanges are the faces
    RECTANGULAR = "rectangular"
    TUBULAR = "tubular"  # a rectangle outside, bored along the rod


def _mm(what: str, default: Any = MISSING, **more: str) -> Any:
    return field(metadata={"unit": "mm", "help": what, **more}, default=default)


def _option(what: str, example: str, **more: str) -> Any:
    return _mm(what, 0.0, example=example, **more)


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """Dimensions of a connecting rod in its own frame, unchecked (`geometry.rod.Rod` checks them).

    The crank-pin bore is at the origin, +x leads to the small end, z runs along the pins. The metadata of a
    field are its unit and help, and its example and heading in the commented study, where `key` names it.
    """

    length: float = _mm("distance between the centres of the bores")
    big_end_bore: float = _mm("bore diameter")
    small_end_bore: float = _mm("bore diameter, of the bushing if there is one")
    big_end_ring: float = _mm(
        "radial thickness",
        above="All other dimensions follow from these three in usual proportions (shown here) unless they "
        "are given:",
    )
    big_end_width: float = _mm("along the pins")
    small_end_ring: float = _mm("radial thickness, with the bushing")
    small_end_width: float = _mm("along the pins")
    #: Depths extend straight to where the axis meets each ring's outer circle, linear between.
    shank_depth_big_end: float = _mm("in the plane of motion")
    shank_depth_small_end: float = _mm("in the plane of motion")
    shank_width: float = _mm("along the pins, over the flanges")
    shank_section: ShankSection = field(
        metadata={"help": 'or "H" (channels in the sides), "rectangular", "tubular" (bored along the rod)'}
    )
    flange_thickness: float = _mm("square to the shank's edge; of an H-section along the pins")
    web_thickness: float = _mm("along the pins; of an H-section in the plane of motion")
    big_end_fillet: float = _mm("radius between shank and ring, seen along the pins")
    small_end_fillet: float = _mm("radius between shank and ring, seen along the pins")
    ring_step_radius: float = _mm("radius between the faces of the shank and those of the wider rings")
    pocket_corner_radius: float = _mm(
        "corners of the pockets beside the web, seen along the pins; of an H-section from the side"
    )
    pocket_floor_radius: float = _mm("radius between flange and web")
    pocket_setback: float = _mm(
        "distance of the ends of pockets, or of a tubular shank's bore, from the rings"
    )  #: or feet of the ring steps
    #: Options: 0 leaves them out.
    small_end_crown_width: float = _option(
        "slanted small end: its width at the crown",
        "18.0",
        above="Optional features, left out unless they are given:",
    )
    bushing: float = _option(
        "wall thickness of a bushing in the small end; for its material see [material.bushing]", "1.5"
    )
    oil_hole: float = _option("diameter of a hole through the crown of the small end", "3.0")
    cap_bolt: float = _option(
        "diameter of two bolt holes beside the big end; the next three keys belong to it", "8.0"
    )
    cap_bolt_spacing: float = _option("distance between the axes of the bolts", "80.0")
    cap_boss_length: float = _option("length of the bosses around the bolts, along the rod", "40.0")
    cap_boss_fillet: float = _option("radius between boss and ring", "4.0")
    #: A chamfer's height along the axis is how much it widens the bore's radius.
    big_end_chamfer: float = _option("45° chamfers of the bores' ends", "0.5")
    small_end_chamfer: float = _option("not together with small_end_crown_width_mm", "0.5")
    oil_gallery: float = _option(
        "diameter of an oil passage drilled along the shank, from bore to bore", "3.0"
    )
    shank_bore: float = _option(
        'diameter to which a "tubular" shank is bored, from the big end to before the small end', "9.0"
    )
    cap_boss_round: float = _option(
        "radius to which the bosses are rounded about the bolts, at both faces", "7.0"
    )
    cap_rib: float = _option(
        "height of a rib over the back of the cap; for a thick crown it is as wide as the big end", "4.0"
    )
    cap_rib_width: float = _option("along the pins", "14.0")
    cap_rib_groove: float = _option("width of a groove that makes two ribs of it", "6.0")

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
        return self.mean_small_end_width - 2 * self.small_end_chamfer

    @property
    def mean_small_end_width(self) -> float:
        """Width of the small end, averaged round the bore if the end is slanted, mm."""
        return (self.small_end_width + (self.small_end_crown_width or self.small_end_width)) / 2

    @property
    def crank_bearing_width(self) -> float:
        """Length of the big-end bore, mm."""
        return self.big_end_width - 2 * self.big_end_chamfer

    @property
    def pin_bearing_taper(self) -> float:
        """Length of the small-end bore on its +x side over its mean length, mm; negative: shorter."""
        narrower = self.small_end_width - (self.small_end_crown_width or self.small_end_width)
        return -narrower / 2 * (self.small_end_bore / 2) / self.small_end_radius

    @property
    def has_pockets(self) -> bool:
        """Whether the shank has a web between flanges."""
        return self.shank_section in (ShankSection.I, ShankSection.H)

    @property
    def has_side_pockets(self) -> bool:
        """Whether the pockets beside the web are in the sides of the shank, not in its faces."""
        return self.shank_section is ShankSection.H

    @property
    def least_depth(self) -> float:
        """The lesser depth of the shank in the plane of motion, mm."""
        return min(self.shank_depth_big_end, self.shank_depth_small_end)

    @property
    def drilled_thickness(self) -> float:
        """Thickness of what is drilled along the rod: of the web, or of the shank, mm."""
        return self.web_thickness if self.has_pockets else min(self.shank_width, self.least_depth)

    @property
    def big_end_opening(self) -> float:
        """Diameter of the hole along the rod where it opens into the big end's bore, mm; 0 for none."""
        return max(self.oil_gallery, self.shank_bore)

    @property
    def shank_bore_end(self) -> float:
        """The x where the bore of a tubular shank ends, mm."""
        return self.length - self.small_end_radius - self.pocket_setback

    @property
    def shank_bore_round(self) -> float:
        """Radius at the end of that bore, whose bottom is flat in the middle, mm."""
        return 0.4 * self.shank_bore


@cache
def dimensions() -> tuple[str, ...]:
    """Names of the fields that are lengths in mm."""
    return tuple(each.name for each in fields(Dimensions) if each.metadata.get("unit") == "mm")


@cache
def options() -> tuple[str, ...]:
    """Names of the dimensions that may be 0, which leaves out the feature that they describe."""
    return tuple(each.name for each in fields(Dimensions) if each.default == 0)


def key(name: str) -> str:
    """Return the key of a field in the [rod] table of a study, which ends with its unit."""
    return f"{name}_mm" if name in dimensions() else name
