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

    # Where separate parts touch, one surface of each, and where bolts press.
    JOINT = "joint"  # the rod's side of the big end's joint, with the ends of the upper shell
    JOINT_CAP = "joint_cap"
    BUSHING_SEAT = "bushing_seat"  # the bore in the rod that holds the bushing
    BUSHING_BACK = "bushing_back"
    SHELL_SEAT = "shell_seat"  # the bore in rod and cap that holds the bearing shells
    SHELL_BACK = "shell_back"
    BOLT_HEAD = "bolt_head"
    BOLT_THREAD = "bolt_thread"  # under the nut, or the wall that the thread engages with

    # Of benchmark bodies.
    INNER = "inner"
    OUTER = "outer"
    LOADED = "loaded"
    CLAMPED = "clamped"
    ROLLER = "roller"  # free to slide, held along its normal


# Where separate parts touch: the surface of the one and the surface of the other.
INTERFACES = (
    (Surface.JOINT, Surface.JOINT_CAP),
    (Surface.BUSHING_SEAT, Surface.BUSHING_BACK),
    (Surface.SHELL_SEAT, Surface.SHELL_BACK),
)
