"""Element sizes that vary over the solid, as requested by an earlier solution on it."""

from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats, Ints

# Neighbours considered when limiting the growth of sizes: the smallest sizes matter, and they are near.
_NEIGHBOURS = 64


@dataclass(frozen=True)
class SizeField:
    """Wanted edge lengths on a mesh of the solid as it is drawn.

    Attributes
    ----------
    points
        (n_nodes, 3), mm.
    tets
        (n_elements, 4) vertices.
    size
        (n_nodes,) wanted edge length, mm, linear in between; used at vertices only.
    """

    points: Floats
    tets: Ints
    size: Floats

    def graded(self, growth: float) -> "SizeField":
        """Return the field with sizes that grow by at most `growth` per distance (mm/mm)."""
        vertices = np.unique(self.tets)
        places, wanted = self.points[vertices], self.size[vertices]
        small = np.flatnonzero(wanted < wanted.max())
        if not small.size:
            return self
        # An exact limit would need an advancing front; the nearest seeds give practically the same bound.
        seeds, sizes = places[small], wanted[small]
        from scipy.spatial import KDTree  # noqa: PLC0415 - only a refined mesh needs it

        distance, nearest = KDTree(seeds).query(places, k=min(_NEIGHBOURS, small.size))
        distance, nearest = distance.reshape(len(places), -1), nearest.reshape(len(places), -1)
        bound = np.minimum(wanted, (sizes[nearest] + growth * distance).min(axis=1))
        # Far from a large cluster of seeds, the smallest of all may not be among the nearest.
        least = int(sizes.argmin())
        bound = np.minimum(bound, sizes[least] + growth * np.linalg.norm(places - seeds[least], axis=1))
        size = self.size.copy()
        size[vertices] = bound
        return SizeField(self.points, self.tets, size)

    def add(self) -> int:
        """Add it to the open gmsh model; returns the tag of the background field."""
        view = gmsh.view.add("wanted sizes")
        corners = self.points[self.tets].transpose(0, 2, 1).reshape(len(self.tets), 12)
        rows = np.hstack([corners, self.size[self.tets]])
        gmsh.view.addListData(view, "SS", len(rows), rows.ravel())
        field: int = gmsh.model.mesh.field.add("PostView")
        gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
        # Curved boundaries reach beyond the straight tetrahedra of the view.
        gmsh.model.mesh.field.setNumber(field, "UseClosest", 1)
        return field
