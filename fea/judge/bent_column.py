"""The load up to which a column carries that is bowed from the beginning and yields.

Plane sections of elastic–perfectly plastic fibres. The deflection q keeps the shape of the elastic buckling
mode (Ježek 1937 does so for uniform columns; quoted from memory), and the load is the one that every section
between the bores carries. Where all is elastic this is exact: P = P_E q/(e + q) with the bow e. As yielding
concentrates curvature in the section that governs, which the elastic shape does not, the limit is on the safe
side. It lies between the load at which the first fibre yields (Ayrton & Perry 1886) and the lesser of Euler's
load and yield strength times least area.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from fea.judge.column import Plane, buckling_mode
from geometry.arrays import Floats, Mask
from mesh.slices import Slice

_BINS = 28  # of a section over its height
_STEPS = 40  # deflections that are tried
_HALVINGS = 26  # of the interval that contains the strain of an axis
_LARGEST = 0.1  # deflection beyond which small rotations do not hold, over the length


@dataclass(frozen=True)
class Fibres:
    """Sections of a column as fibres, of which the centre is the axis."""

    height: Floats  #: (n, m) mm from the axis about which they bend
    area: Floats  #: (n, m) mm²
    outermost: Floats  #: (n,) mm

    @classmethod
    def of(cls, slices: tuple[Slice, ...], plane: Plane) -> "Fibres":
        """Sort the triangles of slices by their distance from the axis about which a plane bends."""
        axis = 0 if plane is Plane.IN_PLANE else 1
        height, area, outermost = np.zeros((len(slices), _BINS)), np.zeros((len(slices), _BINS)), []
        for row, each in enumerate(slices):
            # Three points at the middles of its sides have the first and second moments of a triangle.
            corners = each.places[..., axis]
            at, weight = (corners + np.roll(corners, 1, axis=1)).ravel() / 2, np.repeat(each.areas / 3, 3)
            centre = at @ weight / weight.sum()
            reach = np.abs(corners - centre).max()
            number = np.clip(((at - centre) / reach + 1) * _BINS / 2, 0, _BINS - 1).astype(int)
            area[row] = np.bincount(number, weight, _BINS)
            height[row] = np.bincount(number, weight * (at - centre), _BINS) / np.maximum(area[row], 1e-30)
            outermost.append(float(reach))
        return cls(height, area, np.array(outermost))

    @property
    def second_moment(self) -> Floats:
        """(n,) mm⁴."""
        return np.asarray((self.area * self.height**2).sum(axis=1))

    def __getitem__(self, which: Mask) -> "Fibres":
        return Fibres(self.height[which], self.area[which], self.outermost[which])


@dataclass(frozen=True)
class BentColumn:
    """A bowed column that bends in a plane: load over deflection, from first yield on."""

    plane: Plane
    bow: float  #: mm, of the unloaded column at its largest
    strength: float  #: at which it yields, MPa
    euler: float  #: elastic critical load, N
    squash: float  #: yield strength times the least area, N
    perry: float  #: load at which the first fibre yields, N
    slope: float  #: ∫φ′² dx of the mode φ, whose largest value is 1, 1/mm
    deflection: Floats  #: (k,) that is added to the bow, mm
    load: Floats  #: (k,) N

    @property
    def limit(self) -> float:
        """The largest load, N."""
        return float(self.load.max())

    @cached_property
    def falling(self) -> "BentColumn":
        """The column from its limit on."""
        beyond = slice(int(self.load.argmax()), None)
        return replace(self, deflection=self.deflection[beyond], load=self.load[beyond])

    @property
    def shortening(self) -> Floats:
        """(k,) by which bending brings the ends closer, mm."""
        return self._closer(self.deflection)

    @property
    def left(self) -> tuple[Floats, Floats]:
        """Deflection and shortening (k,) without load, which is taken away elastically, mm."""
        left = self.deflection - self.load * (self.bow + self.deflection) / self.euler
        return left, self._closer(left)

    def _closer(self, deflection: Floats) -> Floats:
        return self.slope * ((self.bow + deflection) ** 2 - self.bow**2) / 2


def bent_column(
    plane: Plane,
    ends: Floats,
    fibres: Fibres,
    bearing: Mask,
    *,
    youngs_modulus: float,
    yield_strength: float,
    bow: float,
) -> BentColumn:
    """Follow a column from first yield until it carries no more and beyond.

    `fibres`: of the section (n) midway between each two of the `ends` (n + 1,), mm; those that are `bearing`
    (n,) may yield. Both ends are pinned in the plane of motion, and built in sideways.
    """
    E, stiffness = youngs_modulus, youngs_modulus * fibres.second_moment
    euler, mode = buckling_mode(ends, stiffness, built_in=plane is Plane.SIDEWAYS)
    mode = mode / np.abs(mode[:, 0]).max()
    length, turned = np.diff(ends), np.diff(mode[:, 1])
    curvature = np.abs(turned / length)  # of a deflection of 1 mm
    work = float((stiffness * curvature**2 * length).sum())
    slope = work / euler  # Rayleigh's quotient
    lever = (stiffness * curvature / euler)[bearing]
    shank, curvature = fibres[bearing], curvature[bearing]
    area = shank.area.sum(axis=1)
    squash = yield_strength * float(area.min())

    def beyond_yield(load: float) -> float:
        bent = bow * load / (euler - load)
        return float((load / area + E * bent * curvature * shank.outermost).max()) - yield_strength

    most = min(squash, euler * (1 - 1e-9))
    perry = float(brentq(beyond_yield, 0.0, most)) if beyond_yield(most) > 0 else most
    first = bow * perry / (euler - perry)
    largest = max(_LARGEST * float(np.ptp(ends)), 2 * first)
    deflection = np.geomspace(first, largest, _STEPS)
    bent, arm = np.multiply.outer(deflection, curvature), np.multiply.outer(bow + deflection, lever)
    load = _carried(shank, bent, arm, youngs_modulus=E, yield_strength=yield_strength).min(axis=1)
    load[0] = perry
    return BentColumn(plane, bow, yield_strength, euler, squash, perry, slope, deflection, load)


def _carried(
    fibres: Fibres, curvature: Floats, arm: Floats, *, youngs_modulus: float, yield_strength: float
) -> Floats:
    """Load (k, n), N, that sections (n) carry with a curvature, 1/mm, at an arm, mm, both (k, n): M = P a."""
    bent = youngs_modulus * curvature[..., None] * fibres.height  # stress, MPa

    def force(at: Floats) -> Floats:
        """Force of every fibre, N, with an elastic stress on the axis, MPa."""
        return np.asarray(np.clip(at[..., None] + bent, -yield_strength, yield_strength) * fibres.area)

    low, high = -(yield_strength + np.abs(bent).max(axis=-1)), np.zeros(arm.shape)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        each = force(middle)
        above = (each * fibres.height).sum(axis=-1) + each.sum(axis=-1) * arm > 0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(-force(high).sum(axis=-1))
