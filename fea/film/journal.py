"""A journal in its film: where it is under a load, and how the film and the bore respond, step by step."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fea.film.grid import applied
from fea.film.reynolds import Balance, Conditions, Film, Reynolds
from fea.solid.errors import FilmError
from geometry.arrays import Floats

# Largest number of Newton's steps; about four are usual.
_STEPS = 60
# Relative changes of pressure and gap at which the iteration ends: the error left is about their square.
_TOLERANCE = 1e-6
# The first instant of a squeezed film, relative to the time in which the journal crosses the clearance.
_INSTANT = 1e-6
# Largest change of a gap in one step, in clearances.
_LARGEST = 3.0
# Smallest part of its gap that a cell keeps in one step.
_KEPT = 0.25


@dataclass(frozen=True)
class ElasticBore:
    """The bore's radial displacement as a sum of smooth functions of angle and width.

    Of a pressure p, the pressures' weights are a = ∫ φ p dA over the bore; the displacement, positive
    outwards, has the weights C a + g, where g is caused by everything else that acts on the rod.
    """

    functions: Floats  #: (n_angle, n_width, n) means of φ over each cell, 1/mm, with ∫ φᵢ φⱼ dA = δᵢⱼ
    compliance: Floats  #: (n, n) C, mm³/N; rows of the functions that move the bore as a whole are zero


@dataclass(frozen=True)
class JournalState:
    """A journal, its film and its bore at an instant."""

    film: Film
    gap: Floats  #: h (n_angle, n_width), mm
    position: Floats  #: (2,) of the journal's centre in the bore, mm
    bulge: Floats  #: (n,) weights of the bore's displacement
    balance: Balance
    steps: int  #: of Newton's method

    def unlike(self, other: "JournalState") -> float:
        """Largest difference of the gaps over the smallest gap, or of the oil in the mean over the oil."""
        gaps = np.abs(self.gap - other.gap).max() / self.gap.min()
        return float(max(gaps, np.abs(self.volume - other.volume).sum() / self.volume.sum()))

    @property
    def volume(self) -> Floats:
        """Oil θh (n_angle, n_width), mm."""
        return self.film.fill * self.gap


class _Iterate(NamedTuple):
    """An iterate of Newton's method: what `JournalState` has of it."""

    film: Film
    gap: Floats
    position: Floats
    bulge: Floats

    def close_to(self, other: "_Iterate", clearance: float) -> bool:
        """Whether the same cells are full, and pressures and gaps differ by the tolerance only."""
        new, old = self.film.pressure, other.film.pressure
        return bool(
            (self.film.full == other.film.full).all()
            and np.abs(new - old).max() <= _TOLERANCE * max(new.max(), old.max())
            and np.abs(self.gap - other.gap).max() <= _TOLERANCE * clearance
        )


