"""A journal in its film: where it is under a load, and how the film and the bore respond, step by step."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fea.film.constitutive import Asperities, Oil
from fea.film.reynolds import Conditions, FilmState, OilBalance, Reynolds, Supply
from fea.solid.errors import FilmError
from geometry.arrays import Floats

# Largest number of Newton's steps; about four are usual.
_STEPS = 120
# Relative changes of pressure and gap squared, and change of the filling times that of the gap, at which the
# iteration ends: the oil's balance is about as linear, so that they estimate the error that is left; ten
# times as much lost 1 % of the oil of films that meet a hole. And what may be missing of the load, relative
# to the integral of the pressure.
_TOLERANCE, _MISSED = 3e-6, 1e-5
# Oil that a state may lose, of what flows in and out, unless it has been bettered so often: through a hole, a
# small error of the pressure drives much oil.
_LOST, _BETTERED = 3e-4, 2
# The first instant of a squeezed film, relative to the time in which the journal crosses the clearance.
_INSTANT = 1e-6
# What rounding may leave of a full cell.
_FULL = 1e-9
# What is left of a step by an earlier response, and the most tries to find it; and after how many steps
# each has its own response, as those that are hard to find need.
_EXACT, _TRIES, _HARD = 2e-4, 8, 7
# Largest change of a gap in one step, in clearances, and in the hard ones: little oil hardly holds a journal;
# and steps of the film alone after each of those.
_LARGEST, _CAREFUL, _SETTLING = 3.0, 0.3, 2
# Smallest part of its gap that a cell keeps in one step; rough surfaces come nearer by this share of their
# roughness at least, and smooth ones meet at this gap, in clearances. And the gap, over the roughness, that a
# hole keeps: nothing resists what bulges into it, which does not cut it off.
_KEPT, _NEARER, _MET, _OPEN = 0.25, 0.25, 1e-9, 0.1


@dataclass(frozen=True)
class ElasticBore:
    """The bore's radial displacement as a sum of smooth functions of angle and width.

    Of a pressure p, the pressures' weights are a = ∫ φ p dA over the bore; the displacement, positive
    outwards, has the weights C a + g, where g is caused by everything else that acts on the rod.
    """

    functions: Floats  #: (n_angle, n_width, n) means of φ over each cell, 1/mm, with ∫ φᵢ φⱼ dA = δᵢⱼ
    ends: Floats  #: (n_angle, n_ends, n) φ at the ends of the bearing that `FilmGrid.ends` names, 1/mm
    compliance: Floats  #: (n, n) C, mm³/N; rows of the functions that move the bore as a whole are zero


@dataclass(frozen=True)
class _Response:
    """How displacement and position answer what is unbalanced, of an earlier film of the same bearing."""

    inverse: Floats  #: (n + 2, n + 2), or n + 4 with tilts

    def solved(
        self, responding: Callable[[Floats], Floats], side: Floats
    ) -> tuple["_Response", Floats] | None:
        """Solve equations like those of the inverse by conjugate residuals; None: not in a few steps.

        What they answered on the way betters the inverse: it is exact there.
        """
        left = (self.inverse @ side)[:, 0]
        solution, enough = np.zeros_like(left), _EXACT**2 * float(left @ left)
        ways, gains = np.zeros((2, _TRIES, len(left)))
        for number in range(_TRIES):
            way, gain = left, (self.inverse @ responding(left[:, None]))[:, 0]
            share = gains[:number] @ gain
            way, gain = way - share @ ways[:number], gain - share @ gains[:number]
            length = math.sqrt(gain @ gain)
            if not length > 0:
                break
            ways[number], gains[number] = way / length, gain / length
            share = gains[number] @ left
            solution, left = solution + share * ways[number], left - share * gains[number]
            if left @ left <= enough:
                better = (ways - gains).T @ (gains @ self.inverse)
                return _Response(self.inverse + better), np.asarray(solution[:, None])
        return None


@dataclass(frozen=True)
class JournalState:
    """A journal, its film and its bore at an instant."""

    film: FilmState
    planes: Floats  #: (n_angle, n_width) gap between the mean planes of the surfaces, mm
    position: Floats  #: (k,) of the journal in the bore, mm: see `FilmGrid.outwards_at`
    bulge: Floats  #: (n,) weights of the bore's displacement
    bearing: "Bearing"
    conditions: Conditions
    response: _Response | None = None  #: with which the next state is found
    parts: Sequence["JournalState"] = ()  #: earlier states of the step, where that was solved in equal parts

    @cached_property
    def space(self) -> tuple[Floats, Floats]:
        """Gap h (n_angle, n_width) that oil can fill, mm, and its derivative: see `Bearing.space`."""
        return self.bearing.space(self.planes, self.conditions.supply)

    @property
    def gap(self) -> Floats:
        """Gap h (n_angle, n_width) that oil can fill, mm."""
        return self.space[0]

    @cached_property
    def edge(self) -> Floats:
        """Gap (n_angle, n_ends) at the ends of the bearing, where a bent bore comes nearest, mm."""
        grid = self.bearing.reynolds.grid
        planes = self.bearing.clearance - grid.outwards_at(grid.ends) @ self.position
        if self.bearing.bore is not None:
            planes = planes + self.bearing.bore.ends @ self.bulge
        return self.bearing.space(planes)[0]

    @property
    def thinnest(self) -> float:
        """Smallest gap, mm, of the cells that holes do not fill and at the ends of the bearing."""
        supply = self.conditions.supply
        gap = self.gap if supply is None else self.gap[supply.land > 0]
        return float(min(gap.min(), self.edge.min()))

    @cached_property
    def balance(self) -> OilBalance:
        """How the oil flows."""
        return self.bearing.reynolds.balance(self.film, self.gap, self.conditions)

    @cached_property
    def flows(self) -> Floats:
        """Oil supplied and leaked, mm³/s, and power brought, N·mm/s (3,), in the mean of the step's parts."""
        balances = [state.balance for state in (*self.parts, self)]
        flows = [(each.supplied, each.leaked, each.brought) for each in balances]
        return np.asarray(np.mean(flows, axis=0))

    @cached_property
    def friction(self) -> tuple[float, float]:
        """Force against the journal's motion, N, and the power of shear and rubbing, N·mm/s."""
        speed, reynolds, asperities = self.conditions.speed, self.bearing.reynolds, self.bearing.asperities
        rubbed = asperities.friction * reynolds.grid.total(self.touching) if asperities else 0.0
        force, power = reynolds.friction(self.film, self.gap, speed)
        return force + math.copysign(rubbed, speed), power + rubbed * abs(speed)

    @cached_property
    def contact(self) -> tuple[Floats, Floats]:
        """Pressure (n_angle, n_width) of asperities, MPa, and its derivative: see `Bearing.touching`."""
        return self.bearing.touching(self.planes, self.conditions.supply)

    @property
    def touching(self) -> Floats:
        """Pressure (n_angle, n_width) of asperities, MPa."""
        return self.contact[0]

    @property
    def pressure(self) -> Floats:
        """Pressure (n_angle, n_width) of the oil and of asperities on the bore, MPa."""
        return self.film.pressure + self.touching

    def unlike(self, other: "JournalState") -> float:
        """Largest change of the distances over the smallest gap or the roughness, or of the oil over it."""
        scale = max(self.gap.min(), self.bearing.asperities.roughness if self.bearing.asperities else 0.0)
        apart = np.abs(self.planes - other.planes).max() / scale
        return float(max(apart, np.abs(self.volume - other.volume).sum() / self.volume.sum()))

    @property
    def volume(self) -> Floats:
        """Oil θh (n_angle, n_width), mm."""
        return self.film.fill * self.gap

    def close_to(self, other: "JournalState") -> bool:
        """Whether the same cells are full, and the changes of pressures, filling and gaps are small."""
        new, old, bearing = self.film.pressure, other.film.pressure, self.bearing
        pressed = np.abs(new - old).max() / (max(new.max(), old.max()) or 1.0)
        wider = (np.abs(self.gap - other.gap) / np.maximum(other.gap, _MET * bearing.clearance)).max()
        filled = np.abs(self.film.fill - other.film.fill).max()
        same = (self.film.full == other.film.full).all()
        return bool(same and filled * wider + (pressed + wider) ** 2 <= bearing.slack * _TOLERANCE)

    def ahead(self, start: "JournalState", end: "JournalState") -> "JournalState":
        """Guess of the state a step later, if it changes as from a start to an end."""
        return replace(
            self,
            film=self.film.ahead(start.film, end.film),
            planes=np.maximum(self.planes + end.planes - start.planes, self.planes / 2),
            position=self.position + end.position - start.position,
            bulge=self.bulge + end.bulge - start.bulge,
        )


