"""Damage over a duty: the cycles of several speeds, summed at every node of a rod.

Every node gets the damage of its largest range at each speed. Where one range dominates, that is nearly all:
by the powers of the S–N line a range of 0.8 counts for a thirtieth. Where the gas does little, both
revolutions of a cycle count alike. So every range of the histories is counted at the nodes of the largest
damage, and the worst of those is the rod's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.envelope import carried
from fea.analysis.cycle.path import path
from fea.analysis.cycle.screened import extremes
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import spots
from fea.judge.fatigue import criterion_strength, reversed_amplitude
from fea.judge.life_line import LifeLine, rainflow
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints

# Nodes at which every range is counted: so many, if their damage is at least this part of the largest, as a
# cycle has a few ranges of any size.
COUNTED, LEAST = 16, 0.2


@dataclass(frozen=True)
class DutyEntry:
    """The crank cycle at one entry of a duty."""

    weights: Weights  #: of the unit solutions, at instants in the order of time
    rate: float  #: cycles per hour of the duty


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


@dataclass(frozen=True)
class DutyDamage:
    """What a duty does to a rod."""

    per_hour: Floats  #: (n_nodes,) damage per hour on the whole rod; NaN in parts without an S–N line
    worst: WorstLife  #: the place of the largest


def duty_damage(analysis: CycleAnalysis, entries: Sequence[DutyEntry]) -> DutyDamage | None:
    """Sum the damage of the entries of a duty; None if no part's life is known.

    Parts without an S–N line, or without the strengths that the mean-stress correction needs, are left out.
    Where nothing is damaged, the worst place is the one nearest to its endurance limit.

    Raises
    ------
    InvalidValue
        See `LifeLine.of`.
    """
    parts = {
        number: of_part
        for number in range(len(analysis.materials))
        if (of_part := _of_part(analysis, entries, number)) is not None
    }
    if not parts:
        return None
    total, order, owner = _ranked(analysis, parts)
    counted = [_counted(analysis, entries, node, int(owner[node])) for node in order]
    whole = analysis.mesh.mirrored
    image = 2 * whole.source + (whole.sign[:, 1] < 0)  # one across z = 0 has the same history
    for place in counted:
        total[image == image[place.node]] = place.damage().sum()
    return DutyDamage(total, max(counted, key=lambda place: float(place.damage().sum())))


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


def _of_part(
    analysis: CycleAnalysis, entries: Sequence[DutyEntry], number: int
) -> tuple[Floats, Floats] | None:
    """Damage per hour by the largest ranges in a part, and the largest of them over the endurance limit.

    Each (n_nodes,) on the whole rod, NaN outside the part; None if its life is not known.
    """
    part, units, material = analysis.units.parts[number], analysis.units, analysis.materials[number]
    line = LifeLine.of(material, analysis.regions.at(part.nodes).factors(material))
    if line is None or criterion_strength(analysis.fatigue, material) is None:
        return None
    amplitudes = []
    for entry in entries:
        (sides,) = extremes([part], path(entry.weights, units.joint), units.sides)
        amplitudes.append(
            [reversed_amplitude(analysis.fatigue, of.mean, of.amplitude, material) for of in sides]
        )
    rate, whole = np.array([entry.rate for entry in entries]), analysis.mesh.mirrored
    sides_of = [np.stack(of_side) for of_side in zip(*amplitudes, strict=True)]
    damage = [line.damage(amplitude, rate).sum(axis=0) for amplitude in sides_of]
    usage = [(amplitude / line.limit).max(axis=0) for amplitude in sides_of]
    return carried(part, damage, whole), carried(part, usage, whole)


def _counted(analysis: CycleAnalysis, entries: Sequence[DutyEntry], node: int, number: int) -> WorstLife:
    """Count every range of the histories of a node, as of a part."""
    material, whole = analysis.materials[number], analysis.mesh.mirrored
    source = whole.source[[node]]
    line = LifeLine.of(material, analysis.regions.at(source).factors(material))
    if line is None:
        raise ValueError("only parts with an S–N line have worst places")
    amplitudes, rates, numbers = [], [], []
    for index, entry in enumerate(entries):
        (spot,) = spots([(node, number)], analysis.units, entry.weights, whole)
        mean, amplitude = rainflow(spot.signed)
        amplitudes.append(reversed_amplitude(analysis.fatigue, mean, amplitude, material))
        rates.append(np.full(len(mean), entry.rate))
        numbers.append(np.full(len(mean), index))
    return WorstLife(
        node,
        number,
        line,
        amplitude=np.concatenate(amplitudes),
        rate=np.concatenate(rates),
        entry=np.concatenate(numbers),
    )
