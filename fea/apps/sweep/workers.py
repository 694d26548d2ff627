"""Compute the rods of a journal in isolated processes, here or by Dask's workers elsewhere."""

import json
import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple

from fea.apps.sweep.journal import Journal, RodResult
from fea.apps.sweep.sweep_file import BaseStudy, SweepOutputs
from fea.base.version import __version__
from fea.machine.isolated import CrashError, IsolatedProcess, OvertimeError, fresh
from fea.machine.system import usable_processors
from fea.machine.threads import variables
from fea.study.study import parse_study
from geometry.errors import InvalidValue, require

_LONGEST_REASON = 600
# Longest time of a rod: the largest shipped study takes some minutes on one core.
DEFAULT_MINUTES = 60.0
# Times that a rod is begun whose process crashes: memory that ran out may be there later.
_TRIES = 3
_OURS = ("fea", "geometry", "loads", "mesh")
# The job of a process, imported there only: it loads what solves.
EVALUATE = "fea.apps.sweep.evaluate:evaluate"


class Task(NamedTuple):
    """A rod to compute: what all rods share, then its digest, the values of the varied keys, its speeds."""

    base: BaseStudy
    outputs: SweepOutputs
    version: str = __version__
    seconds: float = 60 * DEFAULT_MINUTES  #: the most that it may take
    threads: int = 1  #: of the process that computes
    compute: str = EVALUATE  #: "module:function" that analyses a study
    job: str = ""
    design: Mapping[str, Any] = {}
    speeds: Sequence[float | None] = (None,)

    def of(self, journal: Journal, job: str) -> "Task":
        """Return the task of a rod of a journal."""
        design, speeds = journal.design(job)
        return self._replace(job=job, design=design, speeds=speeds)


class VersionError(OSError):
    """A worker has another version of this program (exit code 7)."""


class ClusterError(OSError):
    """No scheduler answers, or the connection to it is lost (exit code 7)."""


class _Processes(list[IsolatedProcess]):
    """The processes of the threads of one pool."""

    ended = False  #: whether they are being ended


class _OfThread(threading.local):
    """A thread of a worker has one process, which computes rod after rod and which it outlives."""

    process: IsolatedProcess | None = None
    processes = _Processes()  #: of its pool; Dask's threads share these


_of_thread = _OfThread()


def work(task: Task) -> RodResult:
    """Compute a rod in a process of its own, whose error, crash and time limit are reasons of the result.

    Raises `VersionError`: this worker's version of the program is not that of the sweep.
    """
    if task.version != __version__:
        raise VersionError(
            f"a worker has version {__version__} of conrod-fea, and this sweep is of {task.version}: "
            "start its workers with the same version."
        )
    start = time.perf_counter()
    causes: list[str] = []
    while len(causes) < _TRIES:
        try:
            result: RodResult = in_own_process(attempt, task, seconds=task.seconds, threads=task.threads)
        except OvertimeError:
            reason = (
                f"took longer than {task.seconds / 60:g} min and was ended: allow more with --limit-minutes, "
                "or use larger elements"
            )
            break
        except CrashError as error:
            if _of_thread.processes.ended:
                reason = "the sweep was interrupted"
                break
            causes.append(error.cause)
            memory = ": the memory may be too small; use fewer workers or larger elements"
            remedy = memory if "SIGKILL" in causes else ""  # as systems do where memory ends
            reason = f"its process crashed {_TRIES} times ({', '.join(dict.fromkeys(causes))}){remedy}"
        else:
            return result
    return RodResult(task.job, {}, time.perf_counter() - start, reason)


def in_own_process(job: Callable[..., Any], *arguments: Any, seconds: float | None, threads: int = 1) -> Any:
    """Run a picklable job in this thread's process. Raises `CrashError`, `OvertimeError`."""
    process = _of_thread.process
    if process is None or not process.alive:
        if process is not None:
            process.close()
        process = _of_thread.process = fresh(variables(threads))
        _of_thread.processes.append(process)
        if _of_thread.processes.ended:
            process.close()
    return process.run(job, *arguments, seconds=seconds)


def attempt(task: Task) -> RodResult:
    """Compute a rod in this process; an error is the reason of its result."""
    start, figures, reason = time.perf_counter(), {}, ""
    try:
        design = task.base.study(task.design, task.speeds)
        study = parse_study(design.text(), design.name, task.base.folder)  # as `fea sweep --study` prints it
        figures = resolve_name(task.compute)(study, task.outputs)
    except Exception as error:  # noqa: BLE001 - whatever it is, the sweep goes on
        text = " ".join(str(error).split())
        ours = type(error).__module__.partition(".")[0] in _OURS
        reason = text if ours and text else f"internal error: {type(error).__name__}: {text}"
    return RodResult(task.job, figures, time.perf_counter() - start, reason[:_LONGEST_REASON])


_CONNECT_SECONDS = 10
_COUNT_SECONDS = 5.0  # between two counts of a cluster's threads


