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
    """A bolt, or a pair of them that are images about z = 0.

    Attributes
    ----------
    at
        Where its axis meets the joint, mm.
    force
        Of each, N.
    count
        One, or two for a pair.
    """

    at: Place
    force: float
    count: int


@dataclass(frozen=True, kw_only=True)
class FaceState:
    """An interface between two parts.

    Attributes
    ----------
    area
        mm².
    force
        Sum of pressure times area, N: of a plane joint, the force that clamps it.
    least, largest
        Of the pressures at the vertices, MPa; 0 where the parts have parted.
    open_share
        Of the area.
    opening
        Largest gap, mm.
    opening_at
        Where that is; None where nothing has opened.
    slipping_share
        Of the area that touches, where friction is used up.
    slip
        Largest, since the parts were put together, mm.
    shear
        Resultant of the shear stresses on a plane joint, N; 0 on a cylindrical seat.
    friction
        What friction can carry, N.
    edge_pressure
        Of the joint: the least pressure at the edge of the bore, MPa; 0 where it has opened there. None for
        other interfaces.
    """

    area: float
    force: float
    least: float
    largest: float
    open_share: float
    opening: float
    opening_at: Place | None
    slipping_share: float
    slip: float
    shear: float
    friction: float
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
    """Bolts and interfaces under one load.

    Attributes
    ----------
    bolts
        All bolts, once each.
    faces
        Interfaces by their first surface.
    """

    bolts: tuple[BoltState, ...]
    faces: Mapping[Surface, FaceState]

    @property
    def bolt_force(self) -> float:
        """Sum of all bolt forces, N."""
        return sum(bolt.count * bolt.force for bolt in self.bolts)

    @property
    def joint(self) -> FaceState:
        """The joint between rod and cap."""
        return self.faces[Surface.JOINT]

    def separating(self, assembled: "AssemblyState") -> float:
        """Load on the joint beside its bolts, N: what bolts gain and the joint loses.

        Parameters
        ----------
        assembled
            The state without load.
        """
        return self.bolt_force - assembled.bolt_force - (self.joint.force - assembled.joint.force)


@dataclass(frozen=True)
class Bolt:
    """One of the equal bolts of a cap.

    Attributes
    ----------
    thread
        Its thread.
    preload
        Force after tightening, less what embedding takes of it, N.
    stiffness
        Force over the elongation of what is not in the solid mesh: head, shank, free and engaged thread,
        and the threads of nut or hole, N/mm.
    head_diameter, nut_diameter
        Outer diameters of the seats, mm; that of the nut is 0 for a screw in a threaded hole.
    engaged
        Length of thread in the rod from the end of the grip, mm; 0 with a nut.
    grip
        From the seat of the head to that of the nut, or to the first thread that carries, mm.
    hole
        Diameter of the hole, mm.
    shank_diameter
        mm.
    proof, yield_strength, ultimate_strength
        S_p, R_p0.2 and R_m, MPa.
    thread_friction, head_friction
        μ_G and μ_K.
    rolled
        When the thread was rolled.
    assembly_preload
        Force after tightening, before embedding, N.
    """

    thread: Thread
    preload: float
    stiffness: float
    head_diameter: float
    nut_diameter: float
    engaged: float
    grip: float
    hole: float
    shank_diameter: float
    proof: float
    yield_strength: float
    ultimate_strength: float
    thread_friction: float
    head_friction: float
    rolled: ThreadRolled
    assembly_preload: float

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
