"""A bolt, and what its forces and its bending in a cycle mean (VDI 2230-1:2015, steps R7 to R10 and R12).

Factors of tension alone stand beside those with bending. Against fatigue the guideline counts bending, as
σ_SAbb of an eccentric joint (R9); against yielding it does not, because only the outer fibre would yield.
"""

import math
from dataclasses import dataclass

import numpy as np

from fea.base.choices import ThreadRolled
from fea.judge import vdi2230
from fea.study.assembly_table import BoltStrength, Thread
from geometry.arrays import Floats

# k_τ: share of the torsion of tightening that remains in service.
_TORSION_LEFT = 0.5
# Play, over the hole's diameter, that is none: what rounding leaves of a bolt in inches.
_FITTED = 1e-9
# Places around a thread whose stress is followed: the largest amplitude is met to 0.2 %.
_AROUND = np.linspace(0, 2 * np.pi, 48, endpoint=False)


@dataclass(frozen=True, kw_only=True)
class BoltShape:
    """A bolt in its seats; lengths in mm."""

    thread: Thread
    grip: float  #: from the seat of the head to that of the nut, or to the first thread that carries
    engaged: float  #: length of thread in the rod from the end of the grip; 0 with a nut
    #: Outer diameters of the seats; that of the nut is 0 for a screw in a threaded hole
    head_diameter: float
    nut_diameter: float
    shank_diameter: float
    free_thread: float  #: length of thread in the grip; the rest is shank
    hole: float  #: its diameter

    @property
    def least_diameter(self) -> float:
        """d₀: the stress diameter of the thread, or the diameter of a thinner shank, mm."""
        return min(self.thread.stress_diameter, self.shank_diameter)

    @property
    def least_area(self) -> float:
        """A₀ = π/4 d₀², mm²."""
        return math.pi / 4 * self.least_diameter**2

    @property
    def play(self) -> float:
        """Least distance between bolt and hole where both are centred, mm."""
        widest = max(self.shank_diameter, self.thread.diameter if self.free_thread else 0.0)
        play = (self.hole - widest) / 2
        return play if play > _FITTED * self.hole else 0.0

    def lift(self, force: float, ends: tuple[float, float]) -> float:
        """Largest moment on a seat over that at which its edge lifts, F (D² + d_h²)/(8 D) of a ring.

        `ends`: moments on head and thread, N mm. Where the pressure on a seat is linear, it vanishes at the
        edge as the force leaves the ring's core.
        """
        seats = zip(ends, (self.head_diameter, self.nut_diameter), strict=True)
        return max(8 * D * moment / (force * (D**2 + self.hole**2)) for moment, D in seats if D)

    @property
    def least_seat_area(self) -> float:
        """A_p: area of the smaller seat, mm²."""
        seat = min(self.head_diameter, self.nut_diameter or self.head_diameter)
        return math.pi / 4 * (seat**2 - self.hole**2)


@dataclass(frozen=True, kw_only=True)
class Bolt(BoltShape):
    """One of the equal bolts of a cap, tightened."""

    strength: BoltStrength
    #: Force over the elongation of what is not in the solid mesh: head, shank, free and engaged thread, and
    #: the threads of nut or hole, N/mm
    stiffness: float
    thread_friction: float  #: μ_G
    rolled: ThreadRolled  #: when the thread was rolled
    assembly_preload: float  #: force after tightening, before embedding, N
    preload: float  #: the same, less what embedding takes of it

    @property
    def proof_load(self) -> float:
        """S_p A₀, N."""
        return self.strength.proof * self.least_area

    def tightening_stress(self, *, turned: bool) -> float:
        """Von Mises stress at the end of tightening, MPa; a bolt that is stretched has no torsion."""
        force = self.assembly_preload
        if not turned:
            return force / self.least_area
        return vdi2230.tightening_stress(force, self.thread, self.least_diameter, self.thread_friction)

    def working_stress(self, tension: float, across: float = 0.0, *, torsion: bool = True) -> float:
        """σ_red,B = √[σ_z² + 3 (k_τ τ + τ_Q)²] of a tensile stress and of shear across the bolt, MPa (R8).

        A stretched bolt has no torsion.
        """
        if torsion:
            twisting = vdi2230.thread_torque(self.assembly_preload, self.thread, self.thread_friction)
            across += _TORSION_LEFT * twisting / (math.pi / 16 * self.least_diameter**3)
        return math.hypot(tension, math.sqrt(3) * across)

    def endurance(self, mean_force: float) -> float:
        """σ_AS of the thread at the mean force of the cycle, MPa."""
        if self.rolled is ThreadRolled.BEFORE:
            return vdi2230.endurance_before(self.thread.diameter)
        yield_force = self.strength.yield_strength * self.thread.stress_area
        return vdi2230.endurance_after(self.thread.diameter, mean_force, yield_force)


