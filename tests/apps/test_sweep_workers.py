"""Rods given out to workers that compute at once, their processes, and clusters that cannot be used."""

import logging
import os
import signal
import time
from concurrent.futures import Executor, Future
from pathlib import Path
from threading import Timer
from types import SimpleNamespace

import pytest

from fea.apps.sweep import workers
from fea.apps.sweep.journal import Journal, RodResult
from fea.apps.sweep.sweep_file import BaseStudy, RowState, SweepOutputs, SweepRow
from fea.apps.sweep.workers import (
    ClusterError,
    Task,
    VersionError,
    Workers,
    cluster,
    compute_pending,
    in_own_process,
)
from fea.machine.isolated import CrashError, OvertimeError, fresh
from geometry.errors import InvalidValue


class KilledWorker(Exception):  # noqa: N818 - the name that Dask gives it
    pass


class Fates(Executor):
    """Ends each rod after some seconds, by its fate: a result, an error, or "cancelled"."""

    def __init__(self, fates, seconds=0.0):
        self.seconds, self.fates, self.out, self.most = seconds, fates, 0, 0

    def submit(self, _function, task):
        fate = self.fates[task.job]
        self.out += 1
        self.most = max(self.most, self.out)
        future = Future()

        def end():
            self.out -= 1
            if fate == "cancelled":
                future.cancel()
                future.set_running_or_notify_cancel()  # as Dask does
            elif isinstance(fate, Exception):
                future.set_exception(fate)
            else:
                future.set_result(fate)

        if self.seconds:
            Timer(self.seconds, end).start()
        else:
            end()
        return future


def task(raw=None, **more):
    return Task(BaseStudy("study", raw or {}, Path("/"), ()), SweepOutputs(), **more)


def journal_of(tmp_path, count):
    journal = Journal(tmp_path / "j.sqlite")
    journal.enter(
        {"schema": "x"}, [SweepRow(n, n, {}, None, job=f"job{n}", key=f"{n}") for n in range(count)]
    )
    return journal


def done(n):
    return RodResult(f"job{n}", {None: {"factor": n}}, 0.1)


def computed(journal, executor, listener=lambda *_: None):
    compute_pending(journal, Workers(executor, 3), task(), listener)
    return journal


def test_every_rod_is_given_out_once_and_entered(tmp_path):
    counted = []
    fates = Fates({f"job{n}": done(n) for n in range(20)})
    journal = computed(journal_of(tmp_path, 20), fates, lambda *seen: counted.append(seen))
    assert journal.counts() == {RowState.PENDING: 0, RowState.DONE: 20, RowState.FAILED: 0}
    assert [row.figures["factor"] for row in journal.rows()] == list(range(20))
    assert sum(len(results) for results, _ in counted) == 20
    assert {threads for _, threads in counted} == {3}


def test_no_more_rods_are_out_than_there_are_threads(tmp_path):
    fates = Fates({f"job{n}": done(n) for n in range(12)}, 0.01)
    computed(journal_of(tmp_path, 12), fates)
    assert fates.most == 3


def test_a_rod_that_kills_its_workers_is_failed_and_the_others_go_on(tmp_path):
    fates = Fates({"job0": done(0), "job1": KilledWorker(), "job2": done(2)})
    journal = computed(journal_of(tmp_path, 3), fates)
    assert [row.state for row in journal.rows()] == [RowState.DONE, RowState.FAILED, RowState.DONE]
    assert "worker" in next(journal.rows(1)).reason


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
        computed(journal, Fates({"job0": done(0), "job1": fate, "job2": done(2)}))
    assert journal.counts()[RowState.FAILED] == 0  # the rods are not to blame
    assert journal.pending()


def test_a_worker_of_another_version_refuses():
    with pytest.raises(VersionError, match=r"a worker has version .*, and this sweep is of 0\.0\.0"):
        workers.work(task(version="0.0.0"))


def test_reasons_name_the_rule_or_the_internal_error():
    def reason(raw, compute=workers.EVALUATE):
        return workers.attempt(task(raw, compute=compute)).reason

    assert reason({"rod": {"preset": "none"}}).startswith("rod.preset = 'none': is not a preset")
    said = reason({"rod": {"preset": "leon-2001"}}, "operator:truediv")
    assert said.startswith("internal error: TypeError: unsupported operand")


def test_the_threads_of_a_scheduler_are_counted_now_and_then(monkeypatch):
    counts = [0, 0, 3]
    client = SimpleNamespace(nthreads=lambda: {"one": counts.pop(0)})
    assert Workers(None, client=client).threads() == 0
    monkeypatch.setattr(workers, "_COUNT_SECONDS", 0.0)
    remote = Workers(None, client=client)
    assert [remote.threads(), remote.threads()] == [0, 3]
    monkeypatch.setattr(workers, "_COUNT_SECONDS", 60.0)
    assert remote.threads() == 3


