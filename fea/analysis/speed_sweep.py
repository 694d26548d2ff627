"""Many speeds with their whole cycles: a full run where it matters, figures for the rest."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from fea.analysis.buckling import column_figures
from fea.analysis.pipeline import Analysis
from fea.analysis.speed_map import first_below
from fea.analysis.summary import load_figures
from fea.cycle.search import SpeedSearch
from fea.cycle.worst import CasePeak, Place, Worst
from fea.machine.threads import side_by_side
from fea.rod.load_cases import speed_loads
from fea.units import DEG

# With more speeds than this the fields are written at the worst ones only.
MOST_FULL_RUNS = 10
# To which the speed where a safety factor falls below 1 is found.
_WITHIN_RPM = 0.1
_LEFT_OUT = (
    ("fields of the load cases and of the envelope", "many speeds: they are written at the worst ones"),
    ("error estimates and displacements", "many speeds: the peaks are superposed, not solved"),
    ("Crossland's factor at every place", "many speeds: only the worst by yield and fatigue are looked at"),
)


class SpeedSweep:
    """The worst places of a rod at each of many speeds.

    Parameters
    ----------
    analysis
        Of a study with an engine, its cycle asked for.
    speeds
        rpm.

    Raises
    ------
    InvalidValue
        Nothing loads the rod at one of the speeds.

    Attributes
    ----------
    critical
        Lowest speed, rpm, from which each factor is below 1, to a tenth; None where there is none.
    """

    def __init__(self, analysis: Analysis, speeds: Sequence[float]) -> None:
        if analysis.engine is None or analysis.gas is None:
            raise ValueError("a sweep needs an engine")
        self._analysis = analysis
        self._loads = {  # a speed that loads the rod with nothing is refused
            rpm: speed_loads(analysis.study, analysis.engine, analysis.gas, analysis.rod, rpm)
            for rpm in speeds
        }
        self._search = SpeedSearch(analysis.cycle_analysis, analysis.engine, analysis.gas, sorted(speeds))
        self._found = dict(zip(sorted(speeds), side_by_side(self._search.at, sorted(speeds)), strict=True))
        self.critical = {name: self._critical(mode) for name, mode in _MODES.items()}

    @property
    def worst(self) -> set[float]:
        """The speed of the least factor against each mode of failure."""
        return {min(self._found, key=lambda rpm: mode(self._found[rpm])) for mode in _MODES.values()}

    def _critical(self, mode: Callable[[Worst], float]) -> float | None:
        rpm = np.array(list(self._found))
        first = first_below(np.array([mode(found) for found in self._found.values()]))
        if first is None or first == 0:
            return None if first is None else float(rpm[0])

        def above(speed: float) -> float:
            """Near to straight where inertia rules: stress goes by the square of speed."""
            return float(np.log(mode(self._found.get(speed) or self._search.at(speed))))

        return float(brentq(above, rpm[first - 1], rpm[first], xtol=_WITHIN_RPM))

    def summary(self, full: Mapping[str, Any], rpm: float) -> dict[str, Any]:
        """Return the summary of a speed whose fields are not written, from that of a full run.

        The checks are those of the full run, whose stiffness and unit solutions these figures are of.
        """
        found = self._found[rpm]
        own, others = self._loads[rpm], self._loads[full["rpm"]]
        elsewhere = {item.what for item in others.left_out}
        shared = [item for item in full["left_out"] if item["what"] not in elsewhere]
        spared = [*((item.what, item.why) for item in own.left_out), *_LEFT_OUT]
        return {
            **full,
            "rpm": rpm,
            "loads": {peak.case.name: load_figures(peak.case) for peak in found.cases},
            "results": {peak.case.name: _result(peak) for peak in found.cases},
            "envelope": _envelope(found, full["envelope"]),
            "buckling": column_figures(self._analysis, [peak.case for peak in found.cases]),
            "notes": [*(note for note in full["notes"] if note not in others.notes), *own.notes],
            "left_out": [*shared, *({"what": what, "why": why} for what, why in spared)],
        }


def _yielding(found: Worst) -> float:
    return min(found.yielding.factor, *(peak.factor for peak in found.cases))


def _fatigue(found: Worst) -> float:
    return np.inf if found.fatigue is None else found.fatigue.factor


def _crossland(found: Worst) -> float:
    """Least of the factors at the worst places against yielding and fatigue: the others are not looked at."""
    places = (found.yielding, found.fatigue)
    factors = [place.crossland for place in places if place is not None and place.crossland is not None]
    return min(factors, default=np.inf)


_MODES: dict[str, Callable[[Worst], float]] = {
    "yield": _yielding,
    "fatigue": _fatigue,
    "crossland": _crossland,
}


def _result(peak: CasePeak) -> dict[str, Any]:
    return {
        "max_von_mises_MPa": peak.von_mises,
        "at_mm": peak.at.tolist(),
        "max_principal_MPa": peak.principal_1,
        "min_principal_MPa": peak.principal_3,
        "max_displacement_mm": None,
        "min_safety_factor": peak.factor,
        "error_percent": None,
        "verdict": None,
    }


def _envelope(found: Worst, full: Mapping[str, Any]) -> dict[str, Any]:
    """The envelope's figures: where a case that is no instant of the cycle is worse, that case's."""
    case = min(found.cases, key=lambda peak: peak.factor)
    place, angle, multiaxial = found.yielding.at, found.yielding.crank_angle, _crossland(found)
    if case.factor < found.yielding.factor:
        place, angle = case.at, case.case.crank_angle
    return {
        "min_safety_factor": _yielding(found),
        "at_mm": place.tolist(),
        "crank_deg": None if angle is None else angle / DEG,
        "min_fatigue_safety_factor": None if found.fatigue is None else found.fatigue.factor,
        "fatigue_criterion": full["fatigue_criterion"],
        "fatigue": None if found.fatigue is None else _place(found.fatigue),
        "min_crossland_safety_factor": multiaxial if np.isfinite(multiaxial) else None,
        "unit_solutions": full["unit_solutions"],
        "instants": full["instants"],
    }


def _place(place: Place) -> dict[str, Any]:
    return {
        "at_mm": place.at.tolist(),
        "mean_MPa": place.mean,
        "amplitude_MPa": place.amplitude,
        "stress_ratio": place.ratio,
        "fatigue_safety_factor": place.factor,
        "crossland_safety_factor": place.crossland,
    }
