"""An elastic pin, solid or hollow, as a body of revolution under pressures that vary around it.

A pressure p cos nφ on a body of revolution causes the displacements u_r cos nφ, u_φ sin nφ, u_z cos nφ: a
plane problem for each harmonic takes the place of a solid mesh (Wilson 1965). Its stiffness is
K₀ + n K₁ + n² K₂, so that it is integrated only once.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dtbtrs
from skfem import Basis, ElementQuad2, MeshQuad

from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask

# Number of elements through the wall, at least; over half of the bore's width, from there to the supports,
# and over the supports. Those at the surface and at the end of the bore are the smallest: neighbours differ
# by these ratios.
RADIAL, TOUCHING, BETWEEN, CARRIED = 6, 12, 3, 4
_RADIAL_RATIO, _AXIAL_RATIO = 0.65, 0.75
# Of the harmonics beyond this one only some are solved for, in growing steps: n times the compliance of the
# others is interpolated, as it hardly changes from one to the next.
_EACH, _FEW = 12, 20
# Exact for products of biquadratic functions; those over r are smooth enough.
_DEGREE = 5
_AXES = 3
# Orders of half a cosine cos φ over |φ| < π/2, and its coefficients; those beyond do not reach the bore.
ORDERS = (0, 1, 2, 4, 6, 8, 10, 12)
HALF_COSINE = np.array([1 / np.pi, 0.5, *(2 / np.pi * (-1) ** (n // 2 + 1) / (n**2 - 1) for n in ORDERS[2:])])


@dataclass(frozen=True)
class Pin:
    """A pin in the middle of its bore, symmetric about z = 0."""

    #: radius, inner_radius: mm; 0 inside for a solid pin
    radius: float
    inner_radius: float
    touching: float  #: half of the length over which it may touch the bore, mm
    #: Distances from the middle between which its supports carry it, mm; None for a slice of a long pin
    #: (plane strain)
    carried: tuple[float, float] | None
    #: youngs_modulus, poissons_ratio: E, MPa, and ν
    youngs_modulus: float
    poissons_ratio: float


@dataclass(frozen=True)
class _Harmonic:
    """The pin's answer to pressures of one harmonic."""

    order: int  #: n
    compliance: Floats  #: (n_z, n_z) inward displacement at the stations, mm, of forces that work on it, N
    carried: Floats  #: (n_z,) inward displacement of a pressure cos nφ of 1 MPa on the supports, mm


@cache
def harmonics(pin: Pin, highest: int, *, mirrored: bool) -> tuple[Floats, tuple[_Harmonic, ...]]:
    """Stations along a pin, and its answer to the harmonics 0 … `highest`; parameters as for `ElasticPin`."""
    half = ElasticPin(pin, mirrored=mirrored, highest=highest)
    return half.stations, tuple(half.harmonics_up_to(highest))


def bending(pin: Pin, force: float, *, evenly: bool = True) -> float:
    """By how much the ends of what touches the bore stand out beyond the middle under a force, N: mm.

    The bore presses evenly along the pin, or else like a parabola that falls to nothing at its ends, the
    supports press evenly, and both with half a cosine around it.
    """
    if pin.carried is None:
        return 0.0
    half, (near, far) = _under_half_cosines(pin), pin.carried
    length = half.stations[-1]
    pressed, carrying = (force / (np.pi * pin.radius * long) for long in (length, far - near))
    shape = 1.0 if evenly else 1.5 * (1 - (half.stations / length) ** 2)
    along = shape * half.along(0.0, length)[: len(half.stations)]
    moved = np.zeros_like(half.stations)
    for answer, share in zip(half.of_half_cosine, HALF_COSINE, strict=True):
        around = np.pi * (1 + (answer.order == 0))
        moved += share * around * pressed * (answer.compliance @ along)
        moved += share * (-1) ** answer.order * carrying * answer.carried
    return float(moved[0] - moved[-1])


@lru_cache(maxsize=1)  # for the forces on one pin: a mesh and its stiffness take megabytes
def _under_half_cosines(pin: Pin) -> "ElasticPin":
    return ElasticPin(pin, highest=ORDERS[-1])


