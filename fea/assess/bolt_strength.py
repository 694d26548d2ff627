"""Strength of bolts in service (VDI 2230-1:2015, steps R8 and R9).

Forces in N, lengths in mm, stresses in MPa.
"""

import math

from fea.assess.bolt_tightening import thread_torque
from fea.choices import ThreadRolled
from fea.rod.bolt import Bolt

# k_τ: share of the torsion of tightening that remains in service.
_TORSION_LEFT = 0.5
# F_Sm/F_0.2 below which the endurance of threads rolled after heat treatment rises no further (step R9).
_LEAST_MEAN = 0.3


def working_stress(bolt: Bolt, largest_force: float, *, torsion: bool = True) -> float:
    """σ_red,B = √[σ_z² + 3 (k_τ τ)²] at the largest force (step R8).

    Parameters
    ----------
    bolt
        The bolt.
    largest_force
        F_Smax, N.
    torsion
        Whether the bolt was tightened by turning; a bolt that was stretched has none.
    """
    tension = largest_force / bolt.least_area
    if not torsion:
        return tension
    twisting = thread_torque(bolt.assembly_preload, bolt.thread, bolt.thread_friction)
    shear = twisting / (math.pi / 16 * bolt.least_diameter**3)
    return math.hypot(tension, math.sqrt(3) * _TORSION_LEFT * shear)


def alternating_stress(area: float, largest: float, least: float) -> float:
    """σ_a = (F_SAo − F_SAu)/(2 A): A is the thread's stress area A_S (R9/1)."""
    return (largest - least) / (2 * area)


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


def endurance(bolt: Bolt, mean_force: float) -> float:
    """σ_AS of a bolt's thread at the mean force of the cycle."""
    diameter = bolt.thread.diameter
    if bolt.rolled is ThreadRolled.BEFORE:
        return endurance_before(diameter)
    return endurance_after(diameter, mean_force, bolt.yield_strength * bolt.thread.stress_area)
