"""Solve an extreme case as a run does, with the measures of numerical quality, and judge the result."""

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from enum import StrEnum

import numpy as np

from fea.base.checks import LIMITS, Check, check
from fea.base.choices import CONVERGED_PERCENT
from fea.base.material import Material, Materials
from fea.judge import verdict
from fea.judge.verdict import Peak
from fea.output.json_file import JsonObject
from fea.solid.assembly import pattern, stiffness
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.stress import von_mises
from fea.solid.supports import require_restrained
from fea.solvers.direct import factorise
from fea.solvers.mixed import MixedSystem, PressureSpace, pressure_space
from fea.solvers.residuals import condition_estimate, residuals
from fea.verify.body import LoadedBody, SolvedBody
from geometry.arrays import Floats


class Outcome(StrEnum):
    """How an extreme case ends."""

    RIGHT = "right"  # within its tolerance
    MARKED = "marked"  # `fea run` would report that it is not to be trusted, whether it is wrong or not
    REFUSED = "refused"  # an error message instead of a result
    WRONG = "wrong"  # wrong, and nothing reports it


Setting = tuple[str, str, float]  # a case, the name of its parameter and the value of that


@dataclass(frozen=True)
class ExtremeRow:
    """One case at one value of its parameter, in the order and by the names that other programs rely on."""

    case: str
    parameter: str
    value: float
    _: KW_ONLY
    #: ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms; None if nothing is solved
    backward_error: float | None = None
    condition_estimate: float | None = None  #: see `fea.solvers.residuals`
    energy_error: float | None = None  #: |uᵀKu − uᵀf| / uᵀf
    #: absolute error of the result relative to the exact one; None if there is no result
    result_error_percent: float | None = None
    tolerance_percent: float | None = None  #: largest error that counts as right
    #: how a run reports the problem: the names of the checks that fail, or its error bar
    noticed_by: tuple[str, ...] = ()
    verdict: Outcome

    @property
    def passed(self) -> bool:
        """Whether the result is right or the problem is reported."""
        return self.verdict is not Outcome.WRONG

    def as_dict(self) -> JsonObject:
        """Return the figures by their JSON keys."""
        return dict(vars(self))


def judged(
    setting: Setting,
    error_percent: float,
    tolerance_percent: float,
    checks: Mapping[str, Check],
    noticed_by: Iterable[str] = (),
) -> ExtremeRow:
    """Judge a result by the checks of its run; `noticed_by`: how else a run would report a problem."""
    noticed = (*noticed_by, *(name for name, check in checks.items() if not check.passed))
    right = Outcome.RIGHT if error_percent <= tolerance_percent else Outcome.WRONG
    values = {name: each.value for name, each in checks.items()}
    return ExtremeRow(
        *setting,
        verdict=Outcome.MARKED if noticed else right,
        result_error_percent=error_percent,
        backward_error=values.get("backward_error"),
        condition_estimate=values.get("condition"),
        energy_error=values.get("energy_balance"),
        tolerance_percent=tolerance_percent,
        noticed_by=noticed,
    )


@dataclass(frozen=True)
class CheckedSolution:
    """The solution of a body, with the checks of a run on its numerical quality."""

    body: SolvedBody
    checks: Mapping[str, Check]
    #: (n_nodes, 1), MPa, positive in tension, of Taylor–Hood elements
    pressure: Floats | None = None

    @property
    def displacement(self) -> Floats:
        """(n_nodes, 3), mm."""
        return self.body.displacement[:, :, 0]

    def row(
        self, setting: Setting, error_percent: float, tolerance_percent: float, noticed_by: Iterable[str] = ()
    ) -> ExtremeRow:
        """Judge a result computed from the displacement; `noticed_by` names other checks that would fail."""
        return judged(setting, error_percent, tolerance_percent, self.checks, noticed_by)

    @property
    def peak(self) -> Peak:
        """The largest von Mises stress and its bar, MPa, as a run prints them."""
        body = self.body
        estimated = ErrorEstimator(body.mesh, [body.material])(body.displacement, [body.stress[:, :, None]])
        return verdict.peak(von_mises(body.stress), estimated.stress[0][:, 0])

    def peak_row(self, setting: Setting, exact: float) -> ExtremeRow:
        """Judge the peak, MPa: if a run calls it converged, its error must be within the limit of that."""
        peak = self.peak
        return self.row(setting, percent(peak.value, exact), CONVERGED_PERCENT, unconverged(peak))


def solved(
    body: LoadedBody, material: Material | Materials | None = None, space: PressureSpace | None = None
) -> CheckedSolution:
    """Solve K u = f as a run does, with the body's material or another one.

    With the pressures of a `space`, elements are Taylor–Hood's, as of nearly incompressible parts, and the
    material is without λ. Raises `UnderconstrainedError`, `SingularMatrixError` and `StagnationError`: there
    is no solution.
    """
    mesh = body.mesh
    require_restrained(mesh, body.fixed)
    held, f, pressure = body.fixed.ravel(), body.forces.reshape(-1, 1), None
    K = stiffness(mesh, material or body.material, pattern(mesh.tets, len(mesh.points)))
    constrained = K.constrained(held)
    factor = factorise(constrained)
    if space is None:
        f = np.where(held[:, None], 0.0, f)
        u = factor(f)
        u[held] = 0.0
        quality = residuals(K, u, f, fixed=held, restraints=np.zeros_like(held))
    else:
        system = MixedSystem(K, space, held, np.ones(space.lame_lambda.size, dtype=bool))
        u, p, quality = system.solve(factor, f)
        pressure = space.nodal(p)[0]
    values = {
        "backward_error": quality.backward_error,
        "energy_balance": quality.energy,
        "condition": condition_estimate(constrained, factor),
        "imbalance": quality.imbalance,
    }
    checks = {name: check(name, value) for name, value in values.items()}
    return CheckedSolution(body.with_displacement(u.reshape(-1, 3, 1)), checks, pressure)


def solved_by(method: str, body: LoadedBody, material: Material) -> CheckedSolution:
    """Solve with displacement elements (``p1`` or ``p2``) or Taylor–Hood elements (``p2/p1``)."""
    if method != "p2/p1":
        return solved(body, material)
    return solved(body, material.without_lambda(), pressure_space(body.mesh, {0: material}))


def beyond(method: str, ratio: float) -> tuple[str, ...]:
    """Return the check of a run that fails for Poisson's ratio, for `ExtremeRow.noticed_by`."""
    name = f"poissons_ratio_{method}"
    return () if name not in LIMITS or check(name, ratio).passed else (name,)


def unconverged(peak: Peak) -> tuple[str, ...]:
    """Return the verdict of a run on a peak, for `ExtremeRow.noticed_by`."""
    if peak.verdict() is verdict.ConvergenceVerdict.CONVERGED:
        return ()
    return (f"not converged, ±{peak.error_percent:.2g} %",)


def percent(computed: float, exact: float) -> float:
    """Absolute relative error, %."""
    return 100 * abs(computed / exact - 1)
