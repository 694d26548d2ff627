"""Run a computation in a fresh process, to measure its peak memory and to survive its crash."""

import contextlib
import os
import signal
import threading
from collections.abc import Callable
from multiprocessing import get_all_start_methods, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import TypeVar

from fea.machine.streams import interrupt_once
from geometry.system import held_back, through

Result = TypeVar("Result")

_PATIENCE = 5.0  # seconds that an interrupted process has to clean up


def in_fresh_process(module: str, work: Callable[..., Result], *arguments: object) -> Result | None:
    """Return the result of `work` from a process that has imported a module and computed nothing else.

    Returns None if the process or the work fails. If this process is interrupted, the other one ends too,
    after cleaning up.

    Parameters
    ----------
    module
        Name of the module with everything that `work` needs, so that its times do not include imports.
    work
        A function of some module.
    arguments
        Its arguments; they and its result must be picklable.
    """
    context = _context(module)
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(there, work, *arguments), daemon=True)
    try:
        resource_tracker.ensure_running()  # otherwise it starts with the process, and accepts signals
        with held_back():  # a signal during the imports would print a traceback
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
    """In the fresh process: send the result of the work, or nothing."""
    with contextlib.suppress(Exception, KeyboardInterrupt):
        interrupt_once(afresh=True)
        threading.Thread(target=_end_with_parent, daemon=True).start()
        through()
        pipe.send(work(*arguments))
    os._exit(0)


def _end_with_parent() -> None:
    """Interrupt this process when its parent has ended, even by ``kill -9``."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGTERM)
