"""Make the standard streams usable even if they are closed, full, without a reader or not in UTF-8."""

import codecs
import io
import os
import sys
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_ESCAPED = "fea.escaped"
_COUNT = 3  # stdin, stdout, stderr


def settle_streams() -> None:
    r"""Set up stdout and stderr so that the program keeps its exit code and loses as little text as possible.

    A character that the encoding lacks is written as in JSON (``\u00b1``). If the reader of a pipe has ended
    (``| head``), the rest is dropped. Other errors of stderr are ignored; those of stdout are raised.
    """
    _open_closed()
    codecs.register_error(_ESCAPED, _escaped)
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        if sys.platform == "win32" and os.isatty(descriptor):
            continue  # Python itself writes any character to a console
        stream = outlet(descriptor, getattr(sys, name), patient=name == "stderr")
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def outlet(descriptor: int, like: TextIO | None, *, patient: bool = False) -> TextIO:
    """Return a text stream into a descriptor, which stays open when the stream is closed.

    It has the encoding of the stream that it replaces; None if that was closed. On Windows, files and pipes
    are in UTF-8, as everything that this program writes. A patient one ignores write errors instead of
    raising `OSError`.
    """
    raw = _Outlet(descriptor, "standard error" if patient else "standard output", patient=patient)
    encoding = "utf-8" if like is None or sys.platform == "win32" else like.encoding
    direct = patient or os.isatty(descriptor)
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, _ESCAPED, line_buffering=direct)


class _Outlet(io.RawIOBase):
    def __init__(self, descriptor: int, name: str, *, patient: bool) -> None:
        self._descriptor, self._name, self._patient = descriptor, name, patient

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
                raise OSError(error.errno, error.strerror, self._name) from error
            return memoryview(data).nbytes


def _open_closed() -> None:
    """Open closed descriptors, because libraries would otherwise write their messages into a result file."""
    for descriptor in range(_COUNT):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if descriptor == 0 else os.O_WRONLY)


def _escaped(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    pairs = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{pairs[i : i + 2].hex()}" for i in range(0, len(pairs), 2)), error.end
