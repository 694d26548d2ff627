"""The row that an extreme case leaves in the table, and the verdict on it."""

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """What became of an extreme case."""

    RIGHT = "right"  # within its tolerance
    MARKED = "marked"  # a run of `fea run` would say that it is not to be trusted, off or not
    REFUSED = "refused"  # an error instead of an answer
    WRONG = "wrong"  # off, and nothing says so


@dataclass(frozen=True)
class ExtremeRow:
    """One case at one value of its parameter.

    Attributes
    ----------
    case, parameter
        Names.
    value
        Of the parameter.
    verdict
        What became of it.
    result_error_percent
        Of the answer, against the exact one, without sign; None where there is no answer.
    backward_error
        ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms; None where nothing is solved.
    condition_estimate
        See `fea.solvers.condition`.
    energy_error
        |uᵀKu − uᵀf| / uᵀf.
    tolerance_percent
        Largest error that is right.
    noticed_by
        What a run says: names of its checks that fail, or its error bar.
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
        """Whether nobody is misled."""
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
    """Return the verdict on an answer; `marked`: a run would not trust it, right or not."""
    if marked:
        return Verdict.MARKED
    return Verdict.RIGHT if error_percent <= tolerance_percent else Verdict.WRONG