class ElasticPin:
    """The half z ≥ 0 of a pin, meshed.

    Its fields are symmetric about z = 0 (`mirrored`) or antisymmetric. The `highest` harmonic reaches as deep
    as the radius over its order. `stations` (n_z,) are the distances from the middle at which the surface is
    observed, mm: the ends and middles of the elements along the part that may touch.
    """

    def __init__(self, pin: Pin, *, mirrored: bool = True, highest: int = 64) -> None:
        self._pin, self._mirrored = pin, mirrored
        touching = _graded(0.0, pin.touching, TOUCHING, _AXIAL_RATIO)
        along = touching
        if pin.carried is not None:
            near, far = pin.carried
            between = np.linspace(pin.touching, near, BETWEEN + 1)[1 : None if near > pin.touching else 1]
            along = np.concatenate([touching, between, np.linspace(near, far, CARRIED + 1)[1:]])
        wall, count = pin.radius - pin.inner_radius, RADIAL
        while _graded(0.0, wall, count, _RADIAL_RATIO)[-2] < wall - pin.radius / highest:
            count += 1
        across = _graded(pin.inner_radius, pin.radius, count, _RADIAL_RATIO)
        self._basis = Basis(MeshQuad.init_tensor(across, along), ElementQuad2(), intorder=_DEGREE)
        r, z = self._basis.doflocs
        # Nodes in the order of z, then of r, which gives the stiffness the narrowest band.
        self._order = np.lexsort((r, np.round(z / pin.radius, 9)))
        self._terms = _stiffness_terms(self._basis, pin.youngs_modulus, pin.poissons_ratio, self._order)
        outer = np.flatnonzero(r > pin.radius * (1 - 1e-9))
        self._outer = outer[np.argsort(z[outer])]
        self.stations = z[self._outer][: 2 * TOUCHING + 1]

    @cached_property
    def of_half_cosine(self) -> tuple[_Harmonic, ...]:
        """Answer to each harmonic of half a cosine."""
        return tuple(self.harmonics(np.array(ORDERS)))

    def harmonics(self, orders: Ints) -> Iterator[_Harmonic]:
        """Answer of each harmonic."""
        load = np.zeros((_AXES * self._basis.N, len(self.stations) + 1))
        surface = _AXES * np.argsort(self._order)[self._outer[: len(self.stations)]]
        load[surface, np.arange(len(surface))] = 1.0
        carrying = np.zeros((self._basis.N, _AXES))  # ∫ N R dz of 1 MPa on the support, per angle
        if self._pin.carried is not None:
            carrying[self._outer, 0] = self.along(*self._pin.carried)
        squeezed = carrying[self._order].ravel()
        for order in orders.tolist():
            around = np.pi * (1 + (order == 0))  # ∫ cos² nφ dφ
            load[:, -1] = around * squeezed
            K0, K1, K2 = self._terms
            held = self._held(order)[self._order].ravel()
            K = around * (K0 + order * K1 + order**2 * K2)  # the lower band, (width, n)
            free = np.append(~held, np.zeros(len(K) - 1, dtype=bool))
            K = np.where(sliding_window_view(free, len(K)).T & ~held, K, 0.0)
            K[0, held] = 1.0
            factor = cholesky_banded(K, lower=True, overwrite_ab=True, check_finite=False)
            # The work FᵀK⁻¹F of the loads F is YᵀY with Y = L⁻¹F, for which forward substitution is enough.
            half = dtbtrs(factor, np.where(held[:, None], 0.0, load), uplo="L", overwrite_b=1)[0]
            work = half.T @ half
            yield _Harmonic(order, work[:-1, :-1], work[:-1, -1])

    def harmonics_up_to(self, highest: int) -> Iterator[_Harmonic]:
        """Answer of the harmonics 0 … `highest`; of those beyond the twelfth, none to the supports."""
        if highest <= _FEW:
            yield from self.harmonics(np.arange(highest + 1))
            return
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - a coarse mesh does without

        steps = np.unique(np.append(_EACH * 1.2 ** np.arange(1, 99), highest).round().astype(int))
        solved = list(self.harmonics(np.append(np.arange(_EACH + 1), steps[steps <= highest])))
        orders = np.array([answer.order for answer in solved])
        between = CubicSpline(orders[2:], [answer.order * answer.compliance for answer in solved[2:]])
        known = {answer.order: answer for answer in solved}
        nowhere = np.zeros(len(self.stations))
        for order in range(highest + 1):
            yield known.get(order) or _Harmonic(order, between(order) / order, nowhere)

    def along(self, near: float, far: float) -> Floats:
        """Radial forces (n_outer,) of 1 MPa on the surface between two stations, per angle."""
        z, forces = self._basis.doflocs[1][self._outer], np.zeros(len(self._outer))
        for start in range(0, len(z) - 2, 2):
            ends = z[start], z[start + 2]
            if near - 1e-9 <= ends[0] and ends[1] <= far + 1e-9:
                forces[start : start + 3] += self._pin.radius * (ends[1] - ends[0]) * np.array([1, 4, 1]) / 6
        return forces

    def _held(self, order: int) -> Mask:
        """Degrees of freedom (n_nodes, 3) fixed by symmetry, at the axis, or to stop a rigid motion."""
        r, z = self._basis.doflocs
        held = np.zeros((self._basis.N, _AXES), dtype=bool)  # u_r, u_φ, u_z
        middle, axis = z < 1e-9, r < 1e-9 * self._pin.radius
        held[middle] |= [False, False, True] if self._mirrored else [True, True, False]
        if self._pin.carried is None:
            held[z > z.max() - 1e-9, 2] = True
        if order == 0:
            held[:, 1] = True
            held[axis, 0] = True
            if not self._mirrored:
                held[self._outer[-1], 2] = True
        elif order == 1:
            held[axis, 2] = True
            # Where a slice is held does not matter: its surface only moves along by cos φ.
            held[self._outer[-1] if self._pin.carried else r < self._pin.inner_radius + 1e-9, 0] = True
        else:
            held[axis] = True
        return held


