"""Orient the boundary facets outwards: CAD kernels orient faces arbitrarily."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Ints
from mesh.errors import MeshError
from mesh.tetmesh import FACES, FACET_TURN, TetMesh

# The faces of a positively oriented tetrahedron, seen from outside counter-clockwise.


def outward(mesh: TetMesh) -> TetMesh:
    """Return the mesh with every facet oriented outwards from the element behind it.

    Raises
    ------
    MeshError
        A facet bounds no element or two elements: the surface of a damaged solid may fold onto itself.
    """
    faces = mesh.tets[:, FACES].reshape(-1, 3)
    keys = face_keys(faces, len(mesh.points))
    order = np.argsort(keys)
    ordered, even = keys[order], _even(faces)

    def turned(facets: Ints) -> Ints:
        found = face_keys(facets[:, :3], len(mesh.points))
        first = np.searchsorted(ordered, found)
        astray = np.searchsorted(ordered, found, side="right") - first != 1
        if astray.any():
            x, y, z = mesh.points[facets[astray][0, :3]].mean(axis=0)
            message = (
                f"{astray.sum()} surface triangles do not bound exactly one tetrahedron each; the first is "
                f"at ({x:.1f}, {y:.1f}, {z:.1f}) mm. The solid may be damaged: export it again, or try "
                "another --size"
            )
            raise MeshError(message)
        wrong = even[order[first]] != _even(facets[:, :3])
        return np.where(wrong[:, None], facets[:, FACET_TURN[facets.shape[1]]], facets)

    return replace(mesh, facets={surface: turned(facets) for surface, facets in mesh.facets.items()})


def face_keys(faces: Ints, n_points: int) -> Ints:
    """One number for the three nodes of a face, independent of their order."""
    a, b, c = np.sort(faces, axis=1).T
    return np.asarray((a * n_points + b) * n_points + c)


def _even(faces: Ints) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether the nodes are an even permutation of their ascending order."""
    a, b, c = faces.T
    return np.asarray((a < b).astype(int) + (b < c) + (c < a) == 2)
