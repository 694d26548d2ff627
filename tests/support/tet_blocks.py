"""Small meshes of tetrahedra, and files of them in other programs' formats."""

import numpy as np

from mesh.files.tets import TetFile
from mesh.tetmesh import EDGES

# Six tetrahedra that fill a cube, by its corners: 1 along x, 2 along y, 4 along z.
_SIX = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])


def block(count=2, order=1, first_number=1):
    """A row of cubes along x, six tetrahedra each."""
    x, y, z = np.meshgrid(np.arange(count + 1.0), [0.0, 1.0], [0.0, 1.0], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    corner = np.array([4 * (k & 1) + 2 * (k >> 1 & 1) + (k >> 2 & 1) for k in range(8)])
    tets = np.concatenate([4 * cube + corner[_SIX] for cube in range(count)])
    if order == 2:
        points, tets = with_middles(points, tets)
    return TetFile(points, tets, np.arange(first_number, first_number + len(tets)))


def with_middles(points, tets):
    """Second-order elements with straight edges."""
    ends = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)
    edges, which = np.unique(ends, axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    return np.concatenate([points, middles]), np.hstack([tets, len(points) + which.reshape(-1, 6)])


def deck(file, kind=None):
    """An Abaqus deck of a mesh."""
    kind = kind or ("C3D4" if file.tets.shape[1] == 4 else "C3D10")
    nodes = "\n".join(f"{n}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in enumerate(file.points.tolist(), 1))
    rows = zip(file.numbers.tolist(), (file.tets + 1).tolist(), strict=True)
    elements = "\n".join(", ".join(map(str, [n, *row])) for n, row in rows)
    return f"*NODE\n{nodes}\n*ELEMENT, TYPE={kind}\n{elements}\n"
