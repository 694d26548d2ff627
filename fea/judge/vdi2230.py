"""Bolts by VDI 2230-1:2015, sections 5.1.1 and 5.5, steps R3 to R9. Forces in N, lengths mm, stresses MPa."""

import math
from dataclasses import dataclass

import numpy as np

from fea.contact.assembly_state import BoltBeam
from fea.study.assembly_table import Thread

# ν of VDI 2230, tables A1 to A4: share of R_p0.2 that tightening uses.
UTILISATION = 0.9
# Rounded in the guideline from 1/(2π) and 1/(2 cos 30°), and from 2/√3.
_PITCH_SHARE, _FLANK_SHARE, _FLANK = 0.16, 0.58, 1.155


@dataclass(frozen=True)
class Lever:
    """What turns torque into preload (R13/1, after Kellermann & Klein 1955)."""

    thread: Thread
    friction_diameter: float  #: D_Km: mean diameter of the friction under the head, mm
    #: thread_friction, head_friction: μ_G and μ_K
    thread_friction: float
    head_friction: float

    @property
    def length(self) -> float:
        """M_A/F_M = 0.16 P + 0.58 d₂ μ_G + D_Km/2 μ_K, mm."""
        pitch, flank = self.thread.pitch, self.thread.pitch_diameter * self.thread_friction
        return _PITCH_SHARE * pitch + _FLANK_SHARE * flank + self.friction_diameter / 2 * self.head_friction

    def torque(self, preload: float) -> float:
        """M_A of a preload F_M."""
        return preload * self.length

    def preload(self, torque: float) -> float:
        """F_M of a tightening torque M_A."""
        return torque / self.length


def thread_torque(preload: float, thread: Thread, thread_friction: float) -> float:
    """M_G = F_M d₂/2 [P/(π d₂) + 1.155 μ_G]: the part of the torque that twists the bolt (step R8)."""
    return preload * thread.pitch_diameter / 2 * _slope(thread, thread_friction)


def _slope(thread: Thread, thread_friction: float) -> float:
    return thread.pitch / (math.pi * thread.pitch_diameter) + _FLANK * thread_friction


def tightening_stress(preload: float, thread: Thread, diameter: float, thread_friction: float) -> float:
    """σ_red,M = σ_M √[1 + 3 (τ_M/σ_M)²]: von Mises stress at the end of tightening (step R7).

    τ_M/σ_M = 3/2 d₂/d₀ [P/(π d₂) + 1.155 μ_G]: shear yields over the whole section of least diameter d₀,
    whose modulus is W_P = π d₀³/12.
    """
    tension = preload / (math.pi / 4 * diameter**2)
    twist = 1.5 * thread.pitch_diameter / diameter * _slope(thread, thread_friction)
    return tension * math.hypot(1.0, math.sqrt(3) * twist)


def allowed_preload(thread: Thread, diameter: float, thread_friction: float, yield_strength: float) -> float:
    """F_Mzul: the preload at which tightening uses ν of the yield strength (R7; tables A1 to A4)."""
    return UTILISATION * yield_strength / tightening_stress(1.0, thread, diameter, thread_friction)


# F_Sm/F_0.2 below which the endurance of threads rolled after heat treatment rises no further (step R9).
_LEAST_MEAN = 0.3


def endurance_before(diameter: float) -> float:
    """σ_ASV = 0.85 (150/d + 45): endurance of threads rolled before heat treatment (step R9), d in mm.

    For 2·10⁶ cycles and more, a mean force of 0.3 to 1 times the force at yield, classes 8.8 to 12.9.
    """
    return 0.85 * (150 / diameter + 45)


def endurance_after(diameter: float, mean_force: float, yield_force: float) -> float:
    """σ_ASG = (2 − F_Sm/F_0.2) σ_ASV: endurance of threads rolled after heat treatment (step R9).

    F_Sm is the mean force of the cycle, preload included; below 0.3 F_0.2 nothing more is gained, and
    beyond F_0.2 nothing is left of what rolling gave.
    """
    ratio = min(max(mean_force / yield_force, _LEAST_MEAN), 1.0)
    return (2 - ratio) * endurance_before(diameter)


def embedding_loss(embedding: float, bolt: float, parts: float) -> float:
    """F_Z = f_Z/(δ_S + δ_P): preload that embedding by f_Z takes (R4/1)."""
    return embedding / (bolt + parts)


# f_Z, mm, of thread, both seats and the joint under axial load, in steel of a roughness R_z of 10 to 40 µm
# (VDI 2230-1, table 5).
USUAL_EMBEDDING = (3.0 + 2 * 3.0 + 2.0) * 1e-3
# Lengths of equivalent cylinders over d: head of a hexagon bolt, engaged thread, nut, threaded hole.
_HEAD, _ENGAGED, _NUT, _THREADED_HOLE = 0.5, 0.5, 0.4, 0.33


@dataclass(frozen=True)
class BoltCompliance:
    """Compliances in series, mm/N."""

    #: head, shank, free_thread, engaged: of the bolt: δ_SK, Σδ_i, δ_Gew and δ_G
    head: float
    shank: float
    free_thread: float
    engaged: float
    counterpart: float  #: δ_M: of the threads of nut or hole

    @property
    def between_ends(self) -> float:
        """Of the bolt alone between its end faces, where its stretch is measured."""
        return self.head + self.shank + self.free_thread + self.engaged

    @property
    def total(self) -> float:
        """δ_S."""
        return self.between_ends + self.counterpart


