"""Many speeds with their whole cycles: a full run where it matters, figures and a map of all."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from fea.analysis.assembly_report import MOST_UNKNOWNS
from fea.analysis.buckling import column_figures
from fea.analysis.cycle.search import SpeedSearch, WorstOfSpeed
from fea.analysis.figures import BucklingFigures, CycleFigures, PassFigures, Summary
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary import endurance_figures, load_figures, summary_of
from fea.base.note import omission
from fea.base.units import DEG
from fea.judge.safety_factor import SafetyFactor
from fea.machine.threads import side_by_side
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.arrays import Floats
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
            ],
        )
        return replace(summary, critical_speeds_rpm=self.critical)

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
            instants=len(cycle_angles()),
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
    """Return the figures of a load case; of an assembled rod, bolts and joint, too."""
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
