"""Many speeds with their whole cycles: a full run where it matters, figures for the rest."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from fea.analysis.buckling import column_figures
from fea.analysis.cycle.search import SpeedSearch, Worst
from fea.analysis.figures import BucklingFigures, CycleFigures, PassFigures, Summary
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult
from fea.analysis.speed_map import first_below, opening_speeds
from fea.analysis.summary import endurance_figures, load_figures, summary_of
from fea.base.note import omission
from fea.base.units import DEG
from fea.machine.threads import side_by_side
from loads.slider_crank import cycle_angles

# With more speeds than this the fields are written at the worst ones only.
MOST_FULL_RUNS = 10
# To which the speed where a safety factor falls below 1 is found.
_WITHIN_RPM = 0.1
_EDGES = omission("structural stress at sharp edges", "they are judged at the worst speeds only, run in full")
_FILM = omission("oil film", "many speeds: it is computed at the worst ones")
_LEFT_OUT = (
    omission(
        "fields of the load cases and of the envelope", "many speeds: they are written at the worst ones"
    ),
    omission("error estimates and displacements", "many speeds: the peaks are superposed, not solved"),
    omission(
        "Crossland's factor at every place",
        "many speeds: it is computed at the places that are worst against yielding and fatigue",
    ),
)


class SpeedSweep:
    """The worst places of a rod at each of many speeds.

    `speeds`: rpm. Raises `InvalidValue`: nothing loads the rod at one of the speeds, or there is no engine.

    Attributes: `critical`: lowest speed, rpm, from which each factor is below 1, to a tenth, and that from
    which a joint opens; None where there is none.
    """

    def __init__(self, rod: PreparedRod, speeds: Sequence[float]) -> None:
        self._rod, loading = rod, rod.engine
        # A speed at which nothing loads the rod is refused.
        self._loads = {rpm: loading.at(rod.mass, rpm) for rpm in speeds}
        analysis, rising = rod.full_cycle, sorted(speeds)
        self._search = SpeedSearch(analysis, rod.crank_cycle, rising)
        self._found = dict(zip(rising, side_by_side(self._search.at, rising), strict=True))
        self.critical = dict(zip(_MODES, side_by_side(self._critical, _MODES.values()), strict=True))
        self.critical |= opening_speeds(rod, speeds)

    @property
    def worst(self) -> set[float]:
        """The speed of the least factor against each mode of failure."""
        return {min(self._found, key=lambda rpm: mode(self._found[rpm])) for mode in _MODES.values()}

    def _critical(self, mode: Callable[[Worst], float]) -> float | None:
        rpm = np.array(list(self._found))
        first = first_below(np.array([mode(worst) for worst in self._found.values()]))
        if first is None or first == 0:
            return None if first is None else float(rpm[0])

        def above(speed: float) -> float:
            """Return the logarithm of the factor: nearly linear where inertia dominates (stress ∝ speed²)."""
            return float(np.log(mode(self._found.get(speed) or self._search.at(speed))))

        return float(brentq(above, rpm[first - 1], rpm[first], xtol=_WITHIN_RPM))

    def summary(self, rpm: float, near: SpeedResult, passes: Sequence[PassFigures]) -> Summary:
        """Return the figures of a speed whose fields are not written.

        `near` is the result of a speed that was solved in full: its checks hold here as well, as the figures
        are of the same stiffness and unit solutions, and so does what it says of mesh and materials.
        """
        worst, loads = self._found[rpm], self._loads[rpm]
        columns = column_figures(self._rod, loads.cases)
        summary = summary_of(
            self._rod,
            passes,
            rpm=rpm,
            loads={case.name: load_figures(case) for case in worst.cases},
            results={case.name: peak for case, peak in zip(worst.cases, worst.peaks, strict=True)},
            envelope=self._envelope(worst),
            buckling=BucklingFigures(column=columns, min_safety_factor=columns.min_safety_factor),
            checks={name: each for name, each in near.checks.items() if not name.startswith("film_")},
            notes=[
                *(note for note in near.notes if note not in near.loads.notes),
                *loads.notes,
                *_LEFT_OUT,
                *([_EDGES] if self._rod.sharp_places else []),
                *([_FILM] if self._rod.options.needs_film else []),
            ],
        )
        return replace(summary, critical_speeds_rpm=self.critical)

    def _envelope(self, worst: Worst) -> CycleFigures:
        """The worst of the cycle: where a case that is no instant of the cycle is worse, that case's."""
        cycle, fatigue, multiaxial = self._rod.cycle, worst.fatigue, _crossland(worst)
        place, angle = worst.yielding.figures.at_mm, worst.yielding.crank_angle
        case, peak = min(zip(worst.cases, worst.peaks, strict=True), key=lambda one: one[1].min_safety_factor)
        if peak.min_safety_factor < worst.yielding.factor:
            place, angle = peak.at_mm, float(case.crank_angle)
        return CycleFigures(
            min_safety_factor=_yielding(worst),
            at_mm=place,
            crank_deg=angle / DEG,
            min_fatigue_safety_factor=None if fatigue is None else fatigue.factor,
            fatigue_criterion=cycle.fatigue.value,
            fatigue=None
            if fatigue is None
            else replace(fatigue.figures, fatigue_safety_factor=fatigue.factor),
            min_crossland_safety_factor=multiaxial if np.isfinite(multiaxial) else None,
            endurance=endurance_figures(self._rod.mesh.parts, self._rod.materials) or None,
            unit_solutions=cycle.units.count,
            instants=len(cycle_angles()),
        )


def _yielding(worst: Worst) -> float:
    return min(worst.yielding.factor, *(peak.min_safety_factor for peak in worst.peaks))


def _crossland(worst: Worst) -> float:
    """Least of the factors at the worst places against yielding and fatigue: the others are not looked at."""
    places = (place.figures.crossland_safety_factor for place in (worst.yielding, worst.fatigue) if place)
    return min((factor for factor in places if factor is not None), default=np.inf)


_MODES: dict[str, Callable[[Worst], float]] = {
    "yield": _yielding,
    "fatigue": lambda worst: np.inf if worst.fatigue is None else worst.fatigue.factor,
    "crossland": _crossland,
}
