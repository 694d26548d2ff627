"""A benchmark problem, and its row in the table."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """A quantity with a known value.

    Attributes
    ----------
    quantity
        The quantity and its place.
    unit
        ``"1"`` for a dimensionless quantity.
    target
        The known value; not zero.
    tolerance_percent
        Largest error that passes.
    why
        The reason for the tolerance, in a sentence.
    """

    quantity: str
    unit: str
    target: float
    tolerance_percent: float
    why: str


@dataclass(frozen=True)
class Computed:
    """The result of one computation.

    Attributes
    ----------
    values
        Values by the name of the quantity.
    dofs
        Degrees of freedom of the (largest) mesh.
    """

    values: Mapping[str, float]
    dofs: int


@dataclass(frozen=True)
class Benchmark:
    """A benchmark problem.

    Attributes
    ----------
    title
        Title of the problem.
    source
        Author, year and place in the publication.
    goals
        The quantities to compare.
    compute
        Computes the quantities with an element size, mm.
    size
        Element size at which the goals must be met, mm.
    converges
        Whether the error decreases with the element size; otherwise it consists of rounding, is a rate or is
        the error of the target, and is not plotted.
    """

    title: str
    source: str
    goals: tuple[Goal, ...]
    compute: Callable[[float], Computed]
    size: float
    converges: bool = True


@dataclass(frozen=True)
class Row:
    """A quantity, computed.

    Attributes
    ----------
    case
        Name of the benchmark.
    source
        Source of its target.
    goal
        The quantity, its target and tolerance.
    computed
        The computed value, in the unit of the goal.
    dofs
        Degrees of freedom of the mesh.
    seconds
        Wall time of the whole case.
    """

    case: str
    source: str
    goal: Goal
    computed: float
    dofs: int
    seconds: float

    @property
    def error_percent(self) -> float:
        """Signed error relative to the target, percent."""
        return 100 * (self.computed - self.goal.target) / abs(self.goal.target)

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance (NaN is not)."""
        return abs(self.error_percent) <= self.goal.tolerance_percent

    def as_dict(self) -> dict[str, object]:
        """Return the row with the names that other programs rely on."""
        return {
            "case": self.case,
            "quantity": self.goal.quantity,
            "unit": self.goal.unit,
            "target": self.goal.target,
            "computed": self.computed,
            "error_percent": self.error_percent,
            "tolerance_percent": self.goal.tolerance_percent,
            "dofs": self.dofs,
            "seconds": self.seconds,
            "pass": self.passed,
            "source": self.source,
        }
