"""Which faces of tetrahedra bound the body, and which elements share the others."""

import numpy as np

from geometry.arrays import Ints, Mask
from mesh.tetmesh import FACE_NODES, FACES


def face_counts(tets: Ints) -> tuple[Ints, Ints]:
    """Return a number of each face (n_elements, 4), equal for equal vertices, and how often each occurs."""
    a, b, c = np.sort(tets[:, FACES].reshape(-1, 3), axis=1).T
    n_points = int(tets.max(initial=0)) + 1
    _, edge = np.unique(a * n_points + b, return_inverse=True)
    _, which, counts = np.unique(edge * n_points + c, return_inverse=True, return_counts=True)
    return which.reshape(-1, 4), counts


def folded(tets: Ints) -> Mask:
    """Elements (n_elements,), positively oriented, that lie on the same side of a face as their neighbour."""
    which, counts = face_counts(tets)
    a, b, c = tets[:, FACES].reshape(-1, 3).T
    even = (a < b).astype(int) + (b < c) + (c < a) == 2  # as a permutation of the rising order
    evens = np.bincount(which.ravel(), even)
    return np.asarray(((counts == 2) & (evens != 1))[which].any(axis=1))


def boundary_facets(tets: Ints) -> Ints:
    """Faces (n, 3) or (n, 6) that belong to a single element, oriented outwards, in `TetMesh`'s order."""
    which, counts = face_counts(tets)
    element, face = np.nonzero(counts[which] == 1)
    return np.asarray(tets[element[:, None], FACE_NODES[tets.shape[1]][face]])
