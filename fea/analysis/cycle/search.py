"""The worst place of a rod at many speeds, without evaluating every place at each.

Only places with a high enough bound on their largest von Mises stress are evaluated. At a speed ω between two
anchors the weights of every instant are w = (1 − s) w₀ + s w₁ + δ with s linear in ω², like inertia; and the
von Mises stress is convex and positively homogeneous, a norm of the deviator. So

    σ_vM(ω, t) ≤ (1 − s) M₀ + s M₁ + Σ_k max_t |δ_k| σ_vM,k

at every instant t, where M is an upper bound of the stress at the anchor (by the chords of
`fea.analysis.cycle.path`) and σ_vM,k is the equivalent stress of unit load k. The factor against yielding is
at least the yield strength over this bound. With |mean| + amplitude ≤ max σ_vM, the utilisation a/S_e + m/S
by Goodman or Soderberg is at most max(1/S_e, 1/S) times the bound, and so is that by Gerber, which is convex
in (a, m) and not larger at either end of that segment. S_e is that of the place: it depends on the finish of
the surface there.

Places are evaluated at every degree in the order of their bounds, until the next bound is not worse than the
worst place found: the places left out cannot be the worst.
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fea.analysis.cycle.path import Path, norms, path, sizes
from fea.analysis.cycle.screened import Block, product, superposed
from fea.analysis.cycle.superposition import CycleAnalysis
from fea.analysis.figures import CaseFigures, PlaceFigures, vector
from fea.base.choices import Region
from fea.judge.fatigue import crossland_factors, fatigue_factor
from fea.judge.history import deviator_norm, deviatoric, extreme_principals, signed_equivalent
from fea.judge.verdict import CAP, safety_factor
from fea.pins.model import Weights
from geometry.arrays import Floats, Ints
from loads.cases import peak_cases
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from loads.slider_crank import cycle_angles

# Number of nodes for which bounds are computed at once.
_NODES = 2000
# Relative allowance for rounding in the bounds.
_ROUNDING = 1e-9


class PartRows:
    """The nodes of a part, then their images across y = 0: rows, with their stresses and bounds on them.

    Nodes near a singular place are left out.
    """

    def __init__(self, analysis: CycleAnalysis, number: int) -> None:
        own, self._sides = analysis.units.parts[number], analysis.units.sides
        counts = analysis.counts[own.nodes]
        if not counts.any():  # a part has a worst place
            counts[:] = True
        self._even, self._odd = deviatoric(own.even[counts]), deviatoric(own.odd[counts])
        self._joint = own.joint
        self._norms = [
            norms(units, joint)[0] for units, joint in zip((self._even, self._odd), own.joint, strict=True)
        ]
        self.material = analysis.materials[number]
        self._criterion, self.regions = analysis.fatigue, analysis.regions.at(own.nodes[counts])
        self._surface = np.tile(self.regions.factors(self.material), len(self._sides))
        points = analysis.mesh.cell.points[own.nodes[counts]]
        self.points = np.concatenate([points * [1, side, 1] for side in self._sides])

    def stress(self, weights: Weights, rows: Ints) -> Floats:
        """Stress (n, 6, n_instants) of some rows."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return product(self._even[node], weights.even) + side * product(self._odd[node], weights.odd)

    def block(self, along: Path, rows: Ints) -> Block:
        """Return some rows over a path."""
        image, node = np.divmod(rows, len(self._even))
        side = np.asarray(self._sides)[image, None, None]
        return Block(self._even[node], side * self._odd[node], along, (1,), principals=False)

    def every(self, weights: Weights) -> Floats:
        """Stress (n_rows, 6, n_instants) of every row."""
        return np.asarray(superposed(self._even, self._odd, self._sides, weights), np.float64)

    def strayed(self, strays: Weights) -> Floats:
        """Upper bound (n_rows, n) of the von Mises stress for weights of at most these sizes."""
        even, odd = (norm @ away for norm, away in zip(self._norms, strays, strict=True))
        return np.concatenate([even + odd] * len(self._sides))

    def bound(self, weights: Weights) -> Floats:
        """Upper bound of the largest von Mises stress (n_rows,) over the instants."""
        along = path(weights, self._joint)
        strays, ends = self.strayed(along.strays), along.at_ends()
        largest = np.empty(len(self.points))
        for start in range(0, len(largest), _NODES):
            rows = np.arange(start, min(start + _NODES, len(largest)))
            at_ends = deviator_norm(self.stress(ends, rows))
            chords = np.maximum(at_ends[:, :-1], at_ends[:, 1:]) + strays[rows]
            largest[rows] = chords.max(axis=1)
        return largest * (1 + _ROUNDING)

    def yielding_bound(self, largest: Floats) -> Floats:
        """Lower bound of the (uncapped) factors against yielding for stresses of at most `largest`."""
        return self.material.yield_strength / np.maximum(largest, np.finfo(float).tiny)

    def yielding_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:  # noqa: ARG002
        """Factors (n,) against yielding of the extremes of the signed equivalent stress of some rows."""
        return self.yielding_bound(np.maximum(np.abs(highest), np.abs(lowest)))

    def fatigue_factor(self, highest: Floats, lowest: Floats, rows: Ints) -> Floats:
        """Factors (n,) against fatigue of the extremes of the signed equivalent stress of some rows."""
        return self._fatigue((highest + lowest) / 2, (highest - lowest) / 2, self._surface[rows])

    def _fatigue(self, mean: Floats, amplitude: Floats, surface: Floats) -> Floats:
        """Factors against fatigue; infinite if the strengths are not known."""
        factors = fatigue_factor(self._criterion, mean, amplitude, self.material, surface)
        return np.full(len(mean), np.inf) if factors is None else factors

    def fatigue_bound(self, largest: Floats) -> Floats:
        """Lower bound (n_rows,) of the fatigue factors where the von Mises stress is at most `largest`."""
        none, surface = np.zeros_like(largest), self._surface
        return np.minimum(self._fatigue(none, largest, surface), self._fatigue(largest, none, surface))

    def surface(self, row: int) -> tuple[float, Region | None]:
        """Return the factor of the surface of a row, and its region; None inside the solid."""
        node = row % len(self._even)
        return float(self._surface[row]), self.regions.region(node, self.material)


