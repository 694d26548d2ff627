"""Unit loads of prescribed bore pressures: their harmonics cos nφ and sin nφ, and four inertia fields."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, reduce

import numpy as np

from fea.base.choices import Support
from fea.pins.unit_loads import ALONE, Contacts, Weights, inertial_fields
from fea.rod.meshed_rod import Bores
from fea.solid.bore import BoreFacets, bore_facets, radial_forces, radial_traction, wrapped
from fea.solid.inertia import Inertia
from fea.solid.tilt import Tilt
from fea.units import DEG
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.bearing import Arc, BorePressure, Shape
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh.tetmesh import TetMesh

Wave = Callable[[Floats], Floats]

# Largest error of the series anywhere on the bore for a continuous pressure, relative to the peak pressure:
# equivalent to about 0.2 % of a rod's peak stress.
TOLERANCE = 1e-2
# Highest order: if the pressure jumps (a uniform arc), the series does not converge at the jump.
HIGHEST = 48
# Coefficients below this are rounding.
_NEGLIGIBLE = 1e-12
_SAMPLES = 1 << 12
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


@dataclass(frozen=True)
class Series:
    """The orders of a series that approximates a pressure.

    Attributes
    ----------
    orders
        (n_terms,) n, increasing, starting with 0 and 1.
    error
        Largest difference from the pressure, relative to its peak.
    """

    orders: Ints
    error: float


@cache
def series(arc: Arc, highest: int | None = None) -> Series:
    """Expand the pressure of an arc.

    Parameters
    ----------
    arc
        The pressure.
    highest
        Highest order; by default the lowest with an error below `TOLERANCE`, at most `HIGHEST`.
    """
    return _enough(arc, np.cos, 1.0) if highest is None else _truncated(arc, highest, np.cos)


@cache
def skewed(arc: Arc, share: float) -> Series:
    """Expand s(ψ) sin ψ, which has at most the weight `share`: a smaller weight needs fewer terms."""
    return _enough(arc, np.sin, share)


def coefficients(arc: Arc, orders: Ints) -> tuple[Floats, Floats]:
    """Return c_n of s(ψ) and d_n of s(ψ) sin ψ, each (n_terms,)."""
    return _coefficients(arc, orders, np.cos), _coefficients(arc, orders, np.sin)


def _enough(arc: Arc, wave: Wave, share: float) -> Series:
    candidates = (_truncated(arc, order, wave) for order in range(8, HIGHEST + 1, 4))
    fit = (found for found in candidates if share * found.error <= TOLERANCE)
    return next(fit, _truncated(arc, HIGHEST, wave))


def _truncated(arc: Arc, highest: int, wave: Wave) -> Series:
    psi = 2 * math.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    orders = np.arange(highest + 1)
    found = _coefficients(arc, orders, wave)
    used = (np.abs(found) > _NEGLIGIBLE) | (orders <= 1)
    sums = wave(np.multiply.outer(psi, orders[used])) @ found[used]
    return Series(orders[used], float(np.abs(sums - _pressure(arc, psi, wave)).max()))


def _coefficients(arc: Arc, orders: Ints, wave: Wave) -> Floats:
    """Coefficients by Gauss quadrature over the arc, within which the pressure is smooth."""
    half = arc.angle / 2
    psi = _PLACES * half
    integrals = half * wave(np.multiply.outer(orders, psi)) @ (_WEIGHTS * _pressure(arc, psi, wave))
    return np.asarray(integrals / np.where(orders == 0, 2 * math.pi, math.pi))


def _pressure(arc: Arc, psi: Floats, wave: Wave) -> Floats:
    """The pressure function that is even about the force (cosine), or odd (sine)."""
    return arc(psi) if wave is np.cos else arc(psi) * np.sin(psi)


# Skewness of a bore's pressure above which additional harmonics are solved for.
SKEWED = 2e-3
_DIRECTIONS = np.arange(0, 360, 30) * DEG


@dataclass(frozen=True)
class StoredFields:
    """Unit loads of one parity on the cell.

    Attributes
    ----------
    nodal
        (n_nodes, 3) each, N.
    pressed
        Per bore (n_nodes, 3, n_units), MPa.
    """

    nodal: tuple[Floats, ...]
    pressed: dict[Surface, Floats]

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return len(self.nodal)

    def forces(self, units: slice) -> tuple[Floats, ...]:
        """Nodal forces (n_nodes, 3) of some of them."""
        return self.nodal[units]

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore."""
        return {surface: values[..., units] for surface, values in self.pressed.items()}


