"""Threads: those of the libraries, whose number must be set before they are loaded, and ours."""

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import TypeVar

from fea.machine.system import memory_limit, usable_processors
from geometry.errors import require

Item = TypeVar("Item")
Result = TypeVar("Result")

_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS")


def limit_threads(threads: int | None) -> None:
    """Limit OpenMP and MKL, unless None. Raises `InvalidValue`: not a positive number."""
    require(threads is None or threads >= 1, "--threads", threads, "must be at least 1")
    os.environ.update(variables(threads))


def variables(threads: int | None) -> dict[str, str]:
    """Return the environment of another process that limits OpenMP and MKL; empty for None."""
    return {} if threads is None else dict.fromkeys(_VARIABLES, str(threads))


def threads(default: int | None = None) -> int:
    """Number of threads: from the environment, or the default, which is one per processor."""
    given = os.environ.get(_VARIABLES[0], "")
    if given.isdecimal() and int(given) >= 1:
        return int(given)
    return usable_processors() if default is None else default


def side_by_side(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Apply a function to each item in parallel threads; it should spend its time in numpy or scipy."""
    every, most = list(items), threads()
    if min(len(every), most) < 2:
        return list(map(function, every))
    with ThreadPoolExecutor(min(len(every), most)) as pool:
        return list(pool.map(function, every))


@contextmanager
def imported_meanwhile(names: Sequence[str]) -> Iterator[None]:
    """Import modules one after another in a thread of their own while the block runs; it ends with the block.

    This saves time where the block calls a library that lets other threads run. The block must not fork: a
    copy would inherit a state half changed. It may import the first module, for which it waits then, and
    none of the others: two threads that import each other's modules from both ends may find half a module.
    A module that cannot be imported raises its error where it is used; if the block fails, the rest is not
    imported. Nor is anything under a memory limit: a thread takes memory of its own.
    """
    failed = threading.Event()
    if not names or memory_limit() is not None:
        yield
        return
    thread = threading.Thread(target=_import, args=(names, failed), name="imports")
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


def _import(names: Sequence[str], failed: threading.Event) -> None:
    for name in names:
        if failed.is_set():
            return
        with suppress(Exception):
            import_module(name)