@dataclass(frozen=True)
class BoltResult:
    """A bolt over load cases or a cycle."""

    #: largest_force, least_force: N; and the place of the former in the sequence
    largest_force: float
    least_force: float
    largest_at: int
    amplitude: float  #: σ_a = (F_SAo − F_SAu)/(2 A_S) in the thread, MPa (R9/1)
    endurance: float  #: σ_AS, MPa, at the mean force
    tightening_use: float  #: von Mises stress at the end of tightening over the yield strength
    working_safety: float  #: S_F: yield strength over the von Mises stress at the largest force
    proof_use: float  #: largest force over the proof load
    seat_pressure: float  #: largest pressure under head or nut, MPa
    #: bending_safety, bending_amplitude: S_F at the outer fibre, and σ_a with bending, MPa (σ_SAbb)
    bending_safety: float
    bending_amplitude: float
    shear_stress: float  #: τ_Q: largest shear stress where it bears on its hole, MPa (R12)

    @property
    def fatigue_safety(self) -> float:
        """S_D = σ_AS/σ_a; infinite for a force that does not change."""
        return self.endurance / self.amplitude if self.amplitude > 0 else float("inf")

    @property
    def bending_fatigue_safety(self) -> float:
        """S_D = σ_AS/σ_SAbb; infinite where nothing changes."""
        return self.endurance / self.bending_amplitude if self.bending_amplitude > 0 else float("inf")

    @property
    def force_amplitude(self) -> float:
        """Half of the force's range, N."""
        return (self.largest_force - self.least_force) / 2

    @classmethod
    def of(
        cls, bolt: Bolt, forces: Floats, fibre: Floats, bending: Floats, shear: float, *, turned: bool = True
    ) -> "BoltResult":
        """Judge a bolt by its force (k,) at k instants, N; it was tightened by turning, or stretched.

        `fibre` (k,) is the largest stress of tension and bending, `bending` (k, 2) the bending stress of the
        first thread that carries in two planes, MPa, `shear` the largest force on the hole, N.
        """
        top = int(forces.argmax())
        largest, least = float(forces[top]), float(forces.min())
        most = max(largest, bolt.assembly_preload)
        around = np.array([np.cos(_AROUND), np.sin(_AROUND)])
        in_thread = forces[:, None] / bolt.thread.stress_area + bending @ around
        tension, limit = largest / bolt.least_area, bolt.strength.yield_strength
        across = shear / bolt.least_area
        outermost = bolt.working_stress(float(fibre.max()), across, torsion=turned)
        return cls(
            largest_force=largest,
            least_force=least,
            largest_at=top,
            amplitude=(largest - least) / (2 * bolt.thread.stress_area),
            endurance=bolt.endurance((largest + least) / 2),
            tightening_use=bolt.tightening_stress(turned=turned) / bolt.strength.yield_strength,
            working_safety=limit / bolt.working_stress(tension, across, torsion=turned),
            proof_use=largest / bolt.proof_load,
            seat_pressure=most / bolt.least_seat_area,
            bending_safety=bolt.strength.yield_strength / outermost,
            bending_amplitude=float(np.ptp(in_thread, axis=0).max()) / 2,
            shear_stress=across,
        )
