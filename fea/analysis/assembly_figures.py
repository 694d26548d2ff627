"""The figures of `summary.json` on a rod of separate parts: bolts, joint and fits."""

from collections.abc import Mapping

from fea.analysis.figures import Figures, OvalityFigures, WhereKnown
from fea.judge.safety_factor import SafetyFactor
from geometry.arrays import Vector


class BoltCaseFigures(Figures):
    """A bolt in a load case."""

    at_mm: Vector  #: where its axis meets the joint
    force_N: float  #: of the bolt, or of each of a pair about z = 0
    change_N: float  #: since the rod was put together, at the engine's temperature
    load_factor: float | None  #: Φ: change over its share in the separating load; None where that is tiny
    bending_MPa: float  #: largest bending stress of any section
    shear_N: float  #: of the bolt on its hole


class BoltsFigures(Figures):
    """``bolts``: by VDI 2230-1:2015."""

    thread: str
    preload_N: float  #: after tightening, less embedding if that is given
    tightened: WhereKnown[str] = None  #: how it follows from a stretch, torque or angle, and how it scatters
    proof_load_N: float
    vdi_load_factor: float  #: Φ_K of a central load, for comparison with those of the load cases
    max_force_N: float  #: of any bolt
    max_case: str | None  #: its load case; None where it is at another crank angle of the cycle
    max_crank_deg: float | None
    min_force_N: float
    amplitude_N: float  #: the largest: over the load cases with assembly alone, or over the whole cycle
    tightening_use: float  #: stress at the end of tightening over the yield strength (R7)
    proof_use: float  #: largest force over the proof load
    yield_safety_factor: SafetyFactor  #: at the largest force, with half the torsion of tightening (R8)
    alternating_stress_MPa: float  #: in the thread (R9), as the next two
    endurance_MPa: float
    fatigue_safety_factor: SafetyFactor | None  #: None where the force does not change
    seat_pressure_MPa: float  #: largest under head or nut (R10)
    max_bending_MPa: float  #: largest bending stress of any section
    #: With bending: at the outer fibre, where the largest force is or not; and σ_SAbb in the thread (R9)
    bending_yield_safety_factor: SafetyFactor
    bending_alternating_stress_MPa: float
    bending_fatigue_safety_factor: SafetyFactor | None
    seat_lift_ratio: float  #: largest moment on a seat over that at which its edge lifts
    hole_play_mm: float  #: slip of the joint from which on a bolt bears on its hole
    #: shear_N, shear_MPa: of a bolt there, the largest, and its shear stress, which the factors contain
    shear_N: float
    shear_MPa: float
    by_case: Mapping[str, tuple[BoltCaseFigures, ...]]


class FaceCaseFigures(Figures):
    """An interface in a load case."""

    mean_pressure_MPa: float  #: over the whole area
    min_pressure_MPa: float  #: 0 where the parts have parted
    max_pressure_MPa: float
    open_percent: float  #: of the area
    opening_um: float  #: the largest gap
    opening_at_mm: Vector | None
    slipping_percent: float  #: of the area that touches, where friction is used up
    slip_um: float  #: the largest since the rod was put together


class JointCaseFigures(FaceCaseFigures):
    """The joint between rod and cap in a load case."""

    clamp_force_N: float  #: with the ends of the shells
    separating_N: float  #: pulls cap and rod apart: what the bolts gain and the joint loses
    edge_pressure_MPa: float | None  #: the least at the edge of the bore; 0 where the joint has opened there
    shear_N: float  #: resultant along the joint
    slip_reserve: float | None  #: slip safety: what friction can carry over the shear; None without either


class OnsetFigures(Figures):
    """The multiple of everything that acts in a load case at which something begins."""

    case: str
    load_factor: float | None  #: None where it does not begin below the largest, 0 where it needs no load
    largest_factor: float


class JointCycleFigures(Figures):
    """The joint over the whole crank cycle: extremes with their crank angles."""

    min_clamp_force_N: float
    min_clamp_crank_deg: float
    max_opening_um: float
    max_opening_crank_deg: float
    open_percent: float  #: of the cycle, in which the joint is open at the edge of the bore
    min_slip_reserve: float | None


class JointFigures(Figures):
    """``joint``."""

    friction: float
    opens: WhereKnown[OnsetFigures] = None  #: at the edge of the bore
    separates: WhereKnown[OnsetFigures] = None
    by_case: Mapping[str, JointCaseFigures]
    cycle: WhereKnown[JointCycleFigures] = None


class FitFigures(Figures):
    """One of ``fits``: bushing or bearing shells in their seat."""

    interference_mm: float  #: diametral, at the temperature where the parts are put together
    lifts_off: WhereKnown[OnsetFigures] = None
    by_case: Mapping[str, FaceCaseFigures]


class AssemblyFigures(Figures):
    """``assembly``."""

    parts: tuple[str, ...]  #: in the order of the numbers in the array ``part`` of the VTU files
    temperature_C: float
    bolts: BoltsFigures
    joint: JointFigures
    fits: Mapping[str, FitFigures]  #: ``bushing``, ``shells``
    ovality: Mapping[str, Mapping[str, OvalityFigures]]  #: by bore and load case
