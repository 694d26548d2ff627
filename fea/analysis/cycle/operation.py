"""What a rod goes through: crank cycles, how often each occurs, and their stress at any gas load.

Stress at another gas load is that of the cycle, plus the change of the load times the stress of the gas
alone: the peak case ``gas``, whose force has the direction of the rod, as the wall takes the rest. So nothing
is solved again. It leaves out that a pin touches another part of its bore under another force; whole runs at
other pressures say how much that is (`tests/benchmarks/scatter.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.basis import joined
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.cycle.unit_solutions import PlaceHistory, spots
from fea.contact.assembly_state import AssemblyState
from fea.judge.cycle_life import varied_pressure
from fea.judge.history import cycle_ends, deviatoric, rainflow, signed_equivalent
from fea.pins.model import Weights
from fea.rod.places import SurfaceRegions
from fea.study.duty_log import DutyLog
from geometry.arrays import Floats, Ints, Mask
from loads.crank_cycle import CrankCycle
from loads.dynamics import EngineInstants
from loads.instants import Instants, assembled
from loads.instants import joined as joined_instants


def gas_cases(cycle: CrankCycle) -> Instants | None:
    """Return the gas alone, at its peak, and nothing; None without gas."""
    gas = [case for case in cycle.peaks.cases if case.name == "gas"]
    return joined_instants([gas[0], assembled()]) if gas else None


def gas_along_rod(some: EngineInstants) -> Floats:
    """Gas force (n_instants,) along the rod, N."""
    return np.asarray(some.gas / np.cos(some.motion.rod_angle))


class Entry(NamedTuple):
    """Crank cycles that are alike."""

    cycle: CrankCycle
    weights: Weights  #: of the unit solutions over a cycle
    rate: float  #: cycles an hour
    gas: Floats  #: (n_instants,) gas force along the rod that differs from cycle to cycle, N
    states: tuple[AssemblyState, ...] = ()  #: of bolts and joint over the cycle; none of a rod of one piece


@dataclass(frozen=True)
class Operation:
    """The crank cycles of a speed, or of a duty."""

    analysis: CycleAnalysis
    entries: tuple[Entry, ...]
    scatter: float = 0.0  #: coefficient of variation of the gas load from cycle to cycle
    log: DutyLog | None = None  #: in whose order the entries follow

    def projected(self) -> "Operation":
        """Return the operation, whose weights are of all unit loads, with those of the unit solutions."""
        own = (each._replace(weights=self.analysis.basis.projected(each.weights)) for each in self.entries)
        return replace(self, entries=tuple(own))

    @cached_property
    def _alone(self) -> tuple[Weights, float] | None:
        """Weights under the largest gas force and under nothing, and that force, N; None without gas."""
        gas = gas_cases(max(self.entries, key=lambda entry: float(np.abs(entry.gas).max())).cycle)
        return None if gas is None else (self.analysis.basis.weights(gas), float(gas[0].gas))

    @property
    def rates(self) -> list[float]:
        """Cycles an hour of the entries."""
        return [entry.rate for entry in self.entries]

    def places(self, where: Sequence[tuple[int, int]]) -> list[tuple[PlaceHistory, Floats]]:
        """Histories of nodes of parts over all entries, one after another.

        Beside each stands the change of stress (6, n_instants), MPa, as the gas load is doubled.
        """
        # Together, as the stress of a place has one sign over all entries.
        units, whole = self.analysis.units, self.analysis.mesh.mirrored
        found = spots(where, units, joined(*(entry.weights for entry in self.entries)), whole)
        if self._alone is None:
            return [(spot, np.zeros_like(spot.stress)) for spot in found]
        weights, force = self._alone
        course = np.concatenate([entry.gas for entry in self.entries]) / force
        pressed = spots(where, units, weights, whole)
        changes = [np.outer(spot.stress[:, 0] - spot.stress[:, 1], course) for spot in pressed]
        return list(zip(found, changes, strict=True))

    def at_gas(self, spot: PlaceHistory, change: Floats, factors: Sequence[float]) -> list[list[Floats]]:
        """Signed stress (n_instants,), MPa, of every entry at gas loads changed by some shares."""
        every = spot.stress + np.array(factors)[:, None, None] * change
        ends = np.cumsum([entry.weights.even.shape[1] for entry in self.entries])[:-1]
        return [np.split(signed, ends) for signed in signed_equivalent(deviatoric(every))]

    def varied(self, spot: PlaceHistory, change: Floats) -> list[tuple[float, list[Floats]]]:
        """Shares of the cycles, and the stress of each entry as `at_gas`: see `varied_pressure`."""
        shares, factors = zip(*varied_pressure(self.scatter), strict=True)
        return list(zip(shares, self.at_gas(spot, change, factors), strict=True))


class JudgedNodes(NamedTuple):
    """How near the nodes of the whole rod are to fatigue, each (n_nodes,)."""

    factor: Floats  #: endurance limit over the largest reversed amplitude, NaN where not known
    part: Ints  #: of which part
    counts: Mask  #: away from stress singularities
    regions: SurfaceRegions


class CountedCycles(NamedTuple):
    """Cycles of the stress of a place, each (n_cycles,)."""

    mean: Floats  #: MPa
    amplitude: Floats  #: MPa
    rate: Floats  #: number per hour
    entry: Ints  #: of the operation
    between: Mask  #: whether it begins in another bin of a log than the entry
    usual: Mask  #: whether the gas load is the mean one


def every_cycle(
    varied: Sequence[tuple[float, Sequence[Floats]]], rates: Sequence[float], log: DutyLog | None = None
) -> CountedCycles:
    """Count every cycle of histories, of which there are so many an hour.

    `varied`: shares, and the histories of the entries at a gas load; the largest share has the mean one. Of a
    log, cycles between its stays follow, at the mean load.
    """
    found, visits = [], np.zeros(len(rates)) if log is None else np.bincount(log.visited) / log.hours
    most, usual = max(varied, key=lambda own: own[0])
    for share, histories in varied:
        for number, (signed, rate) in enumerate(zip(histories, rates, strict=True)):
            mean, amplitude = rainflow(signed)
            each, own = np.full(len(mean), share * rate), np.ones(len(mean), dtype=bool)
            if len(mean):
                each[amplitude.argmax()] -= share * min(rate, visits[number])
            found.append((mean, amplitude, each, number * own, ~own, own & (share == most)))
    if log is not None:
        stress = np.array([[signed.max(), signed.min()] for signed in usual])[log.visited].ravel()
        pairs = cycle_ends(stress)
        pairs = np.take_along_axis(pairs, stress[pairs].argsort(axis=0), axis=0)
        bins = log.visited[pairs // 2]
        code = bins[0] * len(usual) + bins[1]
        _, first, times = np.unique(code, return_index=True, return_counts=True)
        (low, high), (least, largest) = bins[:, first], stress[pairs[:, first]]
        of_stays = (least + largest) / 2, (largest - least) / 2, times / log.hours
        found.append((*of_stays, high, low != high, np.ones(len(times), dtype=bool)))
    return CountedCycles(*map(np.concatenate, zip(*found, strict=True)))