@dataclass(frozen=True)
class Bearing:
    """A film, the clearance of the round journal in the round bore, and how the bore yields."""

    reynolds: Reynolds
    clearance: float  #: radial, mm
    bore: ElasticBore | None = None

    def gap(self, position: Floats, bulge: Floats) -> Floats:
        """Gap h (n_angle, n_width) of a journal at a position (2,) with the bore's displacement, mm."""
        h = self.clearance - self.reynolds.grid.outwards @ position
        return np.asarray(h if self.bore is None else h + self.bore.functions @ bulge)

    def start(self, position: Sequence[float] = (0.0, 0.0)) -> JournalState:
        """A film without pressure round a journal at a position."""
        film, place = Film.at_rest(self.reynolds.grid), np.array(position, dtype=float)
        bulge = np.zeros(0 if self.bore is None else len(self.bore.compliance))
        gap = self.gap(place, bulge)
        balance = self.reynolds.balance(film, gap, Conditions(0.0))
        return JournalState(film, gap, place, bulge, balance, 0)

    def solve(
        self,
        guess: JournalState,
        conditions: Conditions,
        *,
        load: Floats | None = None,
        loaded: Floats | None = None,
    ) -> JournalState:
        """Solve film, bore and position together by Newton's method, where the active set is what is full.

        Parameters
        ----------
        guess
            Where the iteration begins; without a load, its position is kept.
        load
            Force (2,) of the film on the bore, N.
        loaded
            g (n,) of `ElasticBore`.

        Raises
        ------
        FilmError
            The iteration did not end.
        """
        iterate = _Iterate(guess.film, guess.gap, guess.position, guess.bulge)
        if loaded is None:
            loaded = np.zeros_like(guess.bulge)
        for step in range(1, _STEPS + 1):
            balance = self.reynolds.balance(iterate.film, iterate.gap, conditions)
            before, (iterate, limited) = iterate, self._improved(iterate, balance, load, loaded)
            if not limited and iterate.close_to(before, self.clearance):
                balance = self.reynolds.balance(iterate.film, iterate.gap, conditions)
                return JournalState(*iterate, balance, step)
        raise FilmError(f"the oil film was not solved within {_STEPS} steps. Check the values of [film]")

    @cached_property
    def _follows(self) -> Floats:
        """Change (n_angle, n_width, n + 2) of the gap by the bore's weights and the journal's position."""
        outwards = self.reynolds.grid.outwards
        return -outwards if self.bore is None else np.concatenate([self.bore.functions, -outwards], axis=-1)

    def _improved(
        self, at: "_Iterate", balance: Balance, load: Floats | None, loaded: Floats
    ) -> tuple["_Iterate", bool]:
        """One of Newton's steps, and whether it was limited.

        The film is eliminated first: what it does to the oil's balance is a band matrix. What is left is the
        bore's displacement and the position, whose equations are the bore's compliance and the load.
        """
        grid, count = self.reynolds.grid, len(at.bulge)
        follows = self._follows if load is not None else self._follows[..., :count]
        ajar = at.gap - self.gap(at.position, at.bulge)  # what an earlier limited step left open
        moving = applied(balance.by_gap, np.concatenate([ajar[..., None], follows], axis=-1))
        moving[..., 0] -= balance.excess
        try:
            solved = self.reynolds.stencil.solve(balance.by_film, moving)
            pressures = np.where(at.film.full[..., None], solved, 0.0)
            pressures[..., 0] += at.film.pressure
            # Work of the pressures on displacements: weights of the functions, and minus the force.
            forces = grid.area * grid.images * np.tensordot(follows, pressures, axes=((0, 1), (0, 1)))
            matrix, side = np.eye(follows.shape[-1]), np.zeros(follows.shape[-1])
            if self.bore is not None:
                matrix[:count] += self.bore.compliance @ forces[:count, 1:]
                side[:count] = loaded - at.bulge + self.bore.compliance @ forces[:count, 0]
            if load is not None:
                matrix[count:] = forces[count:, 1:]
                side[count:] = load + forces[count:, 0]
            moved = np.asarray(np.linalg.solve(matrix, side))
        except np.linalg.LinAlgError as error:
            raise FilmError("the equations of the oil film are singular") from error
        if not np.isfinite(moved).all():
            raise FilmError("the oil film has no finite pressure")
        wider = follows @ moved - ajar
        part = min(1.0, _LARGEST * self.clearance / max(float(np.abs(wider).max()), self.clearance))
        gap = at.gap + part * wider
        kept = np.maximum(gap, _KEPT * at.gap)
        film = at.film.changed(part * (solved[..., 0] - solved[..., 1:] @ moved))
        position = at.position + part * moved[count:] if load is not None else at.position
        bulge = at.bulge + part * moved[:count]
        return _Iterate(film, kept, position, bulge), part < 1 or bool((kept > gap).any())

    def squeezed(self, position: Sequence[float], velocity: Sequence[float]) -> JournalState:
        """A film that is full but for where the journal leaves it: at a position, with a velocity (2,), mm/s.

        It is that of the first instant, so short that the oil does not yet leave the bearing.
        """
        state = self.start(position)
        rate = math.hypot(*velocity) / self.clearance / _INSTANT
        earlier = state.gap + self.reynolds.grid.outwards @ np.array(velocity) / rate
        return self.solve(state, Conditions(0.0, rate=rate, before=rate * earlier))