def test_a_scheduler_that_is_gone():
    def gone():
        raise OSError("Timed out")

    with pytest.raises(ClusterError, match=r"lost \(Timed out\)"):
        Workers(None, client=SimpleNamespace(nthreads=gone)).threads()
    with pytest.raises(ClusterError, match=r"lost \(closed\)"):
        Workers(None, client=SimpleNamespace(status="closed")).require_connected()


def test_no_scheduler_answers_and_dask_itself_is_silent(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "_CONNECT_SECONDS", 0.2)
    with pytest.raises(ClusterError, match="no scheduler answers"), cluster(None, "tcp://127.0.0.1:9"):
        pass
    assert not logging.getLogger("distributed.client").isEnabledFor(logging.ERROR)


@pytest.mark.parametrize(("count", "address"), [(2, "tcp://127.0.0.1:9"), (0, None)])
def test_workers_are_of_this_machine_and_positive(count, address):
    with pytest.raises(InvalidValue, match="--workers"), cluster(count, address):
        pass


def test_a_scheduler_is_named_by_address_or_file(tmp_path):
    file = tmp_path / "scheduler.json"
    file.write_text('{"address": "tcp://host:8786"}')
    assert workers._scheduler(str(file)) == "tcp://host:8786"
    assert workers._scheduler("tcp://host:8786") == "tcp://host:8786"
    for content in ("", "[]", "{}", "\x00"):
        file.write_text(content)
        with pytest.raises(InvalidValue, match="is not a scheduler file"):
            workers._scheduler(str(file))
    with pytest.raises(InvalidValue, match="neither the address of a scheduler nor"):
        workers._scheduler("scheduler.json")


@pytest.fixture(autouse=True)
def _leave_no_process():
    yield
    process = getattr(workers._of_thread, "process", None)
    if process is not None:
        process.close()
        workers._of_thread.process = None


def test_a_process_that_crashed_or_was_endless_is_replaced():
    first = in_own_process(os.getpid, seconds=60)
    assert first != os.getpid()
    assert in_own_process(os.getpid, seconds=60) == first  # its libraries are loaded once
    with pytest.raises(CrashError, match="SIGSEGV"):
        in_own_process(os.kill, first, signal.SIGSEGV, seconds=60)
    with pytest.raises(CrashError) as crash:
        in_own_process(os._exit, 3, seconds=60)
    assert crash.value.cause == "exit code 3"
    with pytest.raises(OvertimeError):
        in_own_process(time.sleep, 600, seconds=1.0)
    idle = in_own_process(os.getpid, seconds=60)
    os.kill(idle, signal.SIGKILL)
    workers._of_thread.process.started.wait()
    assert in_own_process(os.getpid, seconds=60) != idle


def test_processes_end_with_the_threads_that_asked_and_others_do_not():
    with workers.own_processes(2) as pool:
        first = pool.submit(in_own_process, os.getpid, seconds=60).result()
        asleep = pool.submit(in_own_process, time.sleep, 600, seconds=600)
        mine = in_own_process(os.getpid, seconds=60)
    assert isinstance(asleep.exception(), CrashError)
    assert not Path("/proc", str(first)).exists()
    assert in_own_process(os.getpid, seconds=60) == mine
    with workers.own_processes(1) as pool:
        assert pool.submit(in_own_process, os.getpid, seconds=60).result() not in (first, mine)


def test_a_job_that_prints_does_not_spoil_its_answer():
    assert in_own_process(os.write, 1, b"a library prints", seconds=60) == 16


def test_a_process_ends_when_nobody_asks_any_more():
    with fresh() as process:
        process.started.stdin.close()  # what remains of a worker where the system tells of no parents
        assert process.started.wait(60) == 0


def test_a_process_ends_with_its_worker(tmp_path):
    worker = os.fork()
    if not worker:
        try:
            (tmp_path / "pid").write_text(f"{in_own_process(os.getpid, seconds=60)}")
            in_own_process(time.sleep, 600, seconds=600)
        finally:
            os._exit(1)
    limit = time.monotonic() + 60
    while not (tmp_path / "pid").exists() or not (pid := (tmp_path / "pid").read_text()):
        assert time.monotonic() < limit
        time.sleep(0.05)
    os.kill(worker, signal.SIGKILL)
    os.waitpid(worker, 0)
    while Path("/proc", pid).exists() and "zombie" not in Path("/proc", pid, "status").read_text():
        assert time.monotonic() < limit
        time.sleep(0.05)
