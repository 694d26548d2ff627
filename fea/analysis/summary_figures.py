"""`summary.json` as a whole, with its figures on bolts, joint and fits, buckling, flow and oil film."""

from collections.abc import Mapping

from fea.analysis.defect_figures import DefectFigures
from fea.analysis.figures import (
    SCHEMA,
    CaseFigures,
    EngineFigures,
    Figures,
    LoadFigures,
    ModelFigures,
    OvalityFigures,
    RodFigures,
    WhereKnown,
)
from fea.analysis.fretting_figures import FrettingFigures
from fea.analysis.life_figures import BenchFigures, CycleFigures, EnvelopeFigures, LifeFigures
from fea.analysis.overload_figures import BendingFigures, OverloadFigures, SetFigures
from fea.base.checks import Check
from fea.base.note import Note
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


class GaugeCaseFigures(Figures):
    """Strain of a gauge in a load case."""

    strain_um_m: float
    error_um_m: float | None  #: of the mesh; None at a speed of many that is only superposed
    measured_um_m: WhereKnown[float] = None


class GaugeFigures(Figures):
    """An entry of ``gauges``: a strain gauge."""

    name: str
    at_mm: Vector  #: on the surface
    cases: Mapping[str, GaugeCaseFigures]
    history_um_m: WhereKnown[tuple[float, ...]] = None  #: over the crank cycle, at every degree


class PlaneFigures(Figures):
    """The column formulas for bending in one plane; the factor is None where nothing compresses the rod."""

    slenderness: float
    euler_N: float
    johnson_N: float
    rankine_N: float
    safety_factor: SafetyFactor | None


class ColumnFigures(Figures):
    """The rod as a column under the load case that compresses it most."""

    force_N: float
    case: str | None
    least_area_mm2: float
    planes: Mapping[str, PlaneFigures]

    @property
    def min_safety_factor(self) -> SafetyFactor | None:
        """The least factor of both planes."""
        factors = [plane.safety_factor for plane in self.planes.values() if plane.safety_factor is not None]
        return min(factors, default=None)


class BucklingModeFigures(Figures):
    """A buckling mode: factor on the load of its case, and which way the rod moves."""

    factor: float
    moves: str


class BucklingFigures(Figures):
    """``buckling``: column formulas always; with `--buckling` the modes of the solid, by load case."""

    column: ColumnFigures
    modes: WhereKnown[Mapping[str, tuple[BucklingModeFigures, ...]]] = None
    shapes_of: WhereKnown[str] = None
    min_safety_factor: SafetyFactor | None

    @property
    def min_mode_factor(self) -> float | None:
        """The least factor of all modes."""
        return min((mode.factor for modes in (self.modes or {}).values() for mode in modes), default=None)

    def of_case(self, case: str) -> tuple[float | None, float | None]:
        """Return the least factors of a load case: by the column formulas, and of the solid's modes."""
        column = self.column.min_safety_factor if self.column.case == case else None
        modes = (self.modes or {}).get(case, ())
        return column, min((mode.factor for mode in modes), default=None)


class SurvivalFigures(Figures):
    """``survival``: whether the rod survives, with the error bar taken off the safety factor."""

    answer: str  #: ``survives``, ``fails``, or ``undecided`` where the error bar includes the required factor
    text: str
    required_safety_factor: float  #: 1, or ``--min-safety``
    #: The governing factor: ``yielding``, ``fatigue`` or ``buckling``, of the rod or by name of its bolts, or
    #: slip or separation of the joint; its load case, None for the cycle; the sharp edge it is of
    mode: str
    case: str | None
    place: WhereKnown[str] = None
    safety_factor: SafetyFactor
    assured_safety_factor: float  #: what remains of it if the stress is higher by its error bar
    #: Where the cycle is not computed and the strengths are known: factor against fatigue between the load
    #: cases, which over the cycle is that or less, and its place in words
    fatigue_at_most: WhereKnown[SafetyFactor] = None
    fatigue_where: WhereKnown[str] = None
    #: Where it survives: the operation for which it does, in words, and the multiple of all its loads at
    #: which the assured factor is the required one
    stands_on: WhereKnown[str] = None
    ends_at_load: WhereKnown[float] = None


class SettledFatigueFigures(Figures):
    """``plastic.fatigue``: over the cycle or a fatigue test, with the mean stress that flow has left."""

    safety_factor: SafetyFactor
    elastic_safety_factor: SafetyFactor  #: of the elastic stress, wherever that is least
    where: str  #: of the former, in words
    elastic_mean_MPa: float  #: there, before flow, as `mean_MPa` after it
    mean_MPa: float


