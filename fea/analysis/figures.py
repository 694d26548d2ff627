"""The figures of `summary.json`, units in names; None is ``null``, or left out where `WhereKnown`."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from math import isnan
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform, get_args

from fea.base.checks import Check
from fea.base.note import Note
from fea.base.units import DEG, KG, KG_M2, N_M, UM
from fea.judge.safety_factor import SafetyFactor, without_bar
from geometry.arrays import Vector

SCHEMA = "fea/summary/1"

Known = TypeVar("Known")
ONLY_WHERE_KNOWN = "only where known"
_ROUNDING = 1e-9
WhereKnown = Annotated[Known | None, ONLY_WHERE_KNOWN]

# Units at the end of a name, longer ones first, in the units of the program.
_UNITS = {
    "_kg_m2": KG_M2, "_deg": DEG, "_kg": KG, "_um": UM, "_Nm": N_M, "_mm": 1.0, "_mm2": 1.0,
    "_mm4": 1.0, "_MPa": 1.0, "_N": 1.0,
}  # fmt: skip


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Figures:
    """Figures for JSON: every subclass is a frozen dataclass, whose fields are given by name.

    Safety factors that are given as plain numbers have no error bar. Forces, stresses and lengths below
    10⁻⁹ N, MPa or mm are what rounding leaves of nothing, and become 0.
    """

    factor_names: ClassVar[tuple[str, ...]] = ()  #: names of the fields that are safety factors
    rounded_names: ClassVar[tuple[str, ...]] = ()  #: names of forces, stresses and lengths

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)
        every = fields(cls)  # type: ignore[arg-type]
        cls.factor_names = tuple(field.name for field in every if _is_factor(field.type))
        cls.rounded_names = tuple(field.name for field in every if field.name.endswith(("_N", "_MPa", "_mm")))

    def __post_init__(self) -> None:
        for name in self.factor_names:
            object.__setattr__(self, name, without_bar(getattr(self, name)))
        for name in self.rounded_names:
            if isinstance(value := getattr(self, name), float) and abs(value) < _ROUNDING:
                object.__setattr__(self, name, 0.0)


def _is_factor(hint: Any) -> bool:
    return hint is SafetyFactor or any(_is_factor(part) for part in get_args(hint))


Kind = TypeVar("Kind", bound=Figures)


def figures(kind: type[Kind], source: object, **given: Any) -> Kind:
    """Fill fields from the attributes of `source`, but for those that are given or have a default.

    The units are those of the names: ``length_mm`` is `length`, ``opening_deg`` is `opening`, rad, and
    ``open_percent`` is `open_share`.
    """
    required = [field.name for field in fields(kind) if field.default is MISSING]  # type: ignore[arg-type]
    return kind(**{name: _read(source, name) for name in required if name not in given}, **given)


def _read(source: object, name: str) -> Any:
    if hasattr(source, name):
        return plain(getattr(source, name))
    if name.endswith("_percent"):
        return 100 * plain(getattr(source, f"{name.removesuffix('_percent')}_share"))
    suffix, unit = next(item for item in _UNITS.items() if name.endswith(item[0]))
    value = plain(getattr(source, name.removesuffix(suffix)))
    return value if value is None or unit == 1 else value / unit


def plain(value: Any) -> Any:
    """Return a value in Python's own types; None for a number that does not apply (NaN)."""
    if isinstance(value, Enum):
        return value.value
    if hasattr(value, "tolist"):  # arrays and scalars of NumPy
        value = value.tolist()
    if isinstance(value, float) and isnan(value):
        return None
    return tuple(map(plain, value)) if isinstance(value, list | tuple) else value


class RodFigures(Figures):
    """``rod``: mass properties of the meshed rod; the inertia is I_z about the centre of gravity."""

    mass_kg: float
    center_of_gravity_mm: Vector
    inertia_kg_m2: float
    length_mm: float


class EngineFigures(Figures):
    """``engine``."""

    crank_radius_mm: float
    rod_length_mm: float
    bore_mm: float
    piston_mass_kg: float
    strokes: int = 4


class LoadFigures(Figures):
    """``loads``: what acts in a load case; None where it does not apply, as a crank angle to given forces."""

    crank_deg: float | None
    gas_N: float | None
    pin_axial_N: float
    pin_transverse_N: float
    crank_axial_N: float
    crank_transverse_N: float
    wall_N: float | None
    torque_Nm: float | None


