"""Run jobs in a process of their own, whose crash, endless loop or lack of memory is an error here.

There are two kinds: a copy of this process, which starts at once and has everything loaded, and a fresh
interpreter, for libraries that must not be copied, or whose memory is measured. Both take jobs and send
progress and results, pickled, through pipes; both end with this process, even by ``kill -9``.
"""

import os
import pickle
import signal
import subprocess
import sys
import threading
from _thread import interrupt_main
from collections.abc import Callable, Mapping
from concurrent.futures import Future, wait
from contextlib import suppress
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryFile
from typing import IO, Any, Self, TypeVar

from fea.machine import system
from geometry.signals import ENDS, held_back, through

Result = TypeVar("Result")

_START = "from fea.machine.isolated import serve; serve(patient={patient})"
# On Windows, where Ctrl-C reaches every process of a console.
_LEAVE_CTRL_C = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
_STATUS_ERROR, _STATUS_CTRL_C = 0xC0000000, 0xC000013A  # how Windows says that a process has crashed
_BETWEEN_INTERRUPTS = 0.1  # seconds
_PATIENCE = 5.0  # seconds that an interrupted process has to clean up
# Kinds of messages of a process: any number of the first two, then one of the last two.
_PROGRESS, _LIMIT, _RESULT, _ERROR = range(4)


class _Inside:
    """In an isolated process: the pipe to its parent, and whether its processor time is limited."""

    answers: IO[bytes] | None = None
    limited = False


class CrashError(Exception):
    """The process ended without a result; `cause` is its signal (``"SIGSEGV"``) or ``"exit code 1"``."""

    def __init__(self, message: str, cause: str) -> None:
        super().__init__(message, cause)
        self.cause = cause

    def __str__(self) -> str:
        return str(self.args[0])


class OvertimeError(Exception):
    """The job took longer than it may; its process was ended."""


def begun(
    job: Callable[[], object], *, seconds: float | None = None, memory: int | None = None
) -> "IsolatedProcess":
    """Return a process that does a job, and then further ones: a copy of this one.

    Where processes cannot be copied (Windows), a fresh interpreter does the job, which must be picklable
    there. Its result and errors always must, and it must have no other effects. It may take `seconds` of
    processor time (`allow` changes that) and `memory` bytes beyond what it finds, after which it gets a
    `MemoryError`.
    """
    limited = partial(_within, job, seconds, memory)
    if system.CAN_FORK:
        return copied(limited)
    process = fresh()
    process.begin(limited)
    return process


def say(progress: str) -> None:
    """In an isolated process: send a line of progress; elsewhere nothing happens."""
    _send(_PROGRESS, progress)


def allow(seconds: float) -> None:
    """In a job with a limit: allow so much processor time from now on; elsewhere nothing happens."""
    if _Inside.limited:
        system.limit_processor_time(seconds)
        _send(_LIMIT, seconds)


