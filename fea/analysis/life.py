"""How many hours of a duty a rod lasts, at its worst place.

Every node gets the damage of its largest range at each speed. Where one range dominates, that is nearly all:
by the powers of the S–N line a range of 0.8 counts for a thirtieth. Where the gas does little, both
revolutions of a four-stroke cycle count alike. So every range of the histories is counted at the nodes of
the largest damage, and the worst of those is the rod's. Pressure differs from cycle to cycle: there the mean
damage of the cycles counts, and the tail for `endless`.

A log has the order of the speeds too. Of each stay at a speed and load, one cycle of the crank is taken out:
the highest and lowest stresses of all stays are a history of their own, with cycles between speeds.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.envelope import carried
from fea.analysis.cycle.operation import (
    CountedCycles,
    Entry,
    JudgedNodes,
    Operation,
    every_cycle,
    gas_along_rod,
)
from fea.analysis.cycle.screened import path, signed_extremes
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.life_figures import DutyFigures, LifeFigures, LogFigures
from fea.analysis.scatter import UNFIRED
from fea.base.note import Note, assumptions, doubt, omission, remark, warning
from fea.judge.cycle_life import band_of, life_line
from fea.judge.fatigue import LifeLine, criterion_strength, reversed_amplitude
from fea.judge.verdict import CAP
from fea.rod.loading import DutyLoads
from fea.study.duty_log import DutyLog
from fea.study.speed_tables import DutyTable
from geometry.arrays import Floats, Ints, vector
from geometry.mass import MassProperties

# What the band is of.
_OF_KNOWN = "strengths 2 standard deviations below and above the mean"
_OF_ASSUMED = "strengths a standard deviation of such estimates below and above the assumed S–N line"
# Nodes at which every range is counted: so many, if their damage is at least this part of the largest, as a
# cycle has a few ranges of any size.
COUNTED, LEAST = 16, 0.2
# Ranges of at least this part of the largest are made exact: smaller ones hardly damage.
_EXACT = 0.7
CRITICAL_DAMAGE = 0.3  # Miner's sum at failure by varying amplitudes, beside 1 (FKM guideline; from memory)
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


@dataclass(frozen=True)
class Life:
    """The life of a rod over a duty."""

    figures: LifeFigures | None  #: of the worst place; None where no part's S–N line is known
    notes: tuple[Note, ...]  #: what a reader must know beside them, and what the life does not contain
    #: (n_nodes,) damage per hour, NaN in parts without an S–N line; None as the figures
    damage: Floats | None = None
    log: Mapping[str, Floats] | None = None  #: columns of ``log.csv``, where the duty is a log
    operation: Operation | None = None  #: the cycles of the duty; None as the figures, like the next
    nodes: JudgedNodes | None = None

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
    amplitude: Floats  #: (n_cycles,) fully reversed, MPa, of the cycles counted there
    cycles: CountedCycles

    def damage(self, strength: float = 1.0, stress: float = 1.0) -> Floats:
        """Damage per hour (n_cycles,), with all strengths and all stresses multiplied by factors."""
        line = self.line.stronger(strength)
        return np.asarray(line.damage(stress * self.amplitude[:, None], self.cycles.rate)[:, 0])


def life_of(analysis: CycleAnalysis, mass: MassProperties, duty: DutyLoads, scatter: float = 0.0) -> Life:
    """Return the life of a rod over a duty.

    `scatter`: of the gas load from cycle to cycle. Parts without an S–N line, or without the strengths that
    the mean-stress correction needs, are left out. Where nothing is damaged, the worst place is the one
    nearest to its endurance limit. Raises `InvalidValue`: the S–N line of a material does not fit its
    endurance limit.
    """
    unknown = tuple(_unknown(analysis))
    table, log = duty.table, duty.table.read
    fastest = max(zip(table.entries, duty.loadings, strict=True), key=lambda own: own[0].rpm)
    analysis = analysis.supported(fastest[1].crank_cycle(mass, fastest[0].rpm))
    full = Operation(analysis, tuple(_entries(analysis, mass, duty)), scatter, log)
    operation = full.projected()
    of_parts = {n: _of_part(operation, n) for n in range(len(analysis.materials))}
    parts = {number: own for number, own in of_parts.items() if own is not None}
    if not parts:
        return Life(None, unknown)
    damage, usage, order, owner = _ranked(analysis, parts)
    make_exact(full, [(node, int(owner[node])) for node in order])
    operation = full.projected()
    counted = [_counted(operation, node, int(owner[node])) for node in order]
    whole = analysis.mesh.mirrored
    image = 2 * whole.source + (whole.sign[:, 1] < 0)  # one across z = 0 has the same history
    for place in counted:
        damage[image == image[place.node]] = place.damage().sum()
    worst = max(counted, key=lambda place: float(place.damage().sum()))
    figures, along = _figures(analysis, duty, worst), None
    known = list(_limits(table, worst, figures, singular=bool(analysis.masked.any())))
    if log is not None:
        by_bin = np.bincount(worst.cycles.entry, worst.damage(), len(log.bins))
        along = log.along(np.asarray(by_bin, np.float64))
        figures = replace(figures, log=_of_log(log, worst, figures, along))
        known += log.notes()
    counts, regions = analysis.counts[whole.source], analysis.regions.at(whole.source)
    nodes = JudgedNodes(1 / np.maximum(usage, 1 / CAP), owner, counts, regions)
    return Life(figures, (*unknown, *known, _OMISSION), damage, along, operation, nodes)


def _entries(analysis: CycleAnalysis, mass: MassProperties, duty: DutyLoads) -> Iterator[Entry]:
    """Yield the crank cycle of every entry of a duty, with weights of all unit loads."""
    for (rpm, share, gas, _), loading in zip(duty.table.entries, duty.loadings, strict=True):
        # At every degree and at the peaks, as `CycleAnalysis.at` takes its extremes.
        cycle, cases = loading.crank_cycle(mass, rpm), loading.at(mass, rpm).cases
        instants = cycle.at(np.append(cycle.degrees.crank_angle, cases.crank_angle[cases.in_cycle]))
        order = np.argsort(instants.crank_angle)
        full = analysis.basis.full(instants, cycle).at(order)
        pulls = gas_along_rod(instants)[order] * (gas not in UNFIRED)
        states = analysis.basis.contacts(cycle).states if analysis.loads.path_dependent else ()
        yield Entry(cycle, full, share * rpm * loading.engine.cycles_per_hour, pulls, states)


def make_exact(full: Operation, places: Sequence[tuple[int, int]]) -> None:
    """Make the stress exact where the largest ranges of nodes of parts end, in either half of a cycle.

    The operation has weights of all unit loads.
    """
    analysis, ends, ranges = full.analysis, [], []
    for weights in (entry.weights for entry in full.entries):
        half = weights.even.shape[1] // 2
        for stretch in (weights.at(slice(half)), weights.at(slice(half, None))):
            projected = analysis.basis.projected(stretch)
            found = spots(places, analysis.units, projected, analysis.mesh.mirrored)
            reached = [at for spot in found for at in (spot.signed.argmax(), spot.signed.argmin())]
            ends.append(stretch.at(np.unique(reached)))
            ranges.append(max(float(np.ptp(spot.signed)) for spot in found))
    large = [own for own, size in zip(ends, ranges, strict=True) if size >= _EXACT * max(ranges)]
    analysis.basis.exact_at(joined(*large))


def _ranked(
    analysis: CycleAnalysis, parts: Mapping[int, tuple[Floats, Floats]]
) -> tuple[Floats, Floats, Ints, Ints]:
    """Damage per hour and usage (n_nodes,), the first nodes by them, and the part (n_nodes,) they are of."""
    damages, usages = (np.stack(of_parts) for of_parts in zip(*parts.values(), strict=True))
    total, usage = np.fmax.reduce(damages), np.fmax.reduce(usages)
    known, whole = ~np.isnan(total), analysis.mesh.mirrored
    counts = analysis.counts[whole.source] & known
    counts = counts if counts.any() else known
    once = np.flatnonzero(counts & (whole.sign[:, 2] > 0))
    order = once[np.lexsort((-usage[once], -total[once]))][:COUNTED]
    ranking = np.nan_to_num(np.where(total > 0, damages, usages), nan=-1.0)
    owner = np.array(list(parts))[ranking.argmax(axis=0)]
    return total, usage, order[total[order] >= LEAST * total[order[0]]], owner


def _of_part(operation: Operation, number: int) -> tuple[Floats, Floats] | None:
    """Damage per hour by the largest ranges in a part, and the largest of them over the endurance limit.

    Each (n_nodes,) on the whole rod, NaN outside the part; None if its life is not known.
    """
    analysis, rates, log = operation.analysis, operation.rates, operation.log
    part, units = analysis.units.parts[number], analysis.units
    material = analysis.materials[number]
    line = life_line(material, analysis.regions.at(part.nodes).factors(material))
    if line is None or criterion_strength(analysis.fatigue, material) is None:
        return None
    paths = [path(entry.weights, units.joint) for entry in operation.entries]
    every = [signed_extremes(part, own, units.sides) for own in paths]
    if log is not None:
        highest, lowest = np.max(every, axis=0)[:, 0], np.min(every, axis=0)[:, 1]
        every, rates = [*every, np.stack([highest, lowest], axis=1)], [*rates, 1 / log.hours]
    amplitudes = []
    for ends in every:
        halves = [((high + low) / 2, (high - low) / 2) for high, low in ends]
        amplitudes.append([reversed_amplitude(analysis.fatigue, *half, material) for half in halves])
    rate, whole = np.array(rates), analysis.mesh.mirrored
    sides_of = [np.stack(of_side) for of_side in zip(*amplitudes, strict=True)]
    damage = [line.damage(amplitude, rate).sum(axis=0) for amplitude in sides_of]
    usage = [(amplitude / line.limit).max(axis=0) for amplitude in sides_of]
    return carried(part, damage, whole), carried(part, usage, whole)


def _counted(operation: Operation, node: int, number: int) -> WorstLife:
    """Count every range of the histories of a node, as of a part."""
    analysis = operation.analysis
    material, source = analysis.materials[number], analysis.mesh.mirrored.source[[node]]
    line = life_line(material, analysis.regions.at(source).factors(material))
    if line is None:
        raise ValueError("only parts with an S–N line have worst places")
    (place,) = operation.places([(node, number)])
    found = every_cycle(operation.varied(*place), operation.rates, operation.log)
    amplitude = reversed_amplitude(analysis.fatigue, found.mean, found.amplitude, material)
    return WorstLife(node, number, line, amplitude, found)


def _figures(analysis: CycleAnalysis, duty: DutyLoads, worst: WorstLife) -> LifeFigures:
    mesh, damage, entries = analysis.mesh.whole, worst.damage(), duty.table.entries
    total, of_use = float(damage.sum()), duty.table.total_hours
    counted = worst.cycles
    by_entry = np.bincount(counted.entry, damage, len(entries))
    usual = [counted.usual & (counted.entry == number) for number in range(len(entries))]
    largest = sum(float(damage[own].max(initial=0.0)) for own in usual)
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
        duties=None if hours is None or of_use is None else hours / of_use,
        at_mm=vector(mesh.points[worst.node]),
        part=list(analysis.mesh.parts)[worst.part],
        damage_per_hour=total,
        largest_range_percent=100 * largest / float(damage[counted.usual].sum()) if total else None,
        duty=tuple(
            DutyFigures(
                rpm=entry.rpm,
                gas=entry.gas,
                load=entry.load,
                time_percent=100 * entry.share,
                damage_percent=100 * float(by_entry[number]) / total if total else None,
                reversed_amplitude_MPa=float(worst.amplitude[usual[number]].max(initial=0.0)),
            )
            for number, entry in enumerate(entries)
        ),
        knee_cycles=worst.line.knee,
        endurance_MPa=float(worst.line.limit[0]),
        fatigue_criterion=analysis.fatigue.value,
    )


def _of_log(log: DutyLog, worst: WorstLife, life: LifeFigures, along: Mapping[str, Floats]) -> LogFigures:
    """What of a log does the damage: its worst stretch of time, and the cycles between speeds."""
    damage, starts = worst.damage(), along["time_s"]
    most, total = int(along["damage_percent"].argmax()), float(damage.sum())
    return LogFigures(
        file=log.source,
        load=None if log.kind is None else log.kind.value,
        hours=log.hours,
        between_cycles=float(worst.cycles.rate[worst.cycles.between].sum() * log.hours),
        between_percent=100 * float(damage[worst.cycles.between].sum()) / total if total else None,
        critical_damage=CRITICAL_DAMAGE,
        hours_at_critical_damage=None if life.hours is None else CRITICAL_DAMAGE * life.hours,
        worst_from_s=float(starts[most]),
        worst_to_s=float(starts[most] + starts[1] - starts[0]),
        worst_percent=float(along["damage_percent"][most]),
    )


def _hours(damage: Floats) -> float | None:
    total = float(damage.sum())
    return 1 / total if total else None


def _unknown(analysis: CycleAnalysis) -> Iterator[Note]:
    for part, own in zip(analysis.mesh.parts, analysis.materials, strict=True):
        line = own.basquin or life_line(own, np.array([each.factor for each in own.marin.surfaces.values()]))
        if own.basquin is None and line is not None:
            yield from assumptions("life", [_ASSUMED_LINE.format(part)])
        needed = {
            "S–N line (fatigue_strength_coefficient_MPa and fatigue_strength_exponent, or sn_cycles and "
            "sn_amplitude_MPa)": line,
            "endurance limit (endurance_MPa)": own.endurance_limit,
            "ultimate strength (ultimate_MPa)": criterion_strength(analysis.fatigue, own),
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
