"""Jobs in processes that may crash or never end."""

import os
import signal
import time
from pathlib import Path

import pytest

pytest.importorskip("cloudpickle")

from fea.apps.sweep import apart as module
from fea.apps.sweep.apart import CrashError, EndlessError, apart


@pytest.fixture(autouse=True)
def _leave_no_process():
    yield
    process = getattr(module._own, "process", None)
    if process is not None:
        process.kill()
        module._buried(process)


def test_a_process_that_crashed_or_was_endless_is_replaced():
    first = apart(os.getpid, seconds=60)
    assert first != os.getpid()
    assert apart(os.getpid, seconds=60) == first  # its libraries are loaded once
    with pytest.raises(CrashError, match="SIGSEGV"):
        apart(os.kill, first, signal.SIGSEGV, seconds=60)
    with pytest.raises(CrashError, match="exit code 3"):
        apart(os._exit, 3, seconds=60)
    with pytest.raises(EndlessError):
        apart(time.sleep, 600, seconds=1.0)
    idle = apart(os.getpid, seconds=60)
    os.kill(idle, signal.SIGKILL)
    module._own.process.wait()
    assert apart(os.getpid, seconds=60) != idle


def test_a_job_that_prints_does_not_spoil_its_answer():
    assert apart(os.write, 1, b"a library prints", seconds=60) == 16


def test_a_process_ends_when_nobody_asks_any_more():
    process = module._started()
    process.stdin.close()  # what remains of a worker where the system tells of no parents
    assert process.wait(60) == 0
    process.stdout.close()


def test_a_process_ends_with_its_worker(tmp_path):
    worker = os.fork()
    if not worker:
        try:
            (tmp_path / "pid").write_text(f"{apart(os.getpid, seconds=60)}")
            apart(time.sleep, 600, seconds=600)
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
