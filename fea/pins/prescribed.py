"""Pins whose load on a bore follows from their force alone: linear in it, or a pressure over an arc.

Unit loads of a pressure over an arc are harmonics cos nφ and sin nφ.
"""

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, reduce
from typing import Self

import numpy as np

from fea.base.choices import Support
from fea.base.units import DEG
from fea.pins.model import (
    PinModel,
    PinModelContext,
    Response,
    UnitLoads,
    Weights,
    inertial_fields,
    odd_part,
    total,
)
from fea.rod.meshed_rod import Bores
from fea.solid.bore import BoreFacets, BoreLoad, bore_facets, bore_load, radial_loads, wrapped
from fea.solid.inertia import Inertia, Tilt
from fea.solid.parity import Parity, ParityPair
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.bearing import BorePressure, PressureArc
from loads.crank_cycle import CrankCycle
from loads.instants import Instants
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class LoadedBore:
    """A bore that its pin loads."""

    surface: Surface
    facets: BoreFacets  #: on the meshed cell
    outwards: int  #: sign of the force along x that pulls this end outwards
    radius: float  #: mm
    width: float  #: mm, in the mean
    taper: float = 0.0  #: the width at the angle φ from +x is width + taper cos φ, mm

    def force(self, instants: Instants) -> Floats:
        """Force (2, n) of its pin on the rod, N."""
        return instants.pin if self.surface is Surface.SMALL_END_BORE else instants.crank


class PrescribedPins(PinModel):
    """Pins whose load on a bore follows from their force alone.

    `support`: with a clamped big end, the crank force is a reaction and not applied.
    """

    def __init__(
        self, mesh: TetMesh, bores: Bores, inertia: Inertia, support: Support, pressure: str = ""
    ) -> None:
        self.n_nodes, self.pressure, self.inertia = len(mesh.points), pressure, inertia
        small = bore_facets(mesh, Surface.SMALL_END_BORE, bores.rod_length)
        measures = (bores.small_radius, bores.small_width, bores.small_taper)
        self.bores = [LoadedBore(Surface.SMALL_END_BORE, small, 1, *measures)]
        if support is not Support.CLAMPED:
            big = bore_facets(mesh, Surface.BIG_END_BORE, 0.0)
            self.bores.append(LoadedBore(Surface.BIG_END_BORE, big, -1, bores.big_radius, bores.big_width))
        held = support is Support.CLAMPED or Surface.SYMMETRY_Z in mesh.facets  # neither lets it tilt
        self.tilt = None if held else Tilt.of(mesh.points, inertia)
        self._rod_length = bores.rod_length

    @classmethod
    def of(cls, structure: PinModelContext) -> Self:
        """Prepare the model for a rod."""
        with structure.clock("loads"):
            rod = structure
            return cls(rod.mesh, rod.bores, rod.inertia, rod.support, rod.pressure)

    @abstractmethod
    def load(self, bore: LoadedBore, force: tuple[float, float]) -> BoreLoad:
        """Load a bore with a force (x, y) on the whole rod, N."""

    def respond(self, instants: Instants, cycle: CrankCycle | None = None) -> list[Response]:  # noqa: ARG002
        """Return what acts on the rod at instants: see `PinModel.respond`."""
        return [self.response(instant, {}) for instant in instants]

    def response(self, instant: Instants, given: Mapping[Surface, BoreLoad]) -> Response:
        """Return what acts at one instant; `given`: loads of bores that take the place of the model's."""
        loads = dict(given)
        for bore in self.bores:
            if bore.surface not in loads:
                x, y = bore.force(instant)
                loads[bore.surface] = self.load(bore, (float(x), float(y)))
        parts = [load.forces for load in loads.values()]
        if instant.motions.any():
            parts.append(self.inertia.forces(instant))
        forces, tilt, largest = total(parts), None, float(instant.largest_force)
        # A mesh that can tilt is not cut at z = 0 and hence not at y = 0: the forces have one part only.
        if self.tilt is not None:
            force, *moments = self.tilt.out_of_plane(forces.symmetric)
            length = self._rod_length
            tilt = float(max(abs(force) * length, *map(abs, moments)) / (largest * length))
            forces = ParityPair(self.tilt.balanced(forces.symmetric), None)
        return Response(
            forces=forces,
            traction={surface: load.traction for surface, load in loads.items()},
            scale=max((load.scale for load in loads.values()), key=lambda scale: abs(scale - 1)),
            largest=largest,
            tilt=tilt,
        )


class LinearPins(PrescribedPins):
    """Pins whose load on a bore is linear in the components of the force: the sum of those along x and y."""

    def span(self, cycles: Sequence[CrankCycle]) -> UnitLoads:  # noqa: ARG002
        """Return forces along x and y on each bore, and inertia: they span every instant."""
        return UnitForces(self)


