"""Pins that press by a cosine or uniformly over an arc; unit loads are harmonics cos nφ and sin nφ."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, reduce

import numpy as np

from fea.base.units import DEG
from fea.pins.model import UnitLoads, Weights, inertial_fields
from fea.pins.prescribed import LoadedBore, PrescribedPins, StoredFields
from fea.solid.bore import BoreFacets, BoreLoad, bore_load, radial_loads, wrapped
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.bearing import BorePressure, PressureArc
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

Wave = Callable[[Floats], Floats]

# Largest error of the series anywhere on the bore for a continuous pressure, relative to the peak pressure:
# equivalent to about 0.2 % of a rod's peak stress.
TOLERANCE = 1e-2
# Highest order; if the pressure jumps (a uniform arc), the series does not converge at the jump.
HIGHEST, _AT_JUMPS = 64, 48
# Coefficients below this are rounding.
_NEGLIGIBLE = 1e-12
_SAMPLES = 1 << 12
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class Series:
    """The orders of a series that approximates a pressure."""

    orders: Ints  #: (n_terms,) n, increasing, starting with 0 and 1
    error: float  #: largest difference from the pressure, relative to its peak


@cache
def series(arc: PressureArc, highest: int | None = None) -> Series:
    """Expand an arc's pressure: up to order `highest`, or to an error of `TOLERANCE`, at most `HIGHEST`."""
    return _enough(arc, np.cos, 1.0) if highest is None else _truncated(arc, highest, np.cos)


@cache
def _enough(arc: PressureArc, wave: Wave, share: float) -> Series:
    """Expand s(ψ) or s(ψ) sin ψ with the weight `share`: a smaller weight needs fewer terms."""
    highest = _AT_JUMPS if arc.profile.jumps else HIGHEST
    candidates = (_truncated(arc, order, wave) for order in range(8, highest + 1, 4))
    fit = (each for each in candidates if share * each.error <= TOLERANCE)
    return next(fit, _truncated(arc, highest, wave))


def _truncated(arc: PressureArc, highest: int, wave: Wave) -> Series:
    psi = 2 * math.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    orders = np.arange(highest + 1)
    terms = _coefficients(arc, orders, wave)
    used = (np.abs(terms) > _NEGLIGIBLE) | (orders <= 1)
    sums = wave(np.multiply.outer(psi, orders[used])) @ terms[used]
    return Series(orders[used], float(np.abs(sums - _pressure(arc, psi, wave)).max()))


def _coefficients(arc: PressureArc, orders: Ints, wave: Wave) -> Floats:
    """Coefficients by Gauss quadrature over the arc, within which the pressure is smooth."""
    half = arc.angle / 2
    psi = _PLACES * half
    integrals = half * wave(np.multiply.outer(orders, psi)) @ (_WEIGHTS * _pressure(arc, psi, wave))
    return np.asarray(integrals / np.where(orders == 0, 2 * math.pi, math.pi))


def _pressure(arc: PressureArc, psi: Floats, wave: Wave) -> Floats:
    """The pressure function that is even about the force (cosine), or odd (sine)."""
    return arc(psi) if wave is np.cos else arc(psi) * np.sin(psi)


# Skewness of a bore's pressure above which additional harmonics are solved for.
SKEWED = 2e-3
_DIRECTIONS = np.arange(0, 360, 30) * DEG


