"""The number of threads of the libraries, which must be set before they are loaded."""

import os
import resource
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from typing import Any, TypeVar

from geometry.errors import require

Item = TypeVar("Item")
Found = TypeVar("Found")

_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def limit_threads(threads: int | None) -> None:
    """Limit OpenMP, MKL and OpenBLAS to `threads`; None leaves the environment unchanged.

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
    """Number of threads: from the environment, or one per processor."""
    said = os.environ.get(_VARIABLES[0], "")
    if said.isdecimal() and int(said) >= 1:
        return int(said)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let BLAS run in one thread meanwhile: over small matrices, more threads are several times slower."""
    with _controller().limit(limits=1, user_api="blas"):
        yield


@cache
def _controller() -> Any:
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415 - it looks at every library that is loaded

    return ThreadpoolController()


def side_by_side(function: Callable[[Item], Found], items: Iterable[Item]) -> list[Found]:
    """Apply a function to each item in parallel threads; it should spend its time in numpy or scipy."""
    every, most = list(items), threads()
    if min(len(every), most) < 2:
        return list(map(function, every))
    with ThreadPoolExecutor(min(len(every), most)) as pool:
        return list(pool.map(function, every))


def peak_memory() -> float:
    """Largest resident memory of this process so far, MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)
