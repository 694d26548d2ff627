"""Solve a body with Taylor–Hood elements, as a run does with nearly incompressible parts."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.base.material import Material
from fea.solid.assembly import pattern, stiffness
from fea.solid.supports import require_restrained
from fea.solvers.linear.choice import factorise
from fea.solvers.mixed import MixedSystem, pressure_space, shear_materials
from fea.solvers.residuals import condition_estimate
from fea.verify.stability.solved import Solved
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class SolvedPair:
    """A displacement and its pressure.

    Attributes
    ----------
    solved
        The displacement; the condition number is that of the factorised matrix.
    pressure
        (n_nodes, 1), MPa, positive in tension.
    """

    solved: Solved
    pressure: Floats


def solved_pair(
    mesh: TetMesh, material: Material, forces: Floats, fixed: npt.NDArray[np.bool_]
) -> SolvedPair:
    """Solve with `fixed` displacements (n_nodes, 3) zero.

    Raises
    ------
    UnderconstrainedError, SingularMatrixError, StagnationError
        There is no solution.
    """
    require_restrained(mesh, fixed)
    held = fixed.ravel()
    A = stiffness(mesh, shear_materials([material], [0])[0], pattern(mesh.tets, len(mesh.points)))
    space = pressure_space(mesh, {0: material})
    constrained = A.constrained(held)
    factor = factorise(constrained)
    system = MixedSystem(A, space, held, np.ones(space.lame_lambda.size, dtype=bool))
    u, p, found = system.solve(factor, forces.reshape(-1, 1))
    condition = condition_estimate(constrained, factor)
    solved = Solved(u.reshape(-1, 3), found.backward_error, found.energy, condition, found.imbalance)
    return SolvedPair(solved, space.nodal(p, len(mesh.points))[0])
