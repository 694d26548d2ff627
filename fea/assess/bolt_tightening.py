"""Tightening of bolts: torque, preload and stress (VDI 2230-1:2015, steps R7 and R13).

Forces in N, lengths in mm, torques in N·mm, stresses in MPa.
"""

import math
from dataclasses import dataclass

from fea.study.metric_thread import Thread

# ν of VDI 2230, tables A1 to A4: share of R_p0.2 that tightening uses.
UTILISATION = 0.9
# Rounded in the guideline from 1/(2π) and 1/(2 cos 30°), and from 2/√3.
_PITCH_SHARE, _FLANK_SHARE, _FLANK = 0.16, 0.58, 1.155


@dataclass(frozen=True)
class Lever:
    """What turns torque into preload (R13/1, after Kellermann & Klein 1955).

    Attributes
    ----------
    thread
        Of the bolt.
    friction_diameter
        D_Km: mean diameter of the friction under the head, mm.
    thread_friction, head_friction
        μ_G and μ_K.
    """

    thread: Thread
    friction_diameter: float
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


def twist_ratio(thread: Thread, diameter: float, thread_friction: float) -> float:
    """τ_M/σ_M = 3/2 d₂/d₀ [P/(π d₂) + 1.155 μ_G] while a bolt is tightened (step R7).

    Shear yields over the whole section of least diameter d₀, whose modulus is W_P = π d₀³/12.
    """
    return 1.5 * thread.pitch_diameter / diameter * _slope(thread, thread_friction)


def tightening_stress(preload: float, thread: Thread, diameter: float, thread_friction: float) -> float:
    """σ_red,M = σ_M √[1 + 3 (τ_M/σ_M)²]: von Mises stress at the end of tightening (step R7)."""
    tension = preload / (math.pi / 4 * diameter**2)
    return tension * math.hypot(1.0, math.sqrt(3) * twist_ratio(thread, diameter, thread_friction))


def allowed_preload(
    thread: Thread,
    diameter: float,
    thread_friction: float,
    yield_strength: float,
    utilisation: float = UTILISATION,
) -> float:
    """F_Mzul: the preload at which tightening uses a share of the yield strength (R7; tables A1 to A4)."""
    return utilisation * yield_strength / tightening_stress(1.0, thread, diameter, thread_friction)
