"""Shape functions and quadrature of the elements of a written file, from scikit-fem."""

from functools import cache

import numpy as np
from skfem import ElementTetP1, ElementTetP2, ElementTriP1, ElementTriP2, MeshTet, MeshTri
from skfem.quadrature import get_quadrature

_ELEMENTS = {4: ElementTetP1, 10: ElementTetP2, 3: ElementTriP1, 6: ElementTriP2}


@cache
def rule(n_nodes, degree):
    """Weights, values (q, n) and slopes (q, n, dim) of the reference element with so many nodes."""
    points, weights = get_quadrature((MeshTet if n_nodes in (4, 10) else MeshTri).elem.refdom, degree)
    return weights, *shapes(n_nodes, points)


def shapes(n_nodes, points):
    """Values (q, n) and slopes (q, n, dim) of the shape functions at points (dim, q)."""
    element = _ELEMENTS[n_nodes]()
    tables = [element.lbasis(points, i) for i in range(n_nodes)]
    values = np.stack([np.broadcast_to(v, points.shape[1]) for v, _ in tables], axis=1)
    slopes = np.stack([_spread(np.asarray(g, dtype=float), points.shape) for _, g in tables], axis=1)
    return values, slopes


def _spread(slope, shape):
    return np.broadcast_to(slope.reshape(shape[0], -1), shape).T
