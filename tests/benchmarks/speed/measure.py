"""Runs a program as its own process: wall time, processor time, most memory, under limits."""

import os
import resource
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Measured:
    """Cost of one process.

    Attributes
    ----------
    status
        "done", "too long", "out of memory" or "failed".
    wall, processor
        Seconds; `processor` over all threads, user and system.
    peak_mb
        Most memory ever resident, MB, of the process and the largest of its children.
    message
        The end of what it said, where it failed.
    """

    status: str
    wall: float
    processor: float
    peak_mb: float
    message: str = ""

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def measured(
    command: Sequence[str | Path], folder: Path, threads: int, seconds: float, memory_gb: float
) -> Measured:
    """Run `command` in `folder` to its end or to a limit."""
    environment = os.environ | {
        "OMP_NUM_THREADS": str(threads),
        "MKL_NUM_THREADS": str(threads),
        "OPENBLAS_NUM_THREADS": str(threads),
    }
    limit = int(memory_gb * 1e9)
    log = folder / "log.txt"
    with log.open("wb") as output:
        start = time.perf_counter()
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=folder,
            env=environment,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            # It fails alone rather than the machine with it.
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),  # noqa: PLW1509
        )
        late = threading.Event()

        def stop() -> None:
            late.set()
            os.killpg(process.pid, signal.SIGKILL)

        timer = threading.Timer(seconds, stop)
        timer.start()
        try:
            _, code, usage = os.wait4(process.pid, 0)
        except KeyboardInterrupt:  # it has a session of its own, which hears no Ctrl-C
            os.killpg(process.pid, signal.SIGKILL)
            raise
        finally:
            timer.cancel()
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(code)
    said = log.read_text(encoding="utf-8", errors="replace")
    status = _status(process.returncode, said, late=late.is_set())
    return Measured(
        status,
        wall,
        usage.ru_utime + usage.ru_stime,
        usage.ru_maxrss / 1024,
        "" if status == "done" else said[-2000:],
    )


def _status(code: int, said: str, *, late: bool) -> str:
    if code == 0:
        return "done"
    if late:
        return "too long"
    short = ("memory", "bad_alloc", "malloc", "Cannot allocate")
    return "out of memory" if any(word in said for word in short) else "failed"
