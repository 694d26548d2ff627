"""The peak of a solved body with its error bar, as a run prints it."""

from fea.base.choices import CONVERGED_PERCENT
from fea.judge.verdict import Peak, Verdict, peak
from fea.stress.error_estimate import ErrorEstimator
from fea.stress.stress import von_mises
from fea.verify.body import SolvedBody
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import Solved, percent


def peak_of(body: SolvedBody) -> Peak:
    """Find the largest von Mises stress and its bar, MPa."""
    estimated = ErrorEstimator(body.mesh, [body.material])(body.displacement, [body.stress[:, :, None]])
    return peak(von_mises(body.stress), estimated.stress[0][:, 0])


def noticed(found: Peak) -> tuple[str, ...]:
    """Return the verdict of a run on a peak, for `ExtremeRow.noticed_by`."""
    if found.verdict() is Verdict.CONVERGED:
        return ()
    return (f"not converged, ±{found.error_percent:.2g} %",)


def peak_row(place: tuple[str, str, float], result: Solved, found: Peak, exact: float) -> ExtremeRow:
    """Judge a peak: if it is called converged, its error must be within the limit of convergence.

    Parameters
    ----------
    place
        Case, parameter and its value.
    result, found
        The solution and its peak.
    exact
        The peak, MPa.
    """
    error = percent(found.value, exact)
    return result.row(*place, error, CONVERGED_PERCENT, noticed_by=noticed(found))