class QualityFigures(Figures):
    """Quality of the elements, and what was done about bad ones."""

    least_scaled_jacobian: float
    least_shape: float
    median_shape: float
    worst_at_mm: Vector
    straightened_elements: int
    repairs: tuple[str, ...]
    repaired_size_mm: float | None


class ModelFigures(Figures):
    """``model``: nodes, elements and dofs of the whole rod as written; `solved_dofs` were factorised."""

    nodes: int
    elements: int
    dofs: int
    solved_dofs: int
    element: str
    formulation: str
    size_mm: float
    symmetry: str
    support: str
    pressure: str
    solver: str
    assembly: str
    quality: QualityFigures
    mesh_from_file: WhereKnown[bool] = None  #: such a mesh cannot be refined


class OvalityFigures(Figures):
    """The shape of a bore beside the round one that was made: directions are from rod +x."""

    ovality_mm: float
    widest_mm: float
    widest_deg: float
    narrowest_mm: float
    narrowest_deg: float


class BoreFigures(OvalityFigures):
    """Contact on a bore, and how its diameter changes."""

    max_pressure_MPa: float
    at_deg: float  #: where it is largest
    at_z_mm: float
    arc_deg: float  #: on which it presses; the length is along z


class SharpEdgeFigures(Figures):
    """A sharp re-entrant edge that matters: the elastic stress at it is infinite, what follows is not."""

    name: str  #: a letter, the same in every load case
    at_mm: Vector  #: where its structural stress is largest
    between: tuple[str, str]  #: the faces that meet there
    opening_deg: float  #: of the notch, outside the material
    length_mm: float
    thickness_mm: float  #: t of the extrapolation, which reads the stress 0.4 t and 1.0 t beside the edge
    structural_stress_MPa: float  #: hot-spot stress across the edge
    structural_von_mises_MPa: float  #: of all its components
    error_percent: float  #: error bar of the latter
    safety_factor: SafetyFactor  #: against yielding, by the structural stress
    #: K, MPa·mm^(exponent), of the stress K/√(2π) r^(−exponent) across the bisector of the notch; None where
    #: the flanks are too short or the notch too narrow
    notch_intensity: float | None
    notch_exponent: float
    required_safety_factor: float  #: ``--min-safety``, or 1
    fillet_radius_mm: float | None  #: whose peak has that factor; None where no fillet up to the largest has
    largest_fillet_mm: float | None  #: beyond it the relation between notch and fillet does not hold


class WeakestFigures(Figures):
    """Where the smallest safety factor is: in words, its part, and the yield strength there."""

    at_mm: Vector
    where: str
    part: str
    yield_MPa: float


class LiningFigures(Figures):
    """The lining of a bore in a load case: where it yields it settles, which does not end the rod."""

    safety_factor: SafetyFactor  #: against yielding
    specific_load_MPa: float  #: force of the pin over diameter times width of its bore


class CaseFigures(Figures):
    """``results``: extremes of a load case away from singular places; None where they were not computed."""

    max_von_mises_MPa: float
    at_mm: Vector
    max_principal_MPa: float
    min_principal_MPa: float
    max_displacement_mm: float | None
    min_safety_factor: SafetyFactor
    weakest: WhereKnown[WeakestFigures] = None
    error_percent: float | None
    energy_error_percent: WhereKnown[float] = None
    verdict: str | None
    unmasked_max_von_mises_MPa: WhereKnown[float] = None
    unmasked_min_safety_factor: WhereKnown[SafetyFactor] = None
    unmasked_verdict: WhereKnown[str] = None
    singular_max_von_mises_MPa: WhereKnown[float] = None
    singular_verdict: WhereKnown[str] = None
    singular_where: WhereKnown[str] = None  #: the place of the largest stress among those, in words
    sharp_edges: WhereKnown[tuple[SharpEdgeFigures, ...]] = None
    contact: WhereKnown[Mapping[str, BoreFigures]] = None
    linings: WhereKnown[Mapping[str, LiningFigures]] = None  #: bushing and shells, by part


class SurfaceFigures(Figures):
    """A region of a part's surface: its finish, the factor of it, and the endurance limit that remains."""

    finish: str
    surface_factor: float
    endurance_MPa: float
    assumed: WhereKnown[bool] = None  #: where the study does not give it


class EnduranceFigures(Figures):
    """``endurance`` of a part: that of a region (``bores``, ``faces``, ``rest``) has all factors."""

    specimen_MPa: float  #: the limit of polished specimens
    cycles: WhereKnown[float] = None  #: for which it holds, of a metal without a true limit
    estimated: bool
    size_factor: float
    load_factor: float
    reliability_factor: float
    reliability_percent: float  #: part of the rods that bear the limit: 50 is the median
    regions: Mapping[str, SurfaceFigures]


