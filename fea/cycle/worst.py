"""The worst of a cycle at one speed: the peaks of the load cases, and the places that fail first."""

from dataclasses import dataclass

from fea.choices import Region
from geometry.arrays import Floats
from loads.cases import LoadCase


@dataclass(frozen=True)
class Place:
    """The worst place against one mode of failure.

    Attributes
    ----------
    factor
        Its safety factor.
    at
        (3,) mm.
    crank_angle
        Of the largest von Mises stress, rad; None if it does not occur in the cycle.
    mean, amplitude, ratio
        Of the signed equivalent stress, MPa.
    crossland
        Crossland's factor there, or None if it is not known.
    endurance
        Endurance limit there with the factor of the surface, MPa, or None if it is not known.
    region
        Of the surface; None inside the solid.
    """

    factor: float
    at: Floats
    crank_angle: float | None
    mean: float
    amplitude: float
    ratio: float
    crossland: float | None
    endurance: float | None = None
    region: Region | None = None


@dataclass(frozen=True)
class CasePeak:
    """A peak case, superposed: largest stresses, MPa, and least safety factor."""

    case: LoadCase
    von_mises: float
    at: Floats
    principal_1: float
    principal_3: float
    factor: float


@dataclass(frozen=True)
class Worst:
    """The worst of the cycle at one speed.

    Attributes
    ----------
    rpm
        The speed.
    cases
        The peak cases.
    yielding, fatigue
        The worst places; fatigue is None if no part's strengths are known.
    """

    rpm: float
    cases: tuple[CasePeak, ...]
    yielding: Place
    fatigue: Place | None
