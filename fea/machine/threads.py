"""Threads: those of the libraries, whose number must be set before they are loaded, and ours."""

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import cache, partial
from importlib import import_module
from typing import Any, TypeVar

from geometry.errors import require
from geometry.system import memory_limit, usable_processors

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
    return usable_processors()


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


@contextmanager
def meanwhile(*jobs: Callable[[], object]) -> Iterator[None]:
    """Run jobs one after another in a thread of their own while the block runs; no thread is left after it.

    The time is won where the block calls a library that lets other threads run. The block must not fork: a
    copy would inherit a state half changed. What a job cannot do is left undone, without a message, and so
    are the jobs not begun when the block fails. Under a memory limit, nothing is done: a thread takes memory
    of its own.
    """
    failed = threading.Event()
    if not jobs or memory_limit() is not None:
        yield
        return
    thread = threading.Thread(target=_work, args=(jobs, failed), name="meanwhile")
    try:
        thread.start()
    except RuntimeError:  # the system allows no more threads
        yield
        return
    try:
        yield
    except BaseException:
        failed.set()
        raise
    finally:
        thread.join()


@contextmanager
def imported_meanwhile(names: Sequence[str]) -> Iterator[None]:
    """Import modules in this order while the block runs; what cannot be imported says so later.

    The block itself may import the first one, for which it waits then, and none of the others: two threads
    that import each other's modules from both ends may find half a module.
    """
    with meanwhile(*(partial(import_module, name) for name in names)):
        yield


def _work(jobs: Sequence[Callable[[], object]], failed: threading.Event) -> None:
    for job in jobs:
        if failed.is_set():
            return
        with suppress(Exception):
            job()