def _bending_area(diameter: float) -> float:
    """Second moment of area I = π/64 d⁴, mm⁴."""
    return math.pi / 64 * diameter**4


# Of the section's shear stiffness κ G A of steel (Cowper 1966, a circle), over E A.
_SHEAR = 0.886 / 2.6
# Length of bolt over d that bends as a head turns on its seat: of a solid one, 1.6 d wide and 0.75 d high
# (tests/benchmarks/bolts_calculix.py). The guideline's 0.5 d is the length that stretches as a head gives.
HEAD_TURN = 0.2


@dataclass(frozen=True, kw_only=True)
class BoltBody:
    """A bolt that stretches and bends."""

    thread: Thread
    grip: float  #: from seat to seat, or to the first thread that carries, mm
    free_thread: float  #: length of the threaded part of the grip, whose rest is shank, mm
    shank: float  #: diameter, mm
    modulus: float  #: E, MPa
    counter_modulus: float  #: E of the nut or of the rod, MPa
    nut: bool

    @property
    def compliance(self) -> BoltCompliance:
        """δ_S and its parts."""
        thread, d = self.thread, self.thread.diameter
        counter = (_NUT if self.nut else _THREADED_HOLE) * d
        return BoltCompliance(
            head=_HEAD * d / (self.modulus * thread.nominal_area),
            shank=(self.grip - self.free_thread) / (self.modulus * math.pi / 4 * self.shank**2),
            free_thread=self.free_thread / (self.modulus * thread.root_area),
            engaged=_ENGAGED * d / (self.modulus * thread.root_area),
            counterpart=counter / (self.counter_modulus * thread.nominal_area),
        )

    def beam(self, play: float = 0.0) -> BoltBeam:
        """Return it as it bends, with the sections and equivalent cylinders of its compliance δ_S.

        Section 5.1.1.2: β_S = Σ l_i/(E I_i), with I_d3 of the thread and I_N of nut or hole; a head is
        stiffer than its cylinder there (`HEAD_TURN`). Stress in the thread is that of its stress diameter.
        `play`: half of how much wider its hole is.
        """
        thread, grip, modulus, d = self.thread, self.grip, self.modulus, self.thread.diameter
        flexibility, span, threaded = np.zeros((2, 2)), 0.0, self.free_thread / grip
        for end, diameter in ((threaded, thread.root_diameter), (1.0, self.shank)):
            # ∫ s², −∫ s (1 − s) and ∫ (1 − s)² of the moments that grow from either end, and shear alike.
            a, b = span, end
            bent = grip / (modulus * _bending_area(diameter))
            far = (b**3 - a**3) / 3
            mixed = (b**2 - a**2) / 2 - far
            flexibility += bent * np.array([[far, -mixed], [-mixed, (b - a) - (b**2 - a**2) + far]])
            flexibility += (b - a) / (grip * _SHEAR * modulus * math.pi / 4 * diameter**2)
            span = end
        nominal = _bending_area(d)
        flexibility[0, 0] += HEAD_TURN * d / (modulus * nominal)
        flexibility[1, 1] += _ENGAGED * d / (modulus * _bending_area(thread.root_diameter))
        flexibility[1, 1] += (_NUT if self.nut else _THREADED_HOLE) * d / (self.counter_modulus * nominal)
        sections = [(0.0, thread.stress_diameter)]
        if threaded > 0:
            sections.append((threaded, thread.stress_diameter))
        if threaded < 1:
            sections += [(threaded, self.shank), (1.0, self.shank)]
        places, diameters = np.array(sections).T
        # Across the joint it is built in half a diameter from it on either side, where its hole holds it.
        across = d**3 / (12 * modulus * _bending_area(self.shank))
        across += d / (_SHEAR * modulus * math.pi / 4 * self.shank**2)
        areas, moduli = math.pi / 4 * diameters**2, math.pi / 32 * diameters**3
        return BoltBeam(flexibility, places, areas, moduli, 1 / across, play)


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
    def widest(self) -> float:
        """D_A,Gr: outer diameter that the cones reach, mm."""
        return self.seat + self._cones * self.grip * self.slope

    @property
    def compliance(self) -> float:
        """δ_P of a sleeve (outer at most seat), a cone with a sleeve, or cones alone, mm/N."""
        if self.outer <= self.seat:
            return 4 * self.grip / (math.pi * self.modulus * (self.outer**2 - self.hole**2))
        reach = min(self.outer, self.widest)
        w, h = self.seat, self.hole
        logarithm = math.log((w + h) * (reach - h) / ((w - h) * (reach + h)))
        cone = 2 / (self._cones * h * self.slope) * logarithm
        sleeve = self.grip - (reach - self.seat) / (self._cones * self.slope)
        return (cone + 4 / (reach**2 - self.hole**2) * sleeve) / (math.pi * self.modulus)

    @property
    def _cones(self) -> int:
        """The guideline's w, over 1: cones that meet in the middle with a nut (1), one cone otherwise (2)."""
        return 1 if self.nut else 2
