"""The thinnest places of a rod, which forging and machining limit."""

from geometry.dimensions import Dimensions

# Dimensions that are the thickness of a wall by themselves.
OF_WALLS = (
    "big_end_ring",
    "shank_width",
    "shank_depth_big_end",
    "shank_depth_small_end",
    "web_thickness",
    "flange_thickness",
)


def walls(rod: Dimensions) -> dict[str, float]:
    """Return the thickness of each wall of a rod, mm, by its name."""
    found = {
        "big-end ring": rod.big_end_ring,
        "small-end ring": rod.small_end_ring - rod.bushing,
        "shank": min(rod.shank_width, rod.shank_depth_big_end, rod.shank_depth_small_end),
    }
    if rod.has_pockets:
        found |= {"web": rod.web_thickness, "flange": rod.flange_thickness}
    if rod.cap_bolt:
        found["wall between bolt hole and bore"] = (
            rod.cap_bolt_spacing - rod.cap_bolt - rod.big_end_bore
        ) / 2
    return found
