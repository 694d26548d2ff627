"""The engine with a client that computes at once, and clusters that cannot be used."""

import logging
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from fea.apps.sweep import cluster, work
from fea.apps.sweep.base import Base, Extras
from fea.apps.sweep.cluster import ClusterError, Engine
from fea.apps.sweep.journal import Done, Journal, State
from fea.apps.sweep.sweep_file import PlannedRow
from fea.apps.sweep.work import Rod, Task, VersionError
from fea.base.version import __version__
from geometry.errors import InvalidValue


class KilledWorker(Exception):  # noqa: N818 - the name that Dask gives it
    pass


class Client:
    """Ends each rod after some seconds, as its fate says: a value, an error, or "cancelled"."""

    def __init__(self, fates, seconds=0.0):
        self.seconds = seconds
        self.fates, self.status, self.out, self.most = dict(fates), "running", 0, 0
        self.tasks = []

    def nthreads(self):
        return {"one": 1, "two": 2}

    def submit(self, _function, task, _compute, *, pure):
        assert not pure
        fates = [self.fates[rod.job] for rod in task.rods]
        fate = next((one for one in fates if not isinstance(one, Done)), fates)
        self.tasks.append(len(task.rods))
        self.out += 1
        self.most = max(self.most, self.out)
        status = fate if isinstance(fate, str) else "error" if isinstance(fate, Exception) else "finished"
        future = SimpleNamespace(
            status=status,
            result=lambda: fate,
            exception=lambda: fate if status == "error" else None,
            release=lambda: None,
        )

        def end(put):
            self.out -= 1
            put(Hashed(future))

        def tell(put):
            if self.seconds:
                threading.Timer(self.seconds, end, [put]).start()
            else:
                end(put)

        return Hashed(future, tell)


class Hashed:
    """A future, equal by what it is."""

    def __init__(self, future, tell=None):
        self._future, self.add_done_callback = future, tell

    def __getattr__(self, name):
        return getattr(self._future, name)

    def __hash__(self):
        return id(self._future)

    def __eq__(self, other):
        return self._future is other._future


def task(jobs, raw=None):
    base = Base("study", raw or {}, Path("/"), ())
    return Task(tuple(Rod(job, {}, [None]) for job in jobs), base, Extras(), __version__)


def attempted(raw, compute=None):
    one = task(["a"], raw)
    return work.attempt(one, one.rods[0], compute)


def journal_of(tmp_path, count):
    journal = Journal(tmp_path / "j.sqlite")
    rows = [
        PlannedRow(number=n, sample=n, design={}, rpm=None, job=f"job{n}", key=f"{n}") for n in range(count)
    ]  # fmt: skip
    journal.enter({"schema": "x"}, rows)
    return journal


def done(n):
    return Done(f"job{n}", {None: {"factor": n}}, 0.1)


def test_every_rod_is_given_out_once_and_entered(tmp_path):
    journal, counted = journal_of(tmp_path, 20), []
    client = Client({f"job{n}": done(n) for n in range(20)})
    Engine(journal, client, task).run(lambda count, threads, _: counted.append((count, threads)))
    assert journal.counts() == {State.PENDING: 0, State.DONE: 20, State.FAILED: 0}
    assert [entry.figures["factor"] for entry in journal.entries()] == list(range(20))
    assert sum(count for count, _ in counted) == 20
    assert {threads for _, threads in counted} == {3}


def test_no_more_rods_are_out_than_there_are_threads(tmp_path):
    client = Client({f"job{n}": done(n) for n in range(12)}, 0.01)
    Engine(journal_of(tmp_path, 12), client, task).run(lambda *_: None)
    assert client.most == 3


def test_a_rod_that_kills_its_workers_is_failed_and_the_others_go_on(tmp_path):
    journal = journal_of(tmp_path, 3)
    Engine(journal, Client({"job0": done(0), "job1": KilledWorker(), "job2": done(2)}), task).run(
        lambda *_: None
    )
    assert [entry.state for entry in journal.entries()] == [State.DONE, State.FAILED, State.DONE]
    assert "worker" in next(journal.entries(1)).reason