@dataclass(frozen=True)
class Place:
    """The worst place against one mode of failure."""

    factor: float  #: its safety factor
    crank_angle: float  #: of the largest von Mises stress, rad
    figures: PlaceFigures  #: without the factor against fatigue


@dataclass(frozen=True)
class Worst:
    """The worst of the cycle at one speed."""

    cases: tuple[Instants, ...]  #: the peak cases
    peaks: tuple[CaseFigures, ...]  #: of the cases, superposed
    #: yielding, fatigue: the worst places; fatigue is None if no part's strengths are known
    yielding: Place
    fatigue: Place | None


# Number of speeds at which bounds are computed for every place; between them bounds are interpolated.
ANCHORS = 9
# If δ increases the bounds by more than this fraction on average, they are computed again for every place:
# that is cheaper than evaluating many places.
STRAYED = 0.2
# Places evaluated at once: some 12 MB with their unit stresses, 3.5 kB each, and 50 ends of chords.
ROWS = 2000
# Size of the first batch, which is likely to contain the worst place.
FIRST_ROWS = 50


class SpeedSearch:
    """Finds the worst places at any speed between the first and the last.

    It needs memory for a copy of the unit stresses, and 8 bytes per place and anchor.

    `cycles`: the crank cycle at a speed, rpm; `speeds`: rpm; at least one.
    """

    def __init__(
        self, analysis: CycleAnalysis, cycles: Callable[[float], CrankCycle], speeds: Sequence[float]
    ) -> None:
        self._analysis, self._cycles = analysis, cycles
        self._degrees = cycle_angles()
        self._parts = [PartRows(analysis, number) for number in range(len(analysis.units.parts))]
        places = np.unique(np.linspace(0, len(speeds) - 1, min(ANCHORS, len(speeds))).round().astype(int))
        self._anchors = np.sort(np.asarray(speeds, float))[places]
        self._weights = [self._at(rpm, self._degrees) for rpm in self._anchors]
        self._largest = [[part.bound(weights) for part in self._parts] for weights in self._weights]

    @property
    def instants(self) -> int:
        """How many instants of the cycle are looked at."""
        return len(self._degrees)

    def at(self, rpm: float) -> Worst:
        """Find the worst places at a speed between the first and the last, rpm."""
        cases = peak_cases(self._cycles(rpm)).cases
        of_cases = self._analysis.case_weights(cases)
        cyclic = cases.in_cycle
        degrees = self._at(rpm, self._degrees)
        angles = np.append(self._degrees, cases.crank_angle[cyclic])
        order = np.argsort(angles)
        pairs = zip(degrees, of_cases.at(cyclic), strict=True)
        joined = Weights(*(np.append(w, c, axis=1) for w, c in pairs))
        cycle = _Cycle(angles[order], joined.at(order))
        at_cases = [part.every(of_cases) for part in self._parts]
        bounds = [
            np.maximum(bound, deviator_norm(stress[..., cyclic]).max(axis=1, initial=0.0))
            for bound, stress in zip(self._bounds(rpm, degrees), at_cases, strict=True)
        ]
        yielding = self._worst(cycle, bounds, PartRows.yielding_bound, PartRows.yielding_factor)
        yielding = dataclasses.replace(yielding, factor=min(yielding.factor, CAP))
        fatigue = self._worst(cycle, bounds, PartRows.fatigue_bound, PartRows.fatigue_factor)
        peaks = tuple(self._peak([stress[..., k] for stress in at_cases]) for k in range(len(cases)))
        return Worst(tuple(cases), peaks, yielding, fatigue if np.isfinite(fatigue.factor) else None)

    def _at(self, rpm: float, angles: Floats) -> Weights:
        return self._analysis.weights(self._cycles(rpm), angles)

    def _bounds(self, rpm: float, weights: Weights) -> list[Floats]:
        """Upper bound of the largest von Mises stress of every row of each part."""
        above = int(np.clip(np.searchsorted(self._anchors, rpm), 1, max(len(self._anchors) - 1, 1)))
        if len(self._anchors) == 1:
            return [part.bound(weights) for part in self._parts]
        low, high = self._anchors[above - 1] ** 2, self._anchors[above] ** 2
        share = (rpm**2 - low) / (high - low)
        before, after = self._weights[above - 1], self._weights[above]
        strays = Weights(
            *(
                sizes(w - (1 - share) * b - share * a, own).max(axis=1)[:, None]
                for w, b, a, own in zip(weights, before, after, self._analysis.units.joint, strict=True)
            )
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
        bound: Callable[[PartRows, Floats], Floats],
        factor: Callable[[PartRows, Floats, Floats, Ints], Floats],
    ) -> Place:
        """The place of the smallest factor."""
        least = np.concatenate([bound(part, b) for part, b in zip(self._parts, bounds, strict=True)])
        order, first = np.argsort(least), np.cumsum([0, *(len(b) for b in bounds)])
        best, at, along = np.inf, int(order[0]), path(cycle.weights, self._analysis.units.joint)
        for start, stop in pairwise([0, *range(FIRST_ROWS, len(order), ROWS), len(order)]):
            chosen = order[start:stop]
            chosen = chosen[least[chosen] < best]
            if not chosen.size:
                break
            of_part = np.searchsorted(first, chosen, side="right") - 1
            for number in np.unique(of_part):
                rows = chosen[of_part == number] - first[number]
                part = self._parts[number]
                highest, lowest = part.block(along, rows).signed()
                factors = factor(part, highest, lowest, rows)
                if factors.min() < best:
                    best, at = float(factors.min()), int(rows[factors.argmin()] + first[number])
        number = int(np.searchsorted(first, at, side="right") - 1)
        return self._place(best, self._parts[number], at - int(first[number]), cycle)

    def _place(self, factor: float, part: PartRows, row: int, cycle: "_Cycle") -> Place:
        history = part.stress(cycle.weights, np.array([row]))
        signed = signed_equivalent(history)[0]
        highest, lowest = float(signed.max()), float(signed.min())
        angle = float(cycle.angles[np.abs(signed).argmax()])
        skin, region = part.surface(row)
        limit, spot = part.material.endurance_limit, crossland_factors(history, part.material, skin)
        history_figures = PlaceFigures(
            at_mm=vector(part.points[row]),
            mean_MPa=(highest + lowest) / 2,
            amplitude_MPa=(highest - lowest) / 2,
            stress_ratio=lowest / highest if highest else 0.0,
            fatigue_safety_factor=None,
            crossland_safety_factor=None if spot is None else float(spot[0]),
            endurance_MPa=None if limit is None else skin * limit,
            surface_region=None if region is None else region.value,
        )
        return Place(factor, angle, history_figures)

    def _peak(self, stresses: list[Floats]) -> CaseFigures:
        peaks = []
        for part, stress in zip(self._parts, stresses, strict=True):
            equivalent = deviator_norm(stress[..., None])[:, 0]
            largest, least = (sign * _largest_principal(sign * stress, equivalent) for sign in (1, -1))
            row = int(equivalent.argmax())
            peak = CaseFigures(
                max_von_mises_MPa=float(equivalent[row]),
                at_mm=vector(part.points[row]),
                max_principal_MPa=largest,
                min_principal_MPa=least,
                max_displacement_mm=None,
                min_safety_factor=float(
                    safety_factor(equivalent[row : row + 1], part.material.yield_strength)[0]
                ),
                error_percent=None,
                verdict=None,
            )
            peaks.append(peak)
        return dataclasses.replace(
            max(peaks, key=lambda peak: peak.max_von_mises_MPa),
            max_principal_MPa=max(peak.max_principal_MPa for peak in peaks),
            min_principal_MPa=min(peak.min_principal_MPa for peak in peaks),
            min_safety_factor=min(peak.min_safety_factor for peak in peaks),
        )


@dataclass(frozen=True)
class _Cycle:
    """Instants of a cycle: crank angles, rad, and weights."""

    angles: Floats
    weights: Weights


def _largest_principal(stress: Floats, equivalent: Floats) -> float:
    """Largest principal stress of all (n, 6), evaluated only where the bound σ_m + ⅔ σ_vM requires it."""
    bound = stress[:, 5] + 2 / 3 * equivalent
    best = [bound.argmax()]
    largest = extreme_principals(stress[best].T, equivalent[best])[0]
    high = bound > largest
    return float(np.append(extreme_principals(stress[high].T, equivalent[high])[0], largest).max())
