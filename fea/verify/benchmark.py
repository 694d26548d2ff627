"""A benchmark problem: a function from an element size to quantities with known values."""

import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from fea.machine.clock import Listener
from fea.output.json_file import JsonObject
from geometry.errors import require

Row = TypeVar("Row")


class Quantity(NamedTuple):
    """A computed quantity and its known value."""

    #: name, unit: the quantity and its place; ``"1"`` for a dimensionless one
    name: str
    unit: str
    #: target, computed: the known value, not zero, and the computed one
    target: float
    computed: float
    tolerance_percent: float  #: largest error that passes
    why: str  #: the reason for the tolerance, in a sentence

    @property
    def error_percent(self) -> float:
        """Signed error relative to the target, percent."""
        return 100 * (self.computed - self.target) / abs(self.target)

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance (NaN is not)."""
        return abs(self.error_percent) <= self.tolerance_percent


# The quantities of one computation; returned are the degrees of freedom of the (largest) mesh.
Quantities = Generator[Quantity, None, int]


@dataclass(frozen=True)
class BenchmarkRow:
    """A quantity of a case with its cost; `seconds` is the wall time of the whole case."""

    case: "Benchmark"
    quantity: Quantity
    dofs: int
    seconds: float

    def as_dict(self) -> JsonObject:
        """Return the row with the names that other programs rely on."""
        named = ("unit", "target", "computed", "error_percent", "tolerance_percent")
        of_quantity = {name: getattr(self.quantity, name) for name in named}
        cost = {"dofs": self.dofs, "seconds": self.seconds, "pass": self.passed, "source": self.case.source}
        return {"case": self.case.name, "quantity": self.quantity.name, **of_quantity, **cost}

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.quantity.passed


@dataclass(frozen=True)
class Benchmark:
    """A benchmark problem, with its name on the command line and in words, and the source of its targets."""

    name: str
    title: str
    source: str
    #: compute, size: from an element size, mm, to the quantities; the size at which tolerances must be met
    compute: Callable[[float], Quantities]
    size: float
    #: whether the error decreases with the element size and is plotted; otherwise it consists of rounding, is
    #: a rate or is the error of the target
    converges: bool = False

    def rows(self, factor: float = 1.0) -> list[BenchmarkRow]:
        """Compute the quantities with elements of `factor` times the size."""
        start, dofs = time.perf_counter(), 0

        def computed() -> Iterator[Quantity]:
            nonlocal dofs
            dofs = yield from self.compute(factor * self.size)

        quantities = list(computed())
        seconds = time.perf_counter() - start
        return [BenchmarkRow(self, quantity, dofs, seconds) for quantity in quantities]


CASES: dict[str, Benchmark] = {}


def benchmark(
    source: str, *, size: float, converges: bool = False
) -> Callable[[Callable[[float], Quantities]], Benchmark]:
    """Add a function to `CASES`, under its name with hyphens and the title that its docstring begins with."""

    def register(compute: Callable[[float], Quantities]) -> Benchmark:
        name, title = compute.__name__.replace("_", "-"), (compute.__doc__ or "").partition("\n")[0]
        if name in CASES:
            raise ValueError(f"two benchmark problems are named {name}")
        CASES[name] = Benchmark(name, title.removesuffix("."), source, compute, size, converges)
        return CASES[name]

    return register


def compute_rows(
    cases: Mapping[str, Callable[[], Iterable[Row]]],
    kind: str,
    names: Sequence[str] = (),
    listener: Listener | None = None,
) -> list[Row]:
    """Compute the rows of some cases of a `kind`, such as "a benchmark", or of all.

    `listener` is called with the name of each case before it begins. Raises `InvalidValue`: there is no such
    case; it is raised before anything is computed.
    """
    for name in names:
        require(name in cases, "CASE", name, f"is not {kind}", f"Choose from {', '.join(cases)}.")
    rows: list[Row] = []
    for name in names or cases:
        if listener:
            listener(name)
        rows += cases[name]()
    return rows
