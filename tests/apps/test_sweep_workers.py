from types import SimpleNamespace

import pytest

from fea.apps.sweep.cluster import ClusterError, Workers


def client(threads, processes=None):
    """Of Dask, with as many threads as a list says, one look after another."""
    return SimpleNamespace(nthreads=lambda: {"one": threads.pop(0)}, cluster=processes)


def test_workers_of_this_machine_that_ended_are_replaced_and_missed_after_a_while():
    now, asked = [0.0], []
    processes = SimpleNamespace(worker_spec={0: 0, 1: 1}, scale=asked.append)
    workers = Workers(client([2, 0, 1, 0, 0], processes), lambda: now[0])
    for at, expected in ((0, 2), (1, 2), (10, 0), (20, 1), (200, 0)):
        now[0] = float(at)
        assert workers.threads() == expected
    assert asked == [2] * 4
    now[0] = 400.0
    with pytest.raises(ClusterError, match="no worker was available for 300 s"):
        workers.threads()


def test_those_of_a_scheduler_are_waited_for():
    now = [0.0]
    workers = Workers(client([0, 0]), lambda: now[0])
    workers.threads()
    now[0] = 1e6
    assert workers.threads() == 0


def test_a_scheduler_that_is_gone():
    def gone():
        raise OSError("Timed out")

    with pytest.raises(ClusterError, match=r"lost \(Timed out\)"):
        Workers(SimpleNamespace(nthreads=gone, cluster=None)).threads()
