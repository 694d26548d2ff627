"""Safety factors of a rod in parts at an operating point: a crank cycle of its own, with its friction.

Friction makes an instant depend on those before it, and preload makes stress no multiple of the load. A
point is therefore gone through as `fea run --cycle` does, and the stress of its instants is solved directly.
Elsewhere the factors are estimated from the instants that decide, each from the rod at rest: what came before
changes a factor by about as much as it did at the last point that was gone through.
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
from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.analysis.prepared_rod import PreparedRod
from fea.apps.limits.states import (
    EVERY_PLACE,
    Histories,
    Mode,
    State,
    States,
    Worst,
    around,
    closest,
    decisive,
    gas_peak,
    judged,
    usage_of,
    worst,
)
from fea.base.units import DEG
from fea.contact.assembly_state import AssemblyState, FaceState
from fea.pins.assembly import AssemblyPins
from fea.pins.model import Fields, Response, UnitLoads, Weights
from fea.pins.prescribed import StoredFields
from fea.solid.errors import UnsettledError
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

# Instants whose responses are in memory at once.
_AT_ONCE = 24
# Forces of one parity, over those of the other, that are none; and a utilisation that is none.
_ROUNDING, _TINY = 1e-12, 1e-12
_SEATS = {Mode.BUSHING: Surface.BUSHING_SEAT, Mode.SHELLS: Surface.SHELL_SEAT}


class _Alone(UnitLoads):
    """Instants that are unit loads of their own."""

    def __init__(self, responses: Sequence[Response]) -> None:
        largest = [
            max(float(np.abs(one.forces.part(parity)).max()) for one in responses) for parity in Parity
        ]
        even, odd = (
            _stored(responses if own > _ROUNDING * max(largest) else [], parity)
            for own, parity in zip(largest, Parity, strict=True)
        )
        self._fields = even, odd

    def fields(self) -> tuple[Fields, Fields]:
        return self._fields

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        even, odd = (np.eye(fields.count, len(instants)) for fields in self._fields)
        return Weights(even, odd)


def _stored(responses: Sequence[Response], parity: Parity) -> StoredFields:
    """The forces and tractions of one parity at instants."""
    pressed = {
        surface: np.stack([one.traction[surface].part(parity) for one in responses], axis=-1)
        for surface in (responses[0].traction if responses else ())
    }
    return StoredFields([one.forces.part(parity) for one in responses], pressed)


class _Solved(NamedTuple):
    """Instants with the stress of every place."""

    parts: list[PartRows]
    weights: Weights
    states: list[AssemblyState]


def _most_stressed(solved: _Solved) -> list[tuple[PartRows, Ints, Floats]]:
    """Rows of each part that may be the worst, with their stress (n, 6, n_instants)."""
    pairs = [(part, closest(usage_of(part, solved.weights))) for part in solved.parts]
    return [(part, rows, part.stress(solved.weights, rows)) for part, rows in pairs]


class AssembledStates(States):
    """The factors of a rod in parts."""

    costly = True

    def __init__(self, rod: PreparedRod, pins: AssemblyPins) -> None:
        super().__init__(rod)
        self._rod, self._pins = rod, pins
        self._start = pins.assembly.sums(pins.assembly.assembled.start)
        self._decided = np.zeros(0)  # crank angles, rad
        self._gone_through: tuple[CrankCycle, State] | None = None
        self._history = dict[Mode, float]()  # factors over those without what came before

    @property
    def rest(self) -> State:
        """Return the factors of the rod that is put together, as warm as the engine."""
        return self._worst(self._solved(self._pins.resting), np.zeros(1))

    def estimate(self, cycle: CrankCycle) -> State:
        """Estimate the factors over a cycle at the instants that decided before and at its peaks."""
        left = self._left_by_history()
        found = self._from_rest(cycle).items()
        return {mode: replace(worst, factor=worst.factor * left.get(mode, 1.0)) for mode, worst in found}

    def _left_by_history(self) -> dict[Mode, float]:
        """Factors over those from rest, in the cycle that was gone through last."""
        if self._gone_through is not None:
            at, state = self._gone_through
            self._gone_through, before = None, self._from_rest(at)
            before.pop(Mode.SLIP, None)  # which instant slips first depends on what came before
            ratios = {mode: state[mode].factor / old.factor for mode, old in before.items() if mode in state}
            self._history |= {mode: ratio for mode, ratio in ratios.items() if math.isfinite(ratio)}
        return self._history

    def _from_rest(self, cycle: CrankCycle) -> dict[Mode, Worst]:
        first, angles = self._at_decided(cycle)
        return self._worst(first, angles) | {Mode.BUCKLING: self.buckling(cycle)}

    def _at_decided(self, cycle: CrankCycle) -> tuple[_Solved, Floats]:
        peaks = cycle.peaks.cases
        angles = np.union1d(self._decided, peaks.crank_angle[peaks.in_cycle])
        return self._solved(cycle.at(angles)), angles

    def at(self, cycle: CrankCycle) -> State:
        """Return the factor of each mode over a cycle, with its place; every place is looked at."""
        try:
            (places, angles), states = self._over(cycle)
        except UnsettledError:
            self.unsettled += 1
            return self.estimate(cycle)
        found = worst(places, angles) | self._of_parts(states, angles)
        found[Mode.BUCKLING] = self.buckling(cycle)
        self._gone_through = cycle, found
        return found

    def histories(self, cycle: CrankCycle, *, estimated: bool = False) -> Histories:
        """Return the most stressed places: see `States.histories`."""
        with suppress(UnsettledError):
            if not estimated:
                return self._over(cycle)[0]
        solved, angles = self._at_decided(cycle)
        stress = 1 / self._left_by_history().get(Mode.FATIGUE, 1.0)
        return [(part, rows, stress * past) for part, rows, past in _most_stressed(solved)], angles.tolist()

    def _over(self, cycle: CrankCycle) -> tuple[Histories, list[AssemblyState]]:
        """Go through a cycle: at every few degrees, then around the instants that decide."""
        angles = np.append(np.arange(0, 720, EVERY_PLACE) * DEG, gas_peak(cycle))
        first = self._solved(cycle.at(angles), cycle)
        places = _most_stressed(first)
        histories = [course for _, _, course in places]
        usage = [judged(part, course, rows) for part, rows, course in places]
        self._decided = np.union1d(self._decided, decisive(angles, histories, usage, 0))
        least = self._of_parts(first.states, angles.tolist()).values()
        of_parts = around(np.array([worst.crank_angle for worst in least if worst.crank_angle is not None]))
        more = np.setdiff1d(np.union1d(decisive(angles, histories, usage), of_parts), angles)
        second = self._solved(cycle.at(more), cycle)
        both = [
            (part, rows, np.concatenate([course, of_second.stress(second.weights, rows)], axis=2))
            for (part, rows, course), of_second in zip(places, second.parts, strict=True)
        ]
        return (both, [*angles, *more]), [*first.states, *second.states]

    def _worst(self, solved: _Solved, angles: Floats) -> dict[Mode, Worst]:
        return worst(_most_stressed(solved), angles.tolist()) | self._of_parts(solved.states, angles.tolist())

    def _solved(self, instants: Instants, cycle: CrankCycle | None = None) -> _Solved:
        """Stress of every place at instants, and what bolts and interfaces do."""
        units, states, loads = list[UnitSolutions](), list[AssemblyState](), list[_Alone]()
        for some in np.array_split(np.arange(len(instants)), -(-len(instants) // _AT_ONCE)):
            responses = self._pins.respond(instants[some], cycle)
            loads = [_Alone(responses)]
            units.append(self._rod.solved_units(loads[0].fields(), single=True))
            states += [one.assembly for one in responses if one.assembly is not None]
        every, one = reduce(UnitSolutions.followed_by, units), np.eye(len(instants))
        weights = Weights(one, one)
        if not every.parts[0].odd.shape[2]:  # nothing acts in the other parity
            every = replace(every, parts=tuple(replace(part, odd=part.even) for part in every.parts))
            weights = Weights(one, 0 * one)
        analysis = self._rod.superposing(FullBasis(loads[0], lambda _fields: every))
        parts = [PartRows(analysis, number) for number in range(len(analysis.materials))]
        return _Solved(parts, weights, states)

    def _of_parts(self, states: Sequence[AssemblyState], angles: Sequence[float]) -> dict[Mode, Worst]:
        assembling = self._rod.assembling
        if assembling is None:
            raise ValueError("a rod of one piece has no bolts")
        bolts = judged_bolts(assembling, states)
        places = [bolt.at for bolt in self._start.bolts]
        hard = min(range(len(bolts)), key=lambda number: bolts[number].working_safety)
        tired = min(range(len(bolts)), key=lambda number: bolts[number].bending_fatigue_safety)
        at = angles[bolts[hard].largest_at]
        found = {
            Mode.BOLT_YIELD: Worst(bolts[hard].working_safety, places[hard], at),
            Mode.BOLT_FATIGUE: Worst(bolts[tired].bending_fatigue_safety, places[tired]),
        }
        joint, before = [state.joint for state in states], self._start.joint
        slip = [state.slip_reserve or math.inf for state in joint]
        if assembling.bolt.bolt.play:  # else the bolts carry what friction does not
            found[Mode.SLIP] = Worst(min(slip), None, angles[int(np.argmin(slip))])
        edge = before.edge_pressure or 0.0
        lost = {Mode.OPENING: [_lost(state.edge_pressure or 0.0, edge, state) for state in joint]}
        for mode, seat in _SEATS.items():
            if seat in self._start.faces:
                held = self._start.faces[seat].min_pressure
                faces = [state.faces[seat] for state in states]
                least = [fit.min_pressure if fit.open_share == 0 else 0.0 for fit in faces]
                lost[mode] = [_lost(left, held, fit) for left, fit in zip(least, faces, strict=True)]
        for mode, usage in lost.items():
            if math.isfinite(most := max(usage)):
                found[mode] = Worst(1 / max(most, _TINY), None, angles[int(np.argmax(usage))])
        return found


def _lost(left: float, before: float, face: FaceState) -> float:
    """Share of a pressure lost; beyond 1, of the area opened; infinite where there was no pressure."""
    if before <= 0:
        return math.inf
    return 1 - left / before if left > 0 else 1 + face.open_share
