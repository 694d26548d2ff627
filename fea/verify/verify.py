"""Find benchmark problems by name and compute them."""

import importlib
import pkgutil
import time
from collections.abc import Callable, Sequence

from fea.verify import cases
from fea.verify.benchmark import Benchmark, Row
from geometry.errors import require


def case_names() -> tuple[str, ...]:
    """Return the names of all cases: the modules of `fea.verify.cases` (none is loaded)."""
    return tuple(_name(module.name) for module in pkgutil.iter_modules(cases.__path__))


def benchmark(name: str) -> Benchmark:
    """Load the benchmark called `name`.

    Raises
    ------
    InvalidValue
        There is no such case.
    """
    names = case_names()
    require(name in names, "CASE", name, "is not a benchmark", f"Choose from {', '.join(names)}.")
    module = importlib.import_module(f"{cases.__name__}.{name.replace('-', '_')}")
    loaded: Benchmark = module.BENCHMARK
    return loaded


def verify(names: Sequence[str] = (), listener: Callable[[str], None] | None = None) -> list[Row]:
    """Compute some cases, or all; return one row per quantity.

    Parameters
    ----------
    names
        Names of the cases; empty for all.
    listener
        Called with the name of each case before it begins.

    Raises
    ------
    InvalidValue
        There is no such case; it is raised before anything is computed.
    """
    chosen = {name: benchmark(name) for name in names or case_names()}
    rows: list[Row] = []
    for name, case in chosen.items():
        if listener:
            listener(name)
        rows += computed_rows(name, case, case.size)
    return rows


def computed_rows(name: str, case: Benchmark, size: float) -> list[Row]:
    """Compute a case with elements of `size`."""
    start = time.perf_counter()
    found = case.compute(size)
    seconds = time.perf_counter() - start
    return [
        Row(name, case.source, goal, found.values[goal.quantity], found.dofs, seconds) for goal in case.goals
    ]


def _name(module: str) -> str:
    return module.replace("_", "-")
