"""Extremes over a cycle, evaluated only at the instants at which they can occur.

A cycle is a path through the space of unit loads. Between two instants a and b of the path the weights are
w = (1 − s) w_a + s w_b + δ. A convex function f of stress that is positively homogeneous, such as the von
Mises or the largest principal stress, is then at most max(f(σ_a), f(σ_b)) + Σ_k |δ_k| ‖σ_k‖, where ‖σ_k‖
bounds ±f of the unit stress σ_k. Where there are many unit loads, the root of Σ_k δ_k² over some of them,
times the most that unit weights of them can cause, takes the place of their part of the sum.

Every node is evaluated at the ends of the chords of the path; within a chord only if that bound exceeds the
largest value already found at the node. The result is the same as that of evaluating every instant, in a
fifth of the time. Single precision is used: its error is about a hundred times smaller than that of the
superposition.
"""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from fea.analysis.cycle.unit_solutions import PartStress
from fea.judge.history import NO_SIGN, Extremes, deviator_norm, deviatoric, extreme_principals
from fea.machine.threads import side_by_side
from fea.pins.model import NOT_JOINT, JointBounds, Weights
from geometry.arrays import Floats, Ints, Reals

# Instants from one end of a chord to the other.
CHORD = 15
# Allowance for rounding in the bounds on what many unit loads can do together, in single precision.
_ROUNDING = 1e-3


@dataclass(frozen=True)
class Path:
    """The instants of a cycle in order."""

    weights: Weights  #: at every instant
    ends: Ints  #: (n_chords + 1,) the instants at which chords begin and end
    strays: Weights  #: (m, n_chords) largest sizes of δ, as of `sizes`, of the even and the odd weights
    joint: JointBounds  #: unit loads whose deviations are bounded jointly

    def at_ends(self) -> Weights:
        """Weights at the ends of the chords."""
        return self.weights.at(self.ends)

    def inside(self, chord: int) -> tuple[slice, Weights]:
        """Instants within a chord, its ends left out, and their weights."""
        inside = slice(int(self.ends[chord]) + 1, int(self.ends[chord + 1]))
        return inside, self.weights.at(inside)


def path(weights: Weights, joint: JointBounds = NOT_JOINT) -> Path:
    """Divide the instants, in the given order, into chords."""
    count = weights.even.shape[1]
    ends = np.unique(np.append(np.arange(0, count, CHORD), count - 1))
    strays = Weights(*(_strays(w, ends, norms) for w, norms in zip(weights, joint, strict=True)))
    return Path(weights, ends, strays, joint)


def sizes(away: Floats, joint: slice) -> Floats:
    """Sizes (m, n) of deviations (n_units, n): of each by itself, then of those bounded jointly."""
    alone = np.abs(np.delete(away, joint, axis=0))
    bounded = np.linalg.norm(away[joint], axis=0, keepdims=True)
    return np.concatenate([alone, bounded]) if away[joint].size else alone


def norms(units: Reals, joint: slice) -> tuple[Reals, Reals]:
    """Largest von Mises stress, and largest mean stress, each (n, m), that deviations of unit size can cause.

    `units` (n, 6, n_units) unit stresses, components of `fea.judge.history`; `joint`: as for `sizes`.
    """
    alone, others = np.delete(units, joint, axis=2), units[..., joint]
    equivalent, mean = deviator_norm(alone), np.abs(alone[:, 5])
    if not others.shape[2]:
        return equivalent, mean
    q = others[:, :5]
    largest = np.linalg.eigvalsh(q @ q.swapaxes(1, 2))[:, -1:]
    furthest = (1 + _ROUNDING) * np.sqrt(np.maximum(largest, 0.0))
    pressed = (1 + _ROUNDING) * np.linalg.norm(others[:, 5], axis=1, keepdims=True)
    return np.concatenate([equivalent, furthest], axis=1), np.concatenate([mean, pressed], axis=1)


