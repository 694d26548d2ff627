"""Judges load cases at sharp re-entrant edges.

The structural (hot-spot) stress is extrapolated to the edge from the surface beside it, at 0.4 and 1.0
thicknesses (IIW recommendations, Hobbacher 2016, section 2.2.3): the stress that the edge would carry without
its notch effect. That effect is fitted to the stress along both flanks.

Near the tip of a sharp re-entrant corner the stress across it grows as r^(λ − 1) (Williams 1952, J. Appl.
Mech. 19, 526). Where the corner is rounded by a radius ρ, small against the section, the peak is that of the
same field with the tip moved into the notch (Creager & Paris 1967 for cracks; Filippi, Lazzarin & Tovo 2002,
Int. J. Solids Struct. 39, 4543, for V-notches).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import CAP
from fea.solid.sharp_edges import SharpEdges, SurfacePaths
from fea.solid.stress import matrices, von_mises
from geometry.arrays import Floats, Ints, Mask

# Rise of the peak of a rounded notch over the stress of the sharp one at the same distance r₀ from the tip,
# by the opening angle in degrees: ω̃₁ of Filippi, Lazzarin & Tovo 2002; 0 where there is no notch.
_OPENINGS = (0.0, 30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0)
_RISES = (1.0, 1.034, 1.014, 0.970, 0.810, 0.570, 0.432, 0.0)
_RISE = PchipInterpolator(_OPENINGS, _RISES)


@dataclass(frozen=True)
class VNotch:
    """A re-entrant corner between two flat flanks."""

    opening: float  #: angle of the notch, outside the material, rad: 0 for a crack, π for a flat surface

    @property
    def half(self) -> float:
        """γ, half the angle of the material, rad."""
        return math.pi - self.opening / 2

    @cached_property
    def opens(self) -> float:
        """λ₁: under a load that opens it symmetrically the stress grows as r^(λ₁ − 1).

        Root of sin 2λγ + λ sin 2γ = 0 in ½ … 3π/4γ.
        """
        gamma = self.half

        def equation(x: float) -> float:
            return math.sin(2 * x * gamma) + x * math.sin(2 * gamma)

        return float(brentq(equation, 0.4999, 3 * math.pi / (4 * gamma)))

    @cached_property
    def slides(self) -> float:
        """λ₂, of the antisymmetric field; above 1, where the stress is finite, for openings beyond 102.6°.

        Root of sin 2λγ − λ sin 2γ = 0 in π/2γ … π/γ, but for the rigid motion λ = 1.
        """
        gamma = self.half
        low, high = 0.9998 * math.pi / (2 * gamma), 1.0002 * math.pi / gamma

        def equation(x: float) -> float:
            return (math.sin(2 * x * gamma) - x * math.sin(2 * gamma)) / (x - 1)

        return float(brentq(equation, low, high))

    @property
    def flank(self) -> float:
        """Stress along the flanks over that across the bisector at the same distance, symmetric field."""
        lam, gamma = self.opens, self.half
        chi = -(1 + lam) / (1 - lam) * math.cos((1 - lam) * gamma) / math.cos((1 + lam) * gamma)
        return float(4 * math.cos((1 - lam) * gamma) / (1 + lam + chi * (1 - lam)))

    @property
    def rounded(self) -> float:
        """Peak at a rounded tip over the stress across the bisector of the sharp notch, one radius away."""
        rise = float(_RISE(math.degrees(self.opening)))
        q = 2 - self.opening / math.pi
        tip = (q - 1) / q  # distance r₀ of the field's origin from it over its radius (Neuber's hyperbola)
        return float((1 + rise) * tip ** (self.opens - 1))


# Flanks of a narrower notch hardly carry stress, so that nothing can be fitted to it.
_LEAST_OPENING = math.radians(60.0)
# Powers of the distance from the tip of what is added to the singular fields: the next eigenvalues of a right
# angle are 1.63 (symmetric) and 2.30.
_NEXT = (0.63, 1.3)
# Share of the antisymmetric stress at the peak, which lies between the bisector, where there is none, and the
# flank: with it the peaks at fillets of 0.02 to 0.3 thicknesses, in plane shoulders of 90° to 135° in tension
# and bending, are between 10 % too low and 12 % too high.
_SLID = 0.7
# The smallest radius that is looked for, over the largest.
_SMALLEST = 1e-3


@dataclass(frozen=True)
class NotchField:
    """The singular stress at a sharp notch."""

    notch: VNotch
    #: opening, sliding: coefficients of the stress along the flanks: the mean of both flanks is opening ·
    #: r^(λ₁ − 1), half their difference sliding · r^(λ₂ − 1), MPa with r in mm
    opening: float
    sliding: float
    longest: float  #: distance up to which the stress is fitted, and largest radius of a fillet, mm

    @property
    def intensity(self) -> float:
        """K₁, MPa·mm^(1 − λ₁) (Gross & Mendelson 1972): √(2π) r^(1 − λ₁) times the stress on the bisector."""
        return math.sqrt(2 * math.pi) * self.opening / self.notch.flank

    def peak(self, radius: float) -> float:
        """Largest stress along a fillet of this radius, mm: MPa, of the sign of the opening field.

        The symmetric part is that of a rounded notch; of the antisymmetric one, which hardly changes with the
        distance, a share is taken from the flank of the sharp notch, one radius from the tip.
        """
        notch = self.notch
        opened = self.opening / notch.flank * notch.rounded * radius ** (notch.opens - 1)
        slid = _SLID * abs(self.sliding) * radius ** (notch.slides - 1)
        return float(opened + math.copysign(slid, opened))

    def radius(self, allowed: float) -> float | None:
        """Smallest fillet radius, mm, whose peak is at most `allowed`, MPa; None above `longest`."""

        def excess(radius: float) -> float:
            return abs(self.peak(radius)) - allowed

        if excess(self.longest) > 0:
            return None
        least = _SMALLEST * self.longest
        return least if excess(least) <= 0 else float(brentq(excess, least, self.longest))


def fitted_notch(notch: VNotch, distance: Floats, first: Floats, second: Floats) -> NotchField | None:
    """Fit to stress (n,) across the edge on both flanks, MPa, at `distance` (n,), mm; None if impossible."""
    if notch.opening < _LEAST_OPENING or len(distance) < 3:
        return None
    powers = notch.opens - 1, notch.slides - 1
    coefficients = [
        np.linalg.lstsq(np.stack([distance**power, distance**following], axis=1), stress, rcond=None)[0][0]
        for power, following, stress in zip(
            powers, _NEXT, ((first + second) / 2, (first - second) / 2), strict=True
        )
    ]
    return NotchField(notch, float(coefficients[0]), float(coefficients[1]), float(distance.max()))


# Element size, of the shorter flank and within so much of the thickness, with which the structural stress and
# the notch are known to a few percent; not less than this share of the thickness.
FINE, FINE_WITHIN, _FINEST = 0.12, 0.6, 0.08
# An edge matters where its structural stress uses at least this share of the strength that the worst place of
# its case uses; up to so many edges do in a case.
SHARE, _MATTERING, _IF_DIVERGING = 0.5, 4, 2


@dataclass(frozen=True, kw_only=True)
class SharpPlace:
    """A sharp re-entrant edge under one load case."""

    at: Floats  #: (3,) where its structural stress is largest, mm
    between: tuple[str, str]  #: the faces that meet there, in words
    #: opening, length: angle of the notch, outside the material, rad, and length of the connected edge, mm
    opening: float
    length: float
    #: The measure t of the extrapolation, mm: of the material behind the flank with the larger structural
    #: stress, or the length of that flank where it is shorter
    thickness: float
    structural_stress: float  #: across the edge, MPa, tension positive
    #: structural_von_mises, bar: MPa, and its error bar, from the errors where it is read
    structural_von_mises: float
    bar: float
    change: float  #: the part of the bar that is the change to the next place, where the flank ends, MPa
    yield_strength: float  #: of the part there, MPa
    notch: NotchField | None  #: the singular field; None where it cannot be fitted
    shorter: float  #: the smaller measure of both flanks, mm
    #: Von Mises stress over the stress across the edge, at the surface of a fillet: plane strain along it
    plane: float

    @property
    def safety_factor(self) -> SafetyFactor:
        """Against yielding, by the structural stress, with its error bar."""
        factor = min(self.yield_strength / max(self.structural_von_mises, 1e-300), CAP)
        return SafetyFactor.of_stress(factor, self.error_percent)

    @property
    def notch_exponent(self) -> float:
        """1 − λ₁: the elastic stress grows as r^(λ₁ − 1) towards the edge."""
        return 1 - VNotch(self.opening).opens

    @property
    def error_percent(self) -> float:
        """The bar relative to the structural stress."""
        return 100 * self.bar / self.structural_von_mises if self.structural_von_mises > 0 else 0.0

    @property
    def highest(self) -> float:
        """Its utilisation, one over the safety factor, at the upper end of its error bar."""
        return 1 / self.safety_factor.low

    @property
    def element_size(self) -> float:
        """Element size that the place needs, mm."""
        return max(FINE * self.shorter, _FINEST * self.thickness)

    def fillet(self, required: float) -> float | None:
        """Least fillet radius, mm, with this safety factor at its peak; None where none is small enough."""
        if self.notch is None or self.safety_factor < required:
            return None
        return self.notch.radius(self.yield_strength / required / self.plane)


def worst_of_edges(cases: Iterable[Sequence[SharpPlace]]) -> list[SharpPlace]:
    """Return each edge once, as it is in the load case where its safety factor is least."""
    worst: dict[tuple[str, str], SharpPlace] = {}
    for place in (place for places in cases for place in places):
        if place.between not in worst or place.safety_factor < worst[place.between].safety_factor:
            worst[place.between] = place
    return sorted(worst.values(), key=lambda place: place.safety_factor)


def mattering(
    places: Sequence[SharpPlace], least_factor: float, *, diverging: bool
) -> tuple[SharpPlace, ...]:
    """Return the places of one case, the worst first, that matter beside the rest of the rod.

    At least two matter where the stress near singular places exceeds that of the rest (`diverging`).
    """
    limit = min([least_factor, *(place.safety_factor for place in places)]) / SHARE
    kept = [place for place in places if place.safety_factor <= limit]
    return tuple(places[: max(min(len(kept), _MATTERING), _IF_DIVERGING if diverging else 0)])


# Steps of a path over one thickness, those that find the end of a shorter flank, and the weights of the
# stress after 0.4 and 1.0 of it.
_STEPS, _FINE_STEPS = 10, 40
_READ, _WEIGHTS = [3, 9], np.array([1.67, -0.67])
# The notch is fitted over this share of the thickness, beyond so many elements from the edge: the stress in
# those that touch it is wrong. They may take this share of the path.
_NOTCH, _BEYOND, _WRONG = 0.5, 1.5, 0.6
# Steps by which a path stops short of the end of a short flank.
_SHORT = 1.2
# Of flanks that end before one thickness, those are read that have this share of the longest.
_LONG = 0.8
# Reference points beyond this share of the rod would lie on another part of it.
_LONGEST = 0.25


class SharpPlaces:
    """Judges load cases at the sharp edges of a rod, with Poisson's ratio."""

    def __init__(self, edges: SharpEdges, poisson: float) -> None:
        self._edges, self._poisson = edges, poisson

    def __call__(
        self, stress: Floats, error: Floats, safety_factor: Floats, least_factor: float
    ) -> tuple[SharpPlace, ...]:
        """Judge one case; the place with the highest structural stress comes first.

        Stress (n_nodes, 6), the error (n_nodes,) of the von Mises stress, MPa, and the safety factor
        (n_nodes,) against yielding, of which `least_factor` is the smallest away from singular places: edges
        with more than twice as much even where they are singular are left out.
        """
        edges, equivalent = self._edges, von_mises(stress)
        rows = _highly_stressed(edges, 1 / safety_factor, SHARE / least_factor)
        if not rows.size:
            return ()
        measure, spots, bars, changes = self._structural(rows, stress, error)
        sizes = von_mises(spots)
        worst = [np.flatnonzero(edges.place[rows] == number) for number in np.unique(edges.place[rows])]
        worst = [of[np.isfinite(sizes[of]).any(axis=1)] for of in worst]
        chosen = np.array([of[np.nanmax(sizes[of], axis=1).argmax()] for of in worst if of.size], dtype=int)
        sides = np.nanargmax(sizes[chosen], axis=1) if chosen.size else chosen
        fields = self._notches(rows[chosen], measure[chosen], stress)
        places = []
        for at, side, notch in zip(chosen.tolist(), sides.tolist(), fields, strict=True):
            row = rows[at]
            node, away = edges.nodes[row, 0], edges.away[row, side]
            places.append(
                SharpPlace(
                    at=edges.at[row],
                    between=edges.between[edges.place[row]],
                    opening=float(edges.opening[row]),
                    length=float(edges.length[row]),
                    thickness=float(measure[at, side]),
                    structural_stress=float(away @ matrices(spots[at, side]) @ away),
                    structural_von_mises=float(sizes[at, side]),
                    bar=float(bars[at, side] + changes[at, side]),
                    change=float(changes[at, side]),
                    yield_strength=float(safety_factor[node] * equivalent[node]),
                    notch=notch,
                    shorter=float(measure[at].min()),
                    plane=math.sqrt(1 - self._poisson + self._poisson**2),
                )
            )
        return tuple(sorted(places, key=lambda place: place.safety_factor))

    def _structural(self, rows: Ints, stress: Floats, error: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Measure t (n, 2), structural stress (n, 2, 6) and the parts of its bar (n, 2) per flank.

        These are its error, and the change to where the flank ends. NaN where it is not read.
        """
        n = len(rows)
        measure, short = np.empty((n, 2)), np.empty((n, 2), dtype=bool)
        spots, bars = np.empty((n, 2, 6)), np.empty((n, 2))
        for side in (0, 1):
            measure[:, side], short[:, side], paths = self._flank(rows, side)
            lost = paths.length < _STEPS
            spots[:, side] = np.einsum("s,nsc->nc", _WEIGHTS, paths.values(stress)[:, _READ])
            bars[:, side] = paths.values(error)[:, _READ] @ np.abs(_WEIGHTS)
            spots[lost, side] = bars[lost, side] = np.nan
        # Flanks that end before one thickness would be read within the notch effect, closer to the edge the
        # shorter they are. Another flank that is long enough takes their place; where an edge has none, its
        # longest ones do.
        alone, place = np.asarray(short.all(axis=1)), self._edges.place
        longest = np.zeros(int(place.max()) + 1)
        np.maximum.at(longest, place[rows[alone]], measure[alone].max(axis=1))
        left_out = short & (~alone[:, None] | (measure < _LONG * longest[place[rows]][:, None]))
        spots[left_out] = bars[left_out] = np.nan
        return measure, spots, bars, self._changes(rows, von_mises(spots))

    def _changes(self, rows: Ints, sizes: Floats) -> Floats:
        """By how much sizes (n, 2) change to the next station where those of a flank begin or end to be read.

        How far it is read depends on the mesh there.
        """
        change = np.abs(np.diff(sizes, axis=0, append=np.nan))
        together = np.append(np.diff(self._edges.edge[rows]) == 0, False)
        change[~together] = 0.0  # ends of the edge, which are those of the drawing
        before = np.concatenate([np.zeros((1, 2)), change[:-1]])
        lost = np.isnan(change) != np.isnan(before)
        return np.where(lost, np.fmax(change, before), 0.0)

    def _flank(self, rows: Ints, side: int) -> tuple[Floats, Mask, SurfacePaths]:
        """Follow a flank for one thickness, or to its end where that is nearer: measure, ends and paths."""
        edges = self._edges
        most = _LONGEST * float(np.ptp(edges.surface.points, axis=0).max())
        measure = np.minimum(edges.thickness(rows)[:, side], most)
        within = measure / _STEPS
        paths = edges.paths(side, rows, within, _STEPS, within)
        ends = paths.length < _STEPS
        if not ends.any():
            return measure, ends, paths
        # The end lies within the next step; then a little before it.
        next_step = (paths.length[ends] + 1) / _STEPS
        fine = measure[ends] * next_step / _FINE_STEPS
        reached = edges.paths(side, rows[ends], fine, _FINE_STEPS, within[ends]).length
        measure[ends] = fine * np.maximum(reached - _SHORT, 0.5)
        return measure, ends, edges.paths(side, rows, measure / _STEPS, _STEPS, within)

    def _notches(self, rows: Ints, measure: Floats, stress: Floats) -> list[NotchField | None]:
        """Fit the notch field of each edge over half the smaller of the measures of its flanks."""
        edges = self._edges
        step = _NOTCH * measure.min(axis=1) / _STEPS
        flanks = [edges.paths(side, rows, step, _STEPS, step) for side in (0, 1)]
        sampled = [
            np.einsum("nsi,nsij,nsj->ns", paths.ahead, matrices(paths.values(stress)), paths.ahead)
            for paths in flanks
        ]
        distance = step[:, None] * np.arange(1, _STEPS + 1)
        fields: list[NotchField | None] = []
        for k, row in enumerate(rows):
            first = _BEYOND * edges.size[row]
            if first > _WRONG * distance[k, -1] or any(paths.length[k] < _STEPS for paths in flanks):
                fields.append(None)
                continue
            use = distance[k] >= first
            notch = VNotch(float(edges.opening[row]))
            fields.append(fitted_notch(notch, distance[k, use], sampled[0][k, use], sampled[1][k, use]))
        return fields


def _highly_stressed(edges: SharpEdges, utilisation: Floats, least: float) -> Ints:
    """Stations of the edges whose utilisation (n_nodes,) reaches `least` anywhere."""
    at_stations = utilisation[edges.nodes].mean(axis=1)
    return np.flatnonzero(np.isin(edges.place, edges.place[at_stations >= least]))