class CyclicFigures(Figures):
    """``plastic.cyclic``: what flows to and fro in every turn, at its worst place."""

    strain_range: float  #: of a turn, elastic and plastic
    strength_MPa: float  #: at which it flows: the cyclic yield strength where that is smaller
    turns: float | None  #: until it cracks; None where no strain-life curve is known or can be assumed
    minutes: float | None  #: at the speed; None without an engine, too
    assumed: bool | None  #: whether a constant of the curve is


class PlasticFigures(Figures):
    """``plastic``: what becomes of a rod whose elastic stress exceeds yield, turn by turn."""

    state: str  #: a `fea.plastic.cycling.PlasticAnswer`
    max_plastic_strain: float  #: at the end of the last turn that was followed
    strain_per_turn: float  #: plastic strain of a turn added up, where flow does not end; else 0
    at_mm: Vector
    where: str  #: in words
    elements: int  #: of the whole rod that have flowed
    turns: int  #: in which something flowed
    cases: tuple[str, ...]  #: load cases or crank angles under which something flowed
    residual_MPa: float  #: principal stress of largest magnitude left there without load
    #: What is left without load, µm and degrees: see `fea.analysis.permanent_set.permanent_set`
    set_um: Mapping[str, float]
    set_judged: WhereKnown[SetFigures] = None  #: None where no equilibrium is left
    strength_MPa: float  #: at which it flowed: the cyclic yield strength where that is smaller and decides
    #: Multiple of all loads up to which it was followed and settles: below 1 where it does not settle now
    settling_factor: SafetyFactor
    fatigue: WhereKnown[SettledFatigueFigures] = None
    cyclic: WhereKnown[CyclicFigures] = None
    #: The shank under the load case that presses most on it, and the multiple of that at which it bends
    bending: WhereKnown[BendingFigures] = None
    collapse_factor: WhereKnown[float] = None


class PassFigures(Figures):
    """One mesh of a refinement."""

    elements: int  #: of the whole rod, as the nodes
    nodes: int
    error_percent: float  #: the largest error bar of any load case
    seconds: float  #: wall time

    def text(self, number: int) -> str:
        """Return the progress line of the pass."""
        return f"pass {number}: {self.elements} elements, ±{self.error_percent:.1f} %, {self.seconds:.1f} s"


class EnvironmentFigures(Figures):
    """``environment``."""

    versions: Mapping[str, str]
    platform: str
    threads: int | None


class FilmFigures(Figures):
    """The oil film of a bearing over the crank cycle; errors are of grids, steps and the bore's mesh."""

    h_min_um: float  #: smallest gap
    h_min_deg: float  #: of the crank
    h_min_error_percent: float
    p_max_MPa: float  #: highest pressure
    p_max_deg: float
    p_max_error_percent: float
    power_W: float  #: mean friction
    power_error_percent: WhereKnown[float] = None  #: of the mean effective pressure, too
    friction_mep_bar: float  #: mean effective pressure of that, of one cylinder
    flow_l_min: float  #: oil that leaves the bearing
    flow_error_percent: WhereKnown[float] = None
    filled_percent: float  #: mean share of the gap that is full of oil
    temperature_C: float | None  #: of the film; None where its viscosity is given
    temperature_error_K: WhereKnown[float] = None  #: None where the temperature is given
    viscosity_mPas: float  #: at that temperature, without pressure
    radial_clearance_um: float
    lambda_min: float | None  #: smallest gap over the roughness; None of smooth surfaces
    asperity_percent: float  #: largest share of the pressure that asperities carry
    asperity_error_percent: WhereKnown[float] = None  #: of the same pressure
    specific_load_MPa: float  #: largest force over diameter times width
    lining_factor: float | None  #: what the lining endures over that; None where the study does not say
    verdict: str  #: ``hydrodynamic``, ``mixed``, ``metal to metal`` or why there is none


class HeadClearanceFigures(Figures):
    """What the gap between piston and head must leave at the dead centre of gas exchange, mm."""

    rod_stretch_mm: float  #: of the rod between its pins, with ovality and joint
    clearances_mm: float  #: radial, of both pins
    pin_bending_mm: float
    crank_mm: float  #: main bearing and crank, assumed
    cold_mm: float  #: the sum of these
    piston_growth_mm: float  #: of the warm engine, assumed, as the next three
    rod_growth_mm: float
    aluminium_block_growth_mm: float
    iron_block_growth_mm: float
    #: hot_aluminium_block_mm, hot_iron_block_mm: cold, with the growth of piston and rod, less the block's
    hot_aluminium_block_mm: float
    hot_iron_block_mm: float
    crown_height_mm: float  #: from the pin to the crown of the piston, assumed

    @property
    def most_mm(self) -> float:
        """The largest of the sums."""
        return max(self.cold_mm, self.hot_aluminium_block_mm, self.hot_iron_block_mm)


