"""Under a memory limit, run the program in a child process, so that its death can be explained.

A library that gets no memory usually ends its process: gmsh aborts, OpenBLAS dereferences a null pointer, MKL
exits with a code of its own. Without a limit, memory is not refused, and nothing is done here.
"""

import contextlib
import os
import signal
import sys
import tempfile
from collections.abc import Callable
from typing import IO

from fea.machine.exit_codes import MACHINE
from fea.machine.streams import outlet
from fea.machine.system import CAN_FORK, memory_limit
from geometry.signals import ENDS

_MIB = 2**20
# Below this limit some libraries neither load nor fail, but wait for memory forever.
LEAST = 512 * _MIB
_LONGEST_REASON = 200


def guarded(job: Callable[[], int]) -> int:
    """Return the exit code of `job`, or 7 if a memory limit ended it. The job is the whole program."""
    limit = memory_limit()
    if limit is None or not CAN_FORK:
        return job()
    if limit < LEAST:
        sys.stderr.write(
            f"fea: the memory limit of {limit // _MIB} MiB is too low: the libraries alone need more than "
            f"{LEAST // _MIB} MiB. Raise the limit (ulimit -v)\n"
        )
        return MACHINE
    from fea.machine.isolated import Copy  # noqa: PLC0415 - a run without a limit starts without it

    with tempfile.TemporaryFile() as chatter:
        read, write = os.pipe()
        child = Copy(lambda: _run(job, write, chatter))
        os.close(write)

        # Forward Ctrl-C and similar signals to the child; the program treats a repeated one as one.
        def forward(number: int, _frame: object) -> None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(child.pid, number)

        for number in ENDS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, forward)
        with os.fdopen(read, "rb") as pipe:
            said = pipe.read(1)
        code = child.wait()
        if said:
            return said[0]
        chatter.seek(0)
        _explain(limit, code, chatter.read().decode(errors="replace"))
    return MACHINE


def _run(job: Callable[[], int], write: int, chatter: IO[bytes]) -> None:
    code: int | None = None
    try:
        # Let Python write to copies of its streams, and redirect the messages of libraries to `chatter`.
        for name, descriptor in (("stdout", 1), ("stderr", 2)):
            stream = getattr(sys, name)
            stream.flush()
            copy = outlet(os.dup(descriptor), stream, patient=stream is sys.stderr)
            setattr(sys, name, copy)
            setattr(sys, f"__{name}__", copy)
            os.dup2(chatter.fileno(), descriptor)
        code = job()
    except SystemExit as leaving:
        code = leaving.code if isinstance(leaving.code, int) else 1
    finally:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        if code is not None:
            os.write(write, bytes([code & 0xFF]))
        os._exit(MACHINE)


def _explain(limit: int, code: int, chatter: str) -> None:
    how = f"was ended by {signal.Signals(-code).name}" if code < 0 else "stopped"
    lines = [line.strip() for line in chatter.splitlines() if line.strip()]
    reason = f" ({lines[-1][:_LONGEST_REASON]})" if lines else ""
    sys.stderr.write(
        f"fea: a library {how}{reason} under the memory limit of {limit // _MIB} MiB. "
        "Raise the limit (ulimit -v), or use larger elements (--size)\n"
    )