def _graded(start: float, end: float, count: int, ratio: float) -> Floats:
    """Ends of elements whose lengths fall by a ratio towards the end."""
    lengths = ratio ** np.arange(count)
    inside = start + (end - start) * np.cumsum(lengths)[:-1] / lengths.sum()
    return np.concatenate([[start], inside, [end]])


def _stiffness_terms(basis: Basis, E: float, nu: float, order: Ints) -> tuple[Floats, ...]:
    """Lower bands (width, n) of K₀, K₁ and K₂ of one radian, with three degrees of freedom per node in order.

    The entry of row i and column j is that of row i − j and column j of the band, as LAPACK has it.
    """
    r, weight = np.asarray(basis.global_coordinates())[0], basis.dx
    n = len(basis.basis)
    values = np.stack([np.broadcast_to(np.asarray(f[0]), r.shape) / r for f in basis.basis], axis=-1)
    d_r, d_z = (np.stack([f[0].grad[axis] for f in basis.basis], axis=-1) for axis in (0, 1))
    # Strains rr, φφ, zz, rφ, φz, rz of u_r, u_φ, u_z: those without n, and those times n.
    plain, times = np.zeros((2, *r.shape, 6, n, _AXES))
    plain[..., 0, :, 0] = d_r
    plain[..., 1, :, 0] = values
    plain[..., 2, :, 2] = d_z
    plain[..., 3, :, 1] = d_r - values
    plain[..., 4, :, 1] = d_z
    plain[..., 5, :, 0], plain[..., 5, :, 2] = d_z, d_r
    times[..., 1, :, 1] = values
    times[..., 3, :, 0] = -values
    times[..., 4, :, 2] = -values
    plain, times = (of.reshape(*r.shape, 6, _AXES * n) for of in (plain, times))
    law, mu = np.zeros((6, 6)), E / (2 * (1 + nu))
    law[:3, :3] = 2 * mu * nu / (1 - 2 * nu)
    law[np.arange(6), np.arange(6)] += mu * np.array([2, 2, 2, 1, 1, 1])
    nodes = np.argsort(order)[basis.element_dofs.T]
    dofs = (_AXES * nodes[:, :, None] + np.arange(_AXES)).reshape(len(nodes), -1)
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    size, lower = _AXES * basis.N, rows >= columns
    at = (rows - columns)[lower] * size + columns[lower]
    width = int((rows - columns).max()) + 1

    def product(one: Floats, other: Floats) -> Floats:
        return np.asarray(np.einsum("eq,eqsa,st,eqtb->eab", weight * r, one, law, other, optimize=True))

    def band(local: Floats) -> Floats:
        return np.asarray(np.bincount(at, local[lower], width * size), float).reshape(width, size)

    mixed = product(plain, times)
    return band(product(plain, plain)), band(mixed + mixed.swapaxes(1, 2)), band(product(times, times))


