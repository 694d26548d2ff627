"""The figures of `summary.json` on fretting."""

from collections.abc import Mapping

from fea.analysis.figures import Figures, WhereKnown
from fea.judge.safety_factor import SafetyFactor
from geometry.arrays import Vector


class FrettingPlaceFigures(Figures):
    """A place that rubs: stresses are those of the instant of the largest `ruiz_2`."""

    pair: str
    part: str  #: whose tension counts: rod or cap where there is a choice
    at_mm: Vector
    crank_deg: float
    slip_um: float  #: range of slip over the cycle
    pressure_MPa: float
    shear_MPa: float
    tension_MPa: float  #: largest normal stress along the surface
    energy_mJ: float  #: that a cycle costs on 1 mm² there
    ruiz_1: float  #: τδ, MPa·mm, the largest of the cycle
    ruiz_2: float  #: σ_T τ δ, MPa²·mm
    #: By Crossland, of the stress below the surface; None where too few facets span the zone of slip, or
    #: strengths are not known
    factor: SafetyFactor | None
    averaged_mm: float  #: radius of the half ball over which that stress is averaged
    facets_across: int  #: facets that span the zone of slip


class FrettingPairFigures(Figures):
    """Two parts that touch with friction."""

    slip_um: float  #: the largest range of slip over the cycle
    slipping_percent: float  #: of the area, where the slip exceeds a hundredth of that
    creep_um: float  #: the largest slip that the last cycle followed left: later ones settle, or add to it
    energy_mJ: float  #: that a cycle costs on the whole of it
    duty_W: WhereKnown[float] = None  #: mean power of that over the duty
    most_energy_mJ: float  #: on 1 mm² where it is largest
    most_energy_at_mm: Vector
    #: tension_MPa, tension_at_mm: the largest along the surface, wherever that is; None where every place is
    #: near a stress singularity
    tension_MPa: float | None
    tension_at_mm: Vector | None


class FrettingChangeFigures(Figures):
    """The same pair under another assumption."""

    slip_um: float
    energy_mJ: float
    ruiz_1: float  #: the largest, MPa·mm


class BoltSeatFigures(Figures):
    """Under the heads or the nuts of bolts, at the worst place of all: an estimate, see `bolt_seats`."""

    friction: float
    reserve: float  #: what friction bears over half the range of the shear; heads slide below 1
    slides_um: float  #: range over the cycle by which a head slides as a whole
    at_mm: Vector
    crank_deg: float
    slip_um: float  #: range over the cycle, of that and of the seat that stretches under a rigid head
    pressure_MPa: float  #: even over the seat
    tension_MPa: float | None  #: largest normal stress along the surface; None near a stress singularity
    ruiz_1: float  #: μ p δ, MPa·mm, the largest of the cycle
    ruiz_2: float | None  #: σ_T μ p δ, MPa²·mm; None where every place is near a stress singularity


class FrettingFigures(Figures):
    """``fretting``: a ranking of places by `ruiz_2`, for which no limit is known."""

    friction: float
    proven_ruiz_2: WhereKnown[float] = None  #: of the study: what has served, MPa²·mm
    places: tuple[FrettingPlaceFigures, ...]
    pairs: Mapping[str, FrettingPairFigures]
    #: By what was changed, in words, then by pair
    changes: WhereKnown[Mapping[str, Mapping[str, FrettingChangeFigures]]] = None
    bolt_seats: WhereKnown[Mapping[str, BoltSeatFigures]] = None  #: of ``heads`` and ``nuts``