class IsolatedProcess:
    """A process that does one job after another; made by `copied` and `fresh`, it ends with its block."""

    def __init__(
        self,
        started: "subprocess.Popen[bytes] | Copy",
        jobs: IO[bytes],
        answers: IO[bytes],
        messages: IO[bytes] | None = None,
        *,
        patient: bool = False,
        pending: int = 0,
    ) -> None:
        self.started = started
        self._jobs, self._answers, self._messages = jobs, answers, messages
        self._patient, self._pending = patient, pending
        # Once it has ended: the last line that it or a library wrote to standard error, where that is kept.
        self.last_message = ""
        self._reading = threading.RLock()  # a pipe must not be closed while another thread reads from it

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def alive(self) -> bool:
        """Whether it can do another job."""
        return self.started.poll() is None

    def begin(self, job: Callable[..., Any], *arguments: Any) -> None:
        """Send a picklable job; `result` returns that of the last one that was sent."""
        # Two layers: only the thread that does the job may import its modules.
        order = pickle.dumps(pickle.dumps((job, arguments)))
        self._pending += 1
        # It has ended, or another thread has closed it: `result` says how.
        with suppress(OSError, ValueError), system.broken_pipes_raise():
            self._jobs.write(order)
            self._jobs.flush()

    def result(self, listener: Callable[[str], None] | None = None, *, seconds: float | None = None) -> Any:
        """Wait for the result of a job, or raise its error; arguments as `run`."""
        late, timer = threading.Event(), None

        def end() -> None:
            late.set()
            self.started.kill()

        if seconds is not None:
            timer = threading.Timer(seconds, end)
            timer.daemon = True
            timer.start()
        try:
            while self._pending:
                kind, value = self._received(listener)
                self._pending -= 1
        except BaseException as error:
            self.close()
            if late.is_set() and isinstance(error, CrashError):
                raise OvertimeError(f"it took longer than {seconds:g} s") from error
            raise
        finally:
            if timer:
                timer.cancel()
        if kind == _ERROR:
            raise value
        return value

    def run(
        self,
        job: Callable[..., Result],
        *arguments: Any,
        seconds: float | None = None,
        listener: Callable[[str], None] | None = None,
    ) -> Result:
        """Return the result of a picklable job, or raise its error.

        After `seconds` of wall time the process is killed; the listener is called with lines of progress.
        Raises `CrashError` and `OvertimeError`: the process has ended; it cannot be given another job.
        """
        self.begin(job, *arguments)
        return self.result(listener, seconds=seconds)  # type: ignore[no-any-return]

    def close(self) -> None:
        """End the process; one that is patient and at work may clean up first."""
        if self._pending and self._patient and self.alive:
            if os.name == "posix":
                os.kill(self.started.pid, signal.SIGTERM)
            else:  # Windows' `kill` waits for nothing; a process without orders interrupts itself
                self._jobs.close()
            with suppress(subprocess.TimeoutExpired):
                self.started.wait(_PATIENCE)
        self.started.kill()
        self.started.wait()
        with suppress(OSError), system.broken_pipes_raise():  # what was not sent
            self._jobs.close()
        with self._reading:  # the pipe has ended, so that a reader leaves it
            self._answers.close()
        if self._messages is not None and not self._messages.closed:
            with self._messages:
                self._messages.seek(0)
                self.last_message = self._messages.read().decode(errors="replace").strip().rpartition("\n")[2]

    def _received(self, listener: Callable[[str], None] | None) -> tuple[int, Any]:
        progress, limit = "", 0.0
        with self._reading, suppress(EOFError, pickle.UnpicklingError):
            while not self._answers.closed:
                kind, value = _interruptible(partial(pickle.load, self._answers))
                if kind == _PROGRESS:
                    progress = value
                    if listener:
                        listener(value)
                elif kind == _LIMIT:
                    limit = value
                else:
                    return kind, value
        raise _death(self.started.wait(), f", while {progress}" if progress else "", limit)


def copied(job: Callable[[], object]) -> IsolatedProcess:
    """Copy this process; the copy does a job, which need not be picklable, and then further ones.

    Only the thread that calls this is in the copy: no other one may hold what the job needs.
    """
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    (jobs, ours_out), (ours_in, answers) = os.pipe(), os.pipe()

    def work() -> None:
        for number in ENDS:
            signal.signal(number, signal.SIG_DFL)
        through()
        if _Inside.answers is not None:  # of the process that is copied
            os.close(_Inside.answers.fileno())
        nowhere = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nowhere, descriptor)
        os.close(ours_out)
        os.close(ours_in)
        _Inside.answers = os.fdopen(answers, "wb")
        _answer(job)
        with os.fdopen(jobs, "rb") as orders, suppress(EOFError):
            while True:
                _answer(partial(_unpacked, pickle.load(orders)))  # noqa: S301 - from our own process

    def start() -> IsolatedProcess:
        child = Copy(work)
        os.close(jobs)
        os.close(answers)
        return IsolatedProcess(child, os.fdopen(ours_out, "wb"), os.fdopen(ours_in, "rb"), pending=1)

    return _started(start)


def fresh(
    environment: Mapping[str, str] | None = None, *, patient: bool = False, messages: bool = False
) -> IsolatedProcess:
    """Start a Python interpreter that finds the same modules as this one.

    `environment` is added to that of this process. A `patient` one lets a job that is interrupted clean up;
    others are killed, and Ctrl-C is left to this process. With `messages`, its standard error is kept. Raises
    `OSError`: it could not be started.
    """
    path = os.pathsep.join(place or str(Path.cwd()) for place in sys.path)
    kept = TemporaryFile() if messages else None  # noqa: SIM115 - it goes with the process

    def start() -> IsolatedProcess:
        started = subprocess.Popen(  # noqa: S603 - our own interpreter and module
            [sys.executable, "-P", "-c", _START.format(patient=patient)],
            env={**os.environ, "PYTHONPATH": path, **(environment or {})},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=kept or subprocess.DEVNULL,
            creationflags=_LEAVE_CTRL_C,
        )
        assert started.stdin is not None  # noqa: S101 - for mypy: both are pipes
        assert started.stdout is not None  # noqa: S101
        return IsolatedProcess(started, started.stdin, started.stdout, kept, patient=patient)

    try:
        return _started(start)
    except OSError:
        if kept:
            kept.close()
        raise


