"""A computation in a process of its own, so that its peak memory is its own and its death no other's."""

import contextlib
import os
import signal
import threading
from collections.abc import Callable
from multiprocessing import get_all_start_methods, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import TypeVar

from fea.machine.signals import interrupt_once
from geometry.system.signals import held_back, through

Result = TypeVar("Result")

_PATIENCE = 5.0  # seconds that an interrupted process has to clean up


def in_fresh_process(module: str, work: Callable[..., Result], *arguments: object) -> Result | None:
    """Return what `work` returns in a process that has imported a module and computed nothing.

    Where the process or the work fails, None. What interrupts this process ends that one too, which cleans up
    first.

    Parameters
    ----------
    module
        Its name: all that `work` needs, so that its times are not those of imports.
    work
        A function of some module.
    arguments
        What it is given; they and what it returns can be pickled.
    """
    context = _context(module)
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(there, work, *arguments), daemon=True)
    try:
        resource_tracker.ensure_running()  # else it starts with the process, and lets signals through
        with held_back():  # those that it got while it imports would print a traceback
            process.start()
        there.close()
        return here.recv()  # type: ignore[no-any-return]
    except EOFError:
        return None
    except BaseException:
        if process.pid:
            process.terminate()
            process.join(_PATIENCE)
        raise
    finally:
        if process.pid:
            process.kill()
            process.join()
        here.close()


def _context(module: str) -> ForkServerContext | SpawnContext:
    if "forkserver" not in get_all_start_methods():
        return get_context("spawn")
    context = get_context("forkserver")
    context.set_forkserver_preload([module])
    return context


def _answer(pipe: Connection, work: Callable[..., object], *arguments: object) -> None:
    """In the fresh process: send what the work returns, or nothing."""
    with contextlib.suppress(Exception, KeyboardInterrupt):
        interrupt_once(afresh=True)
        threading.Thread(target=_end_with_parent, daemon=True).start()
        through()
        pipe.send(work(*arguments))
    os._exit(0)


def _end_with_parent() -> None:
    """Interrupt this process when the one that asked for it is gone, were it by ``kill -9``."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGTERM)