class PlaceFigures(Figures):
    """The stress history at one place: mean and amplitude are of the signed equivalent stress."""

    at_mm: Vector
    where: WhereKnown[str] = None  #: in words
    mean_MPa: float
    amplitude_MPa: float
    stress_ratio: float
    fatigue_safety_factor: SafetyFactor | None
    crossland_safety_factor: SafetyFactor | None
    endurance_MPa: WhereKnown[float] = None  #: with the factor of its region of the surface
    surface_region: WhereKnown[str] = None  #: none inside the solid
    support_factor: WhereKnown[float] = None  #: of the gradient of stress, contained in that limit


class SpotFigures(PlaceFigures):
    """A place with its whole history: the signed von Mises stress at every degree."""

    max_von_mises_MPa: float
    crank_deg: float
    safety_factor: SafetyFactor
    history_MPa: tuple[float, ...]


class BLifeFigures(Figures):
    """Hours by which 1, 10 and 50 % have failed; None: no such share by 10⁸ cycles, or never."""

    b1_hours: float | None
    b10_hours: float | None
    b50_hours: float | None


class PlaceLifeFigures(BLifeFigures):
    """A place that may fail first."""

    where: str
    at_mm: Vector | None  #: None for a bolt
    count: int  #: of equal places of a rod
    assumed: bool  #: whether its S–N line is


class ReliabilityFigures(BLifeFigures):
    """``reliability``: hours by which a share of the rods has failed, if places fail independently."""

    at_most: WhereKnown[BLifeFigures] = None  #: if they depend on one another, where that is a tenth more
    first: str  #: the place that fails first
    conditional: bool  #: whether they hold only if an assumed strength or peak pressure is right
    places: tuple[PlaceLifeFigures, ...]
    rods: int  #: of an engine
    engine_b10_hours: float | None  #: by which a tenth of the engines has lost a rod
    by_hours: WhereKnown[float] = None  #: of [scatter]
    failed_percent: WhereKnown[tuple[float, float]] = None  #: of the rods by then, least and most
    samples: int
    sampling_error_percent: float  #: standard error of the hours by sampling, the largest
    scatter_percent: Mapping[str, float]  #: by cause, a coefficient of variation


class CycleLifeFigures(Figures):
    """Hours of running at one speed until the place of the smallest factor against fatigue fails.

    None stands for no damage: `unlimited` says whether life may then be called so, else no failure is
    expected by 10⁸ cycles.
    """

    hours: float | None
    #: low_hours, high_hours: with all strengths lower and higher by `band_percent`
    low_hours: float | None
    high_hours: float | None
    band_percent: float
    cycles: float | None
    assumed: bool  #: whether the line of the life is assumed from the strengths
    unlimited: bool
    by_strain: bool  #: whether the cycles, below 10⁴, are those of local strain; else indicative there
    reliability: WhereKnown[ReliabilityFigures] = None


class TestLifeFigures(Figures):
    """Cycles to failure in a fatigue test; None for no damage, as in `CycleLifeFigures`."""

    cycles: float | None
    low: float | None  #: with all strengths lower by `band_percent`, as `high` with higher ones
    high: float | None
    band_percent: float
    assumed: bool  #: as in `CycleLifeFigures`, like the next two
    unlimited: bool
    by_strain: bool


class BenchFigures(Figures):
    """``bench``: a fatigue test between two forces along the rod, at its worst place."""

    forces_N: tuple[float, ...]  #: upper, lower
    safety_factor: SafetyFactor  #: against fatigue, on both forces
    at_mm: Vector
    where: str  #: in words
    mean_MPa: float  #: of the signed equivalent stress there, as the amplitude
    amplitude_MPa: float
    life: TestLifeFigures | None  #: None where no S–N line is known or can be assumed


class CycleFigures(Figures):
    """``envelope`` of a speed whose fields are not written: the worst of the whole crank cycle."""

    min_safety_factor: SafetyFactor
    at_mm: Vector
    where: WhereKnown[str] = None  #: in words
    crank_deg: float | None
    min_fatigue_safety_factor: SafetyFactor | None
    #: where the local stress counts fully: the smallest of all places
    min_fatigue_safety_factor_without_support: WhereKnown[float] = None
    fatigue_error_percent: WhereKnown[float] = None  #: error bar of the stress behind the smallest factor
    fatigue_criterion: str
    fatigue: PlaceFigures | None
    min_crossland_safety_factor: SafetyFactor | None
    endurance: WhereKnown[Mapping[str, EnduranceFigures]] = None  #: by part, where the limit is known
    unit_solutions: int
    instants: int


