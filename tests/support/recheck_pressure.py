"""λ ∇·u of a written displacement, as the program understands it: projected where a material hardly gives."""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve
from skfem import ElementTetP1

# Above this Poisson's ratio second-order elements have a continuous linear pressure of their own.
LIMIT = 0.4
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])


def pressures(tets, dilation, volumes, values, constants):
    """Pressure (n_elements, n_points), positive in tension.

    Parameters
    ----------
    tets
        (n_elements, 4 or 10).
    dilation, volumes
        (n_elements, n_points) ∇·u, and weight times determinant.
    values
        (n_points, 4 or 10) shape functions.
    constants
        (λ, ν, number of the material), each (n_elements,).
    """
    lame, nu, material = constants
    found = lame[:, None] * dilation
    if tets.shape[1] == 4:
        return found
    places = values @ np.vstack([_CORNERS, _CORNERS[_EDGES].mean(axis=1)])
    linear = np.stack([np.broadcast_to(ElementTetP1().lbasis(places.T, i)[0], len(places)) for i in range(4)])
    for number in np.unique(material[nu > LIMIT]):
        own = material == number
        nodes, local = np.unique(tets[own, :4], return_inverse=True)
        local = local.reshape(-1, 4)
        right = np.bincount(local.ravel(), ((volumes * found)[own] @ linear.T).ravel())
        squares = np.einsum("eq,iq,jq->eij", volumes[own], linear, linear)
        rows, columns = np.repeat(local, 4, axis=1).ravel(), np.tile(local, (1, 4)).ravel()
        mass = sparse.csc_array(sparse.coo_array((squares.ravel(), (rows, columns)), shape=(nodes.size,) * 2))
        found[own] = spsolve(mass, right)[local] @ linear
    return found
