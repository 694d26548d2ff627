"""Do something else while the program waits for a library."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module

from fea.machine.guard import memory_limit


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
    """Import modules while the block runs, as `meanwhile` does; what cannot be imported says so later.

    Parameters
    ----------
    names
        Of the modules, in the order in which to import them. The block itself may import the first one, for
        which it waits then, and none of the others: two threads that import each other's modules from both
        ends may find half a module.
    """
    with meanwhile(*(partial(import_module, name) for name in names)):
        yield


def _work(jobs: Sequence[Callable[[], object]], failed: threading.Event) -> None:
    for job in jobs:
        if failed.is_set():
            return
        with suppress(Exception):
            job()
