"""Bolts by VDI 2230-1:2015, sections 5.1.1 and 5.5, steps R3 to R10, R12 and R13.

Forces are in N, lengths in mm and stresses in MPa. Factors of tension alone stand beside those with bending.
Against fatigue the guideline counts bending, as σ_SAbb of an eccentric joint (R9); against yielding it does
not, because only the outer fibre would yield.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fea.base.choices import ThreadRolled
from fea.base.note import Note
from fea.base.units import KN
from fea.contact.assembly_state import BoltBeam
from fea.study.assembly_table import BoltStrength, Thread
from geometry.arrays import Floats

# ν of VDI 2230, tables A1 to A4: share of R_p0.2 that tightening uses.
UTILISATION = 0.9
# Rounded in the guideline from 1/(2π) and 1/(2 cos 30°), and from 2/√3.
_PITCH_SHARE, _FLANK_SHARE, _FLANK = 0.16, 0.58, 1.155
# k_τ: share of the torsion of tightening that remains in service.
_TORSION_LEFT = 0.5
# F_Sm/F_0.2 below which the endurance of threads rolled after heat treatment rises no further (R9).
_LEAST_MEAN = 0.3
# f_Z, mm, of thread, both seats and the joint under axial load, in steel of a roughness R_z of 10 to 40 µm
# (table 5).
USUAL_EMBEDDING = (3.0 + 2 * 3.0 + 2.0) * 1e-3
# Lengths of equivalent cylinders over d: head of a hexagon bolt, engaged thread, nut, threaded hole.
_HEAD, _ENGAGED, _NUT, _THREADED_HOLE = 0.5, 0.5, 0.4, 0.33
# Of the section's shear stiffness κ G A of steel (Cowper 1966, a circle), over E A.
_SHEAR = 0.886 / 2.6
# Length of bolt over d that bends as a head turns on its seat: of a solid one, 1.6 d wide and 0.75 d high
# (tests/benchmarks/bolts_calculix.py). The guideline's 0.5 d is the length that stretches as a head gives.
HEAD_TURN = 0.2
# Play, over the hole's diameter, that counts as none: rounding of a bolt in inches.
_FITTED = 1e-9
# Places around a thread whose stress is followed: the largest amplitude is met to 0.2 %.
_AROUND = np.linspace(0, 2 * np.pi, 48, endpoint=False)


def _area(diameter: float) -> float:
    return math.pi / 4 * diameter**2


def _bending_area(diameter: float) -> float:
    """Second moment of area I = π/64 d⁴, mm⁴."""
    return math.pi / 64 * diameter**4


@dataclass(frozen=True, kw_only=True)
class Bolt:
    """One of the equal bolts of a cap in its seats; lengths in mm."""

    thread: Thread
    grip: float  #: from the seat of the head to that of the nut, or to the first thread that carries
    engaged: float  #: length of thread in the rod from the end of the grip; 0 with a nut
    #: Outer diameters of the seats; that of the nut is 0 for a screw in a threaded hole
    head_diameter: float
    nut_diameter: float
    shank_diameter: float
    free_thread: float  #: length of thread in the grip; the rest is shank
    hole: float  #: its diameter
    modulus: float  #: E, MPa
    counter_modulus: float  #: E of the nut or of the rod, MPa
    strength: BoltStrength
    #: thread_friction, head_friction: μ_G and μ_K
    thread_friction: float
    head_friction: float
    rolled: ThreadRolled  #: when the thread was rolled

    @property
    def least_diameter(self) -> float:
        """d₀: the stress diameter of the thread, or the diameter of a thinner shank, mm."""
        return min(self.thread.stress_diameter, self.shank_diameter)

    @property
    def least_area(self) -> float:
        """A₀ = π/4 d₀², mm²."""
        return _area(self.least_diameter)

    @property
    def proof_load(self) -> float:
        """S_p A₀, N."""
        return self.strength.proof * self.least_area

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

    @property
    def lever(self) -> float:
        """M_A/F_M = 0.16 P + 0.58 d₂ μ_G + D_Km/2 μ_K: torque over preload, mm (R13/1)."""
        thread, friction_diameter = self.thread, (self.head_diameter + self.hole) / 2
        in_thread = _PITCH_SHARE * thread.pitch + _FLANK_SHARE * thread.pitch_diameter * self.thread_friction
        return in_thread + friction_diameter / 2 * self.head_friction

    @property
    def thread_lever(self) -> float:
        """M_G/F_M = d₂/2 [P/(π d₂) + 1.155 μ_G]: the part of the lever that twists the bolt, mm (R8)."""
        thread = self.thread
        return thread.pitch / (2 * math.pi) + thread.pitch_diameter / 2 * _FLANK * self.thread_friction

    def tightening_stress(self, preload: float, *, turned: bool = True) -> float:
        """σ_red,M = σ_M √[1 + 3 (τ_M/σ_M)²]: von Mises stress at the end of tightening, MPa (R7).

        τ_M/σ_M = 3/2 d₂/d₀ [P/(π d₂) + 1.155 μ_G]: shear yields over the whole section of least diameter d₀,
        whose modulus is W_P = π d₀³/12. A bolt that is stretched has no torsion.
        """
        twist = 3 * self.thread_lever / self.least_diameter if turned else 0.0
        return preload / self.least_area * math.hypot(1.0, math.sqrt(3) * twist)

    @property
    def allowed_preload(self) -> float:
        """F_Mzul: the preload at which tightening uses ν of the yield strength, N (R7; tables A1 to A4)."""
        return UTILISATION * self.strength.yield_strength / self.tightening_stress(1.0)

    def endurance(self, mean_force: float) -> float:
        """σ_AS of the thread at the mean force of the cycle, preload included, MPa (R9).

        For 2·10⁶ cycles and more, a mean force of 0.3 to 1 times the force at yield, classes 8.8 to 12.9:
        σ_ASV = 0.85 (150/d + 45) of threads rolled before heat treatment, σ_ASG = (2 − F_Sm/F_0.2) σ_ASV of
        those rolled after it. Below 0.3 F_0.2 nothing more is gained, and beyond F_0.2 nothing is left of
        what rolling gave.
        """
        before = 0.85 * (150 / self.thread.diameter + 45)
        if self.rolled is ThreadRolled.BEFORE:
            return before
        yield_force = self.strength.yield_strength * self.thread.stress_area
        return (2 - min(max(mean_force / yield_force, _LEAST_MEAN), 1.0)) * before

    @property
    def _counterpart(self) -> float:
        """Length of the cylinder, mm, that gives as much as the threads of nut or hole."""
        return (_THREADED_HOLE if self.engaged else _NUT) * self.thread.diameter

    @property
    def stretch_compliance(self) -> float:
        """Of the bolt alone between its end faces, where its stretch is measured: δ_SK + Σδ_i + δ_G, mm/N."""
        thread, d = self.thread, self.thread.diameter
        head = _HEAD * d / (self.modulus * thread.nominal_area)
        shank = (self.grip - self.free_thread) / (self.modulus * _area(self.shank_diameter))
        free_thread = self.free_thread / (self.modulus * thread.root_area)
        return head + shank + free_thread + _ENGAGED * d / (self.modulus * thread.root_area)

    @property
    def compliance(self) -> float:
        """δ_S: with δ_M of the threads of nut or hole, mm/N."""
        counterpart = self._counterpart / (self.counter_modulus * self.thread.nominal_area)
        return self.stretch_compliance + counterpart

    @property
    def beam(self) -> BoltBeam:
        """The bolt as it bends, with the sections and equivalent cylinders of its compliance δ_S.

        Section 5.1.1.2: β_S = Σ l_i/(E I_i), with I_d3 of the thread and I_N of nut or hole; a head is
        stiffer than its cylinder there (`HEAD_TURN`). Stress in the thread is that of its stress diameter.
        """
        thread, grip, modulus, d = self.thread, self.grip, self.modulus, self.thread.diameter
        flexibility, start, threaded = np.zeros((2, 2)), 0.0, self.free_thread / grip
        for end, diameter in ((threaded, thread.root_diameter), (1.0, self.shank_diameter)):
            # ∫ s², −∫ s (1 − s) and ∫ (1 − s)² of the moments that grow from either end, and shear alike.
            bent = grip / (modulus * _bending_area(diameter))
            far = (end**3 - start**3) / 3
            mixed = (end**2 - start**2) / 2 - far
            near = (end - start) - (end**2 - start**2) + far
            flexibility += bent * np.array([[far, -mixed], [-mixed, near]])
            flexibility += (end - start) / (grip * _SHEAR * modulus * _area(diameter))
            start = end
        nominal = _bending_area(d)
        flexibility[0, 0] += HEAD_TURN * d / (modulus * nominal)
        flexibility[1, 1] += _ENGAGED * d / (modulus * _bending_area(thread.root_diameter))
        flexibility[1, 1] += self._counterpart / (self.counter_modulus * nominal)
        sections = [(0.0, thread.stress_diameter)]
        if threaded > 0:
            sections.append((threaded, thread.stress_diameter))
        if threaded < 1:
            sections += [(threaded, self.shank_diameter), (1.0, self.shank_diameter)]
        places, diameters = np.array(sections).T
        # Across the joint it is built in half a diameter from it on either side, where its hole holds it.
        across = d**3 / (12 * modulus * _bending_area(self.shank_diameter))
        across += d / (_SHEAR * modulus * _area(self.shank_diameter))
        areas, moduli = math.pi / 4 * diameters**2, math.pi / 32 * diameters**3
        return BoltBeam(flexibility, places, areas, moduli, 1 / across, self.play)


@dataclass(frozen=True)
class ClampedParts:
    """Parts under a bolt, clamped along its axis."""

    grip: float  #: l_K, mm
    seat: float  #: d_W: outer diameter of the head's seat, mm
    hole: float  #: d_h, mm
    outer: float  #: D_A: diameter of a cylinder around the bolt that the parts fill, mm
    modulus: float  #: E_P, MPa
    nut: bool = True  #: whether a nut seats on the far side, too; else the bolt is screwed into the last part

    @property
    def slope(self) -> float:
        """Tan φ of the cone's half angle, which depends on the parts' proportions."""
        slender = self.grip / self.seat
        wide = math.log(max(self.outer, self.seat) / self.seat)
        if self.nut:
            return 0.362 + 0.032 * math.log(slender / 2) + 0.153 * wide
        return 0.348 + 0.013 * math.log(slender) + 0.193 * wide

    @property
    def compliance(self) -> float:
        """δ_P of a sleeve (outer at most seat), a cone with a sleeve, or cones alone, mm/N."""
        if self.outer <= self.seat:
            return 4 * self.grip / (math.pi * self.modulus * (self.outer**2 - self.hole**2))
        # The guideline's w, over 1: cones that meet in the middle with a nut (1), one cone otherwise (2).
        widening, w, h = (1 if self.nut else 2) * self.slope, self.seat, self.hole
        reach = min(self.outer, w + widening * self.grip)  # D_A,Gr: outer diameter that the cones reach
        logarithm = math.log((w + h) * (reach - h) / ((w - h) * (reach + h)))
        sleeve = self.grip - (reach - w) / widening
        cone = 2 / (h * widening) * logarithm
        return (cone + 4 / (reach**2 - h**2) * sleeve) / (math.pi * self.modulus)


class Tightening(NamedTuple):
    """How bolts are tightened."""

    preload: float  #: N, before embedding
    how: str  #: in words
    scatter: tuple[int, int] | None = None  #: of the preload, ± per cent from and to, where it is usual
    yields: bool = False  #: whether it is the force at which the turned bolt yields
    turned: bool = True  #: or stretched

    def __str__(self) -> str:
        scatter = "" if self.scatter is None else ", usually ±{} to {} % (VDI 2230)".format(*self.scatter)
        return f"{self.preload / KN:.3g} kN {self.how}{scatter}"


@dataclass(frozen=True)
class TightenedBolt:
    """A bolt with its preload, and the notes for the reader on both."""

    bolt: Bolt
    tightening: Tightening
    embedding_loss: float  #: F_Z = f_Z/(δ_S + δ_P): preload that embedding by f_Z takes, N (R4/1)
    parts_compliance: float  #: δ_P of the clamped parts by the deformation cone, mm/N, for comparison
    notes: tuple[Note, ...] = ()

    @property
    def preload(self) -> float:
        """Force after tightening and embedding, N."""
        return self.tightening.preload - self.embedding_loss

    @property
    def tightening_stress(self) -> float:
        """Von Mises stress at the end of tightening, MPa."""
        return self.bolt.tightening_stress(self.tightening.preload, turned=self.tightening.turned)

    @property
    def load_factor(self) -> float:
        """Φ_K = δ_P/(δ_S + δ_P) of a central load at the seats (R3), for comparison."""
        return self.parts_compliance / (self.bolt.compliance + self.parts_compliance)

    def working_stress(self, tension: float, across: float = 0.0) -> float:
        """σ_red,B = √[σ_z² + 3 (k_τ τ + τ_Q)²] of a tensile stress and of shear across the bolt, MPa (R8)."""
        bolt = self.bolt
        if self.tightening.turned:
            twisting = self.tightening.preload * bolt.thread_lever
            across += _TORSION_LEFT * twisting / (math.pi / 16 * bolt.least_diameter**3)
        return math.hypot(tension, math.sqrt(3) * across)


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
        cls, tightened: TightenedBolt, forces: Floats, fibre: Floats, bending: Floats, shear: float
    ) -> "BoltResult":
        """Judge a bolt by its force (k,) at k instants, N.

        `fibre` (k,) is the largest stress of tension and bending, `bending` (k, 2) the bending stress of the
        first thread that carries in two planes, MPa, `shear` the largest force on the hole, N.
        """
        bolt, top = tightened.bolt, int(forces.argmax())
        largest, least = float(forces[top]), float(forces.min())
        around = np.array([np.cos(_AROUND), np.sin(_AROUND)])
        in_thread = forces[:, None] / bolt.thread.stress_area + bending @ around
        limit, across = bolt.strength.yield_strength, shear / bolt.least_area
        return cls(
            largest_force=largest,
            least_force=least,
            largest_at=top,
            amplitude=(largest - least) / (2 * bolt.thread.stress_area),
            endurance=bolt.endurance((largest + least) / 2),
            tightening_use=tightened.tightening_stress / limit,
            working_safety=limit / tightened.working_stress(largest / bolt.least_area, across),
            proof_use=largest / bolt.proof_load,
            seat_pressure=max(largest, tightened.tightening.preload) / bolt.least_seat_area,
            bending_safety=limit / tightened.working_stress(float(fibre.max()), across),
            bending_amplitude=float(np.ptp(in_thread, axis=0).max()) / 2,
            shear_stress=across,
        )
