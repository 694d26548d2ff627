"""Element quality, measured on the curved elements and not on their straight-sided approximations."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Floats, vector
from mesh.tetmesh import EDGES, TetMesh

# An element is too distorted to trust if its smallest Jacobian is below this fraction of its mean.
LEAST_SCALED_JACOBIAN = 0.05
# Share of the volume that straight edges may miss; beyond, the bow of edges is first halved so often.
_MISSED, _HALVINGS = 5e-4, 2


@dataclass(frozen=True)
class Quality:
    """Quality of a mesh."""

    #: Smallest Jacobian determinant of any element over its mean, after the order was raised; a lower bound
    #: over the whole element, 1 for straight-sided ones
    least_scaled_jacobian: float
    #: least_shape, median_shape: mean ratio of straight-sided elements (Liu & Joe 1994); regular ones have 1
    least_shape: float
    median_shape: float
    worst_at: tuple[float, float, float]  #: (x, y, z) mm, the centre of the element with the least shape
    mended: tuple[int, ...] = ()  #: numbers of the elements whose curved edges were straightened

    @property
    def straightened(self) -> int:
        """Number of elements whose edges were straightened."""
        return len(self.mended)


def shape(mesh: TetMesh) -> Floats:
    """Mean ratio 12 (3V)^(2/3) / Σ edge² of each straight-sided element (Liu & Joe 1994)."""
    corners = mesh.points[mesh.tets[:, :4]]
    spans = corners[:, 1:] - corners[:, :1]
    volume = np.linalg.det(spans) / 6
    squares = sum(((corners[:, b] - corners[:, a]) ** 2).sum(axis=1) for a, b in EDGES)
    return np.asarray(np.sign(volume) * 12 * (3 * np.abs(volume)) ** (2 / 3) / squares)


# Places of a cubic's Bernstein coefficients, in thirds: the barycentric coordinates of a lattice.
_LATTICE = np.array([each for each in np.ndindex(4, 4, 4, 4) if sum(each) == 3])


def scaled_jacobian(mesh: TetMesh) -> Floats:
    """Lower bound of det J over each element, relative to the mean over the element: (n_elements,).

    That of a ten-node tetrahedron is a cubic, nowhere below its smallest Bernstein coefficient (Johnen,
    Remacle & Geuzaine 2013). A first-order element gives its sign.
    """
    if mesh.order == 1:
        return np.sign(shape(mesh))
    coefficients = _determinants(mesh)
    return np.asarray(coefficients.min(axis=1) / np.abs(coefficients.mean(axis=1)))


def _determinants(mesh: TetMesh) -> Floats:
    """Bernstein coefficients (n_elements, 20) of det J of ten-node tetrahedra; their mean is six volumes."""
    lattice = _LATTICE[:, [3, 0, 1, 2]] / 3.0
    slope = np.concatenate([-np.ones((1, 3)), np.eye(3)])
    corner = (4 * lattice[:, :, None] - 1) * slope
    edge = [4 * (lattice[:, a, None] * slope[b] + lattice[:, b, None] * slope[a]) for a, b in EDGES]
    gradients = np.concatenate([corner, np.stack(edge, axis=1)], axis=1)
    corners = mesh.points[mesh.tets]
    flat = gradients.transpose(1, 0, 2).reshape(10, -1)
    jacobian = (corners.transpose(0, 2, 1) @ flat).reshape(len(corners), 3, 20, 3)
    a, b, c = jacobian[:, 0], jacobian[:, 1], jacobian[:, 2]
    determinant = (a * np.cross(b, c)).sum(axis=-1)
    multinomial = 6 / np.array([1, 1, 2, 6])[_LATTICE].prod(axis=1)
    basis = multinomial * np.prod((_LATTICE / 3.0)[:, None] ** _LATTICE, axis=2)  # at the lattice
    return np.asarray(determinant @ np.linalg.inv(basis).T)


def measure(mesh: TetMesh, straightened: tuple[int, ...] = ()) -> Quality:
    """Measure the mesh; `straightened` are the numbers of elements with straightened edges."""
    shapes = shape(mesh)
    worst = int(shapes.argmin())
    return Quality(
        float(scaled_jacobian(mesh).min()),
        float(shapes.min()),
        float(np.median(shapes)),
        vector(mesh.points[mesh.tets[worst, :4]].mean(axis=0)),
        straightened,
    )


def with_straight_edges(mesh: TetMesh, *, keep_bow: bool = False) -> tuple[TetMesh, tuple[int, ...]]:
    """Straighten the edges of elements that are inverted or too distorted, until none is left.

    The second result are the numbers of these elements; straight-sided inverted ones stay as they are. With
    `keep_bow`, edges are only less bent where straight ones would miss too much of the volume.
    """
    straight, changed = _straightened(mesh, 0)
    if changed and keep_bow:
        volume, missed = _determinants(mesh).mean(axis=1).sum(), _determinants(straight).mean(axis=1).sum()
        if abs(missed - volume) > _MISSED * volume:
            return _straightened(mesh, _HALVINGS)
    return straight, changed


def _straightened(mesh: TetMesh, halvings: int) -> tuple[TetMesh, tuple[int, ...]]:
    """Halve the bow of the edges of distorted elements so often, then make them straight."""
    rounds = np.zeros(len(mesh.tets), dtype=np.int64)
    while mesh.order > 1:
        bad = (scaled_jacobian(mesh) < LEAST_SCALED_JACOBIAN) & (rounds <= halvings)
        if not bad.any():
            break
        rounds[bad] += 1
        points, tets = mesh.points.copy(), mesh.tets[bad]
        kept = np.where(rounds[bad] <= halvings, 0.5, 0.0)[:, None]
        for middle, (a, b) in enumerate(EDGES, start=4):
            chord = mesh.points[tets[:, [a, b]]].mean(axis=1)
            points[tets[:, middle]] = chord + kept * (mesh.points[tets[:, middle]] - chord)
        mesh = replace(mesh, points=points)
    return mesh, tuple(map(int, np.flatnonzero(rounds)))
