"""The figures of the crank cycle and of a duty, as `summary.json` holds them."""

from collections.abc import Mapping
from dataclasses import dataclass

from fea.run.figure_types import Vector, WhereKnown


@dataclass(frozen=True, kw_only=True)
class SurfaceFigures:
    """A region of a part's surface: its finish, the factor of it, and the endurance limit that remains.

    `assumed` is there where the finish is not given but follows from that of the rest of the part.
    """

    finish: str
    surface_factor: float
    endurance_MPa: float
    assumed: WhereKnown[bool] = None


@dataclass(frozen=True, kw_only=True)
class EnduranceFigures:
    """``endurance`` of a part: the limit of polished specimens, and what is left of it in the part.

    The limit of a region (``bores``, ``faces`` or ``rest``) is `specimen_MPa` times all factors.
    """

    specimen_MPa: float
    estimated: bool
    size_factor: float
    load_factor: float
    reliability_factor: float
    regions: Mapping[str, SurfaceFigures]


@dataclass(frozen=True, kw_only=True)
class PlaceFigures:
    """The stress history at one place: mean and amplitude are of the signed equivalent stress.

    The endurance limit is that of the place, with the factor of its region of the surface; there is no region
    inside the solid.
    """

    at_mm: Vector
    mean_MPa: float
    amplitude_MPa: float
    stress_ratio: float
    fatigue_safety_factor: float | None
    crossland_safety_factor: float | None
    endurance_MPa: WhereKnown[float] = None
    surface_region: WhereKnown[str] = None


@dataclass(frozen=True, kw_only=True)
class SpotFigures(PlaceFigures):
    """A place with its whole history: the signed von Mises stress at every degree."""

    max_von_mises_MPa: float
    crank_deg: float
    safety_factor: float
    history_MPa: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class CycleFigures:
    """``envelope`` of a speed whose fields are not written: the worst of the whole crank cycle.

    `endurance` is by part; parts without a known endurance limit are left out.
    """

    min_safety_factor: float
    at_mm: Vector
    crank_deg: float | None
    min_fatigue_safety_factor: float | None
    fatigue_criterion: str
    fatigue: PlaceFigures | None
    min_crossland_safety_factor: float | None
    endurance: WhereKnown[Mapping[str, EnduranceFigures]] = None
    unit_solutions: int
    instants: int


@dataclass(frozen=True, kw_only=True)
class EnvelopeFigures(CycleFigures):
    """``envelope``: the worst of the whole crank cycle, and the places where stress is largest."""

    fatigue: SpotFigures | None
    max_von_mises_MPa: float
    max_principal_MPa: float
    min_principal_MPa: float
    crossland: SpotFigures | None
    spots: tuple[SpotFigures, ...]
    unmasked_max_von_mises_MPa: WhereKnown[float] = None
    unmasked_min_safety_factor: WhereKnown[float] = None


@dataclass(frozen=True, kw_only=True)
class DutyFigures:
    """An entry of the duty: its share of the time, and of the damage at the worst place.

    `reversed_amplitude_MPa` is that of its largest range there, corrected for its mean stress. `gas` is there
    where the duty names it.
    """

    rpm: float
    gas: WhereKnown[str] = None
    time_percent: float
    damage_percent: float | None
    reversed_amplitude_MPa: float


@dataclass(frozen=True, kw_only=True)
class LifeFigures:
    """``life``: hours of the duty until the worst place fails, by Palmgren–Miner's sum.

    Attributes
    ----------
    hours
        At the reliability of the study, or for the mean of all rods; None if nothing is damaged (`endless`).
    band_hours
        At the worst place, of rods whose strength against fatigue is below and above the mean by
        `band_percent` of it; None for no end.
    band_percent, band_of
        Two standard deviations of the endurance limit of steels (see `fea.study.endurance`), in words too.
    duties
        How many times the hours of the duty that is, where the duty has hours.
    at_mm, part
        The worst place.
    damage_per_hour
        There, over all cycles.
    largest_range_percent
        Share of that damage which the largest range of every entry does alone.
    duty
        By entry.
    knee_cycles, endurance_MPa, fatigue_criterion
        Where the S–N line bends, the endurance limit at the worst place, and the mean-stress correction.
    """

    hours: float | None
    band_hours: tuple[float | None, float | None]
    band_percent: float
    band_of: str
    endless: bool
    duties: WhereKnown[float] = None
    at_mm: Vector
    part: str
    damage_per_hour: float
    largest_range_percent: float | None
    duty: tuple[DutyFigures, ...]
    knee_cycles: float
    endurance_MPa: float
    fatigue_criterion: str
