"""Safety factors of the cycle against engine speed, and the speeds at which they fall below 1."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from fea.analysis.assembly_report import MOST_UNKNOWNS
from fea.analysis.figures import Summary
from fea.analysis.prepare import PreparedRod
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.arrays import Floats

MODES = {
    "yield": "yield_safety_factor",
    "fatigue": "fatigue_safety_factor",
    "crossland": "crossland_safety_factor",
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
