"""How many hours of a duty a rod lasts, at its worst place."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.duty import DutyDamage, DutyEntry, duty_damage
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import DutyFigures, LifeFigures, vector
from fea.base.material import SCATTER, Material
from fea.base.note import Note, doubt, omission, remark, warning
from fea.judge.fatigue import criterion_strength
from fea.rod.loading import DutyLoads
from fea.study.option_tables import DutyTable
from geometry.arrays import Floats
from geometry.mass import MassProperties

# Of a four-stroke cycle, 720°, that the angles of a history cover.
_CYCLES_PER_HOUR = 30.0  # at 1 rpm
# Standard deviations of the band.
_BAND = 2
_NOT_JUDGED = -1.0
_LIFE = "life"
_OMISSION = omission(
    "fretting, residual stress, growth of cracks and overspeed in the life",
    "the S–N line is that of smooth specimens at the stresses of the duty alone",
)


@dataclass(frozen=True)
class Life:
    """The life of a rod over a duty."""

    figures: LifeFigures | None  #: of the worst place; None where no part's S–N line is known
    notes: tuple[Note, ...]  #: what a reader must know beside them, and what the life does not contain
    #: (n_nodes,) damage per hour, NaN in parts without an S–N line; None as the figures
    damage: Floats | None = None

    def point_data(self) -> dict[str, Floats]:
        """Return the array of the envelope's VTU file: 0 without damage, −1 where it is not judged."""
        if self.damage is None:
            return {}
        return {"damage_per_hour": np.nan_to_num(self.damage, nan=_NOT_JUDGED)}


def life_of(analysis: CycleAnalysis, mass: MassProperties, duty: DutyLoads) -> Life:
    """Return the life of a rod over a duty.

    Raises
    ------
    InvalidValue
        The S–N line of a material does not fit its endurance limit.
    """
    unknown = tuple(map(warning, _unknown(analysis)))
    entries = list(_entries(analysis, mass, duty))
    damage = duty_damage(analysis, entries)
    if damage is None:
        return Life(None, unknown)
    figures = _figures(analysis, duty.table, damage)
    known = _limits(duty.table, damage, figures, singular=bool(analysis.masked.any()))
    return Life(figures, (*unknown, *known, _OMISSION), damage.per_hour)


def _entries(analysis: CycleAnalysis, mass: MassProperties, duty: DutyLoads) -> Iterator[DutyEntry]:
    """The cycle of every entry at every degree and at its peaks, as `CycleAnalysis.at` takes its extremes."""
    table = duty.table
    for rpm, share, loading in zip(table.rpm, table.shares, duty.loadings, strict=True):
        cycle, cases = loading.crank_cycle(mass, rpm), loading.at(mass, rpm).cases
        angles = np.sort(np.append(cycle.degrees.crank_angle, cases.crank_angle[cases.in_cycle]))
        weights = analysis.weights(cycle, angles)
        yield DutyEntry(weights, share * rpm * _CYCLES_PER_HOUR)


def _figures(analysis: CycleAnalysis, duty: DutyTable, found: DutyDamage) -> LifeFigures:
    worst, mesh = found.worst, analysis.mesh.whole
    damage = worst.damage()
    total = float(damage.sum())
    by_entry = np.bincount(worst.entry, damage, len(duty.rpm))
    largest = sum(float(damage[worst.entry == number].max(initial=0.0)) for number in range(len(duty.rpm)))
    reliability = analysis.materials[worst.part].marin.reliability
    low, high = (_hours(worst.damage((1 + sign * _BAND * SCATTER) / reliability)) for sign in (-1, 1))
    hours = _hours(damage)
    return LifeFigures(
        hours=hours,
        band_hours=(low, high),
        band_percent=100 * _BAND * SCATTER,
        band_of=f"strengths {_BAND} standard deviations below and above the mean",
        endless=hours is None,
        duties=None if hours is None or duty.hours is None else hours / sum(duty.hours),
        at_mm=vector(mesh.points[worst.node]),
        part=list(analysis.mesh.parts)[worst.part],
        damage_per_hour=total,
        largest_range_percent=100 * largest / total if total else None,
        duty=tuple(
            DutyFigures(
                rpm=rpm,
                gas=None if duty.gas is None else duty.gas[number],
                time_percent=100 * share,
                damage_percent=100 * float(by_entry[number]) / total if total else None,
                reversed_amplitude_MPa=float(worst.amplitude[worst.entry == number].max(initial=0.0)),
            )
            for number, (rpm, share) in enumerate(zip(duty.rpm, duty.shares, strict=True))
        ),
        knee_cycles=worst.line.knee,
        endurance_MPa=float(worst.line.limit[0]),
        fatigue_criterion=analysis.fatigue.value,
    )


def _hours(damage: Floats) -> float | None:
    """Hours until the damage is 1; None where there is none."""
    total = float(damage.sum())
    return 1 / total if total else None


def _unknown(analysis: CycleAnalysis) -> Iterator[str]:
    """Say so of every part whose life is not judged, and why."""
    for part, material in zip(analysis.mesh.parts, analysis.materials, strict=True):
        missing = [name for name, known in _needed(analysis, material).items() if not known]
        if missing:
            yield (
                f"the life of {part} is not judged, only its safety factors: its material has no "
                f"{' and no '.join(missing)}"
            )


def _needed(analysis: CycleAnalysis, material: Material) -> Mapping[str, bool]:
    strength = criterion_strength(analysis.fatigue, material)
    return {
        "S–N line (fatigue_strength_coefficient_MPa and fatigue_strength_exponent, or sn_cycles and "
        "sn_amplitude_MPa)": material.basquin is not None,
        "endurance limit (endurance_MPa)": material.endurance_limit is not None,
        "ultimate strength (ultimate_MPa)": strength is not None,
    }


def _limits(duty: DutyTable, found: DutyDamage, figures: LifeFigures, *, singular: bool) -> Iterator[Note]:
    worst = found.worst
    if figures.hours is not None:
        more = _hours(worst.damage(stress=1.01)) or 0.0
        text = (
            f"1 % more stress takes {100 * (1 - more / figures.hours):.0f} % of the hours; the band is "
            "of the strength alone, not of the error of the mesh or of the loads"
        )
        yield warning(text, _LIFE)
    if float(worst.line.cycles(worst.amplitude[:, None]).min()) < 1e3 and figures.hours is not None:
        text = (
            "some cycles break the rod within 1000: low-cycle regime, where stress is not elastic; the hours "
            "are indicative only"
        )
        yield doubt(text, _LIFE)
    if duty.gas is not None:
        text = "each entry of [duty] has its own gas; the runs of the speeds have that of [engine]"
        yield remark(text, _LIFE)
    if singular:
        yield warning("places where the exact stress is infinite (singular) are left out", _LIFE)
