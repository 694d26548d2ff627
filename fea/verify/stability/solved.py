"""Solve a body and keep the measures of numerical quality."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.base.checks import check
from fea.base.material import Material, Materials
from fea.solid.assembly import pattern, stiffness
from fea.solid.supports import require_restrained
from fea.solvers.linear.choice import factorise
from fea.solvers.residuals import condition_estimate, residuals
from fea.verify.stability.row import ExtremeRow, judged
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class Solved:
    """A displacement and its numerical quality.

    Attributes
    ----------
    displacement
        (n_nodes, 3), mm.
    backward_error, energy_error, condition
        See `ExtremeRow`.
    imbalance
        See `fea.solvers.residuals.Residuals`.
    """

    displacement: Floats
    backward_error: float
    energy_error: float
    condition: float
    imbalance: float

    @property
    def failed(self) -> tuple[str, ...]:
        """Names of the checks of a run that would fail."""
        values = {
            "backward_error": self.backward_error,
            "energy_balance": self.energy_error,
            "condition": self.condition,
            "imbalance": self.imbalance,
        }
        return tuple(name for name, value in values.items() if not check(name, value).passed)

    def row(
        self,
        case: str,
        parameter: str,
        value: float,
        error_percent: float,
        tolerance_percent: float,
        *,
        noticed_by: tuple[str, ...] = (),
    ) -> ExtremeRow:
        """Judge a result computed from the displacement.

        Parameters
        ----------
        case, parameter, value
            See `ExtremeRow`.
        error_percent, tolerance_percent
            Error of the result, and the largest error that counts as right.
        noticed_by
            Names of other checks that would fail.
        """
        noticed = (*noticed_by, *self.failed)
        return ExtremeRow(
            case=case,
            parameter=parameter,
            value=value,
            verdict=judged(error_percent, tolerance_percent, marked=bool(noticed)),
            result_error_percent=error_percent,
            backward_error=self.backward_error,
            condition_estimate=self.condition,
            energy_error=self.energy_error,
            tolerance_percent=tolerance_percent,
            noticed_by=noticed,
        )


def solved(
    mesh: TetMesh, material: Material | Materials, forces: Floats, fixed: npt.NDArray[np.bool_]
) -> Solved:
    """Solve K u = f with `fixed` displacements (n_nodes, 3) zero, as a run does.

    Raises
    ------
    UnderconstrainedError, SingularMatrixError
        There is no solution.
    """
    require_restrained(mesh, fixed)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    held = fixed.ravel()
    constrained = K.constrained(held)
    factor = factorise(constrained)
    f = np.where(held, 0.0, forces.ravel())
    u = factor(f[:, None])[:, 0]
    u[held] = 0.0
    found = residuals(K, u[:, None], f[:, None], fixed=held, restraints=np.zeros_like(held))
    condition = condition_estimate(constrained, factor)
    return Solved(u.reshape(-1, 3), found.backward_error, found.energy, condition, found.imbalance)


def percent(computed: float, exact: float) -> float:
    """Absolute relative error, %."""
    return 100 * abs(computed / exact - 1)
