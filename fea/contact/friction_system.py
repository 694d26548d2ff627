"""Parts that touch with friction, their bolts and their pins: one step from a known state under a new load.

Unilateral contact and Coulomb friction, implicit in the step:

    λ_n ≥ 0,  y_n ≥ 0,  λ_n y_n = 0
    |λ_t| ≤ μ λ_n,  and where it slips  λ_t = −μ λ_n Δy_t / |Δy_t|

with the gaps y of `fea.contact.problem`. The primal-dual active set is a semismooth Newton method (Alart &
Curnier 1991; Hüeber, Stadler & Wohlmuth 2008), whose unknowns are the pressures of the pins that touch and
the gaps of what opens or slips: few, as long as the parts hold together.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass, field, replace

import numpy as np
from scipy.optimize import nnls

from fea.contact.active_set import BALANCE, ContactSystem, balanced
from fea.contact.block import ContactBlock, CoupledBlocks, Guess, Places, StickingState
from fea.contact.problem import CondensedInterface
from fea.contact.trial import ROUNDING, TOLERANCES, Tolerances, Trial
from fea.machine.threads import side_by_side
from fea.solid.errors import ContactError, UnsettledError
from geometry.arrays import Floats, Ints, Mask

# Guesses in the beginning that change everything at once.
_ALL_AT_ONCE = 40
# Share of the largest violation from which on only the worst place is changed.
_SINGLE = 0.8
# Largest change of a direction of slip between guesses that are the same.
_TURNED = 1e-6


class GuessCorrection:
    """Corrects guesses until one obeys every law.

    A semismooth Newton method changes all places that are wrong. If that does not settle, pins come first and
    friction comes last, because what the parts do under a wrong load of the pins says nothing about friction.
    Where the method returns to a guess, it runs in a circle: from then on, only the worst places of that kind
    are changed, fewer each time, down to single ones. If these return to a guess with the same directions of
    slip, it never settles.
    """

    def __init__(self, exact: Tolerances) -> None:
        self._exact = exact
        self._seen = dict[bytes, Guess]()
        self._least = np.zeros(3)
        self._all_at_once = _ALL_AT_ONCE
        self.in_circle = False  #: whether it would only do again what it did

    def of(self, trial: Trial) -> Guess | None:
        """Return the next guess, or None if this one obeys every law."""
        if trial.obeys(self._exact):
            return None
        all_at_once = self._all_at_once > 0
        self._all_at_once -= 1
        pins, normal, _ = trial.violations
        kind = 2 if all_at_once else 0 if pins.any() else 1 if normal.any() else 2
        wrong = []
        for number, (violation, least) in enumerate(zip(trial.violations, self._least, strict=True)):
            worst = (violation > 0) & (violation >= least * violation.max(initial=0.0))
            wrong.append(worst if number <= kind else np.zeros_like(worst))
        better = trial.corrected(*wrong)
        if any(violation.any() for violation in wrong):
            key = np.packbits(np.concatenate([better.touching, better.opened, better.slipping])).tobytes()
            before = self._seen.get(key)
            self._seen = ({} if before else self._seen) | {key: better}
            if before and self._all_at_once > 0:
                self._all_at_once = 0
            elif before:
                turned = np.abs(better.direction - before.direction).max(initial=0.0)
                self.in_circle = bool(self._least[kind] == 1 and turned < _TURNED)
                halfway = (1 + self._least[kind]) / 2
                self._least[kind] = halfway if halfway < _SINGLE else 1.0
        return better


# States that are tried at most.
_MOST = 300
UNSETTLED = (
    "contact and friction between the parts did not settle: choose a larger --size or another "
    "assembly.joint_friction"
)


class _BlockSearch:
    """Searches the state of a block.

    `pin_held` (m, k): share of the motions that only the pins resist in those of the parts; they are the last
    of all `motions` of the pins. `names` (k,): of the parts that these motions move, with their articles.
    """

    def __init__(self, pin_held: Floats, motions: int, names: Sequence[str] = ()) -> None:
        self._pin_held, self._motions, self._names = pin_held, motions, names

    def __call__(
        self, problem: tuple[ContactBlock, StickingState, Guess, Tolerances, Trial | None]
    ) -> tuple[Trial, int]:
        """Find the solution of a block, and how many states were tried.

        `problem`: a block, its sticking state, the first guess, the exactness of the laws, an earlier
        solution. Where pins hardly press, their contact area may not settle from the first guess; it then
        begins with that between parts that stick, which exists and is unique. Raises `ContactError`: no
        pressure of the pins has their forces; `UnsettledError`: no state was found that obeys contact and
        friction.
        """
        block, offsets, guess, exact, trial = problem
        try:
            return self._found(block, offsets, guess, exact, trial)
        except UnsettledError:
            if not block.R.size:
                raise
        pressed = ContactSystem(block.effects.A, block.R).solve(offsets.pin_gap, offsets.forces)
        return self._found(block, offsets, replace(guess, touching=pressed.pressure > 0), exact, trial)

    def _found(
        self,
        block: ContactBlock,
        offsets: StickingState,
        guess: Guess,
        exact: Tolerances,
        trial: Trial | None,
    ) -> tuple[Trial, int]:
        """Search from a guess; errors as of a call."""
        correction = GuessCorrection(exact)
        for change in range(1, _MOST + 1):
            trial = Trial.of(block, offsets, guess, trial)
            better = correction.of(trial)
            # Without pins, nothing balances what rounding leaves of loads that balance.
            balance = trial.imbalance <= BALANCE or not block.R.size
            if better is None and balance:
                return trial, change
            if correction.in_circle:
                break
            guess = better or guess
            if not balance and change == 1:
                # Too few places of the pins touch for their forces.
                guess = replace(guess, touching=guess.touching | self._balancing(block, offsets.forces))
            elif better is None:
                guess = replace(guess, touching=guess.touching | self._stopping(trial))
        if trial is None or trial.imbalance <= BALANCE:
            raise UnsettledError(UNSETTLED)
        raise self._unresisted(trial)

    def _balancing(self, block: ContactBlock, forces: Floats) -> Mask:
        """Which pressures (n_p,) of the pins can have the resultants along R together."""
        try:
            return balanced(block.R, forces) > 0
        except ContactError as error:
            if not len(self._pin_held):
                raise
            left = forces - block.R.T @ nnls(block.R.T, forces)[0]
            raise ContactError(self._slides(block, left)) from error

    def _stopping(self, trial: Trial) -> Mask:
        """Which pressures (n_p,) of the pins stop a motion that those that touch do not resist."""
        closing = np.where(trial.guess.touching, 0.0, trial.block.R @ trial.left)
        ahead = closing > BALANCE * np.abs(closing).max(initial=0.0)
        if not ahead.any():
            raise self._unresisted(trial)
        way = np.divide(trial.solution.pin_gap, closing, out=np.full(len(closing), np.inf), where=ahead)
        return np.asarray(way <= way.min())

    def _unresisted(self, trial: Trial) -> UnsettledError:
        return UnsettledError(self._slides(trial.block, trial.left) if len(self._pin_held) else UNSETTLED)

    def _slides(self, block: ContactBlock, resultants: Floats) -> str:
        left = np.zeros(self._motions)
        left[block.motions] = resultants
        moved = np.abs(left[-len(self._pin_held) :] @ self._pin_held)
        name = self._names[int(moved.argmax())] if len(self._names) else "a part"
        return (
            f"{name} slides away, because nothing but friction holds it: give assembly.joint_friction, or "
            "shells that centre the cap"
        )


# How often the blocks of the problem are solved in turn.
_SWEEPS = 10
# What is nothing beside so much of the pressure between the parts is nothing also where hardly anything acts.
_CALM = 1e-3

# Solutions of the blocks by their numbers.
Trials = dict[int, Trial]


@dataclass(frozen=True)
class Load:
    """What acts at the end of a step."""

    gap: Floats  #: g (n,), moments of the gap that everything but the unknowns leaves
    pins: Floats  #: (m,) resultants along the free motions of the pins
    parts: Floats  #: (k,) resultants of other loads along the free motions of the parts
    #: (n_loads,) weights of the other loads, which nothing but the bending of bolts asks for
    motion: Floats = field(default_factory=lambda: np.zeros(0))

    def halfway(self, other: "Load") -> "Load":
        """Return the load between this one and another."""
        return Load(*((one + two) / 2 for one, two in zip(astuple(self), astuple(other), strict=True)))


@dataclass(frozen=True)
class ContactState:
    """The end of a step."""

    load: Load  #: at the end
    values: Floats  #: λ (n,): pressures and shear stresses, MPa, and bolt forces, N
    #: y_J (n_J,), moments of the gaps and slips of the interfaces since the parts were put together
    gap: Floats
    guess: Guess  #: what touches, opens and slips
    pin_held: Floats  #: (m,) motions of the parts that only the pins resist
    residual: float  #: largest violation of contact or friction, relative to the largest stress
    imbalance: float  #: largest error of the resultants of the pins, relative to them
    changes: int  #: how many states were tried


class FrictionSystem:
    """States of parts in contact, with R (n, m) of the pins and the places where the parts touch.

    `names` (k,) are those of the parts that each motion of the parts moves, with their articles.
    """

    def __init__(
        self, condensed: CondensedInterface, rigid: Floats, places: Places, names: Sequence[str] = ()
    ) -> None:
        self.condensed, self.places = condensed, places
        free, self.pin_held = condensed.free
        R = np.hstack([rigid[condensed.pins], free])
        scale = np.abs(R).max(axis=0, initial=0.0)
        self.scale = np.where(scale > 0, scale, 1.0)
        self.whole = ContactBlock.whole(condensed, R / self.scale, places)
        self.coupled = CoupledBlocks.of(self.whole)
        self.search = _BlockSearch(self.pin_held, len(scale), names)

    @property
    def every(self) -> range:
        """Numbers of the blocks, which are hardly coupled: the ends of a rod."""
        return range(len(self.coupled.blocks))

    def together(self, states: Sequence[ContactState]) -> ContactState:
        """One state of the whole from those of each block under the same load."""
        condensed, guess = self.condensed, states[0].guess
        values, gap = states[0].values.copy(), states[0].gap.copy()
        parts = list[tuple[Ints, Ints, Guess]]()
        for block, state in zip(self.coupled.blocks, states, strict=True):
            numbers = np.concatenate([condensed.pins[block.pins], condensed.interface[block.interface]])
            values[numbers], gap[block.interface] = state.values[numbers], state.gap[block.interface]
            parts.append((block.pins, block.sites, state.guess.of(block.pins, block.sites)))
        return replace(
            states[0],
            values=values,
            gap=gap,
            guess=Guess.together(len(guess.touching), len(guess.opened), parts),
            pin_held=np.sum([state.pin_held for state in states], axis=0),
            residual=max(state.residual for state in states),
            imbalance=max(state.imbalance for state in states),
            changes=sum(state.changes for state in states),
        )

    def part_motion(self, state: ContactState) -> Floats:
        """Motions (k,) of the parts."""
        condensed, load = self.condensed, state.load
        open_gap = state.gap - load.gap[condensed.interface]
        return condensed.motions(open_gap, state.values[condensed.pins], load.parts, state.pin_held)


# How often a step that does not settle is halved.
HALVINGS = 2


class Steps:
    """Steps from state to state; what one solved serves the next that begins with its guess.

    The laws hold as exactly as `exact` says; where only some blocks are solved (`numbers`), the others keep
    their gaps. Every step raises `ContactError` where no pressure of the pins has their forces, and
    `UnsettledError` where no state was found that obeys contact and friction.
    """

    def __init__(
        self, system: FrictionSystem, exact: Tolerances = TOLERANCES, numbers: range | None = None
    ) -> None:
        self._system, self._exact = system, exact
        self._numbers = system.every if numbers is None else numbers
        self._trials = Trials()

    def step(self, load: Load, state: ContactState, like: ContactState | None = None) -> ContactState:
        """Go on from a state, if need be in smaller steps; the end resembles the state `like`, if known."""
        if like is not None:
            with suppress(UnsettledError):
                return self.at_once(load, state.gap, like.guess)
        return self._halved(load, state, HALVINGS)

    def _halved(self, load: Load, state: ContactState, halvings: int) -> ContactState:
        try:
            return self.at_once(load, state.gap, state.guess)
        except UnsettledError:
            if not halvings:
                raise
        middle = self._halved(state.load.halfway(load), state, halvings - 1)
        return self._halved(load, middle, halvings - 1)

    def at_once(self, load: Load, gap: Floats, guess: Guess, *, frictional: bool = True) -> ContactState:
        """Find the state from gaps y_J (n_J,) and a guess; without `frictional` these hold the final slip."""
        [offsets] = self._offsets([load], [gap])
        return self._solved(load, offsets, guess, frictional=frictional)

    def _solved(self, load: Load, offsets: StickingState, guess: Guess, *, frictional: bool) -> ContactState:
        coupled = self._system.coupled
        trials, changes = self._settled(coupled if frictional else coupled.sticking, offsets, guess)
        self._trials.update(trials)
        condensed, whole = self._system.condensed, self._system.whole
        pressure, stress = np.zeros(len(condensed.pins)), np.zeros(len(condensed.interface))
        gap, motion = offsets.gap.copy(), np.zeros(len(self._system.scale))
        parts = [(whole.pins, whole.sites, guess)]
        for number, trial in trials.items():
            block = self._system.coupled.blocks[number]
            pressure[block.pins], stress[block.interface] = trial.solution.pressure, trial.solution.stress
            gap[block.interface], motion[block.motions] = trial.gap, trial.solution.motion
            parts.append((block.pins, block.sites, trial.guess))
        values = np.zeros(len(load.gap))
        values[condensed.pins], values[condensed.interface] = np.maximum(pressure, 0.0), stress
        return ContactState(
            load=load,
            values=values,
            gap=gap,
            guess=Guess.together(len(condensed.pins), len(whole.sites), parts),
            pin_held=(motion / self._system.scale)[len(load.pins) :],
            residual=max(trial.residual for trial in trials.values()),
            imbalance=max(trial.imbalance for trial in trials.values()),
            changes=changes,
        )

    def _settled(self, coupled: CoupledBlocks, offsets: StickingState, guess: Guess) -> tuple[Trials, int]:
        """Solution of each block under what the others do to it, and how many states were tried."""
        blocks = coupled.blocks
        calm = _CALM * max(self._pressed(offsets, guess), self._exact.elsewhere)
        offsets = replace(offsets, least=max(calm, offsets.least))
        parts = [offsets.of(block.pins, block.interface, block.motions) for block in blocks]
        guesses = [guess.of(block.pins, block.sites) for block in blocks]
        for number, (block, part) in enumerate(zip(blocks, parts, strict=True)):
            # Where none of the pins' pressures that act carries any force, those on one side begin to act.
            if part.forces.any() and not block.R[guesses[number].touching].any():
                guesses[number] = replace(guesses[number], touching=block.R @ part.forces > 0)
        alone = self._numbers[0] if len(self._numbers) == 1 else None
        pressure = [  # of what acts on others
            np.zeros(len(block.pins)) if number == alone else block.carrying(each.touching, part.forces)
            for number, (block, each, part) in enumerate(zip(blocks, guesses, parts, strict=True))
        ]
        moved = [np.zeros(len(block.interface)) for block in blocks]
        trials, changes = Trials(), 0
        # Without friction, a block is hardly worth a thread.
        run = map if coupled is self._system.coupled.sticking else side_by_side
        for _ in range(_SWEEPS):
            loads = {k: coupled.shifted(k, parts[k], pressure, moved) for k in self._numbers}
            left = [
                k
                for k in self._numbers
                if k not in trials
                or blocks[k].change(loads[k], trials[k].offsets) > ROUNDING * trials[k].size
            ]
            if not left:
                break
            least = max([offsets.least, *(trial.size for trial in trials.values())])
            last = self._trials | trials
            jobs = [
                (blocks[k], replace(loads[k], least=least), guesses[k], self._exact, last.get(k))
                for k in left
            ]
            for k, (trial, states) in zip(left, run(self._system.search, jobs), strict=True):
                changes += states
                trials[k], guesses[k] = trial, trial.guess
                pressure[k], moved[k] = trial.solution.pressure, trial.solution.moved
            if alone is not None:
                break
        else:
            raise UnsettledError(UNSETTLED)
        return trials, changes

    def _pressed(self, offsets: StickingState, guess: Guess) -> float:
        """Largest pressure between the parts while nothing moves, MPa."""
        places = self._system.places
        sites = np.concatenate([self._system.coupled.blocks[number].sites for number in self._numbers])
        closed = places.normal[sites[~guess.opened[sites] & ~places.bolt[sites]]]
        return float(np.abs(offsets.stress[closed]).max(initial=0.0))

    def _offsets(self, loads: Sequence[Load], gaps: Sequence[Floats]) -> list[StickingState]:
        """Sticking states under loads, from gaps y_J (n_J,) at the beginning of each step."""
        condensed = self._system.condensed
        begin, given = np.stack(gaps, axis=1), np.stack([load.gap for load in loads], axis=1)
        # What is open now follows from the load, not from what was open before.
        begin[self._system.places.normal] = 0.0
        parts = np.stack([load.parts for load in loads], axis=1)
        pins = np.stack([load.pins for load in loads], axis=1)
        left = begin - given[condensed.interface]
        stress, pin_gap = condensed.V @ parts, given[condensed.pins] + condensed.G @ parts
        for number in self._numbers:
            block = self._system.coupled.blocks[number]
            by_slip = self._system.coupled.slipped(number, left)
            stress[block.interface] += by_slip[0]
            pin_gap[block.pins] += by_slip[1]
        forces = np.concatenate([pins, self._system.pin_held @ parts]) / self._system.scale[:, None]
        columns = (np.ascontiguousarray(columns_of.T) for columns_of in (stress, pin_gap, forces, begin))
        return [StickingState(*instant) for instant in zip(*columns, strict=True)]

    def between(
        self, loads: Sequence[Load], increments: tuple[ContactState, ContactState], shares: Sequence[float]
    ) -> list[ContactState]:
        """Find states between two increments, whose slips they divide by the shares of the way."""
        earlier, later = increments
        gaps = [(1 - share) * earlier.gap + share * later.gap for share in shares]
        states, like = list[ContactState](), earlier
        for load, offsets in zip(loads, self._offsets(loads, gaps), strict=True):
            sticking = replace(like.guess, slipping=np.zeros_like(like.guess.slipping))
            try:
                like = self._solved(load, offsets, sticking, frictional=False)
            except UnsettledError:
                like = Steps(self._system, self._exact, self._numbers).step(load, earlier)
            states.append(like)
        return states
