"""Estimate how many elements a size will produce, before meshing."""

from collections.abc import Sequence
from math import sqrt

import gmsh

from mesh.sizing import Refinement, Sizing

# Volume of a regular tetrahedron with unit edges; gmsh's elements have about two thirds of it.
_VOLUME = sqrt(2) / 12 * 2 / 3


def estimate(refinements: Sequence[Refinement], sizing: Sizing) -> float:
    """Estimate the number of elements that the open model will have.

    The edge length grows with the distance d from a refined face, h = s + g d. Per unit area of the face, the
    integral of h⁻³ over d adds (s⁻² - h∞⁻²) / 2 g to the element density h∞⁻³ of the rest of the volume.
    """
    kernel, size = gmsh.model.occ, sizing.size
    volume = sum(kernel.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    density = volume / size**3
    for refinement in refinements:
        if refinement.size < size:
            area = sum(kernel.getMass(2, face) for face in refinement.faces)
            density += area * (refinement.size**-2 - size**-2) / (2 * sizing.growth)
    return float(density / _VOLUME)
