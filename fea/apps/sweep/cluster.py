"""Compute the rods of a journal on this machine, or by the workers of a Dask scheduler."""

import json
import logging
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fea.apps.sweep.journal import Done, Journal
from fea.apps.sweep.work import Task, VersionError, own_processes, work
from fea.base.version import __version__
from fea.machine.system import usable_processors
from geometry.errors import InvalidValue, require

_CONNECT_SECONDS = 10


class ClusterError(OSError):
    """No scheduler answers, or the connection to it is lost (exit code 7)."""


@contextmanager
def cluster(workers: int | None, address: str | None) -> Iterator[Any]:
    """Yield a Dask client of `workers` on this machine, or of a scheduler.

    `address` is that of the scheduler (``tcp://host:8786``), or the path of a scheduler file. Raises
    `InvalidValue`: both are given, the number is not positive, or it is neither an address nor a scheduler
    file; `ClusterError`: no scheduler answers.
    """
    import distributed  # noqa: F401, PLC0415 - comes with the extra
    import psutil  # noqa: PLC0415 - likewise

    rule = "cannot be combined with --cluster, which has workers of its own"
    require(workers is None or address is None, "--workers", workers, rule, "Leave it out.")
    require(workers is None or workers >= 1, "--workers", workers, "must be at least 1")
    _quiet()
    allowed = usable_processors()
    cores = min(psutil.cpu_count(logical=False) or allowed, allowed)  # without their second threads
    with _local(workers or cores) if address is None else _remote(address) as client:
        yield client


@contextmanager
def _local(workers: int) -> Iterator[Any]:
    """Threads of this process, each of which hands its rods to a process of its own (`in_own_process`)."""
    from distributed import Client, LocalCluster  # noqa: PLC0415 - comes with the extra

    try:
        threads = LocalCluster(
            n_workers=1,
            threads_per_worker=workers,
            processes=False,
            memory_limit=0,  # the rods' processes are none that Dask could pause
            dashboard_address=None,
            worker_dashboard_address=None,
            silence_logs=50,
        )
    except (OSError, RuntimeError) as error:
        why = " ".join(str(error).split())
        raise ClusterError(
            f"the {workers} workers could not be started ({why}): use fewer --workers."
        ) from error
    with threads, Client(threads) as client, own_processes():
        yield client


@contextmanager
def _remote(address: str) -> Iterator[Any]:
    from distributed import Client  # noqa: PLC0415 - comes with the extra

    place = _address(address)
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