def _strays(weights: Floats, ends: Ints, joint: slice) -> Floats:
    instants = np.arange(weights.shape[1])
    chord = np.clip(np.searchsorted(ends, instants, side="right") - 1, 0, max(len(ends) - 2, 0))
    after = np.minimum(chord + 1, len(ends) - 1)
    share = (instants - ends[chord]) / np.maximum(ends[after] - ends[chord], 1)
    straight = (1 - share) * weights[:, ends[chord]] + share * weights[:, ends[after]]
    away = sizes(weights - straight, joint)
    return np.maximum.reduceat(away, ends[:-1], axis=1) if len(ends) > 1 else away[:, :0]


# Number of times that a ball grows.
GROWTHS = 4


def distances_from_middle(paths: Reals, start: Reals) -> Reals:
    """Distances (n, n_points) of the points of paths from the centre of an almost smallest enclosing ball.

    It starts half-way from `start` to the point farthest from it, and grows towards points outside (Ritter
    1990). The largest distance is the radius of a ball that encloses all points.

    `paths` (n, n_dimensions, n_points); `start` (n, n_dimensions), a point on the surface: the longest vector
    of each path.
    """
    squares = np.einsum("nct,nct->nt", paths, paths)
    rows, center = np.arange(len(paths)), start
    radius = np.zeros(len(paths), paths.dtype)
    for _ in range(GROWTHS):
        far = paths[rows, :, _square_distances(paths, squares, center).argmax(axis=1)]
        away = np.linalg.norm(far - center, axis=1)
        radius = np.maximum(radius, (radius + away) / 2)
        step = np.maximum(1 - radius / np.maximum(away, _TINY), 0)
        center = center + step[:, None] * (far - center)
    return np.asarray(np.sqrt(np.maximum(_square_distances(paths, squares, center), 0)))


def _square_distances(paths: Reals, squares: Reals, center: Reals) -> Reals:
    along = (center[:, None] @ paths)[:, 0]
    return np.asarray(squares - 2 * along + (center**2).sum(axis=1)[:, None])


# Bytes of stress at the ends of chords that each thread computes at a time; the quantities derived from it
# take about three times as much.
BLOCK_BYTES = 4 * 2**20
# Avoids a division by zero at a place without stress, MPa.
_TINY = 1e-30


@dataclass(frozen=True)
class ExtremeBounds(Extremes):
    """Extremes, and bounds for Crossland's criterion, each (n,), MPa."""

    radius: Any  #: of a ball, not quite the smallest, that encloses the path of the deviatoric vectors
    tension: Any  #: upper bound of the largest mean (hydrostatic) stress


def extremes(parts: Sequence[PartStress], path: Path, sides: tuple[int, ...]) -> list[list[ExtremeBounds]]:
    """Find the extremes at every node of each part, and of its image across y = 0 (side −1)."""

    def block(item: tuple[PartStress, slice]) -> list[ExtremeBounds]:
        found = NodeBlock(*item, path, sides)
        reach = found.extremes()
        return [_rows(reach, found.count, number) for number in range(len(sides))]

    every = [(part, rows) for part in parts for rows in _rows_at_once(part, path, sides)]
    blocks = iter(side_by_side(block, every))
    of_parts = [list(islice(blocks, len(_rows_at_once(part, path, sides)))) for part in parts]
    return [[_joined(of_side) for of_side in zip(*images, strict=True)] for images in of_parts]


def signed_extremes(part: PartStress, path: Path, sides: tuple[int, ...]) -> Floats:
    """Highest and lowest signed equivalent stress (n_sides, 2, n) alone, which takes half the time."""

    def block(rows: slice) -> Reals:
        found = NodeBlock(part, rows, path, sides, lambda stress: deviator_norm(stress)[None])
        return np.reshape(found.signed(), (2, len(sides), -1))

    blocks = list(side_by_side(block, _rows_at_once(part, path, sides)))
    return np.concatenate(blocks, axis=2, dtype=np.float64).swapaxes(0, 1)


