"""A bolt, and what the forces of a cycle mean for it (VDI 2230-1:2015, steps R7 to R10 and R12).

The bolt of the model carries a force along its axis only: bending of its shank, which the guideline adds for
eccentric joints, is not contained.
"""

import math
from dataclasses import dataclass

from fea.base.choices import ThreadRolled
from fea.judge.bolt_shape import BoltShape
from fea.judge.vdi2230 import (
    alternating_stress,
    endurance_after,
    endurance_before,
    thread_torque,
    tightening_stress,
)
from fea.study.bolts import BoltStrength
from geometry.arrays import Floats

# k_τ: share of the torsion of tightening that remains in service.
_TORSION_LEFT = 0.5


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
        return tightening_stress(force, self.thread, self.least_diameter, self.thread_friction)

    def working_stress(self, largest_force: float, *, torsion: bool = True) -> float:
        """σ_red,B = √[σ_z² + 3 (k_τ τ)²] at the largest force (step R8); a stretched bolt has no torsion."""
        tension = largest_force / self.least_area
        if not torsion:
            return tension
        twisting = thread_torque(self.assembly_preload, self.thread, self.thread_friction)
        shear = twisting / (math.pi / 16 * self.least_diameter**3)
        return math.hypot(tension, math.sqrt(3) * _TORSION_LEFT * shear)

    def endurance(self, mean_force: float) -> float:
        """σ_AS of the thread at the mean force of the cycle, MPa."""
        if self.rolled is ThreadRolled.BEFORE:
            return endurance_before(self.thread.diameter)
        yield_force = self.strength.yield_strength * self.thread.stress_area
        return endurance_after(self.thread.diameter, mean_force, yield_force)


@dataclass(frozen=True)
class BoltResult:
    """A bolt over load cases or a cycle."""

    #: largest_force, least_force: N, and their places in the sequence
    largest_force: float
    least_force: float
    largest_at: int
    least_at: int
    amplitude: float  #: σ_a in the thread, MPa
    endurance: float  #: σ_AS, MPa, at the mean force
    tightening_use: float  #: von Mises stress at the end of tightening over the yield strength
    working_safety: float  #: S_F: yield strength over the von Mises stress at the largest force
    proof_use: float  #: largest force over the proof load
    seat_pressure: float  #: largest pressure under head or nut, MPa

    @property
    def fatigue_safety(self) -> float:
        """S_D = σ_AS/σ_a; infinite for a force that does not change."""
        return self.endurance / self.amplitude if self.amplitude > 0 else float("inf")

    @property
    def force_amplitude(self) -> float:
        """Half of the force's range, N."""
        return (self.largest_force - self.least_force) / 2

    @classmethod
    def of(cls, bolt: Bolt, forces: Floats, *, turned: bool = True) -> "BoltResult":
        """Judge a bolt by its force (k,) at k instants, N; it was tightened by turning, or stretched."""
        top, low = int(forces.argmax()), int(forces.argmin())
        largest, least = float(forces[top]), float(forces[low])
        most = max(largest, bolt.assembly_preload)
        return cls(
            largest_force=largest,
            least_force=least,
            largest_at=top,
            least_at=low,
            amplitude=alternating_stress(bolt.thread.stress_area, largest, least),
            endurance=bolt.endurance((largest + least) / 2),
            tightening_use=bolt.tightening_stress(turned=turned) / bolt.strength.yield_strength,
            working_safety=bolt.strength.yield_strength / bolt.working_stress(largest, torsion=turned),
            proof_use=largest / bolt.proof_load,
            seat_pressure=most / bolt.least_seat_area,
        )
