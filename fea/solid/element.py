"""Shape functions and quadrature of the reference elements, from scikit-fem."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from skfem import ElementTetP1, ElementTetP2, ElementTriP1, ElementTriP2
from skfem.quadrature import get_quadrature

from geometry.arrays import Floats

_ELEMENTS = {4: ElementTetP1, 10: ElementTetP2, 3: ElementTriP1, 6: ElementTriP2}


@dataclass(frozen=True)
class Tabulation:
    """Shape functions of a reference simplex at quadrature points.

    The nodes are numbered as in `mesh.tetmesh.TetMesh`: scikit-fem, like VTK, orders the edges of a
    tetrahedron (0,1), (1,2), (0,2), (0,3), (1,3), (2,3).

    Attributes
    ----------
    weights
        (n_points,) quadrature weights on the reference simplex.
    values
        (n_points, n_nodes) shape functions.
    gradients
        (n_points, n_nodes, dim) derivatives with respect to reference coordinates.
    """

    weights: Floats
    values: Floats
    gradients: Floats


def shape_functions(n_nodes: int, points: Floats) -> tuple[Floats, Floats]:
    """Shape functions and their derivatives at `points` (dim, n) of the reference simplex.

    Returns
    -------
    values, gradients
        (n, n_nodes) and (n, n_nodes, dim).
    """
    element = _ELEMENTS[n_nodes]()
    tables = [element.lbasis(points, node) for node in range(n_nodes)]
    values = np.stack([np.broadcast_to(value, points.shape[1]) for value, _ in tables], axis=1)
    gradients = np.stack([np.broadcast_to(np.asarray(slope), points.shape).T for _, slope in tables], axis=1)
    return values.astype(float), gradients.astype(float)


@cache
def tabulate(n_nodes: int, degree: int) -> Tabulation:
    """Tabulate the simplex with `n_nodes` nodes for a rule exact to polynomial `degree`."""
    points, weights = get_quadrature(_ELEMENTS[n_nodes].refdom, degree)
    return Tabulation(weights, *shape_functions(n_nodes, points))