def _rows_at_once(part: PartStress, path: Path, sides: tuple[int, ...]) -> list[slice]:
    rows = max(1, BLOCK_BYTES // (len(sides) * 6 * 4 * len(path.ends)))
    return [slice(start, start + rows) for start in range(0, len(part.nodes), rows)]


class NodeBlock:
    """Some nodes of a part and their images, over a path.

    `rows`: of the part's nodes; `sides`: 1 for the nodes, −1 for their images across y = 0: rows of what is
    found are those of the first side, then of the next; `measures`: what is found of stress (n, 6,
    n_instants), the von Mises stress first, as of `stress_measures`.
    """

    def __init__(
        self,
        part: PartStress,
        rows: slice,
        path: Path,
        sides: tuple[int, ...],
        measures: Callable[[Reals], Reals] | None = None,
    ) -> None:
        units = [deviatoric(unit[rows]).astype(np.float32) for unit in (part.even, part.odd)]
        (self._even, self._odd), self._path, self._sides = units, path, sides
        self.count, self._measures = len(self._even), measures or stress_measures
        self._at_ends = superposed(self._even, self._odd, self._sides, path.at_ends())
        bounds = [_bounds(*item) for item in zip(units, path.strays, path.joint, strict=True)]
        # (3, n_rows, n_chords): of the von Mises, the largest and the negative least principal stress.
        self._strays = np.concatenate([bounds[0] + bounds[1]] * len(sides), axis=1)[[0, 1, 1]]

    def signed(self) -> tuple[Any, Any]:
        """Highest and lowest signed equivalent stress of every row."""
        largest, _, worst = self._largest()
        return self._signed(largest[0], worst)

    def extremes(self) -> ExtremeBounds:
        """Find the extremes of every row, including principal stresses."""
        largest, instant, worst = self._largest()
        highest, lowest = self._signed(largest[0], worst)
        distance = distances_from_middle(self._at_ends[:, :5], worst[:, :5])
        radius = (_at_either_end(distance) + self._strays[0]).max(axis=1)
        strays = self._strays[1] - 2 / 3 * self._strays[0]
        tension = (_at_either_end(self._at_ends[:, 5]) + strays).max(axis=1)
        return ExtremeBounds(
            von_mises=largest[0],
            instant=instant,
            principal_1=largest[1],
            principal_3=-largest[2],
            highest=highest,
            lowest=lowest,
            radius=np.minimum(radius, largest[0]),
            tension=np.minimum(tension, largest[1]),
        )

    def _signed(self, largest: Reals, worst: Reals) -> tuple[Any, Any]:
        # The least von Mises stress is negative where the stress points against the worst. It is at least the
        # component of q along the worst q, whose deviation from its chord has the same bound.
        direction = worst[:, None, :5] / np.maximum(largest, _TINY)[:, None, None]
        along = (direction @ self._at_ends[:, :5])[:, 0]
        equivalent = deviator_norm(self._at_ends)
        against = -np.copysign(equivalent, along).min(axis=1)
        straight = _at_either_end(-along) + self._strays[0]
        upper = np.where(straight < 0, straight, _at_either_end(equivalent) + self._strays[0])
        for rows, _, stress in self._inside(upper[None], against[None]):
            along = (direction[rows] @ stress[:, :5])[:, 0]
            signed = np.copysign(deviator_norm(stress), along)
            against[rows] = np.maximum(against[rows], -signed.min(axis=1))
        least = -against
        compressed = worst[:, 5] < -NO_SIGN * largest
        return np.where(compressed, -least, largest), np.where(compressed, -largest, least)

    def _largest(self) -> tuple[Reals, Ints, Reals]:
        """Largest measures (k, n_rows); instant and stress (n_rows, 6) of the largest von Mises stress."""
        at_ends = self._measures(self._at_ends)
        end = at_ends[0].argmax(axis=1)
        instant, worst = self._path.ends[end], self._at_ends[np.arange(len(end)), :, end]
        largest = at_ends.max(axis=2)
        upper = _at_either_end(at_ends) + self._strays[: len(at_ends)]
        for rows, start, stress in self._inside(upper, largest):
            inside = self._measures(stress)
            best = inside[0].argmax(axis=1)
            highest = inside.max(axis=2)
            more = highest[0] > largest[0, rows]
            instant[rows[more]] = start + best[more]
            worst[rows[more]] = stress[more, :, best[more]]
            largest[:, rows] = np.maximum(largest[:, rows], highest)
        return largest, instant, worst

    def _inside(self, upper: Reals, reached: Reals) -> Iterator[tuple[Ints, int, Reals]]:
        """Yield rows, first instant and stress (m, 6, n) inside chords that may exceed known maxima.

        `upper` (k, n_rows, n_chords) bounds of k quantities; `reached` (k, n_rows) largest values found so
        far; they may grow during the iteration.
        """
        for chord in range(upper.shape[2]):
            rows = np.flatnonzero((upper[..., chord] > reached).any(axis=0))
            instants, weights = self._path.inside(chord)
            if rows.size and weights.even.size:
                image, node = np.divmod(rows, len(self._even))
                side = np.asarray(self._sides, self._even.dtype)[image, None, None]
                nodes, place = np.unique(node, return_inverse=True)  # both images share the products
                even, odd = product(self._even[nodes], weights.even), product(self._odd[nodes], weights.odd)
                stress = side * odd[place]
                stress += even[place]
                yield rows, instants.start, stress


def superposed(even: Reals, odd: Reals, sides: tuple[int, ...], weights: Weights) -> Reals:
    """Stress (n_sides·n, 6, n_instants) of even and odd units (n, 6, n_units), side after side."""
    of_even, of_odd = product(even, weights.even), product(odd, weights.odd)
    return np.concatenate([of_even + of_odd if side > 0 else of_even - of_odd for side in sides])


def product(units: Reals, weights: Reals) -> Reals:
    """Stress (n, 6, n_instants): units (n, 6, n_units) times weights (n_units, n_instants)."""
    flat = units.reshape(-1, units.shape[2])  # one product for all nodes
    return np.reshape(flat @ weights.astype(units.dtype), (len(units), 6, -1))


def stress_measures(stress: Reals) -> Reals:
    """Von Mises, largest and negative least principal stress (3, n, n_instants)."""
    equivalent = deviator_norm(stress)
    largest, least = extreme_principals(stress, equivalent)
    return np.stack([equivalent, largest, -least])


def _bounds(units: Reals, strays: Reals, joint: slice) -> Reals:
    """Bounds (2, n, n_chords) on von Mises and principal stresses of the deviations from the chords."""
    equivalent, mean = norms(units, joint)
    strays = strays.astype(units.dtype)
    return np.stack([equivalent @ strays, (mean + 2 / 3 * equivalent) @ strays])


def _at_either_end(values: Reals) -> Reals:
    return np.maximum(values[..., :-1], values[..., 1:])


def _rows(reach: ExtremeBounds, count: int, number: int) -> ExtremeBounds:
    rows = slice(number * count, (number + 1) * count)
    return ExtremeBounds(
        **{field.name: getattr(reach, field.name)[rows] for field in dataclasses.fields(ExtremeBounds)}
    )


def _joined(blocks: tuple[ExtremeBounds, ...]) -> ExtremeBounds:
    def every(name: str) -> Any:
        values = np.concatenate([getattr(block, name) for block in blocks])
        return values if name == "instant" else values.astype(np.float64)

    return ExtremeBounds(**{field.name: every(field.name) for field in dataclasses.fields(ExtremeBounds)})
