"""Whether points lie in the material of a solid."""

from collections.abc import Sequence

import gmsh
import numpy as np

from geometry.arrays import Floats


class Interior:
    """The inside of volumes of the open model.

    The kernel takes milliseconds to tell, so it is asked only for volumes whose bounding box holds the point.

    Parameters
    ----------
    volumes
        gmsh's tags.
    """

    def __init__(self, volumes: Sequence[int]) -> None:
        self._volumes = tuple(volumes)
        boxes = np.reshape([gmsh.model.getBoundingBox(3, volume) for volume in volumes], (-1, 2, 3))
        self._low, self._high = boxes[:, 0], boxes[:, 1]

    def contains(self, point: Floats) -> bool:
        """Whether a point lies in any of the volumes."""
        near = ((self._low <= point) & (point <= self._high)).all(axis=1)
        return any(gmsh.model.isInside(3, self._volumes[at], list(point)) for at in np.flatnonzero(near))