class PressedPins(PrescribedPins):
    """Pins that press on one side of their bores, with a pressure of a given shape."""

    @cached_property
    def distribution(self) -> BorePressure:
        """How the pressure is spread."""
        return BorePressure.parse(self.pressure)

    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""
        arc = self.distribution.arc(bore.outwards * force[0])
        magnitude, taper = np.hypot(*force), bore.taper * np.cos(np.arctan2(force[1], force[0]))
        peak = arc.peak(float(magnitude), bore.radius, bore.width, float(taper))
        half = arc.angle / 2
        return bore_load(bore.facets, self.n_nodes, force, lambda psi: peak * arc.unbounded(psi), half)

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return harmonics of the pressure on each bore, and inertia: they span any instant."""
        return Harmonics(self)


@dataclass(frozen=True)
class PressedBore:
    """Harmonic pressures of 1 MPa on one bore."""

    bore: LoadedBore
    arcs: tuple[PressureArc, PressureArc]  #: the pressures in tension and in compression
    orders: Ints  #: (n_terms,) of the harmonics: cos nφ of all, sin nφ of all but n = 0

    def pressures(self, angle: Floats) -> tuple[Floats, Floats]:
        """Harmonics cos nφ (n_terms, …) and sin nφ (n_terms − 1, …) at angles."""
        turned = np.multiply.outer(self.orders, angle)
        return np.cos(turned), np.sin(turned[1:])

    @cached_property
    def resultants(self) -> tuple[Floats, Floats]:
        """Force (2, n) on the whole rod of each even and each odd harmonic, N."""
        return self.bore.facets.resultants(*self.pressures(self.bore.facets.angle))

    def weights(self, force: Floats) -> Weights:
        """Weights of cos nφ (n_terms, n) and sin nφ (n_terms − 1, n) for a resultant `force` (2, n), N.

        The pressure is s(ψ)(a + b sin ψ) with the a and b that `fea.solid.bore` would find: its discrete
        resultant equals the force along its direction and is zero across it.
        """
        direction = np.arctan2(force[1], force[0])
        cosines, sines = self.pressures(direction)
        pulled = self.bore.outwards * force[0] > 0
        pairs = zip(*self._coefficients, strict=True)
        c, d = (np.where(pulled, *(of[:, None] for of in pair)) for pair in pairs)
        shapes = (c * cosines, c[1:] * sines), (-d * np.vstack([0 * sines[:1], sines]), d[1:] * cosines[1:])
        of_even, of_odd = self.resultants
        reached = np.stack([of_even @ even + of_odd @ odd for even, odd in shapes], axis=-1)
        a, b = np.linalg.solve(np.moveaxis(reached, 1, 0), force.T[..., None])[..., 0].T
        (even, odd), (skewed_even, skewed_odd) = shapes
        return Weights(a * even + b * skewed_even, a * odd + b * skewed_odd)

    @cached_property
    def _coefficients(self) -> list[tuple[Floats, Floats]]:
        """Per arc c_n of s(ψ) and d_n of s(ψ) sin ψ, each (n_terms,)."""
        orders = self.orders
        return [(_coefficients(arc, orders, np.cos), _coefficients(arc, orders, np.sin)) for arc in self.arcs]


class Harmonics(UnitLoads):
    """Harmonics cos nφ and sin nφ of the pressure on each bore, and inertia."""

    def __init__(self, pins: PressedPins) -> None:
        self._pins, pressure = pins, pins.distribution
        arcs = (pressure.tension, pressure.compression)
        orders = np.union1d(*(series(arc).orders for arc in arcs))
        self.series_error = max(series(arc).error for arc in arcs)
        self.jumps = any(arc.profile.jumps for arc in arcs)
        self.bores = [PressedBore(bore, arcs, _with_skewed(orders, bore.facets, arcs)) for bore in pins.bores]

    def fields(self) -> tuple[StoredFields, StoredFields]:
        """Return the even and the odd unit loads."""
        even, odd = (
            StoredFields.of(self._count(parity), self._harmonics(parity), inertial, self._pins.tilt)
            for parity, inertial in enumerate(inertial_fields(self._pins.inertia))
        )
        return even, odd

    def _count(self, parity: int) -> int:
        return sum(len(bore.orders) - parity for bore in self.bores)

    def _harmonics(self, parity: int) -> Iterator[tuple[Surface, Floats, Floats]]:
        for pressed in self.bores:
            facets = pressed.bore.facets
            there, nodal = (pressed.pressures(angle)[parity] for angle in (facets.angle, facets.node_angle))
            for load in radial_loads(facets, self._pins.n_nodes, there, nodal):
                yield pressed.bore.surface, *load

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        pressed = [bore.weights(bore.bore.force(instants)) for bore in self.bores]
        even = [*(weights.even for weights in pressed), instants.motions[:2]]
        odd = [*(weights.odd for weights in pressed), instants.motions[2:]]
        return Weights(np.concatenate(even), np.concatenate(odd))


def _with_skewed(orders: Ints, facets: BoreFacets, arcs: tuple[PressureArc, PressureArc]) -> Ints:
    """Orders plus those of s(ψ) sin ψ, if a bore needs more of it than its mesh irregularity causes."""
    shares = {arc: _skewness(facets, arc) for arc in arcs}
    more = [_enough(arc, np.sin, share).orders for arc, share in shares.items() if share > SKEWED]
    return reduce(np.union1d, more, orders)


def _skewness(facets: BoreFacets, arc: PressureArc) -> float:
    """Largest |b / a| of s(ψ)(a + b sin ψ) among forces in some directions."""
    angle, area = facets.angle.ravel(), facets.areas.ravel()
    if facets.cut_y:
        angle, area = np.append(angle, -angle), np.append(area, area)
    most = 0.0  # in a direction without a facet within the arc, too
    for direction in _DIRECTIONS:
        psi = wrapped(angle - direction)
        within = np.abs(psi) < arc.angle / 2
        across = np.sin(psi[within])
        pressed = arc.unbounded(psi[within]) * area[within] * across
        most = max(most, float(abs(pressed.sum()) / max(pressed @ across, np.finfo(float).tiny)))
    return most
