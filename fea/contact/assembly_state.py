"""The state of an assembled rod under load: forces of its bolts, and what its interfaces do."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from fea.base.choices import ThreadRolled
from fea.study.bolts import Thread
from geometry.surfaces import Surface

# Shear, over what friction can carry, that is none.
_ROUNDING = 1e-6

Place = tuple[float, float, float]


@dataclass(frozen=True)
class BoltState:
    """A bolt, or a pair of them that are images about z = 0."""

    at: Place  # where its axis meets the joint, mm
    force: float  # of each, N
    count: int  # one, or two for a pair


@dataclass(frozen=True, kw_only=True)
class FaceState:
    """An interface between two parts."""

    area: float  # mm²
    force: float  # sum of pressure times area, N: of a plane joint, the force that clamps it
    # least, largest: of the pressures at the vertices, MPa; 0 where the parts have parted
    least: float
    largest: float
    open_share: float  # of the area
    opening: float  # largest gap, mm
    opening_at: Place | None  # where that is; None where nothing has opened
    slipping_share: float  # of the area that touches, where friction is used up
    slip: float  # largest, since the parts were put together, mm
    shear: float  # resultant of the shear stresses on a plane joint, N; 0 on a cylindrical seat
    friction: float  # what friction can carry, N
    # Of the joint: the least pressure at the edge of the bore, MPa; 0 where it has opened there. None for
    # other interfaces.
    edge_pressure: float | None = None

    @property
    def mean(self) -> float:
        """Mean pressure, MPa."""
        return self.force / self.area

    @property
    def slip_safety(self) -> float | None:
        """What friction can carry over the shear; None without either (VDI 2230-1, step R12)."""
        return self.friction / self.shear if self.shear > _ROUNDING * self.friction > 0 else None


@dataclass(frozen=True)
class AssemblyState:
    """Bolts and interfaces under one load."""

    bolts: tuple[BoltState, ...]  # all bolts, once each
    faces: Mapping[Surface, FaceState]  # interfaces by their first surface

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


@dataclass(frozen=True)
class Bolt:
    """One of the equal bolts of a cap."""

    thread: Thread
    preload: float  # force after tightening, less what embedding takes of it, N
    # Force over the elongation of what is not in the solid mesh: head, shank, free and engaged thread, and
    # the threads of nut or hole, N/mm
    stiffness: float
    # head_diameter, nut_diameter: outer diameters of the seats, mm; that of the nut is 0 for a screw in a
    # threaded hole
    head_diameter: float
    nut_diameter: float
    engaged: float  # length of thread in the rod from the end of the grip, mm; 0 with a nut
    grip: float  # from the seat of the head to that of the nut, or to the first thread that carries, mm
    hole: float  # diameter of the hole, mm
    shank_diameter: float  # mm
    # proof, yield_strength, ultimate_strength: S_p, R_p0.2 and R_m, MPa
    proof: float
    yield_strength: float
    ultimate_strength: float
    # thread_friction, head_friction: μ_G and μ_K
    thread_friction: float
    head_friction: float
    rolled: ThreadRolled  # when the thread was rolled
    assembly_preload: float  # force after tightening, before embedding, N

    @property
    def compliance(self) -> float:
        """δ_S, mm/N."""
        return 1 / self.stiffness

    @property
    def least_diameter(self) -> float:
        """d₀: the stress diameter of the thread, or the diameter of a thinner shank, mm."""
        return min(self.thread.stress_diameter, self.shank_diameter)

    @property
    def least_area(self) -> float:
        """A₀ = π/4 d₀², mm²."""
        return math.pi / 4 * self.least_diameter**2

    @property
    def proof_load(self) -> float:
        """S_p A₀, N."""
        return self.proof * self.least_area

    @property
    def least_seat_area(self) -> float:
        """A_p: area of the smaller seat, mm²."""
        seat = min(self.head_diameter, self.nut_diameter or self.head_diameter)
        return math.pi / 4 * (seat**2 - self.hole**2)

    @property
    def friction_diameter(self) -> float:
        """D_Km: mean diameter of the friction under the head (VDI 2230), mm."""
        return (self.head_diameter + self.hole) / 2
