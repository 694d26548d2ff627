from types import SimpleNamespace

import pytest

from fea.apps.sweep.cluster import ClusterError, Workers


def client(threads):
    """Of Dask, with as many threads as a list says, one look after another."""
    return SimpleNamespace(nthreads=lambda: {"one": threads.pop(0)})


def test_those_of_a_scheduler_are_waited_for():
    now = [0.0]
    workers = Workers(client([0, 0, 3]), lambda: now[0])
    assert workers.threads() == 0
    now[0] = 1e6
    assert workers.threads() == 0
    now[0] = 2e6
    assert workers.threads() == 3


def test_a_scheduler_that_is_gone():
    def gone():
        raise OSError("Timed out")

    with pytest.raises(ClusterError, match=r"lost \(Timed out\)"):
        Workers(SimpleNamespace(nthreads=gone)).threads()
