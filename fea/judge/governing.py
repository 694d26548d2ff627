"""How well the smallest safety factor of some load cases is known, and how well each of them must be.

The verdict on a rod needs its smallest factor. The largest utilisation (one over the factor) of all cases is
not above the largest sum of utilisation and error over them: a case whose sum stays below that of the
governing one cannot change the factor, however wide its own bar is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from fea.judge.case_result import CaseResult
from fea.judge.verdict import Verdict
from geometry.arrays import vector

# A case that cannot govern is refined to at most so many times the tolerance: 15 % for 5 %.
MOST_RELAXED = 3.0


@dataclass(frozen=True)
class Governing:
    """The largest utilisation of the load cases at one speed, away from singular places."""

    utilisation: float  #: the largest
    highest: float  #: largest sum of utilisation and error
    #: case, place: that sum's load case and place, mm
    case: str
    place: tuple[float, float, float]

    @classmethod
    def of(cls, cases: Sequence[CaseResult]) -> "Governing":
        """Find it among the cases of one speed."""
        utilisation = max(case.worst.value for case in cases)
        upper = max(cases, key=lambda case: case.worst.highest)
        place = vector(upper.mesh.points[upper.worst.bar_node])
        return cls(utilisation, upper.worst.highest, upper.load.name, place)

    @property
    def percent(self) -> float:
        """Error bar of the smallest safety factor."""
        return 100 * (self.highest / self.utilisation - 1) if self.utilisation > 0 else 0.0

    def needed(self, case: CaseResult, tolerance_percent: float) -> float:
        """Error bar, percent, that a case needs for the smallest factor to be within a tolerance."""
        share = case.worst.value / self.utilisation if self.utilisation > 0 else 1.0
        return tolerance_percent / max(share, 1 / MOST_RELAXED)

    def covers(self, case: CaseResult, tolerance_percent: float) -> bool:
        """Whether a case, with its error bar, cannot change the smallest factor by more than a tolerance."""
        return case.worst.highest <= self.utilisation * (1 + tolerance_percent / 100)

    def verdict(self, case: CaseResult, tolerance_percent: float) -> Verdict:
        """Return the verdict on a case; one that cannot govern may have a wide bar."""
        verdict = case.verdict(tolerance_percent)
        spare = verdict is Verdict.NOT_CONVERGED and self.covers(case, tolerance_percent)
        return Verdict.SUFFICIENT if spare else verdict