def _quiet() -> None:
    for name in list(logging.root.manager.loggerDict):  # some have levels of their own
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _address(asked: str) -> str:
    file = Path(asked)
    if not file.exists():
        rule = "is neither the address of a scheduler nor an existing scheduler file"
        require(":" in asked, "--cluster", asked, rule, "An address is, for example, tcp://host:8786.")
        return asked
    try:
        return str(json.loads(file.read_text(encoding="utf-8"))["address"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        rule = "is not a scheduler file, which is JSON with an address"
        remedy = "`dask scheduler --scheduler-file FILE` writes one."
        raise InvalidValue("--cluster", asked, rule, remedy) from error


_LOOK = 5.0  # seconds between two looks


class Workers:
    """The workers of a Dask client."""

    def __init__(self, client: Any, clock: Callable[[], float] = time.monotonic) -> None:
        self._client, self._clock = client, clock
        self._looked, self._threads = -float("inf"), 0

    def threads(self) -> int:
        """Return the number of threads, 0 if there is none. Raises `ClusterError`: the scheduler is gone."""
        now = self._clock()
        if now - self._looked < _LOOK:
            return self._threads
        self._looked = now
        try:
            self._threads = sum(self._client.nthreads().values())
        except (OSError, RuntimeError, TimeoutError) as error:
            raise lost(error) from error
        return self._threads


def lost(why: object) -> ClusterError:
    """Return the error of a scheduler that is gone."""
    return ClusterError(
        f"the connection to the scheduler is lost ({why}). The finished rods are in the journal: start "
        "the scheduler again, and run the same command."
    )


# Seconds between two looks at the cluster where no rod comes back.
_WAIT = 0.5
# Rods of a task: so many take about these seconds, so that giving it out costs little beside computing it,
# and what an end of the program loses stays small.
_TASK_SECONDS, _MOST_RODS = 4.0, 100
# What is left is shared by so many tasks for each thread, so that all end at about the same time.
_SHARES = 4


class Engine:
    """Gives pending rods to a Dask client, as the journal's only writer; `compute` replaces the analysis."""

    def __init__(
        self,
        journal: Journal,
        client: Any,
        task: Callable[[Sequence[str]], Task],
        compute: Callable[..., Any] | None = None,
    ) -> None:
        self._journal, self._client, self._task, self._compute = journal, client, task, compute
        self._back: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._out: dict[Any, Sequence[str]] = {}
        self._workers = Workers(client)
        self._alone: list[str] = []  # rods of which one may have ended its worker
        self._seconds = math.inf  # of a rod, of late

    def run(self, listener: Callable[[int, int, float], None]) -> None:
        """Compute them all.

        `listener` is called about twice a second, and after each entry, with the number of rods that came
        back, the number of threads, and the seconds of a rod of late. Raises `ClusterError`: the scheduler is
        gone; `VersionError`: a worker has another version of the program, or none; `StorageError`: the
        journal cannot be written.
        """
        jobs = deque(self._journal.pending())
        self._give(jobs)
        while self._out:
            back = [rod for future in self._wait() for rod in self._result(future)]
            if back:
                self._journal.finish(back)
                self._seconds = sum(rod.seconds for rod in back) / len(back)
            self._give(jobs)
            listener(len(back), self._workers.threads(), self._seconds)

    def _give(self, jobs: deque[str]) -> None:
        """Keep one task for each thread given out: none waits on a worker that may die."""
        threads = max(1, self._workers.threads())
        while len(self._out) < threads and (jobs or self._alone):
            if self._alone:
                own = [self._alone.pop()]
            else:
                fair = len(jobs) // (_SHARES * threads)
                count = max(1, min(int(_TASK_SECONDS / max(self._seconds, 1e-3)), _MOST_RODS, fair))
                own = [jobs.popleft() for _ in range(count)]
            future = self._client.submit(work, self._task(own), self._compute, pure=False)
            self._out[future] = own
            future.add_done_callback(self._back.put)

    def _wait(self) -> list[Any]:
        futures = []
        try:
            futures.append(self._back.get(timeout=_WAIT))
            while True:
                futures.append(self._back.get_nowait())
        except queue.Empty:
            if self._client.status not in ("running", "connecting"):
                raise lost(self._client.status) from None
        return futures

    def _result(self, future: Any) -> list[Done]:
        jobs = self._out.pop(future)
        if future.status == "cancelled":
            raise lost(future.status)
        error = future.exception()  # waits where the worker that held the result has ended meanwhile
        if error is None:
            done: list[Done] = future.result()
            # As long as it is wanted, Dask computes it again when the worker that holds it ends.
            future.release()
            return done
        if isinstance(error, VersionError):
            raise error
        if type(error).__name__ != "KilledWorker":
            raise _unready(error) from error
        if len(jobs) > 1:
            self._alone += jobs
            return []
        return [Done(jobs[0], {}, 0.0, "the worker that computed it ended repeatedly")]


def _unready(error: BaseException) -> VersionError:
    """What keeps a cluster from beginning a rod, whose own errors are results."""
    why = error.__cause__ or error
    said = f"{type(why).__name__}: {' '.join(str(why).split())}"
    return VersionError(
        f"the cluster cannot begin a rod ({said}): install conrod-fea {__version__} and its extra sweep "
        "where the scheduler and its workers run, and start them again."
    )