class HandFigures(Figures):
    """One of ``hand``: a formula of textbooks worked by hand, beside the result of the finite elements."""

    title: str
    formula: str
    inputs: str  #: what stands in it, with units
    value: float
    unit: str  #: of value and result; empty for a factor
    result: float
    result_of: str  #: what of the finite elements that is, in words
    ratio: float | None  #: result over value
    why: str  #: why the two differ


class Summary(Figures):
    """What `summary.json` holds."""

    schema: str = SCHEMA
    study: str
    rpm: float | None  #: None where forces are given, as the engine
    trusted: bool
    survival: SurvivalFigures
    rod: RodFigures
    engine: EngineFigures | None
    loads: Mapping[str, LoadFigures]  #: by load case, as the results
    model: ModelFigures
    results: Mapping[str, CaseFigures]
    passes: WhereKnown[tuple[PassFigures, ...]] = None
    assembly: WhereKnown[AssemblyFigures] = None
    envelope: WhereKnown[CycleFigures | EnvelopeFigures] = None
    film: WhereKnown[Mapping[str, FilmFigures]] = None  #: by end: ``big_end``, ``small_end``
    fretting: WhereKnown[FrettingFigures] = None
    life: WhereKnown[LifeFigures] = None  #: over the duty of the study, the same at each of its speeds
    defect: WhereKnown[DefectFigures] = None  #: with the cycle, of steels and given flaws
    gauges: WhereKnown[tuple[GaugeFigures, ...]] = None
    buckling: BucklingFigures
    bench: WhereKnown[BenchFigures] = None  #: of [forces] with a ratio
    overload: WhereKnown[OverloadFigures] = None  #: what the single overload of the study leaves
    plastic: WhereKnown[PlasticFigures] = None  #: where the elastic stress exceeds yield and flow is followed
    head_clearance: WhereKnown[HeadClearanceFigures] = None
    hand: WhereKnown[Mapping[str, HandFigures]] = None
    checks: Mapping[str, Check]
    notes: tuple[Note, ...]
    note_kinds: WhereKnown[tuple[tuple[str, ...], ...]] = None  #: kind and topic of each note, in a file
    timings_s: dict[str, float]
    total_s: float
    peak_memory_MiB: float
    left_out: tuple[Note, ...]
    environment: EnvironmentFigures
    #: Of several speeds: with their cycles the lowest speed from which each safety factor is below 1; of an
    #: assembled rod that from which its joint opens at the bore (``joint_opening``)
    critical_speeds_rpm: WhereKnown[Mapping[str, float | None]] = None
    files: WhereKnown[tuple[str, ...]] = None  #: that the run wrote into its folder
    shared_files: WhereKnown[tuple[str, ...]] = None  #: of several speeds, beside the folders of the speeds

    @property
    def cycle(self) -> EnvelopeFigures | None:
        """The whole crank cycle with its histories, where there is one."""
        return self.envelope if isinstance(self.envelope, EnvelopeFigures) else None

    @property
    def cycle_degrees(self) -> int:
        """Crank angle of the engine's cycle, degrees."""
        return 720 if self.engine is None else 180 * self.engine.strokes

    @property
    def title(self) -> str:
        """The study and its speed."""
        return self.study if self.rpm is None else f"{self.study} at {self.rpm:g} rpm"

    @property
    def worst_case(self) -> str:
        """The load case with the smallest safety factor."""
        return min(self.results, key=lambda case: self.results[case].min_safety_factor)

    @property
    def governing_result(self) -> str:
        """The result whose fields show what governs: a load case, or ``envelope`` for the whole cycle."""
        case = self.survival.case or (self.buckling.column.case if self.survival.mode == "buckling" else None)
        if case in self.results:
            return str(case)
        return self.worst_case if self.cycle is None else "envelope"

    @property
    def governing(self) -> CaseFigures | None:
        """The load case whose safety factor governs; None where that is not of a load case."""
        return self.results.get(self.survival.case or "")

    @property
    def min_safety_factor(self) -> SafetyFactor:
        """The smallest safety factor of the load cases."""
        return self.results[self.worst_case].min_safety_factor
