"""Many speeds with their whole cycles: a full run where it matters, figures and a map of all.

The candidates for the worst place follow from a few speeds (see `fea.analysis.cycle.candidates`): between two
of them the stress is bounded by the mean of both in speed squared. Every place is evaluated again at the
worst speeds.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from fea.analysis.assembly_report import MOST_UNKNOWNS
from fea.analysis.buckling import column_figures
from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.candidates import (
    CRITERIA,
    FATIGUE,
    YIELDING,
    CandidateHistories,
    Candidates,
    RowHistories,
    around,
)
from fea.analysis.cycle.figures import endurance_figures
from fea.analysis.cycle.screened import stress_measures
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import CaseFigures
from fea.analysis.life_figures import CycleFigures, PlaceFigures
from fea.analysis.prepared_rod import PreparedRod, evenly_spread
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary import load_figures, summary_of
from fea.analysis.summary_figures import BucklingFigures, PassFigures, Summary
from fea.base.note import omission
from fea.base.units import DEG
from fea.judge.fatigue import crossland_factors, enclosing_balls
from fea.judge.history import signed_equivalent
from fea.judge.safety_factor import SafetyFactor, without_bar
from fea.judge.verdict import CAP, safety_factor
from fea.machine.threads import side_by_side
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.arrays import Floats, vector
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

# With more speeds than this the fields are written at the worst ones only.
MOST_FULL_RUNS = 10
# To which the speed where a safety factor falls below 1 is found.
_WITHIN_RPM = 0.1
_EDGES = omission("structural stress at sharp edges", "they are judged at the worst speeds only, run in full")
_FRETTING = omission("fretting", "many speeds: it is found at the worst ones")
_FILM = omission("oil film", "many speeds: it is computed at the worst ones")
_LEFT_OUT = (
    omission(
        "fields of the load cases and of the envelope", "many speeds: they are written at the worst ones"
    ),
    omission(
        "error estimates, also of gauges, and displacements",
        "many speeds: the peaks are superposed, not solved",
    ),
    omission(
        "Crossland's factor at every place",
        "many speeds: it is computed at the places that are worst against yielding and fatigue",
    ),
)


@dataclass(frozen=True)
class WorstPlace:
    """The worst place against one mode of failure."""

    factor: float  #: its safety factor
    crank_angle: float  #: of the largest von Mises stress, rad
    figures: PlaceFigures  #: without the factor against fatigue


@dataclass(frozen=True)
class WorstOfSpeed:
    """The worst of the cycle at one speed."""

    cases: tuple[Instants, ...]  #: the peak cases
    peaks: tuple[CaseFigures, ...]  #: of the cases, superposed
    #: yielding, fatigue: the worst places; fatigue is None if no part's strengths are known
    yielding: WorstPlace
    fatigue: WorstPlace | None


# Speeds whose peak cases are superposed at once.
AT_ONCE = 10
# Share of the largest distance from its centre, and of the largest mean stress, from which on an instant may
# decide on Crossland's factor of a place.
_DECIDING = 0.98


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    `cycles`: the crank cycle at a speed, rpm; `speeds`: rpm; at least one.
    """

    def __init__(
        self, analysis: CycleAnalysis, cycles: Callable[[float], CrankCycle], speeds: Sequence[float]
    ) -> None:
        analysis = analysis.supported(cycles(max(speeds)))
        self._analysis, self._cycles, self._candidates = analysis, cycles, Candidates(analysis)
        for rpm in sorted(evenly_spread(speeds)):  # every place is evaluated at these
            self._candidates.survey(cycles(rpm))
        self._candidates.choose()
        blocks = [speeds[start : start + AT_ONCE] for start in range(0, len(speeds), AT_ONCE)]
        found = [peaks for block in side_by_side(self._at_peaks, blocks) for peaks in block]
        self._peaks = dict(zip(speeds, found, strict=True))

    def at(self, rpm: float) -> WorstOfSpeed:
        """Find the worst places at a speed between the first and the last, rpm."""
        cycle = self._cycles(rpm)
        cases = cycle.peaks.cases
        figures = self._peaks[rpm] if rpm in self._peaks else self._at_peaks([rpm])[0]
        histories = self._candidates.histories(cycle, cases.crank_angle[cases.in_cycle])
        yielding, fatigue = (self._worst(cycle, histories, mode) for mode in (YIELDING, FATIGUE))
        yielding = replace(yielding, factor=min(yielding.factor, CAP))
        return WorstOfSpeed(tuple(cases), figures, yielding, fatigue if np.isfinite(fatigue.factor) else None)

    def confirmed(self, rpm: float, found: WorstOfSpeed) -> bool:
        """Whether no place is worse than those found at a speed, rpm; any that is joins the candidates."""
        known = np.full(len(CRITERIA), np.nan)
        known[YIELDING] = 1 / found.yielding.factor
        known[FATIGUE] = np.nan if found.fatigue is None else 1 / found.fatigue.factor
        return self._candidates.confirm(self._cycles(rpm), known)

    def _worst(self, cycle: CrankCycle, histories: CandidateHistories, mode: int) -> WorstPlace:
        """Find the worst candidate against a mode of failure."""
        usage = [of_part.utilisation[mode] for of_part in histories.parts]
        number = int(np.argmax([used.max() for used in usage]))
        row = int(usage[number].argmax())
        of_part = histories.parts[number]
        factor = 1 / usage[number][row] if usage[number][row] > 0 else np.inf
        return self._place(factor, of_part.some(np.array([row])), cycle, histories.angles)

    def _place(self, factor: float, worst: RowHistories, cycle: CrankCycle, angles: Floats) -> WorstPlace:
        part, row = worst.part, int(worst.rows[0])
        signed = signed_equivalent(worst.stress)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        skin, region = float(part.surface(worst.rows)[0]), part.region(row)
        limit = part.material.endurance_limit
        spot = crossland_factors(self._around_decisive(worst, cycle, angles), part.material, skin)
        figures = PlaceFigures(
            at_mm=vector(part.points[row]),
            mean_MPa=(highest + lowest) / 2,
            amplitude_MPa=(highest - lowest) / 2,
            stress_ratio=lowest / highest if highest else 0.0,
            fatigue_safety_factor=None,
            crossland_safety_factor=None if spot is None else without_bar(float(spot[0])),
            endurance_MPa=None if limit is None else skin * limit,
            surface_region=None if region is None else region.value,
        )
        return WorstPlace(factor, float(angles[np.abs(signed).argmax()]), figures)

    def _around_decisive(self, worst: RowHistories, cycle: CrankCycle, angles: Floats) -> Floats:
        """Stress (1, 6, n_instants) of a row, also around the instants that decide on Crossland's factor."""
        _, center = enclosing_balls(worst.stress[:, :5])
        (history,) = worst.stress
        away, mean = np.linalg.norm(history[:5] - center[0, :, None], axis=0), history[5]
        deciding = (away >= _DECIDING * away.max()) | (mean == mean.max())
        more = np.setdiff1d(around(cycle, angles[deciding]), angles)
        return worst.extended(worst.part, self._analysis.weights(cycle, more)).stress

    def _at_peaks(self, speeds: Sequence[float]) -> list[tuple[CaseFigures, ...]]:
        """Superpose the peak cases of some speeds: many are hardly more work than those of one."""
        cases = [self._cycles(rpm).peaks.cases for rpm in speeds]
        weights = joined(*(self._analysis.basis.weights(of_speed) for of_speed in cases))
        stress = [part.measured(weights, stress_measures) for part in self._candidates.parts]
        ends = np.cumsum([0, *map(len, cases)])
        return [
            tuple(self._figures([of_part[:, k] for of_part in stress]) for k in range(start, stop))
            for start, stop in pairwise(ends)
        ]

    def _figures(self, stress: Sequence[Floats]) -> CaseFigures:
        """Figures of a case, from the measures (3, n_rows) of `screened` of each part."""
        peaks = []
        for part, (equivalent, largest, opposite) in zip(self._candidates.parts, stress, strict=True):
            row = int(equivalent.argmax())
            factor = safety_factor(equivalent[row : row + 1], part.material.yield_strength)
            peaks.append(
                CaseFigures(
                    max_von_mises_MPa=float(equivalent[row]),
                    at_mm=vector(part.points[row]),
                    max_principal_MPa=float(largest.max()),
                    min_principal_MPa=-float(opposite.max()),
                    max_displacement_mm=None,
                    min_safety_factor=SafetyFactor(float(factor[0])),
                    error_percent=None,
                    verdict=None,
                )
            )
        return replace(
            max(peaks, key=lambda peak: peak.max_von_mises_MPa),
            max_principal_MPa=max(peak.max_principal_MPa for peak in peaks),
            min_principal_MPa=min(peak.min_principal_MPa for peak in peaks),
            min_safety_factor=min(peak.min_safety_factor for peak in peaks),
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
        self._found = self._searched(rising)
        self.critical = {name: self._critical(mode) for name, mode in MODES.items()}
        self.critical |= opening_speeds(rod, speeds)

    @property
    def worst(self) -> set[float]:
        """The speed of the least factor against each mode of failure."""
        return {min(self._found, key=lambda rpm: mode(self._found[rpm])) for mode in MODES.values()}

    def _searched(self, speeds: Sequence[float]) -> dict[float, WorstOfSpeed]:
        """Search at speeds, until a look at every place confirms the worst of them."""
        while True:
            self._found = dict(zip(speeds, side_by_side(self._search.at, speeds), strict=True))
            if all(self._search.confirmed(rpm, self._found[rpm]) for rpm in self.worst):
                return self._found

    def _critical(self, mode: Callable[[WorstOfSpeed], float]) -> float | None:
        rpm, first = list(self._found), first_below(np.array(list(map(mode, self._found.values()))))
        if not first:
            return None if first is None else rpm[0]

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
                *([_FRETTING] if self._rod.options.fretting else []),
            ],
        )
        analysis, cycle = self._rod.full_cycle, self._rod.crank_cycle(rpm)
        gauges = tuple(gauge.superposed(analysis, worst.cases, cycle) for gauge in self._rod.gauges)
        return replace(summary, critical_speeds_rpm=self.critical, gauges=gauges or None)

    def _envelope(self, worst: WorstOfSpeed) -> CycleFigures:
        """The worst of the cycle: where a case that is no instant of the cycle is worse, that case's."""
        cycle, fatigue, multiaxial = self._rod.cycle, worst.fatigue, _crossland(worst)
        place, angle = worst.yielding.figures.at_mm, worst.yielding.crank_angle
        case, peak = min(zip(worst.cases, worst.peaks, strict=True), key=lambda one: one[1].min_safety_factor)
        if peak.min_safety_factor < worst.yielding.factor:
            place, angle = peak.at_mm, float(case.crank_angle)
        return CycleFigures(
            min_safety_factor=SafetyFactor(_yielding(worst)),
            at_mm=place,
            crank_deg=angle / DEG,
            min_fatigue_safety_factor=None if fatigue is None else SafetyFactor(fatigue.factor),
            fatigue_criterion=cycle.fatigue.value,
            fatigue=None
            if fatigue is None
            else replace(fatigue.figures, fatigue_safety_factor=SafetyFactor(fatigue.factor)),
            min_crossland_safety_factor=SafetyFactor(multiaxial) if np.isfinite(multiaxial) else None,
            endurance=endurance_figures(self._rod.mesh.parts, self._rod.materials) or None,
            unit_solutions=cycle.units.count,
            instants=len(self._rod.engine.engine.cycle_angles),
        )


