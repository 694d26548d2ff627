"""The dimensions of a rod, each declared once with its unit and help, and what follows; ranges of engines."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from enum import StrEnum
from functools import cache
from typing import Any

from geometry.surfaces import Mirror


@dataclass(frozen=True)
class Plausible:
    """The range of a key in engines, from model engines to those of ships; each key is in its own unit.

    A value outside of it is noted. One that is `far` times as large or small is refused.
    """

    #: least, most: bounds of the value, over the product of other keys where `of` names some
    least: float
    most: float
    why: str  #: the engines, parts or materials at the bounds
    #: Exponents of other keys: "TABLE.KEY", or "KEY" for the same table
    of: Mapping[str, float] = field(default_factory=dict)
    far: float = 2.5
    refuses_less: bool = True  #: whether a value that is too small may be refused; otherwise it is noted
    #: A key and the value below which the range holds, "" for always
    below: tuple[str, float] = ("", 0.0)


class ShankSection(StrEnum):
    """Cross-section of the shank."""

    I = "I"  # channels in the faces, square to the pins
    H = "H"  # channels in the sides: the flanges are the faces
    RECTANGULAR = "rectangular"
    TUBULAR = "tubular"  # a rectangle outside, bored along the rod


def _mm(what: str, *plausible: Plausible, default: Any = MISSING, **more: str) -> Any:
    return field(metadata={"unit": "mm", "help": what, "plausible": plausible, **more}, default=default)


def _option(what: str, example: str, *plausible: Plausible, **more: str) -> Any:
    return _mm(what, *plausible, default=0.0, example=example, **more)


def _times(other: str, least: float, most: float) -> Plausible:
    """Where a dimension lies as a multiple of another one of the rod.

    Bounds of this program: wider by half or more than those of the rods of `geometry.presets`, of
    production rods and of the public CAD rods that it was tried on.
    """
    return Plausible(least, most, "as in rods of usual proportions", {f"rod.{other}_mm": 1}, far=4.0)


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """Dimensions of a connecting rod in its own frame, unchecked (`geometry.rod.Rod` checks them).

    The crank-pin bore is at the origin, +x leads to the small end, z runs along the pins. The metadata of a
    field are its unit and its help, and for the commented study an example and what stands above it; `key` is
    its key in a study.
    """

    length: float = _mm(
        "distance between the centres of the bores",
        Plausible(11.0, 4000.0, "from model engines of 0.2 cm³ to two-stroke engines of ships"),
        Plausible(
            0.95,
            4.0,
            "rods are 1.9 to 8 crank radii long: 2 in ships, 3 to 4 in cars, 5 and more in racing engines",
            {"engine.stroke_mm": 1},
            far=1.6,
        ),
    )
    big_end_bore: float = _mm(
        "bore diameter",
        Plausible(0.15, 0.62, "bores are a sixth to five eighths of the rod's length", {"rod.length_mm": 1}),
    )
    small_end_bore: float = _mm(
        "bore diameter, of the bushing if there is one",
        Plausible(0.2, 1.1, "at most as wide as the big end's", {"rod.big_end_bore_mm": 1}),
        Plausible(
            0.13,
            1.15,
            "piston pins are a fifth to two fifths of the cylinder's bore, crosshead pins as wide as it",
            {"engine.bore_mm": 1},
            far=2.0,
        ),
    )
    big_end_ring: float = _mm(
        "radial thickness",
        _times("big_end_bore", 0.05, 0.5),
        above="All other dimensions follow from these three in usual proportions (shown here) unless they "
        "are given:",
    )
    big_end_width: float = _mm("along the pins", _times("big_end_bore", 0.15, 1.3))
    small_end_ring: float = _mm("radial thickness, with the bushing", _times("small_end_bore", 0.06, 1.0))
    small_end_width: float = _mm("along the pins", _times("small_end_bore", 0.25, 2.5))
    #: Depths extend straight to where the axis meets each ring's outer circle, linear between.
    shank_depth_big_end: float = _mm("in the plane of motion", _times("big_end_bore", 0.12, 1.2))
    shank_depth_small_end: float = _mm("in the plane of motion", _times("small_end_bore", 0.18, 2.4))
    shank_width: float = _mm("along the pins, over the flanges", _times("big_end_width", 0.1, 1.0))
    shank_section: ShankSection = field(
        metadata={"help": 'or "H" (channels in the sides), "rectangular", "tubular" (bored along the rod)'}
    )
    flange_thickness: float = _mm(
        "square to the shank's edge; of an H-section along the pins",
        _times("shank_depth_small_end", 0.04, 0.5),
    )
    web_thickness: float = _mm(
        "along the pins; of an H-section in the plane of motion", _times("shank_width", 0.07, 0.95)
    )
    big_end_fillet: float = _mm(
        "radius between shank and ring, seen along the pins", _times("big_end_bore", 0.06, 4.0)
    )
    small_end_fillet: float = _mm(
        "radius between shank and ring, seen along the pins", _times("small_end_bore", 0.1, 6.0)
    )
    ring_step_radius: float = _mm(
        "radius between the faces of the shank and those of the wider rings",
        _times("shank_width", 0.004, 3.0),
    )
    pocket_corner_radius: float = _mm(
        "corners of the pockets beside the web, seen along the pins; of an H-section from the side",
        _times("shank_depth_small_end", 0.03, 0.5),
    )
    pocket_floor_radius: float = _mm("radius between flange and web", _times("shank_width", 0.02, 0.5))
    pocket_setback: float = _mm(
        "distance of the ends of pockets, or of a tubular shank's bore, from the rings",
        _times("length", 0.004, 0.2),
    )  #: or feet of the ring steps
    #: Options: 0 leaves them out.
    small_end_crown_width: float = _option(
        "slanted small end: its width at the crown",
        "18.0",
        _times("small_end_width", 0.25, 1.0),
        above="Optional features, left out unless they are given:",
    )
    bushing: float = _option(
        "wall thickness of a bushing in the small end; for its material see [material.bushing]",
        "1.5",
        _times("small_end_bore", 0.015, 0.25),
    )
    oil_hole: float = _option(
        "diameter of a hole through the crown of the small end", "3.0", _times("small_end_bore", 0.03, 0.5)
    )
    cap_bolt: float = _option(
        "diameter of two bolt holes beside the big end; the next three keys belong to it",
        "8.0",
        _times("big_end_bore", 0.07, 0.45),
    )
    cap_bolt_spacing: float = _option(
        "distance between the axes of the bolts", "80.0", _times("big_end_bore", 1.1, 2.6)
    )
    cap_boss_length: float = _option(
        "length of the bosses around the bolts, along the rod", "40.0", _times("big_end_bore", 0.2, 2.5)
    )
    cap_boss_fillet: float = _option(
        "radius between boss and ring", "4.0", _times("big_end_bore", 0.012, 0.5)
    )
    #: A chamfer's height along the axis is how much it widens the bore's radius.
    big_end_chamfer: float = _option(
        "45° chamfers of the bores' ends", "0.5", _times("big_end_bore", 0.003, 0.1)
    )
    small_end_chamfer: float = _option(
        "not together with small_end_crown_width_mm", "0.5", _times("small_end_bore", 0.004, 0.1)
    )
    oil_gallery: float = _option(
        "diameter of an oil passage drilled along the shank, from bore to bore",
        "3.0",
        _times("shank_width", 0.05, 0.6),
    )
    shank_bore: float = _option(
        'diameter to which a "tubular" shank is bored, from the big end to before the small end',
        "9.0",
        _times("shank_width", 0.15, 0.9),
    )
    cap_boss_round: float = _option(
        "radius to which the bosses are rounded about the bolts, at both faces",
        "7.0",
        _times("big_end_width", 0.02, 0.5),
    )
    cap_rib: float = _option(
        "height of a rib over the back of the cap; for a thick crown it is as wide as the big end",
        "4.0",
        _times("big_end_bore", 0.02, 0.35),
    )
    cap_rib_width: float = _option("along the pins", "14.0", _times("big_end_width", 0.1, 1.0))
    cap_rib_groove: float = _option(
        "width of a groove that makes two ribs of it", "6.0", _times("big_end_width", 0.05, 0.9)
    )

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
        """How much longer than its mean the small-end bore is on its +x side (negative: shorter), mm."""
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
    def shank_bore_end(self) -> float:
        """The x where the bore of a tubular shank ends, mm."""
        return self.length - self.small_end_radius - self.pocket_setback

    @property
    def shank_bore_round(self) -> float:
        """Radius at the end of that bore, whose bottom is flat in the middle, mm."""
        return 0.4 * self.shank_bore

    @property
    def smallest_cell(self) -> Mirror:
        """The smallest symmetry cell: the part whose reflections are the whole rod."""
        return Mirror.QUARTER


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
