"""What a benchmark problem is, and the row it leaves in the table."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """A quantity with a known value.

    Attributes
    ----------
    quantity
        What it is, and where.
    unit
        ``"1"`` where it has none.
    target
        The known value; not zero.
    tolerance_percent
        Largest error that passes.
    why
        Why that tolerance, in a sentence.
    """

    quantity: str
    unit: str
    target: float
    tolerance_percent: float
    why: str


@dataclass(frozen=True)
class Computed:
    """What one computation found.

    Attributes
    ----------
    values
        By the name of the quantity.
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
        A line for a reader.
    source
        Author, year and where in it.
    goals
        What is compared.
    compute
        From the element size, mm, to the quantities.
    size
        Element size at which the goals hold, mm.
    converges
        Whether the error falls with the element size; else it is rounding, a rate or that of the target, and
        is not plotted.
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
        Of its target.
    goal
        The quantity, its target and tolerance.
    computed
        In the goal's unit.
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
        """Relative to the target, signed."""
        return 100 * (self.computed - self.goal.target) / abs(self.goal.target)

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance (what is no number is not)."""
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
