"""The figures of `summary.json` on defects."""

from fea.analysis.figures import Figures, WhereKnown
from fea.judge.safety_factor import SafetyFactor
from geometry.arrays import Vector


class DefectPlaceFigures(Figures):
    """Where the smallest defect of a region grows; 1000 µm is the end of the model, 0 fails without one."""

    region: str
    smallest_um: float  #: √area of the largest defect that does not grow there
    #: smallest_um_low, smallest_um_high: with the error bar of the stress
    smallest_um_low: float
    smallest_um_high: float
    at_mm: Vector
    amplitude_MPa: float  #: of the stress across the plane of the largest principal stress
    stress_ratio: float | None  #: None where the plane never opens


class FlawLifeFigures(Figures):
    """A flaw over the cycle of a speed, or over a duty: of the speed at which it is nearest to growth."""

    rpm: float
    normal: Vector  #: of the plane across the largest principal stress
    counted_percent: float  #: of the flaw's area, that it has in projection on that plane
    area_root_um: float  #: √area of that
    amplitude_MPa: float  #: of the stress across it
    stress_ratio: float | None
    criterion: str  #: ``Murakami``, or ``El Haddad`` where it is larger than Murakami's model allows
    factor: SafetyFactor  #: against growth
    hours: WhereKnown[float] = None  #: until it ends the rod; None where it does not grow, or along a surface
    ends: WhereKnown[str] = None  #: what they lead to, in words
    hours_to_surface: WhereKnown[float] = None  #: of a flaw inside, until it breaks through
    depth_after_service_mm: WhereKnown[float] = None  #: the height, of one inside; None where it ends before


class FlawFigures(FlawLifeFigures):
    """A flaw that a study gives, over the crank cycle."""

    depth_mm: float
    length_mm: float
    at_mm: Vector
    where: str  #: in words
    position: str  #: ``surface``, ``touching`` or ``inside``
    duty: WhereKnown[FlawLifeFigures] = None  #: the same over the duty, whose growth adds up


class DefectFigures(Figures):
    """``defect``: the defects that do not grow over the crank cycle, the worst first, and a given flaw."""

    hardness_HV: WhereKnown[float] = None
    smallest_um: WhereKnown[float] = None  #: of all regions, as its place; None without hardness
    at_mm: WhereKnown[Vector] = None
    region: WhereKnown[str] = None
    regions: tuple[DefectPlaceFigures, ...]
    factor: SafetyFactor | None  #: against growth of the given flaw
    flaw: WhereKnown[FlawFigures] = None
