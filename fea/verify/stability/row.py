"""The row of an extreme case in the table, and the verdict on it."""

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """The outcome of an extreme case."""

    RIGHT = "right"  # within its tolerance
    MARKED = "marked"  # `fea run` would report that it is not to be trusted, whether it is wrong or not
    REFUSED = "refused"  # an error message instead of a result
    WRONG = "wrong"  # wrong, and nothing reports it


@dataclass(frozen=True)
class ExtremeRow:
    """One case at one value of its parameter.

    Attributes
    ----------
    case, parameter
        Names of the case and of its parameter.
    value
        Value of the parameter.
    verdict
        The outcome.
    result_error_percent
        Absolute error of the result relative to the exact one; None if there is no result.
    backward_error
        ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms; None if nothing is solved.
    condition_estimate
        See `fea.solvers.residuals`.
    energy_error
        |uᵀKu − uᵀf| / uᵀf.
    tolerance_percent
        Largest error that counts as right.
    noticed_by
        How a run reports the problem: the names of the checks that fail, or its error bar.
    """

    case: str
    parameter: str
    value: float
    verdict: Verdict
    result_error_percent: float | None = None
    backward_error: float | None = None
    condition_estimate: float | None = None
    energy_error: float | None = None
    tolerance_percent: float | None = None
    noticed_by: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether the result is right or the problem is reported."""
        return self.verdict is not Verdict.WRONG

    def as_dict(self) -> dict[str, object]:
        """Return the row with the names that other programs rely on."""
        return {
            "case": self.case,
            "parameter": self.parameter,
            "value": self.value,
            "backward_error": self.backward_error,
            "condition_estimate": self.condition_estimate,
            "energy_error": self.energy_error,
            "result_error_percent": self.result_error_percent,
            "tolerance_percent": self.tolerance_percent,
            "noticed_by": list(self.noticed_by),
            "verdict": self.verdict.value,
        }


def judged(error_percent: float, tolerance_percent: float, *, marked: bool) -> Verdict:
    """Return the verdict on a result; `marked`: a run would report it as not to be trusted."""
    if marked:
        return Verdict.MARKED
    return Verdict.RIGHT if error_percent <= tolerance_percent else Verdict.WRONG
