"""Give out the rods of a journal to a cluster, and enter what comes back: the only writer is here."""

import queue
from collections.abc import Callable, Iterator
from typing import Any

from fea.apps.sweep.cluster import Workers, lost
from fea.apps.sweep.journal import Done, Journal
from fea.apps.sweep.work import Task, VersionError, program_version, work
from geometry.errors import InvalidValue

# Seconds between two looks at the cluster where no rod comes back.
_LOOK = 0.5


class Engine:
    """Computes the pending rods of a journal.

    Parameters
    ----------
    journal
        Where results are entered.
    client
        Of Dask.
    task
        The task of a rod, by its digest.
    compute
        In place of the analysis, for tests.
    """

    def __init__(
        self,
        journal: Journal,
        client: Any,
        task: Callable[[str], Task],
        compute: Callable[..., Any] | None = None,
    ) -> None:
        self._journal, self._client, self._task, self._compute = journal, client, task, compute
        self._back: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._out: dict[Any, str] = {}
        self._workers = Workers(client)

    def run(self, listener: Callable[[int, int], None]) -> None:
        """Compute them all.

        Parameters
        ----------
        listener
            Told, about twice a second and after each entry, how many rods came back and how many threads
            compute.

        Raises
        ------
        ClusterError
            The scheduler is gone.
        VersionError
            A worker has another version of the program, or none.
        StorageError
            The journal cannot be written.
        """
        jobs = iter(self._journal.pending())
        self._give(jobs)
        while self._out:
            back = self._wait()
            if back:
                self._journal.finish([self._result(future) for future in back])
            self._give(jobs)
            listener(len(back), self._workers.threads())

    def _give(self, jobs: Iterator[str]) -> None:
        """Keep one rod for each thread given out: none waits on a worker that may die."""
        while len(self._out) < max(1, self._workers.threads()):
            job = next(jobs, None)
            if job is None:
                return
            try:
                task = self._task(job)
            except InvalidValue as error:  # a design that breaks a rule, tried again
                self._journal.finish([Done(job, {}, 0.0, str(error))])
                continue
            future = self._client.submit(work, task, self._compute, pure=False)
            self._out[future] = job
            future.add_done_callback(self._back.put)

    def _wait(self) -> list[Any]:
        """Return the rods that have come back, after a while none."""
        found = []
        try:
            found.append(self._back.get(timeout=_LOOK))
            while True:
                found.append(self._back.get_nowait())
        except queue.Empty:
            if self._client.status not in ("running", "connecting"):
                raise lost(self._client.status) from None
        return found

    def _result(self, future: Any) -> Done:
        job = self._out.pop(future)
        if future.status == "cancelled":
            raise lost(future.status)
        error = future.exception()  # waits where the worker that held the result has ended meanwhile
        if error is None:
            done: Done = future.result()
            # As long as it is wanted, Dask computes it again when the worker that holds it ends.
            future.release()
            return done
        if isinstance(error, VersionError):
            raise error
        if type(error).__name__ == "KilledWorker":
            return Done(job, {}, 0.0, "the worker that computed it ended, again and again")
        raise _unready(error) from error


def _unready(error: BaseException) -> VersionError:
    """What keeps a cluster from beginning a rod, whose own errors are results."""
    why = error.__cause__ or error
    said = f"{type(why).__name__}: {' '.join(str(why).split())}"
    return VersionError(
        f"the cluster cannot begin a rod ({said}): install conrod-fea[sweep] {program_version()} where the "
        "scheduler and its workers run, and start them again."
    )