@dataclass(frozen=True)
class PressedBore:
    """Harmonic pressures of 1 MPa on one bore.

    Attributes
    ----------
    surface
        The bore.
    facets
        Its facets on the meshed cell.
    outwards
        Sign of the force along x that pulls this end outwards.
    arcs
        The pressures in tension and in compression.
    orders
        (n_terms,) of the harmonics: cos nφ of all, sin nφ of all but n = 0.
    """

    surface: Surface
    facets: BoreFacets
    outwards: int
    arcs: tuple[Arc, Arc]
    orders: Ints

    def pressures(self, angle: Floats) -> tuple[Floats, Floats]:
        """Harmonics cos nφ (n_terms, …) and sin nφ (n_terms − 1, …) at angles."""
        turned = np.multiply.outer(self.orders, angle)
        return np.cos(turned), np.sin(turned[1:])

    @cached_property
    def resultants(self) -> tuple[Floats, Floats]:
        """Force (2, n) on the whole rod of each even and each odd harmonic, N."""
        facets = self.facets
        images = (2 if facets.cut_y else 1) * (2 if facets.cut_z else 1)
        radial = np.stack([np.cos(facets.angle), np.sin(facets.angle)]) * facets.areas * images
        even, odd = (
            np.einsum("dfq,nfq->dn", radial, pressure, optimize=True)
            for pressure in self.pressures(facets.angle)
        )
        if facets.cut_y:  # components that the images across y = 0 cancel
            even[1], odd[0] = 0.0, 0.0
        return even, odd

    def weights(self, force: Floats) -> Weights:
        """Weights of cos nφ (n_terms, n) and sin nφ (n_terms − 1, n) for a resultant `force` (2, n), N.

        The pressure is s(ψ)(a + b sin ψ) with the a and b that `fea.solid.bore` would find: its discrete
        resultant equals the force along its direction and is zero across it.
        """
        direction = np.arctan2(force[1], force[0])
        cosines, sines = self.pressures(direction)
        pulled = self.outwards * force[0] > 0
        c, d = (
            np.where(pulled, *(of[:, None] for of in pair)) for pair in zip(*self._coefficients, strict=True)
        )
        shapes = (c * cosines, c[1:] * sines), (-d * np.vstack([0 * sines[:1], sines]), d[1:] * cosines[1:])
        of_even, of_odd = self.resultants
        reached = np.stack([of_even @ even + of_odd @ odd for even, odd in shapes], axis=-1)
        a, b = np.linalg.solve(np.moveaxis(reached, 1, 0), force.T[..., None])[..., 0].T
        (even, odd), (skewed_even, skewed_odd) = shapes
        return Weights(a * even + b * skewed_even, a * odd + b * skewed_odd)

    @cached_property
    def _coefficients(self) -> list[tuple[Floats, Floats]]:
        return [coefficients(arc, self.orders) for arc in self.arcs]


