"""The figures of `summary.json` on the crank cycle, fatigue and life."""

from collections.abc import Mapping

from fea.analysis.figures import Figures, WhereKnown
from fea.judge.safety_factor import CycleLife, SafetyFactor
from geometry.arrays import Vector


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


class ResponseFigures(Figures):
    """What a further cause does, of which the crank cycle was solved again at four values."""

    cause: str  #: in words
    deviation: float  #: its standard deviation
    unit: str  #: of that
    #: of the amplitude over the strength where the rod fails first, two deviations below and above the mean
    change_percent: tuple[float, float]


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
    responses: WhereKnown[tuple[ResponseFigures, ...]] = None  #: of preload, clearances and friction


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
    #: True where cycles of mean pressure alone would do no damage, and those of more pressure end the life
    steady_is_undamaged: WhereKnown[bool] = None
    reliability: WhereKnown[ReliabilityFigures] = None


class BenchFigures(Figures):
    """``bench``: a fatigue test between two forces along the rod, at its worst place."""

    forces_N: tuple[float, ...]  #: upper, lower
    safety_factor: SafetyFactor  #: against fatigue, on both forces
    at_mm: Vector
    where: str  #: in words
    mean_MPa: float  #: of the signed equivalent stress there, as the amplitude
    amplitude_MPa: float
    life: CycleLife | None  #: None where no S–N line is known or can be assumed


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
    reliability: WhereKnown[ReliabilityFigures] = None
    knee_cycles: float  #: where the S–N line bends
    endurance_MPa: float  #: at the worst place
    fatigue_criterion: str
