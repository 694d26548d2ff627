"""Which part of a symmetric rod is drawn."""

from enum import StrEnum

from geometry.surfaces import Surface

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
        """How many cells make the whole rod."""
        return 1 << len(self.planes)
