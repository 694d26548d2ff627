"""Unit loads with their solutions: what spans the crank cycles of a rod."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

from fea.analysis.cycle.unit_solutions import UnitSolutions
from fea.pins.model import Contacts, Fields, UnitLoads, Weights
from loads.crank_cycle import CrankCycle
from loads.instants import Instants

# Solves even and odd unit loads and recovers their stress.
Solve = Callable[[tuple[Fields, Fields]], UnitSolutions]


class Basis(ABC):
    """Unit loads and their solutions.

    Attributes
    ----------
    loads
        The unit loads that span every instant.
    units
        Solutions of these, or of those of their sums that make up the basis.
    error
        Estimated error of the stress at any place and instant, relative to the largest of the cycle.
    """

    loads: UnitLoads
    units: UnitSolutions
    error: float = 0.0
    small: ClassVar[bool] = False  #: whether it is a `SmallBasis`

    @abstractmethod
    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of `units` at n instants; `cycle` as for `fea.pins.model.PinModel.respond`."""

    @abstractmethod
    def fields(self) -> tuple[Fields, Fields]:
        """Return the even and the odd loads of `units`."""

    @abstractmethod
    def contacts(self, cycle: CrankCycle) -> Contacts:
        """Contact at every degree of a cycle."""


class FullBasis(Basis):
    """Every unit load by itself."""

    def __init__(self, loads: UnitLoads, solve: Solve) -> None:
        self.loads = loads
        self.units = solve(loads.fields()).bounded(loads.joint)

    def weights(self, instants: Instants, cycle: CrankCycle | None = None) -> Weights:
        """Weights of the unit loads: see `Basis.weights`."""
        return self.loads.weights(instants, cycle)

    def fields(self) -> tuple[Fields, Fields]:
        """Return the even and the odd unit loads."""
        return self.loads.fields()

    def contacts(self, cycle: CrankCycle) -> Contacts:
        """Contact at every degree of a cycle."""
        return self.loads.contacts(self.weights(cycle.degrees, cycle), cycle.degrees, cycle)
