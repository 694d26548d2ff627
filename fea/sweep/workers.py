"""How many threads compute; processes of this machine that ended for good are replaced."""

import time
from collections.abc import Callable
from typing import Any

from fea.sweep.cluster import ClusterError

# Seconds between two looks, and for which none of this machine's workers may be there.
_LOOK = 5.0
_PATIENCE = 300.0


class Workers:
    """The workers of a cluster.

    Parameters
    ----------
    client
        Of Dask.
    clock
        Seconds.
    """

    def __init__(self, client: Any, clock: Callable[[], float] = time.monotonic) -> None:
        self._client, self._clock = client, clock
        self._looked, self._seen, self._threads = -float("inf"), clock(), 0

    def threads(self) -> int:
        """Return how many threads there are.

        Raises
        ------
        ClusterError
            The scheduler is gone, or no worker of this machine stays.
        """
        now = self._clock()
        if now - self._looked < _LOOK:
            return self._threads
        self._looked = now
        try:
            self._threads = sum(self._client.nthreads().values())
        except (OSError, RuntimeError, TimeoutError) as error:
            raise lost(error) from error
        if self._threads:
            self._seen = now
        if (processes := self._client.cluster) is not None:
            _replace(processes)
            if now - self._seen > _PATIENCE:
                raise ClusterError(
                    f"no worker process has stayed for {_PATIENCE:.0f} s. The rods that came back are in the "
                    "journal: see that there is memory (use fewer --workers), and run the same command."
                )
        return self._threads


def lost(why: object) -> ClusterError:
    """Return the error of a scheduler that is gone."""
    return ClusterError(
        f"the connection to the scheduler is lost ({why}). The rods that came back are in the journal: start "
        "the scheduler again, and run the same command."
    )


def _replace(processes: Any) -> None:
    """Start workers in place of lost ones: Dask does not where one ended while it started."""
    processes.scale(len(processes.worker_spec))
