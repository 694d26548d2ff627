"""The worst place of a rod at one speed after another, without working out every place at each.

A place is worth looking at only if a bound on its largest von Mises stress says so. At a speed ω between
two anchors the weights of every instant are w = (1 − s) w₀ + s w₁ + δ with s linear in ω², by which inertia
goes; and the von Mises stress is convex and positively homogeneous, a norm of the deviator. So

    σ_vM(ω, t) ≤ (1 − s) M₀ + s M₁ + Σ_k max_t |δ_k| σ_vM,k

at every instant t, where M is no less than the largest at the anchor (by the chords of `fea.cycle.path`)
and σ_vM,k is the equivalent of unit stress k. No place yields before yield / that bound. And with |mean| +
amplitude ≤ max σ_vM, Goodman's and Soderberg's use a/S_e + m/S of a history is at most max(1/S_e, 1/S)
times it, as is Gerber's, which is convex in (a, m) and reaches no more at either end of that segment.

Places are worked out at every degree in the order of their bounds until the next one's bound is no worse than
the worst found: what is left out cannot be the worst.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from fea.assess.crossland import crossland_factors
from fea.assess.deviatoric import deviatoric, extreme_principals
from fea.assess.fatigue import fatigue_factor
from fea.assess.history import signed_equivalent
from fea.assess.safety import CAP, safety_factor
from fea.crank.cycle_table import cycle_angles
from fea.cycle.analysis import CycleAnalysis
from fea.cycle.path import Path, path
from fea.cycle.screened import Block, product
from fea.cycle.unit_solutions import Weights
from fea.units import RPM
from loads.cases import LoadCase
from loads.engine import Engine
from loads.gas import GasModel
from loads.peaks import peak_cases

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Speeds at which every place is bounded; between them bounds are interpolated.
ANCHORS = 9
# Where δ adds more than this part to the bounds on the average, every place is bounded anew: that is cheaper
# than to work out many.
STRAYED = 0.2
# Places worked out at once: with their unit stresses, 3.5 kB each, and 50 ends of chords some 12 MB.
ROWS = 2000
# At first only so many, which are likely to hold the worst.
FIRST_ROWS = 50
# Nodes bounded at once.
_NODES = 2000
# Rounding of the bounds, relative.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Place:
    """The worst place against one mode of failure.

    Attributes
    ----------
    factor
        Its safety factor.
    at
        (3,) mm.
    crank_angle
        Of the largest von Mises stress, rad; None where it is in no cycle.
    mean, amplitude, ratio
        Of the signed equivalent stress, MPa.
    crossland
        Crossland's factor there, or None where it is not known.
    """

    factor: float
    at: Floats
    crank_angle: float | None
    mean: float
    amplitude: float
    ratio: float
    crossland: float | None


@dataclass(frozen=True)
class CasePeak:
    """A peak case, superposed: largest stresses, MPa, and least safety factor."""

    case: LoadCase
    von_mises: float
    at: Floats
    principal_1: float
    principal_3: float
    factor: float


@dataclass(frozen=True)
class Worst:
    """The worst of the cycle at one speed.

    Attributes
    ----------
    rpm
        The speed.
    cases
        The peak cases.
    yielding, fatigue
        The worst places; fatigue is None where no part's strengths are known.
    looked_at
        How many places were worked out.
    """

    rpm: float
    cases: tuple[CasePeak, ...]
    yielding: Place
    fatigue: Place | None
    looked_at: int


class _Part:
    """The nodes of a part, then their images across y = 0: rows."""

    def __init__(self, analysis: CycleAnalysis, number: int) -> None:
        own, self._sides = analysis.units.parts[number], analysis.units.sides
        self._even, self._odd = deviatoric(own.even), deviatoric(own.odd)
        self._norms = _equivalent(self._even), _equivalent(self._odd)
        self.material = analysis.materials[number]
        self._criterion = analysis.fatigue
        points = analysis.mesh.cell.points[own.nodes]
        self.points = np.concatenate([points * [1, side, 1] for side in self._sides])

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return product(self._even[node], weights[0]) + side * product(self._odd[node], weights[1])

    def block(self, along: Path, rows: Ints) -> Block:
        """Some rows over a path."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return Block(self._even[node], side * self._odd[node], along, (1,), principals=False)

    def every(self, weights: Weights) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row."""
        even, odd = product(self._even, weights[0]), product(self._odd, weights[1])
        return np.concatenate([even + odd if side > 0 else even - odd for side in self._sides])

    def strayed(self, strays: Weights) -> Floats:
        """Bound (n_rows, n) on the von Mises stress of weights whose magnitudes are at most these."""
        even, odd = (norm @ away for norm, away in zip(self._norms, strays, strict=True))
        return np.concatenate([even + odd] * len(self._sides))

    def bound(self, weights: Weights) -> Floats:
        """No less than the largest von Mises stress (n_rows,) over the instants."""
        along = path(weights)
        strays, ends = self.strayed(along.strays), along.at_ends()
        largest = np.empty(len(self.points))
        for start in range(0, len(largest), _NODES):
            rows = np.arange(start, min(start + _NODES, len(largest)))
            equivalent = _equivalent(self.stress(ends, rows))
            chords = np.maximum(equivalent[:, :-1], equivalent[:, 1:]) + strays[rows]
            largest[rows] = chords.max(axis=1)
        return largest * (1 + _ROUNDING)

    def yielding_bound(self, largest: Floats) -> Floats:
        """No more than the factors against yielding, not capped, where stress reaches at most `largest`."""
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def yielding_factor(self, highest: Floats, lowest: Floats) -> Floats:
        """Factors (n,) against yielding of the extremes of the signed equivalent stress."""
        return self.yielding_bound(np.maximum(np.abs(highest), np.abs(lowest)))

    def fatigue_factor(self, highest: Floats, lowest: Floats) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress."""
        return self._fatigue((highest + lowest) / 2, (highest - lowest) / 2)

    def _fatigue(self, mean: Floats, amplitude: Floats) -> Floats:
        """Factors against fatigue; infinite where the strengths are not known."""
        found = fatigue_factor(self._criterion, mean, amplitude, self.material)
        return np.full(len(mean), np.inf) if found is None else found

    def fatigue_bound(self, largest: Floats) -> Floats:
        """No more than the fatigue factors of histories whose von Mises stress is at most `largest`."""
        none = np.zeros_like(largest)
        return np.minimum(self._fatigue(none, largest), self._fatigue(largest, none))


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    Memory: the unit stresses once more, and 8 bytes a place and anchor.

    Parameters
    ----------
    analysis
        The unit solutions.
    engine, gas
        What drives the rod.
    speeds
        rpm; at least one.
    """

    def __init__(
        self, analysis: CycleAnalysis, engine: Engine, gas: GasModel, speeds: Sequence[float]
    ) -> None:
        self._analysis, self._engine, self._gas = analysis, engine, gas
        self._degrees = cycle_angles()
        self._parts = [_Part(analysis, number) for number in range(len(analysis.units.parts))]
        places = np.unique(np.linspace(0, len(speeds) - 1, min(ANCHORS, len(speeds))).round().astype(int))
        self._anchors = np.sort(np.asarray(speeds, float))[places]
        self._weights = [self._at(rpm, self._degrees) for rpm in self._anchors]
        self._largest = [[part.bound(weights) for part in self._parts] for weights in self._weights]

    def at(self, rpm: float) -> Worst:
        """Find the worst places at a speed between the first and the last, rpm."""
        cases = peak_cases(self._engine, self._analysis.rod, self._gas, rpm * RPM).cases
        of_cases = self._analysis.case_weights(cases)
        cyclic = np.array([case.motion is not None for case in cases], dtype=bool)
        degrees = self._at(rpm, self._degrees)
        angles = [*self._degrees, *(case.crank_angle or 0.0 for case in cases if case.motion is not None)]
        order = np.argsort(angles)
        joined = [np.append(w, c[:, cyclic], axis=1) for w, c in zip(degrees, of_cases, strict=True)]
        cycle = _Cycle(
            np.asarray(angles)[order],
            (joined[0][:, order], joined[1][:, order]),
        )
        at_cases = [part.every(of_cases) for part in self._parts]
        bounds = [
            np.maximum(bound, _equivalent(stress[..., cyclic]).max(axis=1, initial=0.0))
            for bound, stress in zip(self._bounds(rpm, degrees), at_cases, strict=True)
        ]
        yielding, first = self._worst(cycle, bounds, _Part.yielding_bound, _Part.yielding_factor)
        yielding = dataclasses.replace(yielding, factor=min(yielding.factor, CAP))
        fatigue, second = self._worst(cycle, bounds, _Part.fatigue_bound, _Part.fatigue_factor)
        peaks = tuple(self._peak(case, [s[..., k] for s in at_cases]) for k, case in enumerate(cases))
        return Worst(rpm, peaks, yielding, fatigue if np.isfinite(fatigue.factor) else None, first + second)

    def _at(self, rpm: float, angles: Floats) -> Weights:
        return self._analysis.weights(self._engine, self._gas, rpm * RPM, angles)

    def _bounds(self, rpm: float, weights: Weights) -> list[Floats]:
        """No less than the largest von Mises stress of every row of each part."""
        above = int(np.clip(np.searchsorted(self._anchors, rpm), 1, max(len(self._anchors) - 1, 1)))
        if len(self._anchors) == 1:
            return [part.bound(weights) for part in self._parts]
        low, high = self._anchors[above - 1] ** 2, self._anchors[above] ** 2
        share = (rpm**2 - low) / (high - low)
        before, after = self._weights[above - 1], self._weights[above]
        strays = tuple(
            np.abs(w - (1 - share) * b - share * a).max(axis=1)[:, None]
            for w, b, a in zip(weights, before, after, strict=True)
        )
        between = zip(self._largest[above - 1], self._largest[above], strict=True)
        straight = [(1 - share) * b + share * a for b, a in between]
        strayed = [part.strayed(strays)[:, 0] for part in self._parts]
        if sum(s.sum() for s in strayed) > STRAYED * sum(s.sum() for s in straight):
            return [part.bound(weights) for part in self._parts]
        return [one + other for one, other in zip(straight, strayed, strict=True)]

    def _worst(
        self,
        cycle: "_Cycle",
        bounds: list[Floats],
        bound: Callable[[_Part, Floats], Floats],
        factor: Callable[[_Part, Floats, Floats], Floats],
    ) -> tuple[Place, int]:
        """The place of the least factor, and how many were worked out."""
        least = np.concatenate([bound(part, b) for part, b in zip(self._parts, bounds, strict=True)])
        order, first = np.argsort(least), np.cumsum([0, *(len(b) for b in bounds)])
        best, at, looked, along = np.inf, int(order[0]), 0, path(cycle.weights)
        for start, stop in pairwise([0, *range(FIRST_ROWS, len(order), ROWS), len(order)]):
            chosen = order[start:stop]
            chosen = chosen[least[chosen] < best]
            if not chosen.size:
                break
            looked += len(chosen)
            of_part = np.searchsorted(first, chosen, side="right") - 1
            for number in np.unique(of_part):
                rows = chosen[of_part == number] - first[number]
                part = self._parts[number]
                found = factor(part, *part.block(along, rows).signed())
                if found.min() < best:
                    best, at = float(found.min()), int(rows[found.argmin()] + first[number])
        number = int(np.searchsorted(first, at, side="right") - 1)
        return self._place(best, self._parts[number], at - int(first[number]), cycle), looked

    def _place(self, factor: float, part: _Part, row: int, cycle: "_Cycle") -> Place:
        history = part.stress(cycle.weights, np.array([row]))
        signed = signed_equivalent(history)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        angle = float(cycle.angles[np.abs(signed).argmax()])
        spot = crossland_factors(history, part.material)
        return Place(
            factor,
            part.points[row],
            angle,
            (highest + lowest) / 2,
            (highest - lowest) / 2,
            lowest / highest if highest else 0.0,
            None if spot is None else float(spot[0]),
        )

    def _peak(self, case: LoadCase, stresses: list[Floats]) -> CasePeak:
        found = []
        for part, stress in zip(self._parts, stresses, strict=True):
            equivalent = _equivalent(stress[..., None])[:, 0]
            largest, least = (sign * _largest_principal(sign * stress, equivalent) for sign in (1, -1))
            row = int(equivalent.argmax())
            factor = float(safety_factor(equivalent[row : row + 1], part.material.yield_strength)[0])
            peak = CasePeak(
                case,
                float(equivalent[row]),
                part.points[row],
                largest,
                least,
                factor,
            )
            found.append(peak)
        return dataclasses.replace(
            max(found, key=lambda peak: peak.von_mises),
            principal_1=max(peak.principal_1 for peak in found),
            principal_3=min(peak.principal_3 for peak in found),
            factor=min(peak.factor for peak in found),
        )


@dataclass(frozen=True)
class _Cycle:
    """Instants of a cycle: crank angles, rad, and weights."""

    angles: Floats
    weights: Weights


def _equivalent(stress: Floats) -> Floats:
    q = stress[:, :5]
    return np.asarray(np.sqrt(np.einsum("nct,nct->nt", q, q)))


def _largest_principal(stress: Floats, equivalent: Floats) -> float:
    """Largest principal stress of all (n, 6), by the bound σ_m + ⅔ σ_vM on each."""
    bound = stress[:, 5] + 2 / 3 * equivalent
    best = [bound.argmax()]
    found = extreme_principals(stress[best].T, equivalent[best])[0]
    high = bound > found
    return float(np.append(extreme_principals(stress[high].T, equivalent[high])[0], found).max())
