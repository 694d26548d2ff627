"""Figures of what a rod is left with beyond yield: permanent set, bending of the shank, a single overload."""

from collections.abc import Mapping

from fea.analysis.figures import Figures, WhereKnown
from fea.judge.safety_factor import SafetyFactor
from geometry.arrays import Vector


class SetFigures(Figures):
    """Limits of a permanent set, and what exceeds them; names as in `fea.analysis.permanent_set`."""

    limits: Mapping[str, float]  #: µm, of the twist degrees
    exceeded: tuple[str, ...]  #: the gravest first
    least_factor: WhereKnown[float] = (
        None  #: least ratio of a limit to what is left; None where nothing is left
    )


class BendingFigures(Figures):
    """The shank as a column that is bowed and yields, under the load case that presses most."""

    case: str
    force_N: float  #: of that case
    plane: str  #: in which it bends first: ``in_plane`` of motion, or ``sideways``
    bow_mm: float  #: before it is loaded
    strength_MPa: float  #: at which it yields
    first_yield_N: float  #: force at which its first fibre yields
    limit_N: float  #: largest force that it carries


class OverloadFigures(Figures):
    """``overload``: what a single overload leaves."""

    kind: str  #: ``knock``, ``liquid`` or ``force``
    state: str  #: ``elastic``, ``flows``, ``bends``, or ``collapses`` elsewhere than in the shank
    pressure_bar: WhereKnown[float] = None  #: absolute, over the piston, with `bending.force_N` on the rod
    #: Force limit over the force that acts: of liquid, that on a rod which gives way elastically
    safety_factor: SafetyFactor
    bending: BendingFigures
    max_plastic_strain: float
    elements: int  #: that have flowed
    at_mm: Vector  #: where most has flowed, or stress is largest
    where: str  #: in words
    #: What is left without load, as ``plastic.set_um``; None where nothing ends what the overload does
    set_um: WhereKnown[Mapping[str, float]] = None
    set_judged: WhereKnown[SetFigures] = None