def _yielding(worst: WorstOfSpeed) -> float:
    return min(worst.yielding.factor, *(peak.min_safety_factor for peak in worst.peaks))


def _crossland(worst: WorstOfSpeed) -> float:
    """Least of the factors at the worst places against yielding and fatigue: the others are not looked at."""
    places = (place.figures.crossland_safety_factor for place in (worst.yielding, worst.fatigue) if place)
    return min((factor for factor in places if factor is not None), default=np.inf)


# The factor against each mode of failure, whose column is called ``yield_safety_factor`` and so on.
MODES: dict[str, Callable[[WorstOfSpeed], float]] = {
    "yield": _yielding,
    "fatigue": lambda worst: np.inf if worst.fatigue is None else worst.fatigue.factor,
    "crossland": _crossland,
}


@dataclass(frozen=True)
class SpeedMap:
    """The worst of the cycle at several speeds."""

    #: (n_speeds,) by name, speeds increasing; NaN where fatigue is not judged. Crossland's factor is the
    #: least of the whole rod at speeds that were run in full, at others that of the worst places against
    #: yielding and fatigue. Of buckling the least of every case.
    columns: dict[str, Floats]
    #: Lowest speed, rpm, from which each of `MODES` fails; None where it does not within the map
    critical: Mapping[str, float | None]


