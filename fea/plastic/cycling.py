"""What becomes of a body that flows while its load cases follow one another, turn by turn.

Perfect plasticity: hardening without limit cannot ratchet (Nguyen, J. Mech. Phys. Solids 51, 2003, 101), and
isotropic hardening ends every flow. A turn in which nothing flows repeats for ever; as the yield surface is
convex, every load between the cases is then borne elastically, too (Melan 1938).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import combinations
from math import ceil

import numpy as np

from fea.plastic.increment import ElasticBody, FlowState, NoEquilibriumError, at_rest, increment
from fea.plastic.zone import Zone, equivalent_strain
from geometry.arrays import Floats

MOST_TURNS = 60
# Steps of iterations after which no other turn is begun.
_MOST_STEPS = 1000
# Excess over the yield strength that counts as none.
YIELD_TOLERANCE = 1e-4
# Load steps are divided until none exceeds the yield strength by more than this share of it.
_OVERSHOOT = 0.25
# Of what flows in a turn, the share that remains at its end: below the first the turns only reverse each
# other, and where it falls from turn to turn to less than the second the flow fades.
_REVERSED, _FADING = 0.05, 0.99


class PlasticAnswer(StrEnum):
    """What plastic flow leads to, from good to bad."""

    ELASTIC = "elastic"
    SHAKES_DOWN = "shakes down"
    CYCLIC = "cyclic"
    UNDECIDED = "undecided"
    RATCHETS = "ratchets"
    COLLAPSES = "collapses"


@dataclass(frozen=True)
class Flow:
    """What a body did over the turns."""

    answer: PlasticAnswer
    state: FlowState  #: at the end, in the unloaded body
    turns: int  #: in which something flowed
    cases: tuple[int, ...]  #: load cases under which something flowed
    #: At each load case of the last turn, the displacement of the elastic body, mm, and the state
    ends: tuple[tuple[Floats, FlowState], ...]
    #: Of the last turn, the largest equivalent plastic strain of any point added up over it
    per_turn: float
    unbalanced: float  #: largest force out of balance, relative
    beyond_yield: float  #: largest excess over the yield strength in the last turn, relative to it
    least_dissipation: float  #: of any increment, mJ
    #: Share of the way to the last load case up to which there is equilibrium; 1 unless the body collapses
    borne: float

    @property
    def strain(self) -> Floats:
        """Equivalent plastic strain (n_elements, n_points) at the end."""
        return equivalent_strain(self.state.plastic)

    def strain_range(self, zone: Zone) -> Floats:
        """Largest range of strain (n_elements, n_points) between any two load cases of the last turn.

        Its elastic part is that of a bar with the same von Mises stress: Δσ/E + Δε_p.
        """
        modulus = 9 * zone.bulk * zone.shear / (3 * zone.bulk + zone.shear)
        largest = np.zeros(zone.volumes.shape)
        for (u, one), (v, other) in combinations(self.ends, 2):
            plastic = one.plastic - other.plastic
            stress = zone.usage(u + one.moved - v - other.moved, plastic) * zone.strength
            largest = np.maximum(largest, stress / modulus + equivalent_strain(plastic))
        return largest


@dataclass
class _Walk:
    """A body on its way from load case to load case."""

    zone: Zone
    body: ElasticBody
    elastic: Floats  #: displacement of the elastic body, mm: what acts now
    state: FlowState
    path: Floats  #: plastic strain added up over this turn
    unbalanced: float = 0.0
    beyond_yield: float = 0.0
    least_dissipation: float = 0.0
    borne: float = 1.0
    flowed: set[int] = field(default_factory=set)
    ends: list[tuple[Floats, FlowState]] = field(default_factory=list)  #: of the load cases of this turn
    #: By load case and step, what happened there a turn before
    last: dict[tuple[int, int], tuple[FlowState, FlowState]] = field(default_factory=dict)

    def to(self, case: int, target: Floats) -> None:
        """Go to a load case, in steps."""
        start, excess, inside = self.elastic, self._excess(target), min(0.0, self._excess(self.elastic))
        elastic = inside / (inside - excess) if excess > 0 else 1.0  # as the yield function is convex
        steps = max(1, ceil(excess / _OVERSHOOT))
        for step in range(1, steps + 1):
            self.borne = max(elastic, (step - 1) / steps)
            self.elastic = start + (target - start) * (step / steps)
            if steps > 1:
                excess = self._excess(self.elastic)
            if excess > YIELD_TOLERANCE:
                excess = self._flow(case, step)
            self.beyond_yield = max(self.beyond_yield, excess)
        self.borne = 1.0
        self.ends.append((self.elastic, self.state))

    def _flow(self, case: int, step: int) -> float:
        """Flow, and return the excess that is left."""
        zone, before, last = self.zone, self.state, self.last.get((case, step))
        # As a turn before: by as much, or, where places flow to and fro, to the same end.
        guesses = () if last is None else (before.repeated(*last), last[1])
        after = increment(zone, self.body, self.elastic, before, guesses)
        self.last[case, step] = before, after
        flow, stress = after.plastic - before.plastic, zone.trial(self.elastic + after.moved, after.plastic)
        self.least_dissipation = min(self.least_dissipation, zone.dissipation(stress, flow))
        self.unbalanced = max(self.unbalanced, after.unbalanced)
        self.path = self.path + equivalent_strain(flow)
        self.flowed.add(case)
        self.state = after
        return _beyond(zone, stress)

    def _excess(self, elastic: Floats) -> float:
        return _beyond(self.zone, self.zone.trial(elastic + self.state.moved, self.state.plastic))


def _beyond(zone: Zone, deviatoric: Floats) -> float:
    """Return by how much stress exceeds the yield strength, relative to it."""
    return float(zone.used(deviatoric).max(initial=0.0)) - 1


def cycled(
    zone: Zone,
    body: ElasticBody,
    cases: Sequence[Floats],
    most_turns: int = MOST_TURNS,
    *,
    endless: bool = False,
) -> Flow:
    """Repeat load cases until what happens is known, or until that takes too long.

    `cases`: displacements (n_halves, n_nodes, 3), mm, of the elastic body under each of them, of projected
    volumetric strain (`fea.plastic.increment.projected`), in the order in which they act. An `endless` flow
    is known not to fade (Melan 1938), so that fewer turns say what it leads to.
    """
    nothing = np.zeros(zone.volumes.shape)
    rest = at_rest(zone, body.halves)
    walk, history = _Walk(zone, body, rest.moved, rest, nothing), list[tuple[float, float]]()
    answer: PlasticAnswer | None = None
    last_step = body.steps + _MOST_STEPS
    while answer is None:
        before, walk.path, walk.beyond_yield = walk.state.plastic, nothing, 0.0
        walk.ends.clear()
        try:
            for number, case in enumerate(cases):
                walk.to(number, case)
        except NoEquilibriumError:
            answer = PlasticAnswer.COLLAPSES
        else:
            net = equivalent_strain(walk.state.plastic - before)
            history.append((float(walk.path.max()), float(net.max())))
            most = len(history) if body.steps > last_step else most_turns
            answer = _settled(history, most, endless=endless)
    return Flow(
        answer,
        walk.state,
        turns=sum(path > 0 for path, _ in history),
        cases=tuple(sorted(walk.flowed)),
        ends=tuple(walk.ends),
        per_turn=float(walk.path.max()),
        unbalanced=walk.unbalanced,
        beyond_yield=walk.beyond_yield,
        least_dissipation=walk.least_dissipation,
        borne=walk.borne,
    )


# Turns that must agree before flow that does not end is given a name.
_AGREE = 4


def _settled(
    history: Sequence[tuple[float, float]], most_turns: int, *, endless: bool
) -> PlasticAnswer | None:
    """Name what happens from what flowed in each turn and what of it remained; None while it fades."""
    if history[-1][0] == 0:
        return PlasticAnswer.SHAKES_DOWN if len(history) > 1 else PlasticAnswer.ELASTIC
    (path, net), (old_path, old_net) = history[-1], history[-_AGREE:][0]
    if endless and len(history) > 1 and all(left < _REVERSED * flow for flow, left in history[-2:]):
        return PlasticAnswer.CYCLIC
    if len(history) >= _AGREE:
        steady = _FADING ** (_AGREE - 1)
        if net < _REVERSED * path and path > steady * old_path:
            return PlasticAnswer.CYCLIC
        if net >= _REVERSED * path and net > steady * old_net:
            return PlasticAnswer.RATCHETS
    return PlasticAnswer.UNDECIDED if len(history) >= most_turns else None
