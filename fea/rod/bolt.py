"""A bolt of a rod's cap: what the mechanics of the joint needs of it, and what its strength depends on."""

import math
from dataclasses import dataclass

from fea.choices import ThreadRolled
from fea.study.metric_thread import Thread


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
