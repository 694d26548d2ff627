"""Solve K u = f for every load at once, one factorisation a parity, and check what came out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.choices import SolverName, Support
from fea.clock import Clock
from fea.material import Material
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.parity import Parity, Split
from fea.solid.solvers import factorise
from fea.solid.supports import (
    clamped,
    determinate_restraints,
    plane_conditions,
    require_restrained,
)
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Residuals:
    """How well the equations of one parity are satisfied, the worst over its right-hand sides.

    Attributes
    ----------
    backward_error
        ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms (Rigal & Gaches 1967).
    energy
        |uᵀKu − uᵀf| / uᵀf.
    reaction
        Largest force at a restraint of inertia relief, N; it should vanish.
    """

    backward_error: float
    energy: float
    reaction: float


@dataclass(frozen=True)
class Solution:
    """Displacement of every load case.

    Attributes
    ----------
    displacement
        Per parity (n_nodes, 3, n_cases), mm; the antisymmetric part is absent where no load has one.
    residuals
        Per parity.
    solved_dofs
        Unknowns over all parities.
    solver
        Name of the solver used.
    """

    displacement: dict[Parity, Floats]
    residuals: dict[Parity, Residuals]
    solved_dofs: int
    solver: str


def solve(
    mesh: TetMesh,
    material: Material,
    loads: Sequence[Split],
    support: Support,
    solver: SolverName = SolverName.AUTO,
    clock: Clock | None = None,
) -> Solution:
    """Displacements of the meshed cell under each load.

    Raises
    ------
    UnderconstrainedError
        A rigid motion is left free.
    SingularMatrixError
        The factorisation broke down.
    """
    clock = clock or Clock()
    with clock("assembly"):
        K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
        norm = K.norm()
    displacement: dict[Parity, Floats] = {}
    residuals: dict[Parity, Residuals] = {}
    solved, name = 0, ""
    for parity, f in _right_hand_sides(loads).items():
        planes = plane_conditions(mesh, parity)
        held = _support(mesh, support) & ~planes
        fixed = planes | held
        require_restrained(mesh, fixed)
        with clock("factor"):
            factor = factorise(K.constrained(fixed.ravel()), solver)
        with clock("solve"):
            u = factor.solve(np.where(fixed.ravel()[:, None], 0.0, f))
            u[fixed.ravel()] = 0.0
            residuals[parity] = _residuals(K, norm, u, f, fixed.ravel(), held.ravel())
        displacement[parity] = u.reshape(len(mesh.points), 3, -1)
        solved += int(np.count_nonzero(~fixed))
        name = factor.name
    return Solution(displacement, residuals, solved, name)


def _right_hand_sides(loads: Sequence[Split]) -> dict[Parity, Floats]:
    def column_stack(parts: Sequence[Floats]) -> Floats:
        return np.stack([part.ravel() for part in parts], axis=1)

    sides = {Parity.SYMMETRIC: column_stack([load.symmetric for load in loads])}
    odd = [load.antisymmetric for load in loads if load.antisymmetric is not None]
    if len(odd) == len(loads):
        antisymmetric = column_stack(odd)
        # Purely axial loads leave rounding only.
        if np.abs(antisymmetric).max() > 1e-12 * np.abs(sides[Parity.SYMMETRIC]).max():
            sides[Parity.ANTISYMMETRIC] = antisymmetric
    return sides


def _support(mesh: TetMesh, support: Support) -> npt.NDArray[np.bool_]:
    if support is Support.CLAMPED:
        return clamped(mesh, Surface.BIG_END_BORE)
    return determinate_restraints(mesh)


def _residuals(
    K: SymmetricMatrix,
    norm: float,
    u: Floats,
    f: Floats,
    fixed: npt.NDArray[np.bool_],
    held: npt.NDArray[np.bool_],
) -> Residuals:
    product = K @ u
    residual = np.where(fixed[:, None], 0.0, product - f)
    scale = norm * np.abs(u).max(axis=0) + np.abs(f).max(axis=0)
    work = (u * f).sum(axis=0)
    energy = (u * product).sum(axis=0)
    reaction = np.abs((product - f)[held]).max(initial=0.0)
    return Residuals(
        _worst(np.abs(residual).max(axis=0), scale),
        _worst(np.abs(energy - work), np.abs(work)),
        float(reaction),
    )


def _worst(error: Floats, scale: Floats) -> float:
    """Largest ratio; a load case without any load counts as exact, a value that is not finite as infinite."""
    if not (np.isfinite(error).all() and np.isfinite(scale).all()):
        return float("inf")
    loaded = scale > 0
    return float((error[loaded] / scale[loaded]).max(initial=0.0))
