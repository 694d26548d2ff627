"""Linear buckling: (K + λ K_σ) φ = 0, with the stress of a reference load that λ multiplies.

The ends are held on average, as pins hold bores, so that no rigid motion is left. The parts about y = 0 are
coupled where the reference load has both; those about z = 0 never are, as the load is symmetric about it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from fea.choices import SolverName
from fea.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.geometric_stiffness import geometric_stiffness
from fea.solid.parity import Parity
from fea.solid.pins import TURN_Z, Held, mean_motions, motions
from fea.solvers.constrained import Constrained, constrained
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]

# Of Lanczos's residual; the error of λ is of its square's order.
_ACCURACY = 1e-6
# Lanczos vectors beyond twice the modes: a solution each, fewer than are set up by default.
_SPARE = 4
# A load that nowhere presses leaves eigenvalues that crowd below zero, which Lanczos does not tell apart:
# factors so many times the lowest (of either sign) are of no interest, nor what many restarts do not find.
_NOTHING = 1e-3
_RESTARTS = 20


@dataclass(frozen=True)
class BucklingMode:
    """A way to buckle.

    Attributes
    ----------
    factor
        λ > 0: the reference load times λ is critical.
    shape
        Per parity about y = 0, (n_nodes, 3).
    parity_z
        About z = 0.
    residual
        ‖φ + λ K⁻¹K_σ φ‖ / ‖φ‖, maximum norms.
    """

    factor: float
    shape: dict[Parity, Floats]
    parity_z: Parity
    residual: float


def buckling_modes(
    mesh: TetMesh,
    material: Material | Materials,
    displacement: Mapping[Parity, Floats],
    ends: tuple[Held, ...],
    *,
    count: int,
    choice: SolverName = SolverName.AUTO,
) -> list[list[BucklingMode]]:
    """Find the lowest positive factors of each reference load.

    Parameters
    ----------
    mesh
        The cell.
    material
        Of every element, or of each part.
    displacement
        Under the reference loads, per parity about y = 0, (n_nodes, 3, n_loads), mm.
    ends
        Surfaces held on average. A pressure on one that may turn about z is a pin's: it stays where it is
        when the bore turns.
    count
        How many modes a load.
    choice
        Which direct solver.

    Returns
    -------
    list of list of BucklingMode
        Per load, factors rising; fewer than `count` where tension leaves fewer.

    Raises
    ------
    UnderconstrainedError
        The ends leave a rigid motion.
    SingularMatrixError
        The factorisation broke down.
    """
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    n_loads = next(iter(displacement.values())).shape[-1]
    loads = [
        _Stressed(
            mesh, ends, {p: geometric_stiffness(mesh, material, u[..., i]) for p, u in displacement.items()}
        )
        for i in range(n_loads)
    ]
    sides = tuple(Parity) if Surface.SYMMETRY_Y in mesh.facets else (Parity.SYMMETRIC,)
    found: list[list[BucklingMode]] = [[] for _ in loads]
    for parity_z in tuple(Parity) if Surface.SYMMETRY_Z in mesh.facets else (Parity.SYMMETRIC,):
        bodies = {side: constrained(mesh, K, ends, (side, parity_z), choice) for side in sides}
        for i, load in enumerate(loads):
            found[i] += _modes(K, bodies, load, parity_z, count)
    return [sorted(modes, key=lambda mode: mode.factor)[:count] for modes in found]


class _Stressed:
    """K_σ of a reference load.

    Parameters
    ----------
    mesh
        The cell.
    ends
        As for `buckling_modes`.
    parts
        `geometric_stiffness` of the load's parts about y = 0.
    """

    def __init__(
        self, mesh: TetMesh, ends: tuple[Held, ...], parts: Mapping[Parity, sparse.csr_array]
    ) -> None:
        self._parts = parts
        self._pins: list[tuple[float, Floats]] = []
        forces = parts[Parity.SYMMETRIC] @ mesh.points
        for end in ends:
            if TURN_Z not in end.motions:
                nodes = np.unique(mesh.facets[end.surface])
                arm = motions(mesh.points[nodes], end.center)[TURN_Z]
                turned = np.cross([0.0, 0.0, 1.0], forces[nodes])
                row = mean_motions(mesh, end.surface, end.center)[TURN_Z]
                self._pins.append((float((arm * turned).sum()), row))

    def times(self, shape: Mapping[Parity, Floats], parity_z: Parity) -> dict[Parity, Floats]:
        """K_σ φ of a shape given by its parts (n_nodes, 3)."""
        product_of = {side: np.zeros_like(part) for side, part in shape.items()}
        for (own, matrix), (side, part) in product(self._parts.items(), shape.items()):
            product_of[Parity(own * side)] += matrix @ part
        # Forces fixed to the bore would turn it back; a pin's pressure turns along.
        turning = Parity.ANTISYMMETRIC if Parity.ANTISYMMETRIC in shape else Parity.SYMMETRIC
        for moment, row in self._pins if parity_z is Parity.SYMMETRIC else ():
            product_of[turning] -= moment * float((row * shape[turning]).sum()) * row
        return product_of


def _modes(
    K: SymmetricMatrix, bodies: Mapping[Parity, Constrained], load: _Stressed, parity_z: Parity, count: int
) -> list[BucklingMode]:
    """Lanczos on −K⁻¹K_σ φ = φ/λ in the energy's inner product."""
    n = K.size

    def parts(v: Floats) -> dict[Parity, Floats]:
        return {side: part.reshape(-1, 3) for side, part in zip(bodies, v.reshape(-1, n), strict=True)}

    def joined(part: Mapping[Parity, Floats]) -> Floats:
        return np.concatenate([part[side].ravel() for side in bodies])

    def pushed(v: Floats) -> Floats:
        return -joined(load.times(parts(v.ravel()), parity_z))

    def solved(f: Floats) -> Floats:
        return np.concatenate(
            [body.solve(part) for body, part in zip(bodies.values(), f.reshape(-1, n), strict=True)]
        )

    def stiff(v: Floats) -> Floats:
        return (K @ v.reshape(-1, n).T).T.ravel()

    size = n * len(bodies)
    start, largest = _power(lambda v: solved(pushed(v)), np.sin(np.arange(1.0, size + 1)))
    try:
        values, vectors = eigsh(
            LinearOperator((size, size), matvec=pushed, dtype=np.float64),
            k=count,
            M=LinearOperator((size, size), matvec=stiff, dtype=np.float64),
            Minv=LinearOperator((size, size), matvec=solved, dtype=np.float64),
            which="LA",
            ncv=2 * count + _SPARE,
            v0=start,
            maxiter=_RESTARTS,
            tol=_ACCURACY,
        )
    except ArpackNoConvergence as stopped:
        values, vectors = stopped.eigenvalues, stopped.eigenvectors
    return [
        BucklingMode(
            float(1 / value), parts(vector), parity_z, _residual(solved(pushed(vector)), value, vector)
        )
        for value, vector in zip(values, vectors.T, strict=True)
        if value > _NOTHING * largest
    ]


def _power(operator: Callable[[Floats], Floats], start: Floats) -> tuple[Floats, float]:
    """A vector among the operator's dominant ones, and about its largest eigenvalue's magnitude."""
    vector, growth = start, 0.0
    for _ in range(3):
        vector = operator(vector / np.linalg.norm(vector))
        growth = float(np.linalg.norm(vector))
    return vector, growth


def _residual(image: Floats, value: float, vector: Floats) -> float:
    return float(np.abs(vector - image / value).max() / np.abs(vector).max())
