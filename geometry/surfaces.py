"""The names of surfaces, shared by every stage."""

from enum import StrEnum


class Surface(StrEnum):
    """A named part of the boundary (or of a mirror plane) of a solid."""

    BIG_END_BORE = "big_end_bore"
    SMALL_END_BORE = "small_end_bore"
    SYMMETRY_X = "symmetry_x"  # the cut x = 0; a rod has none
    SYMMETRY_Y = "symmetry_y"  # the cut y = 0
    SYMMETRY_Z = "symmetry_z"  # the cut z = 0
    FREE = "free"  # everything else

    # Of benchmark bodies.
    INNER = "inner"
    OUTER = "outer"
    LOADED = "loaded"
    CLAMPED = "clamped"
    ROLLER = "roller"  # free to slide, held along its normal