class PressureLoads:
    """The unit loads of a meshed rod whose pins press as prescribed.

    Parameters
    ----------
    mesh
        The meshed cell.
    bores
        Dimensions of the bores.
    inertia
        Inertia of the same mesh.
    pressure
        Distribution of the pin pressure on the bores.
    support
        With a clamped big end, the crank force is a reaction and not applied.
    """

    together = ALONE

    remembers = False

    def __init__(
        self, mesh: TetMesh, bores: Bores, inertia: Inertia, pressure: BorePressure, support: Support
    ) -> None:
        self._n_nodes, self._inertia = len(mesh.points), inertia
        self._tilt = Tilt.where_free(mesh, inertia, held=support is Support.CLAMPED)
        arcs = (pressure.tension, pressure.compression)
        orders = np.union1d(*(series(arc).orders for arc in arcs))
        self.series_error = max(series(arc).error for arc in arcs)
        self.jumps = any(arc.shape is Shape.UNIFORM for arc in arcs)
        small = bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length)
        self.bores = [PressedBore(Surface.SMALL_END_BORE, small, 1, arcs, _with_skewed(orders, small, arcs))]
        if support is not Support.CLAMPED:
            big = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
            self.bores.append(
                PressedBore(Surface.BIG_END_BORE, big, -1, arcs, _with_skewed(orders, big, arcs))
            )

    def fields(self) -> tuple[StoredFields, StoredFields]:
        """Return the even and the odd unit loads."""
        even, odd = inertial_fields(self._inertia)
        return self._fields(0, even), self._fields(1, odd)

    def _fields(self, parity: int, inertial: list[Floats]) -> StoredFields:
        """Harmonics of every bore, then the inertia fields."""
        forces: list[Floats] = []
        count = sum(len(bore.orders) - parity for bore in self.bores) + len(inertial)
        traction = {bore.surface: np.zeros((count, self._n_nodes, 3)) for bore in self.bores}
        for bore in self.bores:
            for pressed, nodal in _harmonics(bore, parity):
                traction[bore.surface][len(forces)] = radial_traction(bore.facets, self._n_nodes, nodal)
                forces.append(radial_forces(bore.facets, self._n_nodes, pressed))
        every = {surface: np.moveaxis(values, 0, -1) for surface, values in traction.items()}
        loads = (*forces, *inertial)
        if self._tilt is not None:  # balanced in every load separately, and so in their sum
            loads = tuple(self._tilt.balanced(load) for load in loads)
        return StoredFields(loads, every)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants, as `UnitLoads.weights`."""
        forces = {Surface.SMALL_END_BORE: instants.pin, Surface.BIG_END_BORE: instants.crank}
        pressed = [bore.weights(forces[bore.surface]) for bore in self.bores]
        even = [*(weights.even for weights in pressed), instants.motions[:2]]
        odd = [*(weights.odd for weights in pressed), instants.motions[2:]]
        return Weights(np.concatenate(even), np.concatenate(odd))

    def contacts(self, weights: Weights, instants: Instants, cycle: CrankCycle) -> Contacts:  # noqa: ARG002
        """Nothing: the load on the bores is prescribed."""
        return Contacts()


def _harmonics(bore: PressedBore, parity: int) -> Iterator[tuple[Floats, Floats]]:
    """Pressure of each harmonic at the quadrature points and at the nodes of the facets."""
    there, nodal = bore.pressures(bore.facets.angle), bore.pressures(bore.facets.node_angle)
    yield from zip(there[parity], nodal[parity], strict=True)


def _with_skewed(orders: Ints, facets: BoreFacets, arcs: tuple[Arc, Arc]) -> Ints:
    """Orders plus those of s(ψ) sin ψ, if a bore needs more of it than its mesh irregularity causes."""
    shares = {arc: _skewness(facets, arc) for arc in arcs}
    more = [skewed(arc, share).orders for arc, share in shares.items() if share > SKEWED]
    return reduce(np.union1d, more, orders)


def _skewness(facets: BoreFacets, arc: Arc) -> float:
    """Largest |b / a| of s(ψ)(a + b sin ψ) among forces in some directions."""
    angle, area = facets.angle.ravel(), facets.areas.ravel()
    if facets.cut_y:
        angle, area = np.append(angle, -angle), np.append(area, area)
    return max(_skewed_by(wrapped(angle - direction), area, arc) for direction in _DIRECTIONS)


def _skewed_by(psi: Floats, area: Floats, arc: Arc) -> float:
    """|b / a| in one direction; 0 if no facet lies within the arc."""
    within = np.abs(psi) < arc.angle / 2
    across = np.sin(psi[within])
    pressed = arc.unbounded(psi[within]) * area[within] * across
    return float(abs(pressed.sum()) / max(pressed @ across, np.finfo(float).tiny))
