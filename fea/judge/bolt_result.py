"""What the forces of a cycle mean for a bolt (VDI 2230-1:2015, steps R7 to R10 and R12).

The bolt of the model carries a force along its axis only: bending of its shank, which the guideline adds for
eccentric joints, is not contained.
"""

from dataclasses import dataclass

from fea.contact.assembly_state import Bolt
from fea.judge.vdi2230 import alternating_stress, endurance, tightening_stress, working_stress
from geometry.arrays import Floats


@dataclass(frozen=True)
class BoltResult:
    """A bolt over load cases or a cycle."""

    # largest_force, least_force: N, and their places in the sequence
    largest_force: float
    least_force: float
    largest_at: int
    least_at: int
    amplitude: float  # σ_a in the thread, MPa
    endurance: float  # σ_AS, MPa, at the mean force
    tightening_use: float  # von Mises stress at the end of tightening over the yield strength
    working_safety: float  # S_F: yield strength over the von Mises stress at the largest force
    proof_use: float  # largest force over the proof load
    seat_pressure: float  # largest pressure under head or nut, MPa

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
        stress = bolt.assembly_preload / bolt.least_area
        if turned:
            stress = tightening_stress(
                bolt.assembly_preload, bolt.thread, bolt.least_diameter, bolt.thread_friction
            )
        most = max(largest, bolt.assembly_preload)
        return cls(
            largest_force=largest,
            least_force=least,
            largest_at=top,
            least_at=low,
            amplitude=alternating_stress(bolt.thread.stress_area, largest, least),
            endurance=endurance(bolt, (largest + least) / 2),
            tightening_use=stress / bolt.yield_strength,
            working_safety=bolt.yield_strength / working_stress(bolt, largest, torsion=turned),
            proof_use=largest / bolt.proof_load,
            seat_pressure=most / bolt.least_seat_area,
        )


@dataclass(frozen=True)
class JointResult:
    """The cap's joint over load cases or a cycle."""

    # Least force between cap and rod, N, and its place in the sequence; of the least preload where the
    # tightening factor α_A is given
    least_clamp: float
    least_at: int
    slip_safety: float  # S_G, the least over the sequence: friction times clamp over shear
    # Φ: change of the bolts' force over the load, from where the joint is clamped least; None where the joint
    # opens or no load acts
    load_factor: float | None

    @classmethod
    def of(
        cls,
        bolts: Floats,
        clamp: Floats,
        shear: Floats,
        *,
        assembled: tuple[float, float],
        friction: float,
        tightening_factor: float = 1.0,
    ) -> "JointResult":
        """Judge a joint by its bolts' forces, their sum, and clamp and shear of cap and rod, (k,), N.

        `assembled` are bolts' force and clamp as assembled, N. With α_A = F_Mmax/F_Mmin, the tightening
        factor, the clamp falls by what the least preload lacks of the largest (R12/1).
        """
        lack = assembled[0] * (1 - 1 / tightening_factor)
        held = (clamp - lack).clip(min=0.0)
        at = int(held.argmin())
        needed = abs(shear)
        loaded = needed > 0
        reserve = float((friction * held[loaded] / needed[loaded]).min()) if loaded.any() else float("inf")
        gained, lost = float(bolts[at]) - assembled[0], assembled[1] - float(clamp[at])
        closed = clamp[at] > 0 and gained + lost > 0
        return cls(float(held[at]), at, reserve, gained / (gained + lost) if closed else None)
