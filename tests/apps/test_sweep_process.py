"""Jobs in processes that may crash or never end."""

import os
import signal
import time
from pathlib import Path

import pytest

from fea.apps.sweep import workers
from fea.apps.sweep.workers import in_own_process
from fea.machine.isolated import CrashError, OvertimeError, fresh


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
