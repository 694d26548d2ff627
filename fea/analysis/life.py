"""How many hours of a duty a rod lasts, at its worst place.

Every node gets the damage of its largest range at each speed. Where one range dominates, that is nearly all:
by the powers of the S–N line a range of 0.8 counts for a thirtieth. Where the gas does little, both
revolutions of a four-stroke cycle count alike. So every range of the histories is counted at the nodes of
the largest damage, and the worst of those is the rod's.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.envelope import carried
from fea.analysis.cycle.screened import path, signed_extremes
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.figures import DutyFigures, LifeFigures
from fea.base.note import Note, assumptions, doubt, omission, remark, warning
from fea.judge.cycle_life import band_of, with_line
from fea.judge.fatigue import LifeLine, criterion_strength, rainflow, reversed_amplitude
from fea.pins.model import Weights
from fea.rod.loading import DutyLoads
from fea.study.speed_tables import DutyTable
from geometry.arrays import Floats, Ints, vector
from geometry.mass import MassProperties

# What the band is of.
_OF_KNOWN = "strengths 2 standard deviations below and above the mean"
_OF_ASSUMED = "strengths a standard deviation of such estimates below and above the assumed S–N line"
# Nodes at which every range is counted: so many, if their damage is at least this part of the largest, as a
# cycle has a few ranges of any size.
COUNTED, LEAST = 16, 0.2
_NOT_JUDGED = -1.0
_LIFE = "life"
_ASSUMED_LINE = (
    "the S–N line of {}: 0.75 of the ultimate strength at 10³ cycles, and the endurance limit at 10⁶ or at "
    "material.endurance_cycles (material.fatigue_strength_coefficient_MPa and fatigue_strength_exponent)"
)
_OMISSION = omission(
    "fretting, residual stress, growth of cracks and overspeed in the life",
    "the S–N line is that of smooth specimens at the stresses of the duty alone",
)
# Weights, of all unit loads or of the unit solutions, over the cycle of each entry of a duty; cycles an hour.
_Entries = Sequence[tuple[Weights, float]]


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


@dataclass(frozen=True)
class WorstLife:
    """The place of the largest damage."""

    #: node, part: node on the whole rod; number of its part
    node: int
    part: int
    line: LifeLine  #: its S–N line
    #: amplitude, rate, entry: (n_cycles,) of the cycles counted there: fully reversed amplitude, MPa, number
    #: per hour, and entry of the duty
    amplitude: Floats
    rate: Floats
    entry: Ints

    def damage(self, strength: float = 1.0, stress: float = 1.0) -> Floats:
        """Damage per hour (n_cycles,), with all strengths and all stresses multiplied by factors."""
        line = self.line.stronger(strength)
        return np.asarray(line.damage(stress * self.amplitude[:, None], self.rate)[:, 0])


def life_of(analysis: CycleAnalysis, mass: MassProperties, duty: DutyLoads) -> Life:
    """Return the life of a rod over a duty.

    Parts without an S–N line, or without the strengths that the mean-stress correction needs, are left out.
    Where nothing is damaged, the worst place is the one nearest to its endurance limit. Raises
    `InvalidValue`: the S–N line of a material does not fit its endurance limit.
    """
    unknown = tuple(_unknown(analysis))
    table, entries = duty.table, []
    fastest = int(np.argmax(table.rpm))
    analysis = analysis.supported(duty.loadings[fastest].crank_cycle(mass, table.rpm[fastest]))
    for rpm, share, loading in zip(table.rpm, table.shares, duty.loadings, strict=True):
        # At every degree and at the peaks, as `CycleAnalysis.at` takes its extremes.
        cycle, cases = loading.crank_cycle(mass, rpm), loading.at(mass, rpm).cases
        angles = np.append(cycle.degrees.crank_angle, cases.crank_angle[cases.in_cycle])
        full = analysis.basis.full(cycle.at(angles), cycle).at(np.argsort(angles))
        entries.append((full, share * rpm * loading.engine.cycles_per_hour))
    spanned = _spanned(analysis, entries)
    of_parts = {number: _of_part(analysis, spanned, number) for number in range(len(analysis.materials))}
    parts = {number: own for number, own in of_parts.items() if own is not None}
    if not parts:
        return Life(None, unknown)
    damage, order, owner = _ranked(analysis, parts)
    _make_exact(analysis, entries, [(node, int(owner[node])) for node in order])
    spanned = _spanned(analysis, entries)
    counted = [_counted(analysis, spanned, node, int(owner[node])) for node in order]
    whole = analysis.mesh.mirrored
    image = 2 * whole.source + (whole.sign[:, 1] < 0)  # one across z = 0 has the same history
    for place in counted:
        damage[image == image[place.node]] = place.damage().sum()
    worst = max(counted, key=lambda place: float(place.damage().sum()))
    figures = _figures(analysis, table, worst)
    known = _limits(table, worst, figures, singular=bool(analysis.masked.any()))
    return Life(figures, (*unknown, *known, _OMISSION), damage)


def _spanned(analysis: CycleAnalysis, entries: _Entries) -> _Entries:
    """Entries with weights of the unit solutions, of those with weights of all unit loads."""
    return [(analysis.basis.projected(full), rate) for full, rate in entries]


def _make_exact(analysis: CycleAnalysis, entries: _Entries, places: Sequence[tuple[int, int]]) -> None:
    """Make the stress exact where the largest ranges of nodes of parts end, in either half of a cycle."""
    ends = []
    for full, _ in entries:
        half = full.even.shape[1] // 2
        for stretch in (full.at(slice(half)), full.at(slice(half, None))):
            weights = analysis.basis.projected(stretch)
            found = spots(places, analysis.units, weights, analysis.mesh.mirrored)
            reached = [at for spot in found for at in (spot.signed.argmax(), spot.signed.argmin())]
            ends.append(stretch.at(np.unique(reached)))
    analysis.basis.exact_at(joined(*ends))


def _ranked(analysis: CycleAnalysis, parts: Mapping[int, tuple[Floats, Floats]]) -> tuple[Floats, Ints, Ints]:
    """Damage per hour (n_nodes,) of all parts, the first nodes by it, and the part (n_nodes,) it is of."""
    damages, usages = (np.stack(of_parts) for of_parts in zip(*parts.values(), strict=True))
    total, usage = np.fmax.reduce(damages), np.fmax.reduce(usages)
    known, whole = ~np.isnan(total), analysis.mesh.mirrored
    counts = analysis.counts[whole.source] & known
    counts = counts if counts.any() else known
    once = np.flatnonzero(counts & (whole.sign[:, 2] > 0))
    order = once[np.lexsort((-usage[once], -total[once]))][:COUNTED]
    ranking = np.nan_to_num(np.where(total > 0, damages, usages), nan=-1.0)
    owner = np.array(list(parts))[ranking.argmax(axis=0)]
    return total, order[total[order] >= LEAST * total[order[0]]], owner


def _of_part(analysis: CycleAnalysis, entries: _Entries, number: int) -> tuple[Floats, Floats] | None:
    """Damage per hour by the largest ranges in a part, and the largest of them over the endurance limit.

    Each (n_nodes,) on the whole rod, NaN outside the part; None if its life is not known.
    """
    part, units = analysis.units.parts[number], analysis.units
    material = with_line(analysis.materials[number])
    line = LifeLine.of(material, analysis.regions.at(part.nodes).factors(material))
    if line is None or criterion_strength(analysis.fatigue, material) is None:
        return None
    amplitudes = []
    for weights, _ in entries:
        ends = signed_extremes(part, path(weights, units.joint), units.sides)
        halves = [((high + low) / 2, (high - low) / 2) for high, low in ends]
        own = [reversed_amplitude(analysis.fatigue, *half, material) for half in halves]
        amplitudes.append(own)
    rate, whole = np.array([rate for _, rate in entries]), analysis.mesh.mirrored
    sides_of = [np.stack(of_side) for of_side in zip(*amplitudes, strict=True)]
    damage = [line.damage(amplitude, rate).sum(axis=0) for amplitude in sides_of]
    usage = [(amplitude / line.limit).max(axis=0) for amplitude in sides_of]
    return carried(part, damage, whole), carried(part, usage, whole)


def _counted(analysis: CycleAnalysis, entries: _Entries, node: int, number: int) -> WorstLife:
    """Count every range of the histories of a node, as of a part."""
    material, whole = with_line(analysis.materials[number]), analysis.mesh.mirrored
    source = whole.source[[node]]
    line = LifeLine.of(material, analysis.regions.at(source).factors(material))
    if line is None:
        raise ValueError("only parts with an S–N line have worst places")
    amplitudes, rates, numbers = [], [], []
    for index, (weights, rate) in enumerate(entries):
        (spot,) = spots([(node, number)], analysis.units, weights, whole)
        mean, amplitude = rainflow(spot.signed)
        amplitudes.append(reversed_amplitude(analysis.fatigue, mean, amplitude, material))
        rates.append(np.full(len(mean), rate))
        numbers.append(np.full(len(mean), index))
    every = (np.concatenate(own) for own in (amplitudes, rates, numbers))
    return WorstLife(node, number, line, *every)


def _figures(analysis: CycleAnalysis, duty: DutyTable, worst: WorstLife) -> LifeFigures:
    mesh, damage = analysis.mesh.whole, worst.damage()
    total = float(damage.sum())
    by_entry = np.bincount(worst.entry, damage, len(duty.rpm))
    largest = sum(float(damage[worst.entry == number].max(initial=0.0)) for number in range(len(duty.rpm)))
    material = analysis.materials[worst.part]
    reliability, assumed = material.marin.reliability, material.basquin is None
    band = band_of(assumed=assumed)
    low, high = (_hours(worst.damage((1 + sign * band) / reliability)) for sign in (-1, 1))
    hours = _hours(damage)
    return LifeFigures(
        hours=hours,
        band_hours=(low, high),
        band_percent=100 * band,
        band_of=_OF_ASSUMED if assumed else _OF_KNOWN,
        assumed_line=assumed or None,
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
    total = float(damage.sum())
    return 1 / total if total else None


def _unknown(analysis: CycleAnalysis) -> Iterator[Note]:
    for part, own in zip(analysis.mesh.parts, analysis.materials, strict=True):
        material = with_line(own)
        if own.basquin is None and material.basquin is not None:
            yield from assumptions("life", [_ASSUMED_LINE.format(part)])
        needed = {
            "S–N line (fatigue_strength_coefficient_MPa and fatigue_strength_exponent, or sn_cycles and "
            "sn_amplitude_MPa)": material.basquin,
            "endurance limit (endurance_MPa)": material.endurance_limit,
            "ultimate strength (ultimate_MPa)": criterion_strength(analysis.fatigue, material),
        }
        if missing := [name for name, known in needed.items() if known is None]:
            yield warning(
                f"the life of {part} is not judged, only its safety factors: its material has no "
                f"{' and no '.join(missing)}"
            )


def _limits(duty: DutyTable, worst: WorstLife, figures: LifeFigures, *, singular: bool) -> Iterator[Note]:
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
