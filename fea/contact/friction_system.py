"""Parts that touch with friction, their bolts and their pins: one step from a known state under a new load.

Unilateral contact and Coulomb friction, implicit in the step:

    λ_n ≥ 0,  y_n ≥ 0,  λ_n y_n = 0
    |λ_t| ≤ μ λ_n,  and where it slips  λ_t = −μ λ_n Δy_t / |Δy_t|

with the gaps y of `fea.contact.condensed`. The primal-dual active set is a semismooth Newton method (Alart &
Curnier 1991; Hüeber, Stadler & Wohlmuth 2008), whose unknowns are the pressures of the pins that touch and
the gaps of what opens or slips: few, as long as the parts hold together.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import astuple, dataclass, replace

import numpy as np

from fea.contact.block import Block, Ends
from fea.contact.block_search import UNSETTLED, BlockSearch
from fea.contact.condensed import CondensedInterface
from fea.contact.guess import Guess, Offsets, Places
from fea.contact.trial import EXACT, ROUNDING, Exact, Trial
from fea.machine.threads import side_by_side
from fea.solid.errors import UnsettledError
from geometry.arrays import Floats, Ints

# How often the blocks of the problem are solved in turn.
_SWEEPS = 10
# What is nothing beside so much of the pressure between the parts is nothing also where hardly anything acts.
_CALM = 1e-3

# Solutions of the blocks by their numbers.
Trials = dict[int, Trial]


@dataclass(frozen=True)
class Load:
    """What acts at the end of a step."""

    gap: Floats  # g (n,), moments of the gap that everything but the unknowns leaves
    pins: Floats  # (m,) resultants along the free motions of the pins
    parts: Floats  # (k,) resultants of other loads along the free motions of the parts

    def halfway(self, other: "Load") -> "Load":
        """Return the load between this one and another."""
        return Load(*((one + two) / 2 for one, two in zip(astuple(self), astuple(other), strict=True)))


@dataclass(frozen=True)
class ContactState:
    """The end of a step."""

    load: Load  # at the end
    values: Floats  # λ (n,): pressures and shear stresses, MPa, and bolt forces, N
    # y_J (n_J,), moments of the gaps and slips of the interfaces since the parts were put together
    gap: Floats
    guess: Guess  # what touches, opens and slips
    loose: Floats  # (m,) motions of the parts that only the pins resist
    residual: float  # largest violation of contact or friction, relative to the largest stress
    imbalance: float  # largest error of the resultants of the pins, relative to them
    changes: int  # how many states were tried


class FrictionSystem:
    """Steps from state to state.

    Parameters
    ----------
    condensed
        The condensed problem.
    rigid
        R (n, m) of the pins.
    places
        Where the parts touch.
    names
        (k,) of the part that each motion of the parts moves, with its article.
    """

    def __init__(
        self, condensed: CondensedInterface, rigid: Floats, places: Places, names: Sequence[str] = ()
    ) -> None:
        self._condensed, self._places = condensed, places
        free, self._loose = condensed.free
        R = np.hstack([rigid[condensed.pins], free])
        scale = np.abs(R).max(axis=0, initial=0.0)
        self._scale = np.where(scale > 0, scale, 1.0)
        self._whole = Block.whole(condensed, R / self._scale, places)
        self._ends = Ends.of(self._whole)
        self._solved = range(len(self._ends.blocks))
        self._search = BlockSearch(self._loose, len(scale), names)

    @property
    def ends(self) -> tuple["FrictionSystem", ...]:
        """The same for one block each, while the others keep their gaps: `together` joins their states."""
        return tuple(self._alone(number) for number in self._solved)

    def _alone(self, number: int) -> "FrictionSystem":
        found = copy(self)
        found._solved = range(number, number + 1)  # noqa: SLF001 - a copy of itself
        return found

    def together(self, states: Sequence[ContactState]) -> ContactState:
        """One state of the whole from those of `ends` under the same load."""
        condensed, guess = self._condensed, states[0].guess
        values, gap = states[0].values.copy(), states[0].gap.copy()
        parts = list[tuple[Ints, Ints, Guess]]()
        for own, state in zip(self._ends.blocks, states, strict=True):
            numbers = np.concatenate([condensed.pins[own.pins], condensed.interface[own.interface]])
            values[numbers], gap[own.interface] = state.values[numbers], state.gap[own.interface]
            parts.append((own.pins, own.sites, state.guess.of(own.pins, own.sites)))
        return replace(
            states[0],
            values=values,
            gap=gap,
            guess=Guess.together(len(guess.touching), len(guess.opened), parts),
            loose=np.sum([state.loose for state in states], axis=0),
            residual=max(state.residual for state in states),
            imbalance=max(state.imbalance for state in states),
            changes=sum(state.changes for state in states),
        )

    def part_motion(self, state: ContactState) -> Floats:
        """Motions (k,) of the parts."""
        condensed, load = self._condensed, state.load
        open_gap = state.gap - load.gap[condensed.interface]
        return condensed.motions(open_gap, state.values[condensed.pins], load.parts, state.loose)

    def step(
        self,
        load: Load,
        gap: Floats,
        guess: Guess,
        exact: Exact = EXACT,
        *,
        rubbing: bool = True,
        last: Trials | None = None,
    ) -> ContactState:
        """Find the state under a load.

        Parameters
        ----------
        load
            At the end of the step.
        gap
            y_J (n_J,) at its beginning.
        guess
            Where to begin.
        exact
            How exactly the laws shall hold.
        rubbing
            Whether places may slip; otherwise `gap` holds their slip at the end.
        last
            Solutions of an earlier step, which are of use where the guess is theirs: replaced by those of
            this one.

        Raises
        ------
        ContactError
            No pressure of the pins has their forces.
        UnsettledError
            No state was found that obeys contact and friction.
        """
        return self.under(load, self.offsets([load], [gap])[0], guess, exact, rubbing=rubbing, last=last)

    def under(
        self,
        load: Load,
        offsets: Offsets,
        guess: Guess,
        exact: Exact = EXACT,
        *,
        rubbing: bool = True,
        last: Trials | None = None,
    ) -> ContactState:
        """The same where the state that sticks is known; see `step` and `offsets`."""
        ends = self._ends if rubbing else self._ends.sticking
        trials, changes = self._settled(ends, offsets, guess, exact, last or {})
        if last is not None:
            last.update(trials)
        return self._joined(trials, changes, load, offsets.gap, guess)

    def _settled(
        self, ends: Ends, offsets: Offsets, guess: Guess, exact: Exact, last: Trials
    ) -> tuple[Trials, int]:
        """Solution of each block under what the others do to it, and how many states were tried."""
        blocks = ends.blocks
        calm = _CALM * max(self._pressed(offsets, guess), exact.elsewhere)
        offsets = replace(offsets, least=max(calm, offsets.least))
        parts = [offsets.of(own.pins, own.interface, own.motions) for own in blocks]
        guesses = [
            _begun(own, part, guess.of(own.pins, own.sites)) for own, part in zip(blocks, parts, strict=True)
        ]
        alone = self._solved[0] if len(self._solved) == 1 else None
        pressure = [  # of what acts on others
            np.zeros(len(own.pins)) if number == alone else own.carrying(each.touching, part.forces)
            for number, (own, each, part) in enumerate(zip(blocks, guesses, parts, strict=True))
        ]
        moved = [np.zeros(len(own.interface)) for own in blocks]
        found, changes = Trials(), 0
        each = map if ends is self._ends.sticking else side_by_side  # without friction, hardly worth a thread
        for _ in range(_SWEEPS):
            loads = {own: ends.shifted(own, parts[own], pressure, moved) for own in self._solved}
            left = [own for own in self._solved if _changed(blocks[own], loads[own], found.get(own))]
            if not left:
                break
            least = max([offsets.least, *(own.size for own in found.values())])
            jobs = [
                (blocks[own], replace(loads[own], least=least), guesses[own], exact, (last | found).get(own))
                for own in left
            ]
            for number, (trial, states) in zip(left, each(self._search, jobs), strict=True):
                changes += states
                found[number], guesses[number] = trial, trial.guess
                pressure[number], moved[number] = trial.solution.pressure, trial.solution.moved
            if alone is not None:
                break
        else:
            raise UnsettledError(UNSETTLED)
        return found, changes

    def _pressed(self, offsets: Offsets, guess: Guess) -> float:
        """Largest pressure between the parts while nothing moves, MPa."""
        places, sites = self._places, np.concatenate([self._ends.blocks[own].sites for own in self._solved])
        closed = places.normal[sites[~guess.opened[sites] & ~places.bolt[sites]]]
        return float(np.abs(offsets.stress[closed]).max(initial=0.0))

    def offsets(self, loads: Sequence[Load], gaps: Sequence[Floats]) -> list[Offsets]:
        """Sticking states of the blocks under loads, from gaps y_J (n_J,)."""
        condensed = self._condensed
        begin, given = np.stack(gaps, axis=1), np.stack([load.gap for load in loads], axis=1)
        # What is open now follows from the load, not from what was open before.
        begin[self._places.normal] = 0.0
        parts = np.stack([load.parts for load in loads], axis=1)
        pins = np.stack([load.pins for load in loads], axis=1)
        left = begin - given[condensed.interface]
        stress, pin_gap = condensed.V @ parts, given[condensed.pins] + condensed.G @ parts
        for number in self._solved:
            block = self._ends.blocks[number]
            by_slip = self._ends.slipped(number, left)
            stress[block.interface] += by_slip[0]
            pin_gap[block.pins] += by_slip[1]
        forces = np.concatenate([pins, self._loose @ parts]) / self._scale[:, None]
        columns = (np.ascontiguousarray(own.T) for own in (stress, pin_gap, forces, begin))
        return [Offsets(*instant) for instant in zip(*columns, strict=True)]

    def _joined(self, trials: Trials, changes: int, load: Load, before: Floats, guess: Guess) -> ContactState:
        """State of some blocks; the others keep their gaps (n_J,), and what is guessed of them."""
        condensed, whole = self._condensed, self._whole
        pressure, stress = np.zeros(len(condensed.pins)), np.zeros(len(condensed.interface))
        gap, motion = before.copy(), np.zeros(len(self._scale))
        parts = [(whole.pins, whole.sites, guess)]
        for number, trial in trials.items():
            own = self._ends.blocks[number]
            pressure[own.pins], stress[own.interface] = trial.solution.pressure, trial.solution.stress
            gap[own.interface], motion[own.motions] = trial.gap, trial.solution.motion
            parts.append((own.pins, own.sites, trial.guess))
        values = np.zeros(len(load.gap))
        values[condensed.pins], values[condensed.interface] = np.maximum(pressure, 0.0), stress
        return ContactState(
            load=load,
            values=values,
            gap=gap,
            guess=Guess.together(len(condensed.pins), whole.places.size, parts),
            loose=(motion / self._scale)[len(load.pins) :],
            residual=max(trial.residual for trial in trials.values()),
            imbalance=max(trial.imbalance for trial in trials.values()),
            changes=changes,
        )


def _changed(block: Block, load: Offsets, last: Trial | None) -> bool:
    """Whether the load of a block is not that for which it was last solved."""
    return last is None or block.change(load, last.offsets) > ROUNDING * last.size


def _begun(block: Block, offsets: Offsets, guess: Guess) -> Guess:
    """Begin with the pressures of the pins on one side, if none of those that act carries any force."""
    if offsets.forces.any() and not block.R[guess.touching].any():
        return replace(guess, touching=block.R @ offsets.forces > 0)
    return guess