def rounded(rpm: float) -> str:
    """A critical speed in the three digits that stresses of a few per cent can vouch for."""
    return f"{float(f'{rpm:.3g}'):.0f}"


def first_below(factor: Floats) -> int | None:
    """Number of the first factor below 1; None where there is none."""
    below = np.flatnonzero(factor < 1)
    return int(below[0]) if below.size else None


def speed_map(summaries: Sequence[Summary]) -> SpeedMap | None:
    """Gather the worst of the cycle at several speeds; None where no cycle was worked out."""
    known = [item for item in summaries if item.critical_speeds_rpm is not None and item.envelope is not None]
    critical = known[0].critical_speeds_rpm if known else None
    if critical is None:
        return None
    rows = [_row(summary) for summary in sorted(summaries, key=lambda summary: summary.rpm or 0.0)]
    return SpeedMap({name: np.array([row[name] for row in rows], float) for name in rows[0]}, critical)


def _row(summary: Summary) -> Mapping[str, float | None]:
    envelope = summary.envelope
    if envelope is None or summary.rpm is None:
        raise ValueError("a map over speeds needs the cycle at each of them")
    fatigue = envelope.fatigue
    stress = ("mean_MPa", "amplitude_MPa", "stress_ratio")
    return {
        "rpm": summary.rpm,
        "yield_safety_factor": envelope.min_safety_factor,
        "yield_crank_deg": envelope.crank_deg,
        **_place("yield", envelope.at_mm),
        "fatigue_safety_factor": None if fatigue is None else fatigue.fatigue_safety_factor,
        **_place("fatigue", (None, None, None) if fatigue is None else fatigue.at_mm),
        **{name: getattr(fatigue, name, None) for name in stress},
        "crossland_safety_factor": envelope.min_crossland_safety_factor,
        "column_safety_factor": summary.buckling.column.min_safety_factor,
        "buckling_factor": summary.buckling.min_mode_factor,
    }


