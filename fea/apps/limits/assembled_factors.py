"""Safety factors of a rod of separate parts at an operating point, over its own crank cycle with friction.

With friction an instant depends on those before it, and with preload stress is not in proportion to the load.
The cycle is therefore followed as by `fea run --cycle`, and the stress of its instants is solved directly.
Elsewhere the factors are estimated from the decisive instants, each solved from the rod at rest, times the
ratio of the factors with and without the history in the cycle that was followed last.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

import numpy as np

from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.basis import FullBasis
from fea.analysis.cycle.candidates import (
    ALL_ROWS_STEP,
    RowHistories,
    around,
    decisive_angles,
    most_used,
    sampled_angles,
    utilisation,
)
from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.analysis.prepared_rod import PreparedRod
from fea.apps.limits.factors import (
    Factors,
    FailureMode,
    ModeFactor,
    RodFactors,
    StressHistories,
    worst_of_histories,
)
from fea.contact.assembly_state import AssemblyState, FaceState
from fea.pins.assembly import AssemblyPins
from fea.pins.model import Response, UnitLoadFields, UnitLoads, Weights
from fea.pins.prescribed import StoredFields
from fea.rod.places import SurfaceRegions
from fea.solid.errors import UnsettledError
from fea.solid.parity import Parity
from geometry.arrays import Floats
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

_AT_ONCE = 24  # instants whose responses are in memory
# Forces of one parity relative to the other's that are rounding; and the least utilisation.
_ROUNDING, _TINY = 1e-12, 1e-12
_SEATS = {FailureMode.BUSHING: Surface.BUSHING_SEAT, FailureMode.SHELLS: Surface.SHELL_SEAT}


class _InstantLoads(UnitLoads):
    """Instants as unit loads."""

    def __init__(self, responses: Sequence[Response]) -> None:
        largest = [
            max(float(np.abs(response.forces.part(parity)).max()) for response in responses)
            for parity in Parity
        ]
        even, odd = (
            _stored(responses if size > _ROUNDING * max(largest) else [], parity)
            for size, parity in zip(largest, Parity, strict=True)
        )
        self._fields = even, odd

    def fields(self) -> tuple[UnitLoadFields, UnitLoadFields]:
        return self._fields

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        even, odd = (np.eye(fields.count, len(instants)) for fields in self._fields)
        return Weights(even, odd)


def _stored(responses: Sequence[Response], parity: Parity) -> StoredFields:
    """Forces and tractions of one parity at instants."""
    traction = {
        surface: np.stack([response.traction[surface].part(parity) for response in responses], axis=-1)
        for surface in (responses[0].traction if responses else ())
    }
    return StoredFields([response.forces.part(parity) for response in responses], traction)


class _SolvedInstants(NamedTuple):
    """Instants with the stress of every row and the contact states."""

    parts: list[PartRows]
    weights: Weights
    states: list[AssemblyState]
    regions: SurfaceRegions  #: with the support of the gradient over these instants

    @property
    def most_stressed(self) -> list[RowHistories]:
        """Rows of each part that may be the worst."""
        pairs = [(part, most_used(utilisation(part, self.weights))) for part in self.parts]
        return [RowHistories.of(part, rows, self.weights) for part, rows in pairs]


class AssembledFactors(RodFactors):
    """The safety factors of a rod of separate parts."""

    costly = True

    def __init__(self, rod: PreparedRod, pins: AssemblyPins) -> None:
        super().__init__(rod)
        self._rod, self._pins = rod, pins
        self._start = pins.assembly.sums(pins.assembly.assembled.start)
        self._decisive = np.zeros(0)  # crank angles, rad
        self._followed: tuple[CrankCycle, Factors] | None = None
        self._history_ratio = dict[FailureMode, float]()  # factors with history over those without

    @property
    def rest(self) -> Factors:
        """Factors of the assembled rod at the temperature of the engine."""
        return self._factors(self._solved(self._pins.resting), np.zeros(1))

    def estimate(self, cycle: CrankCycle) -> Factors:
        """Estimate the factors over a cycle at the decisive instants of earlier ones and at its peaks."""
        ratio = self._with_history()
        found = self._without_history(cycle).items()
        return {mode: replace(worst, factor=worst.factor * ratio.get(mode, 1.0)) for mode, worst in found}

    def _with_history(self) -> dict[FailureMode, float]:
        """Ratio of factors with history to those without, in the cycle that was followed last."""
        if self._followed is not None:
            cycle, factors = self._followed
            self._followed, without = None, self._without_history(cycle)
            without.pop(FailureMode.SLIP, None)  # the instant that slips first depends on the history
            modes = without.keys() & factors.keys()
            ratios = {mode: factors[mode].factor / without[mode].factor for mode in modes}
            self._history_ratio |= {mode: ratio for mode, ratio in ratios.items() if math.isfinite(ratio)}
        return self._history_ratio

    def _without_history(self, cycle: CrankCycle) -> dict[FailureMode, ModeFactor]:
        return self._factors(*self._at_decisive(cycle)) | self.by_force(cycle)

    def _at_decisive(self, cycle: CrankCycle) -> tuple[_SolvedInstants, Floats]:
        peaks = cycle.peaks.cases
        angles = np.union1d(self._decisive, peaks.crank_angle[peaks.in_cycle])
        with suppress(UnsettledError):
            return self._solved(cycle.at(angles)), angles
        angles = angles[[self._settles(instant) for instant in cycle.at(angles)]]
        if not angles.size:
            raise UnsettledError("contact and friction between the parts settled at no instant of the cycle")
        return self._solved(cycle.at(angles)), angles

    def _settles(self, instant: Instants) -> bool:
        try:
            self._pins.states(instant[None])
        except UnsettledError:
            return False
        return True

    def at(self, cycle: CrankCycle) -> Factors:
        """Return the factors over a cycle, with their places, from every row."""
        try:
            (rows_of_parts, angles), states = self._over(cycle)
        except UnsettledError:
            self.unsettled += 1
            return self.estimate(cycle)
        found = worst_of_histories(rows_of_parts, angles) | self._of_assembly(states, angles)
        found |= self.by_force(cycle)
        self._followed = cycle, found
        return found

    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> StressHistories:
        """Return the stress of the most stressed rows: see `RodFactors.histories`."""
        with suppress(UnsettledError):
            if not estimated:
                return self._over(cycle)[0]
        solved, angles = self._at_decisive(cycle)
        stress = 1 / self._with_history().get(FailureMode.FATIGUE, 1.0)
        return [each._replace(stress=stress * each.stress) for each in solved.most_stressed], angles

    def under(self, instants: Instants, rows_of_parts: Sequence[RowHistories]) -> list[Floats]:
        """Solve instants: see `RodFactors.under`."""
        solved = self._solved(instants)
        pairs = zip(solved.parts, rows_of_parts, strict=True)
        return [part.stress(solved.weights, each.rows) for part, each in pairs]

    def _over(self, cycle: CrankCycle) -> tuple[StressHistories, list[AssemblyState]]:
        """Follow a cycle: at every few degrees, then around the decisive instants."""
        angles = sampled_angles(cycle, ALL_ROWS_STEP)
        first = self._solved(cycle.at(angles), cycle)
        worst = first.most_stressed
        usage = [each.utilisation for each in worst]
        self._decisive = np.union1d(self._decisive, decisive_angles(cycle, angles, worst, usage, 0))
        of_assembly = self._of_assembly(first.states, angles).values()
        decisive = [each.crank_angle for each in of_assembly if each.crank_angle is not None]
        extremes = decisive_angles(cycle, angles, worst, usage)
        more = np.union1d(extremes, around(cycle, np.array(decisive)))
        more = np.setdiff1d(more, angles)
        second = self._solved(cycle.at(more), cycle, first.regions)
        both = [each.extended(part, second.weights) for each, part in zip(worst, second.parts, strict=True)]
        return (both, np.append(angles, more)), [*first.states, *second.states]

    def _factors(self, solved: _SolvedInstants, angles: Floats) -> dict[FailureMode, ModeFactor]:
        return worst_of_histories(solved.most_stressed, angles) | self._of_assembly(solved.states, angles)

    def _solved(
        self, instants: Instants, cycle: CrankCycle | None = None, regions: SurfaceRegions | None = None
    ) -> _SolvedInstants:
        """Solve instants, each as a unit load; in the order of a cycle where one is given.

        `regions`: those of other instants of the cycle, whose support they have.
        """
        units, states, loads = list[UnitSolutions](), list[AssemblyState](), list[_InstantLoads]()
        for some in np.array_split(np.arange(len(instants)), -(-len(instants) // _AT_ONCE)):
            responses = self._pins.respond(instants[some], cycle)
            loads = [_InstantLoads(responses)]
            units.append(self._rod.solved_units(loads[0].fields(), single=True))
            states += [response.assembly for response in responses if response.assembly is not None]
        every, identity = reduce(UnitSolutions.followed_by, units), np.eye(len(instants))
        weights = Weights(identity, identity)
        if not every.parts[0].odd.shape[2]:  # nothing acts in the other parity
            every = replace(every, parts=tuple(replace(part, odd=part.even) for part in every.parts))
            weights = Weights(identity, 0 * identity)
        analysis = self._rod.superposing(FullBasis(loads[0], lambda _fields: every))
        if regions is not None:
            analysis = replace(analysis, regions=regions)
        elif len(instants) > 1:
            analysis = analysis.supported_by(weights)
        parts = [PartRows(analysis, number) for number in range(len(analysis.materials))]
        return _SolvedInstants(parts, weights, states, analysis.regions)

    def _of_assembly(self, states: Sequence[AssemblyState], angles: Floats) -> dict[FailureMode, ModeFactor]:
        """Factors of bolts, joint and seats over contact states at crank angles, rad."""
        setup = self._rod.assembling
        if setup is None:
            raise ValueError("a rod of one piece has no bolts")
        bolts = judged_bolts(setup, states)
        yielding = min(range(len(bolts)), key=lambda number: bolts[number].working_safety)
        fatigued = min(range(len(bolts)), key=lambda number: bolts[number].bending_fatigue_safety)
        places = [bolt.at for bolt in self._start.bolts]
        at = float(angles[bolts[yielding].largest_at])
        found = {
            FailureMode.BOLT_YIELD: ModeFactor(bolts[yielding].working_safety, places[yielding], at),
            FailureMode.BOLT_FATIGUE: ModeFactor(bolts[fatigued].bending_fatigue_safety, places[fatigued]),
        }
        joint = [state.joint for state in states]
        if setup.bolt.bolt.play:  # otherwise the bolts carry what friction does not
            reserve = [state.slip_reserve or math.inf for state in joint]
            found[FailureMode.SLIP] = ModeFactor(min(reserve), None, float(angles[np.argmin(reserve)]))
        preload = self._start.joint.edge_pressure or 0.0
        lost = {FailureMode.OPENING: [_lost(face.edge_pressure or 0.0, preload, face) for face in joint]}
        for mode, seat in _SEATS.items():
            if seat in self._start.faces:
                preload = self._start.faces[seat].min_pressure
                faces = [state.faces[seat] for state in states]
                least = [face.min_pressure if face.open_share == 0 else 0.0 for face in faces]
                lost[mode] = [_lost(left, preload, face) for left, face in zip(least, faces, strict=True)]
        for mode, usage in lost.items():
            if math.isfinite(most := max(usage)):
                found[mode] = ModeFactor(1 / max(most, _TINY), None, float(angles[np.argmax(usage)]))
        return found


def _lost(left: float, before: float, face: FaceState) -> float:
    """Share of a pressure lost; beyond 1, of the area opened; infinite where there was no pressure."""
    if before <= 0:
        return math.inf
    return 1 - left / before if left > 0 else 1 + face.open_share
