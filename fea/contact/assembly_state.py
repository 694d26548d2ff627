"""How parts are put together, and what contact leaves under load: bolt forces, interfaces, pins in bores."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Ints, Vector
from geometry.assembly import BoltAxis
from geometry.surfaces import Surface

# Shear, over what friction can carry, that is none.
_ROUNDING = 1e-6

# The names of fits, by the seat.
FITS = {Surface.BUSHING_SEAT: "bushing", Surface.SHELL_SEAT: "shells"}


@dataclass(frozen=True)
class BoltBeam:
    """A bolt as a beam, from the first thread that carries (s = 0) to its head (s = 1)."""

    #: (2, 2) turns of the ends at head and thread from the line between the seats, of unit moments on the
    #: ends at head and thread, 1/(N mm)
    flexibility: Floats
    #: Sections where stress is highest, the first of them in the thread: s (n,), area (n,), mm², and section
    #: modulus (n,), mm³
    places: Floats
    areas: Floats
    moduli: Floats
    #: Force over the offset of the parts that bends it where it bears on its hole, N/mm; and the slip of the
    #: joint from which on it does, mm
    lateral: float = 0.0
    play: float = 0.0

    def bending(self, moments: Floats) -> Floats:
        """Bending stress (n, 2) in each plane at the sections of moments (2, 2) on the ends, MPa.

        `moments` has the planes in its rows and the ends at head and thread in its columns, N mm.
        """
        head, thread = np.asarray(moments).T
        inside = np.multiply.outer(self.places, head) - np.multiply.outer(1 - self.places, thread)
        return np.asarray(inside / self.moduli[:, None])


@dataclass(frozen=True, kw_only=True)
class Expansion:
    """A uniform change of temperature, K, and linear expansions, 1/K, of parts, bolts and both pins."""

    rise: float
    parts: tuple[float, ...]
    bolt: float
    piston_pin: float
    crank_pin: float


@dataclass(frozen=True, kw_only=True)
class AssemblySpecification:
    """How the parts of a rod are put together."""

    normal: tuple[float, float]  #: (x, y) of the joint plane, from the cap towards the rod
    bolts: tuple[BoltAxis, ...]  #: of the whole rod
    preload: float  #: of each bolt after tightening, N
    stiffness: float  #: of what of each bolt the mesh does not hold, N/mm
    beam: BoltBeam  #: each bolt as it bends
    friction: float  #: coefficient μ between the parts
    interference: Mapping[Surface, float]  #: radial, mm, by the first surface of an interface
    expansion: Expansion | None = None  #: None where the engine is as warm as the room of the assembly
    parts: tuple[str, ...] = ()  #: names of the parts in the order of their numbers


@dataclass(frozen=True)
class BoltState:
    """A bolt, or a pair of them that are images about z = 0."""

    at: Vector  #: where its axis meets the joint, mm
    force: float  #: of each, N
    count: int  #: one, or two for a pair
    bending: float = 0.0  #: largest bending stress of any section, MPa
    #: Bending stress of the first thread that carries, in two planes square to each other, MPa
    thread_bending: tuple[float, float] = (0.0, 0.0)
    fibre: float = 0.0  #: largest stress of tension and bending together, MPa
    ends: tuple[float, float] = (0.0, 0.0)  #: moments on head and thread, N mm
    shear: float = 0.0  #: of each, where it bears on its hole beside the joint, N


@dataclass(frozen=True, kw_only=True)
class FaceState:
    """An interface between two parts."""

    area: float  #: mm²
    force: float  #: sum of pressure times area, N: of a plane joint, the force that clamps it
    #: min_pressure, max_pressure: of those at the vertices, MPa; 0 where the parts have parted
    min_pressure: float
    max_pressure: float
    open_share: float  #: of the area
    opening: float  #: largest gap, mm
    opening_at: Vector | None  #: where that is; None where nothing has opened
    slipping_share: float  #: of the area that touches, where friction is used up
    slip: float  #: largest, since the parts were put together, mm
    shear: float  #: resultant of the shear stresses on a plane joint, N; 0 on a cylindrical seat
    friction: float  #: what friction can carry, N
    #: Of the joint: the least pressure at the edge of the bore, MPa; 0 where it has opened there. None for
    #: other interfaces.
    edge_pressure: float | None = None

    @property
    def mean_pressure(self) -> float:
        """Mean pressure, MPa."""
        return self.force / self.area

    @property
    def slip_reserve(self) -> float | None:
        """What friction can carry over the shear; None without either (VDI 2230-1, step R12)."""
        return self.friction / self.shear if self.shear > _ROUNDING * self.friction > 0 else None


@dataclass(frozen=True)
class AssemblyState:
    """Bolts and interfaces under one load."""

    bolts: tuple[BoltState, ...]  #: all bolts, once each
    faces: Mapping[Surface, FaceState]  #: interfaces by their first surface

    @property
    def bolt_force(self) -> float:
        """Sum of all bolt forces, N."""
        return sum(bolt.count * bolt.force for bolt in self.bolts)

    @property
    def joint(self) -> FaceState:
        """The joint between rod and cap."""
        return self.faces[Surface.JOINT]

    def separating(self, assembled: "AssemblyState") -> float:
        """Load on the joint beside its bolts, N: what bolts gain and the joint loses against no load."""
        return self.bolt_force - assembled.bolt_force - (self.joint.force - assembled.joint.force)


def bolt_forces(states: Sequence[AssemblyState]) -> Floats:
    """Forces (n_bolts, n) of the bolts in a sequence of states, N."""
    return np.array([[bolt.force for bolt in state.bolts] for state in states]).T


@dataclass(frozen=True)
class SeatFields:
    """What presses on one surface of the whole rod, at the nodes of its facets."""

    nodes: Ints  #: (n,) in ascending order
    pressure: Floats  #: (n,) MPa
    traction: Floats  #: (n, 3) force over area on the part that the surface bounds, with friction, MPa


@dataclass(frozen=True)
class PinContact:
    """Contact of a pin with its bore."""

    max_pressure: float  #: MPa
    at: float  #: where it is, about the bore's axis from rod +x, rad
    at_z: float  #: where it is along the bore, mm
    arc: float  #: angle around the bore over which they touch anywhere, to the distance of two vertices, rad

    @classmethod
    def of(cls, pressure: Floats, angle: Floats, z: Floats, apart: float) -> "PinContact":
        """Find it from pressures (n,), MPa, at angles (n,), rad, `apart` from each other, and z (n,), mm."""
        largest, arc = int(pressure.argmax()), 0.0
        touching = np.sort(angle[pressure > 0])
        if touching.size > 1:
            gaps = np.diff(np.append(touching, touching[0] + 2 * np.pi))
            arc = 2 * np.pi - float(gaps.max() if gaps.max() > 2.5 * apart else 0.0)
        return cls(float(pressure[largest]), float(angle[largest]), float(z[largest]), arc)