class Workers:
    """Threads that do tasks: a number of them here, or those of a Dask client."""

    def __init__(self, executor: Executor, threads: int = 0, client: Any = None) -> None:
        self._executor, self._threads, self._client = executor, threads, client
        self._counted = -math.inf

    def threads(self) -> int:
        """Return the number of threads, 0 if there is none. Raises `ClusterError`: the scheduler is gone."""
        now = time.monotonic()
        if self._client is not None and now - self._counted >= _COUNT_SECONDS:
            self._counted = now
            try:
                self._threads = sum(self._client.nthreads().values())
            except (OSError, RuntimeError, TimeoutError) as error:
                raise _lost(error) from error
        return self._threads

    def submit(self, task: Task) -> "Future[RodResult]":
        """Begin a task."""
        try:
            return self._executor.submit(work, task)
        except RuntimeError as error:  # the system allows no more threads
            why = " ".join(str(error).split())
            raise ClusterError(f"the workers could not be started ({why}): use fewer --workers.") from error

    def require_connected(self) -> None:
        """Raise `ClusterError` if the scheduler is gone."""
        if self._client is not None and self._client.status not in ("running", "connecting"):
            raise _lost(self._client.status)


@contextmanager
def cluster(workers: int | None, address: str | None) -> Iterator[Workers]:
    """Yield `workers` on this machine, by default one for each core, or those of a Dask scheduler.

    `address` is that of the scheduler (``tcp://host:8786``), or the path of a scheduler file. Raises
    `InvalidValue`: both are given, the number is not positive, or it is neither an address nor a scheduler
    file; `ClusterError`: no scheduler answers.
    """
    rule = "cannot be combined with --cluster, which has workers of its own"
    require(workers is None or address is None, "--workers", workers, rule, "Leave it out.")
    require(workers is None or workers >= 1, "--workers", workers, "must be at least 1")
    if address is not None:
        with _connected(address) as client:
            yield Workers(client.get_executor(pure=False), client=client)
        return
    count = workers or usual_workers()
    with own_processes(count) as pool:
        yield Workers(pool, count)


def usual_workers() -> int:
    """Return the number of usable cores, without their second threads where that is known."""
    import psutil  # noqa: PLC0415 - as in `fea.machine.system`

    allowed = usable_processors()
    return min(psutil.cpu_count(logical=False) or allowed, allowed)


@contextmanager
def own_processes(count: int) -> Iterator[Executor]:
    """Yield threads, each with a process of its own, which end with the block, also within a rod."""
    processes = _Processes()
    begin = partial(setattr, _of_thread, "processes", processes)
    with ThreadPoolExecutor(count, initializer=begin) as pool:
        try:
            yield pool
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            processes.ended = True
            for process in tuple(processes):
                process.close()


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    from distributed import Client  # noqa: PLC0415 - comes with the extra

    for name in list(logging.root.manager.loggerDict):  # some have levels of their own
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    place = _scheduler(address)
    try:
        client = Client(place, timeout=_CONNECT_SECONDS)
    except (OSError, ValueError, RuntimeError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise ClusterError(
            f"--cluster {address}: no scheduler answers ({why}). Where conrod-fea and distributed are "
            "installed, start one with `dask scheduler`, and workers with `dask worker ADDRESS --nthreads 1 "
            "--nworkers N`."
        ) from error
    try:
        yield client
    finally:
        client.close(timeout=_CONNECT_SECONDS)


def _scheduler(address: str) -> str:
    """The address of a scheduler that is given by it or by a scheduler file."""
    file = Path(address)
    if not file.exists():
        rule = "is neither the address of a scheduler nor an existing scheduler file"
        require(":" in address, "--cluster", address, rule, "An address is, for example, tcp://host:8786.")
        return address
    try:
        return str(json.loads(file.read_text(encoding="utf-8"))["address"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        rule = "is not a scheduler file, which is JSON with an address"
        remedy = "`dask scheduler --scheduler-file FILE` writes one."
        raise InvalidValue("--cluster", address, rule, remedy) from error


def _lost(why: object) -> ClusterError:
    return ClusterError(
        f"the connection to the scheduler is lost ({why}). The finished rods are in the journal: start "
        "the scheduler again, and run the same command."
    )


# Seconds between two looks at the cluster where no rod comes back.
_WAIT = 0.5


def compute_pending(
    journal: Journal,
    workers: Workers,
    common: Task,
    listener: Callable[[Sequence[RodResult], int], None],
) -> None:
    """Compute the pending rods of a journal, of which this is the only writer, by what is `common` to them.

    `listener` is called about twice a second, and after each entry, with the results that came back and the
    number of threads. Raises `ClusterError`: the scheduler is gone; `VersionError`: a worker has another
    version of the program, or none; `StorageError`: the journal cannot be written.
    """
    jobs = deque(journal.pending())
    running: dict[Future[RodResult], str] = {}
    while jobs or running:
        # One rod for each thread: none waits on a worker that may die.
        while jobs and len(running) < max(1, workers.threads()):
            future = workers.submit(common.of(journal, jobs[0]))
            running[future] = jobs.popleft()
        finished, _ = wait(running, timeout=_WAIT, return_when=FIRST_COMPLETED)
        results = [_result(future, running.pop(future)) for future in finished]
        if results:
            journal.finish(results)
        else:
            workers.require_connected()
        listener(results, workers.threads())


def _result(future: "Future[RodResult]", job: str) -> RodResult:
    if future.cancelled():
        raise _lost("cancelled")
    error = future.exception()
    if error is None:
        return future.result()
    if isinstance(error, VersionError):
        raise error
    if type(error).__name__ == "KilledWorker":
        return RodResult(job, {}, 0.0, "the worker that computed it ended repeatedly")
    why = error.__cause__ or error
    raise VersionError(
        f"the cluster cannot begin a rod ({type(why).__name__}: {' '.join(str(why).split())}): install "
        f"conrod-fea {__version__} and its extra sweep where the scheduler and its workers run, and start "
        "them again."
    ) from error
