"""``assembly`` of `summary.json`: bolts, joint and fits of a rod of separate parts in each load case."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.run.figure_types import Vector, WhereKnown


@dataclass(frozen=True, kw_only=True)
class BoltCaseFigures:
    """A bolt in a load case.

    Attributes
    ----------
    at_mm
        Where its axis meets the joint.
    force_N
        Of the bolt, or of each of a pair about z = 0.
    change_N
        Since the rod was put together, at the engine's temperature.
    load_factor
        Φ: its change over its share in the load that separates the joint; None where there is next to none.
    """

    at_mm: Vector
    force_N: float
    change_N: float
    load_factor: float | None


@dataclass(frozen=True, kw_only=True)
class BoltsFigures:
    """``bolts``: by VDI 2230-1:2015.

    Attributes
    ----------
    thread, preload_N, proof_load_N
        The thread, the force after tightening and embedding, and the proof load.
    vdi_load_factor
        Φ_K of a central load, for comparison with those of the load cases.
    max_force_N, min_force_N
        Of any bolt over the load cases.
    max_case, max_crank_deg
        Where the largest force is: the load case, or None where it is at another crank angle of the cycle.
    amplitude_N
        Of the bolt with the largest amplitude: over the load cases with that of assembly alone, or over the
        whole cycle where it was worked out.
    tightening_use, proof_use
        Stress at the end of tightening over the yield strength (R7), and largest force over the proof load.
    yield_safety_factor
        Against yielding at the largest force, with half the torsion of tightening (R8).
    alternating_stress_MPa, endurance_MPa, fatigue_safety_factor
        In the thread (R9); the factor is None where the force does not change.
    seat_pressure_MPa
        Largest under head or nut (R10).
    by_case
        Every bolt by load case.
    """

    thread: str
    preload_N: float
    proof_load_N: float
    vdi_load_factor: float
    max_force_N: float
    max_case: str | None
    max_crank_deg: float | None
    min_force_N: float
    amplitude_N: float
    tightening_use: float
    proof_use: float
    yield_safety_factor: float
    alternating_stress_MPa: float
    endurance_MPa: float
    fatigue_safety_factor: float | None
    seat_pressure_MPa: float
    by_case: Mapping[str, tuple[BoltCaseFigures, ...]]


@dataclass(frozen=True, kw_only=True)
class FaceCaseFigures:
    """An interface in a load case.

    Attributes
    ----------
    mean_pressure_MPa, min_pressure_MPa, max_pressure_MPa
        The mean is over the whole area; the least is 0 where the parts have parted.
    open_percent
        Share of the area that is open.
    opening_um, opening_at_mm
        The largest gap and its place; None where nothing has opened.
    slipping_percent
        Share of the area that touches where friction is used up.
    slip_um
        The largest slip since the rod was put together.
    """

    mean_pressure_MPa: float
    min_pressure_MPa: float
    max_pressure_MPa: float
    open_percent: float
    opening_um: float
    opening_at_mm: Vector | None
    slipping_percent: float
    slip_um: float


@dataclass(frozen=True, kw_only=True)
class JointCaseFigures(FaceCaseFigures):
    """The joint between rod and cap in a load case.

    Attributes
    ----------
    clamp_force_N
        Between rod and cap, with the ends of the shells.
    separating_N
        Load that pulls cap and rod apart: what the bolts gain and the joint loses; negative presses.
    edge_pressure_MPa
        The least at the edge of the bore; 0 where the joint has opened there.
    shear_N, slip_reserve
        Resultant shear along the joint, and what friction can carry over it; None without shear or friction.
    """

    clamp_force_N: float
    separating_N: float
    edge_pressure_MPa: float | None
    shear_N: float
    slip_reserve: float | None


@dataclass(frozen=True, kw_only=True)
class OnsetFigures:
    """The multiple of everything that acts in a load case at which something begins.

    `load_factor` is None where it does not begin below `largest_factor`, and 0 where it is there without any
    load.
    """

    case: str
    load_factor: float | None
    largest_factor: float


@dataclass(frozen=True, kw_only=True)
class JointCycleFigures:
    """The joint over the whole crank cycle: extremes and their crank angles, and how long it is open.

    `open_percent` is the share of the cycle in which the joint is open at the edge of the bore.
    """

    min_clamp_force_N: float
    min_clamp_crank_deg: float
    max_opening_um: float
    max_opening_crank_deg: float
    open_percent: float
    min_slip_reserve: float | None


@dataclass(frozen=True, kw_only=True)
class JointFigures:
    """``joint``.

    Attributes
    ----------
    friction
        Coefficient between the parts.
    opens
        When it opens at the edge of the bore.
    separates
        When rod and cap come apart.
    by_case
        By load case.
    cycle
        Where the whole crank cycle was worked out.
    """

    friction: float
    opens: WhereKnown[OnsetFigures] = None
    separates: WhereKnown[OnsetFigures] = None
    by_case: Mapping[str, JointCaseFigures]
    cycle: WhereKnown[JointCycleFigures] = None


@dataclass(frozen=True, kw_only=True)
class FitFigures:
    """One of ``fits``: bushing or bearing shells in their seat.

    Attributes
    ----------
    interference_mm
        Diametral, at the temperature where the parts are put together.
    lifts_off
        When it begins to lift off its seat.
    by_case
        By load case.
    """

    interference_mm: float
    lifts_off: WhereKnown[OnsetFigures] = None
    by_case: Mapping[str, FaceCaseFigures]


@dataclass(frozen=True, kw_only=True)
class OvalityFigures:
    """The shape of a bore in a load case, beside the round one that was made with the cap bolted on."""

    ovality_mm: float
    widest_mm: float
    widest_deg: float
    narrowest_mm: float
    narrowest_deg: float


@dataclass(frozen=True, kw_only=True)
class AssemblyFigures:
    """``assembly``.

    Attributes
    ----------
    parts
        Their names, in the order of the numbers in the array ``part`` of the VTU files.
    temperature_C
        Of rod, bolts and pins.
    bolts, joint
        See there.
    fits
        By name: ``bushing``, ``shells``.
    ovality
        By bore and load case.
    """

    parts: tuple[str, ...]
    temperature_C: float
    bolts: BoltsFigures
    joint: JointFigures
    fits: Mapping[str, FitFigures]
    ovality: Mapping[str, Mapping[str, OvalityFigures]]