def serve(*, patient: bool) -> None:
    """In a fresh interpreter: do the jobs that come through standard input."""
    system.die_with_parent()
    if patient:
        system.interrupt_once(afresh=True)
    else:
        for number in ENDS:
            signal.signal(number, signal.SIG_IGN)
    through()
    orders: SimpleQueue[bytes] = SimpleQueue()
    pipe, _Inside.answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    # On Windows, a library that looks at standard input as it loads would wait for the thread that reads it.
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)  # libraries print
    threading.Thread(target=_listen, args=(pipe, orders), kwargs={"patient": patient}, daemon=True).start()
    with suppress(KeyboardInterrupt):
        while True:
            _answer(partial(_unpacked, orders.get()))
    os._exit(1)


def _listen(pipe: IO[bytes], orders: "SimpleQueue[bytes]", *, patient: bool) -> None:
    """Take jobs, and end this process with its parent, also in the middle of a job."""
    with suppress(EOFError):
        while True:
            orders.put(pickle.load(pipe))  # noqa: S301 - from our own process
    if not patient:
        os._exit(0)
    if os.name == "posix":
        os.kill(os.getpid(), signal.SIGTERM)
    else:
        interrupt_main(signal.SIGTERM)


def _unpacked(order: bytes) -> object:
    job, arguments = pickle.loads(order)  # noqa: S301 - from our own process
    return job(*arguments)


def _answer(job: Callable[[], object]) -> None:
    try:
        kind, value = _RESULT, job()
    except Exception as error:  # noqa: BLE001 - it is raised where the result is asked for
        kind, value = _ERROR, error
    _send(kind, value)


def _send(kind: int, value: object) -> None:
    if _Inside.answers is not None:
        pickle.dump((kind, value), _Inside.answers, protocol=pickle.HIGHEST_PROTOCOL)
        _Inside.answers.flush()


def _within(job: Callable[[], Result], seconds: float | None, memory: int | None) -> Result:
    if seconds is not None:
        _Inside.limited = True
        allow(seconds)
    if memory is not None:
        system.limit_memory(memory)
    return job()


def _started(start: Callable[[], IsolatedProcess]) -> IsolatedProcess:
    """Start a process; an interrupt waits until it has started, and then ends it."""
    process = None
    try:
        with held_back():
            process = start()
    except BaseException:
        if process:
            process.close()
        raise
    return process


def _interruptible(read: Callable[[], tuple[int, Any]]) -> tuple[int, Any]:
    """Read from a pipe, which Ctrl-C ends; on Windows it does not, so that another thread reads."""
    if os.name == "posix":
        return read()
    answer: Future[tuple[int, Any]] = Future()

    def work() -> None:
        try:
            answer.set_result(read())
        except Exception as error:  # noqa: BLE001 - it is raised below
            answer.set_exception(error)

    threading.Thread(target=work, daemon=True).start()
    while not wait((answer,), _BETWEEN_INTERRUPTS).done:
        pass
    return answer.result()


def _death(code: int, during: str, limit: float) -> BaseException:
    """Return the error of a process that ended with a code, negative for a signal, on Windows its status."""
    if code == system.OUT_OF_MEMORY:
        return MemoryError()
    if code == system.OVERTIME or (limit and code == -getattr(signal, "SIGPROF", 0)):
        return OvertimeError(f"it did not finish within {limit:.3g} s of processor time{during}")
    if code == _STATUS_CTRL_C or -code in ENDS:
        return KeyboardInterrupt()
    if code >= _STATUS_ERROR:
        return CrashError(f"it crashed (Windows' status {code:#x}){during}", f"status {code:#x}")
    if code >= 0:
        return CrashError(f"it stopped without a message{during}", f"exit code {code}")
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return CrashError(f"it crashed ({name}){during}", name)


class Copy:
    """A copy of this process that does some work and ends without any clean-up, code 0 if nothing was raised.

    Signals arrive there only once it has called `through`, if they are held back here.
    """

    pid: int

    def __init__(self, work: Callable[[], None]) -> None:
        if sys.platform == "win32":
            raise NotImplementedError
        self.returncode: int | None = None
        self.pid = os.fork()
        if not self.pid:
            code = 1
            try:
                system.die_with_parent()
                work()
                code = 0
            finally:
                os._exit(code)

    def poll(self, *, wait: bool = False) -> int | None:
        """Return its code, negative for a signal, None while it lives."""
        if sys.platform == "win32":
            raise NotImplementedError
        if self.returncode is None:
            try:
                pid, status = os.waitpid(self.pid, 0 if wait else os.WNOHANG)
            except ChildProcessError:  # somebody else has waited for it
                self.returncode = 1
            else:
                self.returncode = os.waitstatus_to_exitcode(status) if pid else None
        return self.returncode

    def wait(self, _timeout: float | None = None) -> int:
        """Wait until it ends, and return as `poll`."""
        return self.poll(wait=True) or 0

    def kill(self) -> None:
        """End it at once."""
        if sys.platform == "win32":
            raise NotImplementedError
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)
