"""Free vibration: the lowest modes of K φ = ω² M φ, by Lanczos on a shifted and factorised matrix.

The stiffness of a free body is singular; K + s M with s > 0 is positive definite, so the direct solver
that the statics use factorises it (Ericsson & Ruhe 1980, with the shift below the spectrum).
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from fea.base.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.inertia import mass_matrix
from fea.solid.supports import rigid_modes
from fea.solvers.direct import factorise
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh

RIGID = 6
# The shift relative to the estimated square of the lowest elastic frequency: large enough for K + s M to be
# well conditioned, small enough to keep the modes apart.
_SHARE = 1e-2


@dataclass(frozen=True)
class VibrationModes:
    """Modes of vibration."""

    #: (n_modes,) f = ω/2π, Hz, increasing; the first six are the rigid-body modes of a free body
    frequencies: Floats
    shapes: Floats  #: (n_nodes, 3, n_modes), scaled to φᵀ M φ = 1 t·mm²
    backward_error: float  #: largest ‖Kφ − ω²Mφ‖ / (‖K‖ ‖φ‖ + ω² ‖M‖ ‖φ‖), maximum norms


def free_modes(
    mesh: TetMesh, material: Material | Materials, density: float | Floats, count: int
) -> VibrationModes:
    """Find the `count` lowest elastic modes of a free body, and its six rigid-body modes.

    The density, t/mm³, is of every element, or (n_elements,) of each. Raises `SingularMatrixError`.
    """
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    M = mass_matrix(mesh, density)
    shift = _SHARE * _bending_estimate(mesh, K, M)
    inverse = factorise(SymmetricMatrix(sparse.bsr_array(K.upper + shift * M.upper)))
    n = K.size

    def solve(right: Floats) -> Floats:
        return inverse(right.reshape(n, -1)).reshape(right.shape)

    def product(matrix: SymmetricMatrix) -> LinearOperator:
        return LinearOperator((n, n), matvec=lambda v: matrix @ v.ravel(), dtype=np.float64)

    values, vectors = eigsh(
        product(K),
        k=RIGID + count,
        M=product(M),
        sigma=-shift,
        OPinv=LinearOperator((n, n), matvec=solve, dtype=np.float64),
        v0=np.sin(np.arange(1.0, n + 1)),  # the same start, so the same result, every time
    )
    order = np.argsort(values)
    values, vectors = values[order], vectors[:, order]
    residual = np.abs(K @ vectors - values * (M @ vectors)).max(axis=0)
    scale = (K.norm() + np.abs(values) * M.norm()) * np.abs(vectors).max(axis=0)
    frequencies = np.sqrt(np.maximum(values, 0)) / (2 * np.pi)
    return VibrationModes(frequencies, vectors.reshape(-1, 3, len(values)), float((residual / scale).max()))


def _bending_estimate(mesh: TetMesh, K: SymmetricMatrix, M: SymmetricMatrix) -> float:
    """Rayleigh quotient ω², 1/s², of a parabola without its rigid part: an estimate for the lowest mode."""
    size = np.ptp(mesh.points, axis=0)
    along, across = int(size.argmax()), int(size.argmin())
    x = mesh.points[:, along] - mesh.points[:, along].mean()
    shape = np.zeros_like(mesh.points)
    shape[:, across] = (x / size[along]) ** 2
    shape[:, along] = -2 * x / size[along] ** 2 * (mesh.points[:, across] - mesh.points[:, across].mean())
    rigid, field = rigid_modes(mesh.points).reshape(-1, RIGID), shape.ravel()
    mass = M @ rigid
    field = field - rigid @ np.linalg.solve(rigid.T @ mass, mass.T @ field)
    return float(field @ (K @ field) / (field @ (M @ field)))
