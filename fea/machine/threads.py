"""How many threads the libraries may use; to be said before they are loaded."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from geometry.invalid import require

Item = TypeVar("Item")
Found = TypeVar("Found")

_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def limit_threads(threads: int | None) -> None:
    """Limit OpenMP, MKL and OpenBLAS to `threads`; None leaves what the environment says.

    Raises
    ------
    InvalidValue
        Not a positive number.
    """
    if threads is None:
        return
    require(threads >= 1, "--threads", threads, "must be at least 1")
    for variable in _VARIABLES:
        os.environ[variable] = str(threads)


def threads() -> int:
    """How many threads may run: what the environment says, or one a processor."""
    said = os.environ.get(_VARIABLES[0], "")
    if said.isdecimal() and int(said) >= 1:
        return int(said)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(function: Callable[[Item], Found], items: Iterable[Item]) -> list[Found]:
    """Apply a function that spends its time in numpy or scipy, which let other threads run, to each item."""
    with ThreadPoolExecutor(threads()) as pool:
        return list(pool.map(function, items))