def _place(of: str, at: Sequence[float | None]) -> dict[str, float | None]:
    return {f"{of}_{axis}_mm": coordinate for axis, coordinate in zip("xyz", at, strict=True)}


def case_rows(summaries: Sequence[Summary]) -> list[list[str]]:
    """Return the extremes of every run as rows of text: a heading, then one row per speed and load case."""
    rows = []
    for summary in summaries:
        for name in summary.results:
            figures = ("" if value is None else f"{value:.7g}" for value in _of_case(summary, name).values())
            rows.append([f"{summary.rpm:g}", name, *figures])
    return [["rpm", "case", *_of_case(summaries[0], next(iter(summaries[0].results)))], *rows]


def _of_case(summary: Summary, case: str) -> dict[str, float | None]:
    """Return the figures of a load case; also of bolts and joint, and the strain of gauges, as far as any."""
    load, result = summary.loads[case], summary.results[case]
    formulas, modes = summary.buckling.of_case(case)
    figures = {
        "crank_deg": load.crank_deg,
        "pin_axial_N": load.pin_axial_N,
        "crank_axial_N": load.crank_axial_N,
        "max_von_mises_MPa": result.max_von_mises_MPa,
        "min_safety_factor": result.min_safety_factor,
        "column_safety_factor": formulas,
        "buckling_factor": modes,
    }
    if summary.assembly is not None:
        joint = summary.assembly.joint.by_case[case]
        figures |= {
            "bolt_N": max(bolt.force_N for bolt in summary.assembly.bolts.by_case[case]),
            "joint_clamp_N": joint.clamp_force_N,
            "joint_open_percent": joint.open_percent,
            "joint_opening_um": joint.opening_um,
            "slip_reserve": joint.slip_reserve,
        }
    for gauge in summary.gauges or ():
        figures[f"{gauge.name.replace(' ', '_')}_um_m"] = gauge.cases[case].strain_um_m
    return figures


# The name of that speed among the critical ones.
JOINT_OPENING = "joint_opening"
# To which the speed is found, over itself.
_WITHIN = 0.01
# Stands for the pressure at an edge that has opened, MPa: its sign is what matters.
_OPEN = -1.0


def opening_speeds(rod: PreparedRod, speeds: Sequence[float]) -> dict[str, float | None]:
    """Find the lowest speed, rpm, at which a load case opens the joint at the edge of the bore, by its name.

    It is looked for between the lowest and the highest of `speeds`, rpm, and found to 1 %; of a large contact
    problem, it is the first of `speeds` at which the joint is open. None where it opens at none of them;
    nothing for a rod of one piece.
    """
    pins, rising = rod.assembly_contact, sorted(speeds)
    if pins is None:
        return {}
    number = next((number for number, rpm in enumerate(rising) if _edge(rod, pins, rpm) <= 0), None)
    rpm = None if number is None else rising[number]
    if rpm and number and pins.contact.problem.unfolding.size <= MOST_UNKNOWNS:
        low = rising[number - 1]
        rpm = float(brentq(lambda speed: _edge(rod, pins, speed), low, rpm, xtol=_WITHIN * rpm))
    return {JOINT_OPENING: rpm}


def _edge(rod: PreparedRod, pins: AssemblyPins, rpm: float) -> float:
    """Least pressure, MPa, at the edge of the bore over the load cases; negative where the joint opens."""
    least = []
    for case in rod.loading.at(rod.mass, rpm).cases:
        try:
            pressure = pins.state_under(case).joint.edge_pressure
        except ContactError:
            return _OPEN
        least.append(pressure or _OPEN)
    return min(least)
