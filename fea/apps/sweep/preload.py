"""What Dask loads into each worker of this machine as it starts."""

import signal


def dask_setup(_worker: object) -> None:
    """Leave Ctrl-C to the program, which ends its workers; Dask looks for this name."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
