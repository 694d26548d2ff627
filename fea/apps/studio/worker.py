"""A process that computes for the server, and is started again where it has ended."""

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

from fea.machine.isolated import CrashError, IsolatedProcess, fresh


class Worker:
    """Does one job after another in a process of its own, whose first job is the `opening`."""

    def __init__(self, opening: Callable[..., Any], *arguments: Any) -> None:
        self._opening = partial(opening, *arguments)
        self._process: IsolatedProcess | None = None

    async def run(
        self, job: Callable[..., Any], *arguments: Any, listener: Callable[[str], None] | None = None
    ) -> Any:
        """Return the result of a picklable job, or raise its error.

        The listener is called, in this thread, with the lines that the job says. Raises `CrashError`,
        `MemoryError`: the process has ended; the next job has another one.
        """
        loop = asyncio.get_running_loop()

        def heard(line: str) -> None:
            if listener is not None:
                loop.call_soon_threadsafe(listener, line)

        begins = self._process is None
        # By the main thread, whose end is that of the process.
        process = self._process = self._process or fresh()
        try:
            if begins:
                await asyncio.to_thread(_waited, process, self._opening, None)
            return await asyncio.to_thread(_waited, process, partial(job, *arguments), heard)
        finally:
            if self._process is process and not process.alive:
                self._process = None

    def stop(self) -> None:
        """End the process, also within a job."""
        if self._process is not None:
            self._process.close()
            self._process = None


def _waited(process: IsolatedProcess, job: Callable[[], Any], listener: Callable[[str], None] | None) -> Any:
    try:
        return process.run(job, listener=listener)
    except KeyboardInterrupt:  # it was ended by a signal that would interrupt this program
        raise CrashError("it was ended", "SIGTERM") from None
