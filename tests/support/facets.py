"""Integrals over the facets of a written surface, with their curved sides."""

import meshio
import numpy as np

# Gauss points (Gauss 1814) on the square, collapsed onto the triangle.
_AT, _WEIGHT = (own / 2 for own in np.polynomial.legendre.leggauss(8))
_U, _V = (own.ravel() for own in np.meshgrid(_AT + 0.5, _AT + 0.5, indexing="ij"))
_R, _S = _U, _V * (1 - _U)
_WEIGHTS = np.outer(_WEIGHT, _WEIGHT).ravel() * (1 - _U)


def integral(points, facets, values):
    """Integral of nodal values (n_nodes, …) over six-node facets (n, 6)."""
    one, zero = np.ones_like(_R), np.zeros_like(_R)
    corner, along_r, along_s = np.array([1 - _R - _S, _R, _S]), [-one, one, zero], [-one, zero, one]
    a, b, c = corner

    def with_middles(of_corners, of_middles):
        return np.concatenate([of_corners, of_middles]).T

    def slope(direction):
        u, v, w = direction
        middles = [4 * (u * b + a * v), 4 * (v * c + b * w), 4 * (w * a + c * u)]
        return with_middles((4 * corner - 1) * direction, middles)

    shape = with_middles(corner * (2 * corner - 1), [4 * a * b, 4 * b * c, 4 * c * a])
    r, s = (np.einsum("qa,fad->fqd", slope(np.array(own)), points[facets]) for own in (along_r, along_s))
    area = np.linalg.norm(np.cross(r, s), axis=2) * _WEIGHTS
    return np.einsum("fq,qa,fa...->...", area, shape, values[facets])


class WrittenSeats:
    """The surfaces that something presses on, in contact.vtu of a run."""

    def __init__(self, path):
        self._file = meshio.read(path)
        self._facets = self._file.cells_dict["triangle6"]
        self.names = list(self._file.cell_data)

    def integral(self, seat, array=None):
        """Integral of an array over a seat; its area by default."""
        values = np.ones(len(self._file.points)) if array is None else self._file.point_data[array]
        return integral(self._file.points, self._facets[self._file.cell_data[seat][0] == 1], values)
