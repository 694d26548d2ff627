"""Cross-sections of a mesh: area and second moments of the polygons in which planes cut its tetrahedra."""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from geometry.section import Section
from mesh.tetmesh import Floats, TetMesh

Ints = npt.NDArray[np.int64]

# The eight tetrahedra of a second-order one, of its nodes in VTK's order: four at the vertices, four around
# the diagonal 6–8 of what is left between them.
_EIGHT = np.reshape(
    [0, 4, 6, 7, 1, 4, 5, 8, 2, 5, 6, 9, 3, 7, 8, 9, 6, 8, 4, 5, 6, 8, 5, 9, 6, 8, 9, 7, 6, 8, 7, 4], (8, 4)
)
# By how many of the vertices, sorted by x, are below the plane: the edges cut, as triangles.
_CUTS = {
    1: [[(0, 1), (0, 2), (0, 3)]],
    2: [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]],
    3: [[(0, 3), (1, 3), (2, 3)]],
}


def sections(mesh: TetMesh, stations: Iterable[float]) -> tuple[Section, ...]:
    """Cut a mesh at x = each station, mm; second-order elements as eight straight ones.

    Raises
    ------
    ValueError
        A plane misses the mesh.
    """
    tets = mesh.tets if mesh.order == 1 else mesh.tets[:, _EIGHT].reshape(-1, 4)
    x = mesh.points[tets, 0]
    by_x = np.argsort(x, axis=1)
    tets, x = np.take_along_axis(tets, by_x, axis=1), np.take_along_axis(x, by_x, axis=1)
    return tuple(_section(mesh.points, tets, x, float(station)) for station in stations)


def least_section(mesh: TetMesh, low: float, high: float, count: int = 201) -> Section:
    """Return the section of least area with x between `low` and `high`, mm, of so many."""
    return min(sections(mesh, np.linspace(low, high, count)), key=lambda section: section.area)


def _section(points: Floats, tets: Ints, x: Floats, station: float) -> Section:
    below = (x < station).sum(axis=1)
    triangles = np.concatenate(
        [
            _cut(points[tets[below == count]], edges, station)
            for count, pieces in _CUTS.items()
            for edges in pieces
        ]
    )
    if not len(triangles):
        raise ValueError(f"the plane x = {station:g} mm misses the mesh")
    side, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    areas = np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]) / 2
    area = float(areas.sum())
    total = triangles.sum(axis=1)
    center = areas @ total / (3 * area)
    second = areas @ ((triangles**2).sum(axis=1) + total**2) / 12 - area * center**2
    return Section(station, area, inertia_y=float(second[1]), inertia_z=float(second[0]))


def _cut(corners: Floats, edges: list[tuple[int, int]], station: float) -> Floats:
    """Triangles (n, 3, 2) of y and z where the plane meets three edges of tetrahedra (n, 4, 3)."""
    start, end = corners[:, [a for a, _ in edges]], corners[:, [b for _, b in edges]]
    share = (station - start[..., :1]) / (end[..., :1] - start[..., :1])
    return np.asarray((start + share * (end - start))[..., 1:])