@dataclass(frozen=True)
class Deflection:
    """Inward displacement of an elastic pin, as moments on the cell."""

    compliance: dict[Parity, Floats]  #: per parity (n, n), of pressures on the bore
    #: Per parity (n, n_orders), of pressures of 1 MPa times cos nφ or sin nφ on the supports
    carried: dict[Parity, Floats]

    @classmethod
    def of(
        cls,
        pin: Pin,
        highest: int,
        z: Floats,
        harmonic: Callable[[int, Floats], Mapping[Parity, Floats]],
        *,
        cut_y: bool,
        cut_z: bool,
    ) -> "Deflection":
        """Add up the harmonics up to the `highest`.

        `z` (n_points,) quadrature points on the bore from its middle, mm; `harmonic`: moments (n, k) of cos
        nφ and sin nφ times fields (n_points, k) there; `cut_y`, `cut_z`: see `PinInBore`.
        """
        compliance, carried = dict[Parity, Floats](), dict[Parity, Floats]()
        share = (2 if cut_y else 1) * (1 if cut_z else 0.5)
        for mirrored in (True,) if cut_z else (True, False):
            stations, answers = harmonics(pin, highest, mirrored=mirrored)
            along = _between(stations, np.abs(z)) * (1.0 if mirrored else np.sign(z)[:, None])
            for answer in answers:
                for parity, moments in harmonic(answer.order, along).items():
                    more = share * moments @ answer.compliance @ moments.T
                    compliance[parity] = compliance.get(parity, 0.0) + more
                    if mirrored and answer.order in ORDERS:
                        every = carried.setdefault(parity, np.zeros((len(moments), len(ORDERS))))
                        every[:, ORDERS.index(answer.order)] = moments @ answer.carried
        if not cut_y:
            compliance = {Parity.SYMMETRIC: compliance[Parity.SYMMETRIC] + compliance[Parity.ANTISYMMETRIC]}
        return cls(compliance, carried)

    def pressed(self, pin: Pin, force: Floats) -> dict[Parity, Floats]:
        """Moments (n, …) of the deflection by the supports, for forces (2, …) of the pin on the whole rod, N.

        They press with half a cosine around the side opposite to the force, constant along their length.
        """
        near, far = pin.carried or (0.0, np.inf)
        peak = 2 * np.hypot(*force) / (np.pi * pin.radius * 2 * (far - near))
        share = np.multiply.outer(HALF_COSINE, peak)
        turned = np.multiply.outer(ORDERS, np.arctan2(force[1], force[0]) + np.pi)
        waves = {Parity.SYMMETRIC: np.cos(turned), Parity.ANTISYMMETRIC: np.sin(turned)}
        return {parity: self.carried[parity] @ (share * wave) for parity, wave in waves.items()}


def _between(stations: Floats, z: Floats) -> Floats:
    """Values (n, n_stations) at places z of the quadratic functions: every other station ends an element."""
    ends = stations[::2]
    element = np.clip(np.searchsorted(ends, z, side="right") - 1, 0, len(ends) - 2)
    s = np.clip((z - ends[element]) / (ends[element + 1] - ends[element]), 0.0, 1.0)
    values = np.zeros((len(z), len(stations)))
    rows = np.arange(len(z))
    for place, value in enumerate(((1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1))):
        values[rows, 2 * element + place] = value
    return values