def test_a_task_holds_many_quick_rods_and_what_kills_a_worker_goes_alone(tmp_path):
    journal, fates = journal_of(tmp_path, 3000), {f"job{n}": done(n) for n in range(3000)}
    client = Client(fates | {"job1500": KilledWorker()})
    Engine(journal, client, task).run(lambda *_: None)
    assert max(client.tasks) == 40  # of .1 s
    assert client.tasks[-1] == 1
    assert journal.counts() == {State.PENDING: 0, State.DONE: 2999, State.FAILED: 1}


def test_a_task_holds_one_of_few_rods(tmp_path):
    few = Client({f"job{n}": done(n) for n in range(12)})
    Engine(journal_of(tmp_path, 12), few, task).run(lambda *_: None)
    assert set(few.tasks) == {1}


@pytest.mark.parametrize(
    ("fate", "error", "said"),
    [
        ("cancelled", ClusterError, "the connection to the scheduler is lost"),
        (VersionError("a worker has version 0"), VersionError, "version 0"),
        (ModuleNotFoundError("No module named 'fea'"), VersionError, "install conrod-fea"),
        (RuntimeError("Error during deserialization"), VersionError, r"\(RuntimeError: Error during"),
    ],
)
def test_a_cluster_that_is_gone_or_of_another_version_ends_the_sweep(tmp_path, fate, error, said):
    journal = journal_of(tmp_path, 3)
    with pytest.raises(error, match=said):
        Engine(journal, Client({"job0": done(0), "job1": fate, "job2": done(2)}), task).run(lambda *_: None)
    assert journal.counts()[State.FAILED] == 0  # the rods are not to blame
    assert journal.pending()


def test_a_worker_of_another_version_refuses():
    with pytest.raises(VersionError, match=r"a worker has version .*, and this sweep is of 0\.0\.0"):
        work.work(task(["job0"])._replace(version="0.0.0"))


def test_reasons_name_the_rule_or_the_internal_error():
    refused = attempted({"rod": {"preset": "none"}})
    assert refused.reason.startswith("rod.preset = 'none': is not a preset")

    def broken(_study, _extras):
        raise ZeroDivisionError("by zero")

    said = attempted({"rod": {"preset": "leon-2001"}}, broken).reason
    assert said == "internal error: ZeroDivisionError: by zero"


def test_no_scheduler_answers(monkeypatch):
    monkeypatch.setattr(cluster, "_CONNECT_SECONDS", 0.2)
    with (
        pytest.raises(ClusterError, match="no scheduler answers"),
        cluster.cluster(None, "tcp://127.0.0.1:9"),
    ):
        pass


@pytest.mark.parametrize(("workers", "address"), [(2, "tcp://127.0.0.1:9"), (0, None)])
def test_workers_are_of_this_machine_and_positive(workers, address):
    with pytest.raises(InvalidValue, match="--workers"), cluster.cluster(workers, address):
        pass


def test_a_scheduler_is_named_by_address_or_file(tmp_path):
    file = tmp_path / "scheduler.json"
    file.write_text('{"address": "tcp://host:8786"}')
    assert cluster._address(str(file)) == "tcp://host:8786"
    assert cluster._address("tcp://host:8786") == "tcp://host:8786"
    for content in ("", "[]", "{}", "\x00"):
        file.write_text(content)
        with pytest.raises(InvalidValue, match="is not a scheduler file"):
            cluster._address(str(file))
    with pytest.raises(InvalidValue, match="neither the address of a scheduler nor"):
        cluster._address("scheduler.json")


def test_dask_itself_is_silent():
    pytest.importorskip("distributed")
    cluster._quiet()
    assert not logging.getLogger("distributed.client").isEnabledFor(logging.ERROR)
