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


# Axis of the normal of each mirror plane.
PLANE_AXIS = {Surface.SYMMETRY_X: 0, Surface.SYMMETRY_Y: 1, Surface.SYMMETRY_Z: 2}


class Mirror(StrEnum):
    """The cell that is drawn; its reflections about `planes` are the whole rod."""

    NONE = "none"
    HALF = "half"  # z ≥ 0
    QUARTER = "quarter"  # y ≥ 0 and z ≥ 0

    @property
    def planes(self) -> tuple[Surface, ...]:
        """The mirror planes that bound the cell."""
        return {
            Mirror.NONE: (),
            Mirror.HALF: (Surface.SYMMETRY_Z,),
            Mirror.QUARTER: (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z),
        }[self]

    @property
    def copies(self) -> int:
        """Number of cells that make the whole rod."""
        return 1 << len(self.planes)
