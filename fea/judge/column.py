"""Buckling of the rod as a column: Euler load of its sections, Johnson's parabola, Rankine's formula.

The rod is pinned at both ends in the plane of motion (effective length l) and built in at both ends sideways
(l/2), because a pin allows rotation in the plane of motion only. Shigley, Mechanical Engineering Design,
chapter 4.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cache

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

from geometry.arrays import Floats
from geometry.section import CrossSection


class Plane(StrEnum):
    """The plane in which a column bends."""

    IN_PLANE = "in_plane"  # of motion
    SIDEWAYS = "sideways"

    @property
    def length_factor(self) -> float:
        """Effective length of a uniform column over its length."""
        return 1.0 if self is Plane.IN_PLANE else 0.5

    def inertia(self, section: CrossSection) -> float:
        """Second moment of area of a section for this bending, mm⁴."""
        return section.inertia_z if self is Plane.IN_PLANE else section.inertia_y

    def gyration(self, section: CrossSection) -> float:
        """Radius of gyration of a section for this bending, mm."""
        return math.sqrt(self.inertia(section) / section.area)


@dataclass(frozen=True)
class ColumnLoads:
    """Critical loads of a column that bends in one plane."""

    slenderness: float  #: effective length over the radius of gyration of the smallest section
    euler: float  #: elastic critical load for the varying sections, N
    squash: float  #: yield strength times the smallest area, N

    @property
    def johnson(self) -> float:
        """Johnson's parabola (1893) S_y A (1 − S_y A/4P_E), N; Euler's load, touching it, below S_y A/2."""
        if self.euler < self.squash / 2:
            return self.euler
        return self.squash * (1 - self.squash / (4 * self.euler))

    @property
    def rankine(self) -> float:
        """Rankine and Gordon's S_y A/(1 + a (Kl/r)²) with a = S_y/π²E, N: 1/P = 1/S_y A + 1/P_E."""
        return 1 / (1 / self.squash + 1 / self.euler)

    @property
    def least(self) -> float:
        """The smallest of the critical loads, N."""
        return min(self.euler, self.johnson, self.rankine)


@cache
def column(
    plane: Plane,
    stations: tuple[CrossSection, ...],
    least: CrossSection,
    youngs_modulus: float,
    yield_strength: float,
) -> ColumnLoads:
    """Critical loads in a plane, cached, from sections between the pin centres and the `least` of them."""
    x = np.array([section.x for section in stations])
    inertia = np.array([plane.inertia(section) for section in stations])
    slenderness = plane.length_factor * float(x[-1] - x[0]) / plane.gyration(least)
    euler = euler_load(x, youngs_modulus * inertia, built_in=plane is Plane.SIDEWAYS)
    return ColumnLoads(slenderness, euler, yield_strength * least.area)


def euler_load(x: Floats, bending_stiffness: Floats, *, built_in: bool) -> float:
    """Critical load, N, of a column of varying section EI (n,), N·mm², linear between x (n,), mm."""
    return buckling_mode(x, (bending_stiffness[1:] + bending_stiffness[:-1]) / 2, built_in=built_in)[0]


def buckling_mode(x: Floats, bending_stiffness: Floats, *, built_in: bool) -> tuple[float, Floats]:
    """Critical load, N, of a column of varying section, and its mode: (EI w″)″ + P w″ = 0.

    Beam elements with cubic deflections between the stations x (n,), mm, of EI (n − 1,), N·mm² (Przemieniecki
    1968, chapter 15). Both ends are built in, or both pinned. The mode is deflection and slope (n, 2).
    """
    n = 2 * len(x)
    K, G = np.zeros((2, n, n))
    for i, (h, stiffness) in enumerate(zip(np.diff(x), bending_stiffness, strict=True)):
        dofs = slice(2 * i, 2 * i + 4)
        scale = np.diag([1.0, h, 1.0, h])
        K[dofs, dofs] += stiffness / h**3 * scale @ _BENDING @ scale
        G[dofs, dofs] += scale @ _GEOMETRIC @ scale / (30 * h)
    held = {0, n - 2} | ({1, n - 1} if built_in else set())
    free = np.array([i for i in range(n) if i not in held])
    inner = np.ix_(free, free)
    stiffness, load = (sparse.csc_array(matrix[inner]) for matrix in (K, G))
    largest, shape = eigsh(load, 1, stiffness, which="LA", v0=np.ones(len(free)))
    mode = np.zeros(n)
    mode[free] = shape[:, 0]
    return float(1 / largest[0]), mode.reshape(-1, 2)


_BENDING = np.array(
    [[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]]
)
_GEOMETRIC = np.array(
    [[36.0, 3.0, -36.0, 3.0], [3.0, 4.0, -3.0, -1.0], [-36.0, -3.0, 36.0, -3.0], [3.0, -1.0, -3.0, 4.0]]
)