class EnvelopeFigures(CycleFigures):
    """``envelope``: the worst of the whole crank cycle, and the places where stress is largest."""

    fatigue: SpotFigures | None
    life: WhereKnown[CycleLifeFigures] = None
    max_von_mises_MPa: float
    max_principal_MPa: float
    min_principal_MPa: float
    crossland: SpotFigures | None
    spots: tuple[SpotFigures, ...]
    #: Largest difference to the solved load cases and instants, over the largest stress of each part
    superposition_error: float
    unmasked_max_von_mises_MPa: WhereKnown[float] = None
    unmasked_min_safety_factor: WhereKnown[SafetyFactor] = None


class DutyFigures(Figures):
    """An entry of the duty: its share of the time, and of the damage at the worst place."""

    rpm: float
    gas: WhereKnown[str] = None  #: where the duty names it
    load: WhereKnown[float] = None  #: of a log: percent of full load or throttle, or boost in bar gauge
    time_percent: float
    damage_percent: float | None
    reversed_amplitude_MPa: float  #: of its largest range there, corrected for its mean stress


class LogFigures(Figures):
    """``life.log``: what of the log of a duty does the damage at the worst place."""

    file: str
    load: WhereKnown[str] = None  #: which column gives it
    hours: float  #: in which the engine turns
    between_cycles: float  #: from one speed or load to another, in one run through the log
    between_percent: float | None  #: their share of the damage
    critical_damage: float  #: Miner's sum at failure under varying amplitudes, beside 1; assumed
    hours_at_critical_damage: float | None
    #: The stretch of time that takes most of the damage, one of 240, and its share
    worst_from_s: float
    worst_to_s: float
    worst_percent: float


class LifeFigures(Figures):
    """``life``: hours of the duty until the worst place fails, by Palmgren–Miner's sum."""

    hours: float | None  #: at the reliability of the study, or of the mean of all rods; None for unlimited
    #: At the worst place, of rods whose fatigue strength is below and above the mean by `band_percent`: two
    #: standard deviations of the endurance limit of steels, or what an assumed S–N line may be off by
    band_hours: tuple[float | None, float | None]
    band_percent: float
    band_of: str
    assumed_line: WhereKnown[bool] = None  #: whether the S–N line is assumed from the strengths
    endless: bool  #: nothing is damaged
    duties: WhereKnown[float] = None  #: how many times the hours of the duty, where the duty has hours
    at_mm: Vector
    part: str
    damage_per_hour: float
    largest_range_percent: float | None  #: of that damage, which the largest range of every entry does alone
    duty: tuple[DutyFigures, ...]
    log: WhereKnown[LogFigures] = None  #: of a duty that is a log
    knee_cycles: float  #: where the S–N line bends
    endurance_MPa: float  #: at the worst place
    fatigue_criterion: str


class GaugeCaseFigures(Figures):
    """Strain of a gauge in a load case."""

    strain_um_m: float
    error_um_m: float  #: of the mesh
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
    #: What is left without load, µm: ``length``, by how much the bores are further apart (negative: closer)
    set_um: Mapping[str, float]
    strength_MPa: float  #: at which it flowed: the cyclic yield strength where that is smaller and decides
    #: Multiple of all loads up to which it was followed and settles: below 1 where it does not settle now
    settling_factor: SafetyFactor
    fatigue: WhereKnown[SettledFatigueFigures] = None


class PassFigures(Figures):
    """One mesh of a refinement."""

    elements: int  #: of the whole rod, as the nodes
    nodes: int
    error_percent: float  #: the largest error bar of any load case
    seconds: float  #: wall time

    def text(self, number: int) -> str:
        """Return the progress line of the pass."""
        return f"pass {number}: {self.elements} elements, ±{self.error_percent:.1f} %, {self.seconds:.1f} s"


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
    preload_N: float  #: after tightening and embedding
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
    life: WhereKnown[LifeFigures] = None  #: over the duty of the study, the same at each of its speeds
    gauges: WhereKnown[tuple[GaugeFigures, ...]] = None
    buckling: BucklingFigures
    bench: WhereKnown[BenchFigures] = None  #: of [forces] with a ratio
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
