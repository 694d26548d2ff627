"""Artificial slivers: an inner vertex is moved until an element is almost flat.

The problem is the beam in pure bending, whose solution second-order elements contain, even slivers: the error
consists of rounding, amplified by the flat element.
"""

from dataclasses import replace

import numpy as np

from fea.base.checks import check
from fea.verify.stability.bending import STRESS, beam, bent, stressed
from fea.verify.stability.peaks import noticed, peak_of
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent
from geometry.arrays import Floats
from mesh.quality import measure, shape
from mesh.tetmesh import EDGES, TetMesh

SHAPES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SIZE = 1.0
# For the peak of a linear stress.
TOLERANCE_PERCENT = 1e-2
_BISECTIONS = 60


def rows() -> list[ExtremeRow]:
    """The parameter is the smallest mean ratio of any element (`mesh.quality.Quality.least_shape`)."""
    whole = beam(SIZE, order=2)
    found = []
    for least in SHAPES:
        mesh = with_sliver(whole, least)
        result = bent(mesh)
        peak = peak_of(stressed(mesh, result))
        flat = check("flattest_element", 1 / measure(mesh).least_shape)
        by = (*(() if flat.passed else ("flattest_element",)), *noticed(peak))
        error = percent(peak.value, STRESS)
        found.append(result.row("sliver, p2", "shape", least, error, TOLERANCE_PERCENT, noticed_by=by))
    return found


def with_sliver(mesh: TetMesh, least: float) -> TetMesh:
    """Move an inner vertex towards the opposite face of an element, until the element has the shape `least`.

    Parameters
    ----------
    mesh
        A mesh with straight edges.
    least
        Mean ratio of the flattened element; no other element may become worse or inverted.
    """
    surface = np.unique(np.concatenate([facets.ravel() for facets in mesh.facets.values()]))
    vertices = mesh.tets[:, :4]
    inner = np.setdiff1d(vertices, surface)
    for tet in vertices[np.isin(vertices, inner).any(axis=1)]:
        vertex = tet[np.isin(tet, inner)][0]
        a, b, c = mesh.points[tet[tet != vertex]]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (mesh.points[vertex] - a) @ normal * normal
        moved = _flattened(mesh, int(vertex), height, least)
        if abs(shape(moved).min() / least - 1) < 1e-3:
            return moved
    raise AssertionError("a mesh with inner vertices has one that can be moved")


def _flattened(mesh: TetMesh, vertex: int, height: Floats, least: float) -> TetMesh:
    """Move a vertex along a height of its element, by bisection of the remaining height."""
    low, high = 1e-12, 1.0
    for _ in range(_BISECTIONS):
        left = float(np.sqrt(low * high))
        if shape(_moved(mesh, vertex, (left - 1) * height)).min() < least:
            low = left
        else:
            high = left
    return _moved(mesh, vertex, (high - 1) * height)


def _moved(mesh: TetMesh, vertex: int, by: Floats) -> TetMesh:
    points = mesh.points.copy()
    points[vertex] += by
    around = mesh.tets[(mesh.tets[:, :4] == vertex).any(axis=1)]
    for middle, (a, b) in enumerate(EDGES, start=4):
        points[around[:, middle]] = points[around[:, [a, b]]].mean(axis=1)
    return replace(mesh, points=points)
