"""The standard streams of the program, and the child process that it runs in under a memory limit."""

import codecs
import contextlib
import io
import os
import signal
import sys
import tempfile
from collections.abc import Callable
from typing import IO, TYPE_CHECKING, TextIO

from fea.machine.exit_codes import MACHINE
from fea.machine.system import CAN_FORK, memory_limit
from geometry.signals import ENDS

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_ESCAPED = "fea.escaped"
_STREAMS = (("stdout", 1), ("stderr", 2))


def settle_streams() -> None:
    r"""Set up stdout and stderr so that the program keeps its exit code and loses as little text as possible.

    A character that the encoding lacks is written as in JSON (``\u00b1``). If the reader of a pipe has ended
    (``| head``), the rest is dropped. Other errors of stderr are ignored; those of stdout are raised.
    """
    for descriptor in range(3):  # libraries would write their messages into a result file
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if descriptor == 0 else os.O_WRONLY)
    codecs.register_error(_ESCAPED, _escaped)
    for name, descriptor in _STREAMS:
        if sys.platform != "win32" or not os.isatty(descriptor):  # there Python itself writes any character
            _replace_stream(name, descriptor)


def _replace_stream(name: str, descriptor: int) -> None:
    """Let a standard stream write into a descriptor, which stays open when the stream is closed.

    It keeps its encoding; on Windows, files and pipes are in UTF-8, as everything that this program writes.
    """
    before: TextIO | None = getattr(sys, name)  # None if it was closed
    raw = _Outlet(descriptor, patient=name == "stderr")
    encoding = "utf-8" if before is None or sys.platform == "win32" else before.encoding
    direct = name == "stderr" or os.isatty(descriptor)
    stream = io.TextIOWrapper(io.BufferedWriter(raw), encoding, _ESCAPED, line_buffering=direct)
    setattr(sys, name, stream)
    setattr(sys, f"__{name}__", stream)


class _Outlet(io.RawIOBase):
    """A descriptor; a patient one ignores write errors instead of raising `OSError`, once."""

    def __init__(self, descriptor: int, *, patient: bool) -> None:
        self._descriptor, self._patient = descriptor, patient

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._descriptor

    def isatty(self) -> bool:
        return os.isatty(self._descriptor)

    def write(self, data: "ReadableBuffer", /) -> int:
        try:
            return os.write(self._descriptor, data)
        except OSError as error:
            if not self._patient and not isinstance(error, BrokenPipeError):
                self._patient = True  # raise only once
                raise OSError(error.errno, error.strerror, "standard output") from error
            return memoryview(data).nbytes


def _escaped(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    pairs = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{pairs[i : i + 2].hex()}" for i in range(0, len(pairs), 2)), error.end


_MIB = 2**20
# Below this limit some libraries neither load nor fail, but wait for memory forever.
LEAST = 512 * _MIB
_LONGEST_REASON = 200


def guarded(job: Callable[[], int]) -> int:
    """Return the exit code of `job`, the whole program, or 7 if a memory limit ended it.

    Under a limit the program runs in a child process, so that its death can be explained: a library that gets
    no memory usually ends its process. gmsh aborts, OpenBLAS dereferences a null pointer, MKL exits with a
    code of its own. Without a limit, memory is not refused, and the job runs here.
    """
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
            exit_code = pipe.read(1)
        code = child.wait()
        if exit_code:
            return exit_code[0]
        chatter.seek(0)
        lines = [line for line in chatter.read().decode(errors="replace").splitlines() if line.strip()]
    how = f"was ended by {signal.Signals(-code).name}" if code < 0 else "stopped"
    reason = f" ({lines[-1].strip()[:_LONGEST_REASON]})" if lines else ""
    sys.stderr.write(
        f"fea: a library {how}{reason} under the memory limit of {limit // _MIB} MiB. "
        "Raise the limit (ulimit -v), or use larger elements (--size)\n"
    )
    return MACHINE


def _run(job: Callable[[], int], write: int, chatter: IO[bytes]) -> None:
    """In the child: send the exit code of the job; keep messages of libraries apart from Python's output."""
    code: int | None = None
    try:
        for name, descriptor in _STREAMS:
            getattr(sys, name).flush()
            _replace_stream(name, os.dup(descriptor))
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