@dataclass(frozen=True)
class Bearing:
    """A film, the clearance of the round journal in the round bore, and how the bore yields."""

    reynolds: Reynolds
    clearance: float  #: radial, mm
    bore: ElasticBore | None = None
    asperities: Asperities | None = None  #: None of smooth surfaces
    slack: float = 1.0  #: by how much more than usual its steps and its repetition may lack

    def touching(self, planes: Floats, supply: Supply | None) -> tuple[Floats, Floats]:
        """Pressure of asperities at gaps between mean planes, MPa, and its derivative, MPa/mm, on land."""
        if self.asperities is None:
            return np.zeros_like(planes), np.zeros_like(planes)
        pressure, slope = self.asperities.pressure(planes)
        land = 1.0 if supply is None else supply.land
        return pressure * land, slope * land

    def space(self, planes: Floats, supply: Supply | None = None) -> tuple[Floats, Floats]:
        """Gap that oil can fill between mean planes at distances (n_angle, n_width), and its derivative."""
        if self.asperities is None:
            return planes, np.ones_like(planes)
        gap, widens = self.asperities.space(planes)
        kept = 0.0 if supply is None else _OPEN * self.asperities.roughness * supply.share
        space = np.hypot(gap, kept)
        return space, widens * gap / space

    def with_oil(self, oil: Oil) -> "Bearing":
        """The same with another oil."""
        return replace(self, reynolds=replace(self.reynolds, oil=oil))

    def yielding_by(self, compliance: Floats) -> "Bearing":
        """The same with another compliance of its elastic bore."""
        return replace(self, bore=self.bore and replace(self.bore, compliance=compliance))

    def taken_over(self, state: "JournalState") -> "JournalState":
        """A state of the same bearing on another grid, on this one."""
        grid = self.reynolds.grid
        turns = [np.arange(n + 1) / n for n in (len(state.gap), grid.n_angle)]
        across = [state.bearing.reynolds.grid.z, grid.z]

        def on_grid(values: Floats) -> Floats:
            closed = np.concatenate([values, values[:1]])
            along = np.array([np.interp(across[1], across[0], row) for row in closed])
            return np.array([np.interp(turns[1][:-1], turns[0], column) for column in along.T]).T

        fill = on_grid(state.film.fill)
        full = fill > 1 - _FULL
        film = FilmState(np.where(full, on_grid(state.film.pressure), 0.0), fill, full)
        planes = np.maximum(self.planes(state.position, state.bulge), state.planes.min())
        return JournalState(film, planes, state.position, state.bulge, self, Conditions(0.0))

    def planes(self, position: Floats, bulge: Floats) -> Floats:
        """Gap between mean planes (n_angle, n_width), mm, of a journal at a position (k,) in the bore."""
        h = self.clearance - self.reynolds.grid.outwards @ position
        return np.asarray(h if self.bore is None else h + self.bore.functions @ bulge)

    def start(self, position: Sequence[float] = (0.0, 0.0)) -> JournalState:
        """A film without pressure round a journal at a position."""
        film, place = FilmState.at_rest(self.reynolds.grid), np.zeros(self.reynolds.grid.outwards.shape[-1])
        place[: len(position)] = position
        bulge = np.zeros(0 if self.bore is None else len(self.bore.compliance))
        return JournalState(film, self.planes(place, bulge), place, bulge, self, Conditions(0.0))

    def solve(
        self,
        guess: JournalState,
        conditions: Conditions,
        *,
        load: Floats | None = None,
        loaded: Floats | None = None,
    ) -> JournalState:
        """Solve film, bore and position together by Newton's method, where the active set is what is full.

        `guess`: where the iteration begins; without a load, its position is kept; `load`: force (2,) of the
        film on the bore, N, or (4,) with the moments, 0 by default, of a journal that may tilt, over half the
        width; `loaded`: g (n,) of `ElasticBore`. Raises `FilmError`: the iteration did not end.
        """
        at, bettered = replace(guess, bearing=self, conditions=conditions, parts=()), 0
        if loaded is None:
            loaded = np.zeros_like(guess.bulge)
        for step in range(_STEPS):
            hard = step >= _HARD
            before = replace(at, response=None) if hard else at
            try:
                at, limited = self._improved(before, load, loaded, _CAREFUL if hard else _LARGEST)
                at = self._settled(at, load) if hard else at
            except np.linalg.LinAlgError as error:
                raise FilmError("the equations of the oil film are singular") from error
            if self.asperities is None and at.planes.min() < _MET * self.clearance:
                raise FilmError("smooth surfaces meet, which only oil keeps apart. Give film.roughness_um")
            if limited or not at.close_to(before):
                continue
            off, pressed = self._unbalanced(at, load)
            if off <= self.slack * _MISSED * pressed:
                flows = at.balance.supplied + at.balance.leaked
                if bettered == _BETTERED or at.balance.lost <= self.slack * _LOST * flows:
                    return at
                bettered += 1
        raise FilmError(f"no balance within {_STEPS} steps. Reduce the load or check roughness and clearance")

    def _unbalanced(self, at: JournalState, load: Floats | None) -> tuple[float, float]:
        """What pressures on the bore, of oil and asperities, lack of the load, and their integral, N."""
        count, pressed = len(at.bulge), self.reynolds.grid.total(at.pressure)
        off = 0.0 if load is None else self._works[count : count + len(load)] @ at.pressure.ravel() + load
        return float(np.abs(off).max()), pressed

    def _settled(self, at: JournalState, load: Floats | None) -> JournalState:
        """The same with a film closer to that at these gaps, if that bears the load better."""
        film = at.film
        for _ in range(_SETTLING):
            balance = self.reynolds.balance(film, at.gap, at.conditions)
            change = self.reynolds.stencil.solver(balance.by_film)(-balance.excess.reshape(-1, 1))
            film = film.changed(change.reshape(film.full.shape), self.reynolds.oil)
        return min((replace(at, film=film), at), key=lambda each: self._unbalanced(each, load)[0])

    @cached_property
    def _follows(self) -> Floats:
        """Change (n_cells, n + k) of the gap by the bore's weights and the journal's position."""
        grid = self.reynolds.grid
        cells = grid.outwards.reshape(grid.n_angle * grid.n_width, -1)
        bore = np.zeros((len(cells), 0)) if self.bore is None else self.bore.functions.reshape(len(cells), -1)
        return np.concatenate([bore, -cells], axis=1)

    @cached_property
    def _works(self) -> Floats:
        """Displacement by a pressure in each cell, and its work on those positions (n + k, n_cells)."""
        grid = self.reynolds.grid
        areas = np.broadcast_to(grid.images * grid.area, grid.shape)
        works = np.ascontiguousarray((areas.reshape(-1, 1) * self._follows).T)
        if self.bore is not None:
            count = len(self.bore.compliance)
            works[:count] = self.bore.compliance @ works[:count]
        return works

    def _improved(
        self, at: JournalState, load: Floats | None, loaded: Floats, most: float
    ) -> tuple[JournalState, bool]:
        """One of Newton's steps, and whether it was limited.

        The film is eliminated first: what it does to the oil's balance is a band matrix. What is left is the
        bore's displacement and the position, whose equations are the bore's compliance and the load. In hard
        steps, springs hold the journal, too: full cells at one angle alone do not hold it along the gap.
        """
        grid, count = self.reynolds.grid, len(at.bulge)
        unknowns = count + (len(at.position) if load is not None else 0)
        follows, works = self._follows[:, :unknowns], self._works[:unknowns]
        (gap, widens), (touching, slope) = at.space, at.contact
        balance, stencil = at.balance, self.reynolds.stencil
        ajar = at.planes - self.planes(at.position, at.bulge)  # what an earlier limited step left open
        full, stiffness = at.film.full.reshape(-1, 1), slope.reshape(-1, 1)
        by_planes = stencil.matrix(balance.by_gap, widens)

        def responding(moved: Floats) -> Floats:
            """Left side of the equations of displacements and positions (n + 2 or n + 4, k)."""
            opening = follows @ moved
            found = works @ (solve(by_planes @ opening) * full - stiffness * opening)
            found[:count] += moved[:count]
            found[count:] += held * moved[count:]
            return found

        solve = stencil.solver(balance.by_film)
        opening = ajar.reshape(-1, 1)
        before = solve(by_planes @ opening - balance.excess.reshape(-1, 1))
        pressures = (at.film.pressure + touching).reshape(-1, 1) + before * full - stiffness * opening
        side = works @ pressures
        side[:count, 0] += loaded - at.bulge
        if load is not None:
            side[count : count + len(load), 0] += load
        hard = most < _LARGEST and load is not None
        held = float(np.abs(side[count:]).max()) / (most * self.clearance) if hard else 0.0
        solved = None
        if at.response is not None and len(at.response.inverse) == unknowns:
            solved = at.response.solved(responding, side)
        if solved is None:
            # Where nothing presses, nothing says where a loaded journal goes: it stays.
            invert = np.linalg.inv if full.any() or touching.any() else np.linalg.pinv
            response = _Response(np.asarray(invert(responding(np.eye(unknowns)))))
            solved = response, response.inverse @ side
        response, solution = solved
        moved = solution[:, 0]
        change = before - solve(by_planes @ (follows @ solution))
        if not np.isfinite(moved).all():
            raise FilmError("the oil film has no finite pressure")
        part, planes, held_open = self._moved(at, (follows @ moved).reshape(grid.shape) - ajar, most)
        space = self.space(planes, at.conditions.supply)[0]
        thinner = np.where(at.film.full, 1.0, gap / space)  # what changes is θh, not θ
        after = replace(
            at,
            film=at.film.changed(part * thinner * change.reshape(grid.shape), self.reynolds.oil),
            planes=planes,
            position=at.position + part * moved[count:] if load is not None else at.position,
            bulge=at.bulge + part * moved[:count],
            response=response,
        )
        return after, part < 1 or held_open

    def _moved(self, at: JournalState, wider: Floats, most: float) -> tuple[float, Floats, bool]:
        """Part of a step that is made, gaps after it, mm, and whether some are held open."""
        supply = at.conditions.supply
        part = 1 / max(1.0, float(np.abs(wider).max()) / (most * self.clearance))
        least, after = _KEPT * at.planes, at.planes + part * wider
        if self.asperities is not None:
            land = 1.0 if supply is None else supply.land + _FULL
            least = np.minimum(least, at.planes - _NEARER * self.asperities.roughness / land)
        return part, np.maximum(after, least), bool((after < least).any())

    def squeezed(self, position: Sequence[float], velocity: Sequence[float]) -> JournalState:
        """A film that is full but for where the journal leaves it: at a position, with a velocity (2,), mm/s.

        It is that of the first instant, so short that the oil does not yet leave the bearing.
        """
        state = self.start(position)
        rate = math.hypot(*velocity) / self.clearance / _INSTANT
        earlier = state.gap + self.reynolds.grid.outwards[..., :2] @ np.array(velocity) / rate
        return self.solve(state, Conditions(0.0, rate=rate, before=rate * earlier))