@dataclass(frozen=True)
class StoredFields:
    """Unit loads of one parity on the cell."""

    nodal: Sequence[Floats]  #: (n_nodes, 3) each, N
    pressed: Mapping[Surface, Floats]  #: per bore (n_nodes, 3, n_units), MPa

    @classmethod
    def of(
        cls,
        count: int,
        loads: Iterable[tuple[Surface, Floats, Floats]],
        inertial: Sequence[Floats],
        tilt: Tilt | None,
    ) -> "StoredFields":
        """Store `count` loads of bores, with forces and traction (n_nodes, 3) each, then inertia fields."""
        nodal, pressed = list[Floats](), dict[Surface, Floats]()
        for number, (surface, forces, traction) in enumerate(loads):
            every = pressed.setdefault(surface, np.zeros((count + len(inertial), *forces.shape)))
            every[number] = traction
            nodal.append(forces)
        nodal += inertial
        if tilt is not None:  # balanced in every load separately, and so in their sum
            nodal = [tilt.balanced(load) for load in nodal]
        return cls(nodal, {surface: np.moveaxis(values, 0, -1) for surface, values in pressed.items()})

    @property
    def count(self) -> int:
        """Number of unit loads."""
        return len(self.nodal)

    def forces(self, units: slice) -> Sequence[Floats]:
        """Nodal forces (n_nodes, 3) of some of them."""
        return self.nodal[units]

    def sums(self, units: slice) -> None:
        """Nothing: no forces are condensed where pressures are prescribed."""

    def traction(self, units: slice) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, n) of some of them on each bore."""
        return {surface: values[..., units] for surface, values in self.pressed.items()}


# Of the nodal forces of a load that is linear in its force: what rounding leaves.
_LINEAR = 1e-9
_Load = tuple[Surface, Floats, Floats]  # forces and traction (n_nodes, 3) on a bore


class UnitForces(UnitLoads):
    """Unit forces along x and y on each bore, and inertia."""

    def __init__(self, pins: LinearPins) -> None:
        self._pins = pins

    def fields(self) -> tuple[StoredFields, StoredFields]:
        """Return the even and the odd unit loads."""
        pins, (even_inertia, odd_inertia) = self._pins, inertial_fields(self._pins.inertia)
        even, odd = list[_Load](), list[_Load]()
        for bore in pins.bores:
            along, across, both = (pins.load(bore, force) for force in ((1.0, 0.0), (0.0, 1.0), (-1.0, 2.0)))
            x, y, mixed = (np.stack([load.forces.part(p) for p in Parity]) for load in (along, across, both))
            if np.abs(mixed + x - 2 * y).max() > _LINEAR * np.abs(x).max():
                rule = "is not linear in the components of the force: give it a span of its own"
                raise TypeError(f"{type(pins).__name__}.load {rule}")
            even.append((bore.surface, along.forces.symmetric, along.traction.symmetric))
            odd.append((bore.surface, odd_part(across.forces), odd_part(across.traction)))
        first = StoredFields.of(len(even), even, even_inertia, pins.tilt)
        return first, StoredFields.of(len(odd), odd, odd_inertia, pins.tilt)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:  # noqa: ARG002
        """Weights of the unit loads at n instants: see `UnitLoads.weights`."""
        forces, motions = [bore.force(instants) for bore in self._pins.bores], instants.motions
        return Weights(
            np.concatenate([*(force[:1] for force in forces), motions[:2]]),
            np.concatenate([*(force[1:] for force in forces), motions[2:]]),
        )


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
class _Series:
    """The orders of a series that approximates a pressure."""

    orders: Ints  #: (n_terms,) n, increasing, starting with 0 and 1
    error: float  #: largest difference from the pressure, relative to its peak


@cache
def series(arc: PressureArc, highest: int | None = None) -> _Series:
    """Expand an arc's pressure: up to order `highest`, or to an error of `TOLERANCE`, at most `HIGHEST`."""
    return _enough(arc, np.cos, 1.0) if highest is None else _truncated(arc, highest, np.cos)


@cache
def _enough(arc: PressureArc, wave: Wave, share: float) -> _Series:
    """Expand s(ψ) or s(ψ) sin ψ with the weight `share`: a smaller weight needs fewer terms."""
    highest = _AT_JUMPS if arc.profile.jumps else HIGHEST
    candidates = (_truncated(arc, order, wave) for order in range(8, highest + 1, 4))
    fit = (each for each in candidates if share * each.error <= TOLERANCE)
    return next(fit, _truncated(arc, highest, wave))


def _truncated(arc: PressureArc, highest: int, wave: Wave) -> _Series:
    psi = 2 * math.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    orders = np.arange(highest + 1)
    terms = _coefficients(arc, orders, wave)
    used = (np.abs(terms) > _NEGLIGIBLE) | (orders <= 1)
    sums = wave(np.multiply.outer(psi, orders[used])) @ terms[used]
    return _Series(orders[used], float(np.abs(sums - _pressure(arc, psi, wave)).max()))


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
    """_Harmonic pressures of 1 MPa on one bore."""

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
