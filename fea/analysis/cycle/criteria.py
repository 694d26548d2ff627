"""Bounds of the safety factors of places whose stress is known to an error, and what must be exact.

A small basis leaves out a part of the pressures: stress over a cycle errs by a known part of the largest
stress. So every place whose factor may be the smallest is evaluated again. At these places the error of each
instant is known: the pressure that the basis leaves out then, times the stress per pressure found there. Each
criterion gives the least that the factor of a place can be, and the instants that leave it in doubt, at which
the stress that decides may occur. The instants that make the factors, and any other that could change the
smallest one, join the basis, in which they are exact, until none is left.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.basis import SmallBasis
from fea.analysis.cycle.envelope import Envelope
from fea.analysis.cycle.rows import PartRows, SpannedRod
from fea.judge.fatigue import crossland_bound, enclosing_balls
from fea.judge.history import NO_SIGN, deviator_norm
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import MirroredMesh

# How exactly the smallest factors are found, relative.
WITHIN = 1e-4
# Places in doubt for which instants are solved at once.
_AT_ONCE = 10
_TINY = 1e-30  # a stress that is nothing, MPa


class FactorBounds(NamedTuple):
    """What is known of the factors of places."""

    least: Floats  #: (n,) lower bounds; the factors where no instant is needed
    needed: Mask  #: (n, n_instants) instants that must be exact to know them
    making: Ints  #: (n, k) instants that make them, as far as is known

    def doubtful(self, best: float) -> tuple[float, Ints]:
        """The smallest factor known, `best` at most, and some places in doubt that may have a smaller."""
        open_ = self.needed.any(axis=1)
        best = min(best, float(self.least[~open_].min(initial=np.inf)))
        low = np.flatnonzero(open_ & (self.least < best * (1 - WITHIN / 2)))
        return best, low[np.argsort(self.least[low])[:_AT_ONCE]]


# Judges rows of a part by histories (n, 6, n_instants) with errors (2, n, n_instants), of von Mises and of
# mean stress, MPa. Factors are infinite if strengths are not known.
Judge = Callable[[PartRows, Ints, Floats, Floats], FactorBounds]


def yield_bounds(part: PartRows, _rows: Ints, history: Floats, errors: Floats) -> FactorBounds:
    """Judge against yielding: see `Judge`."""
    size = deviator_norm(history)
    error = _counting(errors[0], size.max(axis=1))
    largest = (size + error).max(axis=1)
    factors = part.yielding_factor(largest, largest)
    return FactorBounds(factors, _longest(size, error), size.argmax(axis=1)[:, None])


def fatigue_bounds(part: PartRows, rows: Ints, history: Floats, errors: Floats) -> FactorBounds:
    """Judge against fatigue: see `Judge`.

    The longest q is that of one of the instants whose upper bound exceeds the largest lower one. From there
    the sign of q · q* at every instant is known, or not, and with it an interval for the least signed stress.
    The utilisation is convex in it, so that the smaller of the factors at its ends counts.
    """
    size, numbers = deviator_norm(history), np.arange(len(rows))
    first = size.argmax(axis=1)
    worst, reached = history[numbers, :5, first], np.maximum(size[numbers, first], _TINY)[:, None]
    along = ((worst / reached)[:, None] @ history[:, :5])[:, 0]
    signed = np.copysign(size, along)
    error = _counting(errors[0], (signed.max(axis=1) - signed.min(axis=1)) / 2)
    upper, lower = size + error, np.maximum(size - error, 0)
    longest, largest = _longest(size, error), upper.max(axis=1)
    away = np.sqrt(np.maximum(size**2 + reached**2 - 2 * along * reached, 0)) + error
    margin = error + upper * np.where(longest, away, 0).max(axis=1, keepdims=True) / reached
    below = np.where(along < margin, -upper, lower)
    least, most = below.min(axis=1), np.where(along < -margin, -lower, upper).min(axis=1)
    unsettled = np.asarray(longest.any(axis=1))
    compressed = ~unsettled & (history[numbers, 5, first] < -NO_SIGN * reached[:, 0])
    ends = (
        part.fatigue_factor(np.where(compressed, -end, largest), np.where(compressed, -largest, end), rows)
        for end in (least, most)
    )
    deciding = (below <= most[:, None]) & (error > 0)
    needed = np.where(unsettled[:, None], longest, deciding)
    return FactorBounds(np.minimum(*ends), needed, np.stack([first, signed.argmin(axis=1)], axis=1))


def crossland_bounds(part: PartRows, rows: Ints, history: Floats, errors: Floats) -> FactorBounds:
    """Judge by Crossland's criterion: see `Judge`.

    A ball encloses the path if it encloses every point with its error. It is the smallest if the points that
    carry it are exact, which none is whose upper bound exceeds the largest lower one.
    """
    radius, center = enclosing_balls(history[:, :5])
    away, mean = np.linalg.norm(history[:, :5] - center[..., None], axis=1), history[:, 5]
    error, pressed = (_counting(own, radius) for own in errors)
    outside, tension = (away + error).max(axis=1), (mean + pressed).max(axis=1)
    factors = crossland_bound(outside, tension, part.material, part.surface(rows))
    least = np.full(len(rows), np.inf) if factors is None else factors
    making = np.stack([away.argmax(axis=1), mean.argmax(axis=1)], axis=1)
    return FactorBounds(least, _longest(away, error) | _longest(mean, pressed), making)


def _counting(error: Floats, scale: Floats) -> Floats:
    """Errors (n, n_instants), 0 where they are nothing beside the stress (n,) that decides."""
    return np.where(error > WITHIN / 2 * scale[:, None], error, 0.0)


def _longest(value: Floats, error: Floats) -> Mask:
    """Instants (n, n_instants) that are not exact and may have the largest value."""
    return np.asarray((value + error > (value - error).max(axis=1, keepdims=True)) & (error > 0))


# Places whose factor exceeds the smallest by more than so many errors of the basis are not looked at again;
# and at most so many of them are.
_ERRORS, _MOST_PLACES = 4, 1000
# Instants that join the basis at a time, and how often.
_JOINING, _ROUNDS = 12, 12


def critical_places(found: Envelope, whole: MirroredMesh, counts: Mask, error: float) -> dict[Judge, Ints]:
    """Nodes of the cell with the smallest factors by each criterion that can be judged.

    `counts` (n_nodes,) of the whole rod; `error` of the basis, MPa.
    """
    factors = {
        yield_bounds: 1 / np.maximum(found.usage, _TINY),
        fatigue_bounds: found.fatigue_factor,
        crossland_bounds: found.crossland_factor,
    }
    places: dict[Judge, Ints] = {}
    for judge, factor in factors.items():
        if factor is None or not np.isfinite(judged := np.where(counts, factor, np.inf)).any():
            continue
        judged = np.nan_to_num(judged, nan=np.inf)
        worst = int(judged.argmin())
        stress = found.von_mises[worst] if judge is yield_bounds else found.amplitude[worst]
        margin = 1 + _ERRORS * error / max(float(stress), _TINY)
        order = np.argsort(judged)[:_MOST_PLACES]
        places[judge] = np.unique(whole.source[order[judged[order] <= margin * judged[worst]]])
    return places


def make_exact(rod: SpannedRod, basis: SmallBasis, full: Weights, places: Mapping[Judge, Ints]) -> bool:
    """Let the basis grow until the smallest factor of each criterion is exact; whether it became so.

    `basis`: that of the rod; `full`: weights of the full unit loads at the instants of the cycle;
    `places`: as of `critical_places`.
    """
    for attempt in range(_ROUNDS):
        pressure = basis.pressure(basis.left(full))
        wanted = np.zeros(len(pressure), dtype=bool)
        for judge, nodes in places.items():
            every, best = list(_bounds(rod, basis, full, nodes, judge)), np.inf
            for known in every:
                best, _ = known.doubtful(best)
            for known in every:
                wanted[known.needed[known.doubtful(best)[1]].any(axis=0)] = True
            if attempt == 0:
                least = min(every, key=lambda known: float(known.least.min()))
                wanted[least.making[least.least.argmin()]] = True
        chosen = np.flatnonzero(wanted & (pressure > 0))
        if not chosen.size:
            return True
        basis.exact_at(full.at(np.sort(chosen[np.argsort(-pressure[chosen])[:_JOINING]])))
    return False


def _bounds(
    rod: SpannedRod, basis: SmallBasis, full: Weights, nodes: Ints, judge: Judge
) -> Iterator[FactorBounds]:
    """Judge both sides of the nodes of each part."""
    pressure, weights = basis.pressure(basis.left(full)), basis.projected(full)
    for number, own in enumerate(basis.units.parts):
        there = np.isin(own.nodes, nodes)
        if there.any():
            part = PartRows(rod, number, there)
            influence = np.concatenate(basis.influence(number, np.flatnonzero(there)), axis=1)
            rows, errors = np.arange(len(part.points)), influence[..., None] * pressure
            yield judge(part, rows, part.every(weights), errors)
