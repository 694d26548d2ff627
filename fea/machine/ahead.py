"""Import modules while the program waits for a library."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module

from fea.machine.guard import memory_limit


@contextmanager
def imported_meanwhile(names: Sequence[str]) -> Iterator[None]:
    """Import modules in a thread of its own while the block runs; no thread is left after it.

    The time is won where the block calls a library that lets other threads run. The block must not fork: a
    copy would inherit half a module. What cannot be imported says so where it is imported next. Under a
    memory limit, nothing is done: a thread takes memory of its own.

    Parameters
    ----------
    names
        Of the modules, in the order in which to import them; those left when the block fails are not. The
        block itself may import the first one, for which it waits then, and none of the others: two threads
        that import each other's modules from both ends may find half a module.
    """
    if not names or memory_limit() is not None:
        yield
        return
    failed = threading.Event()
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
