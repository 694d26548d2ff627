"""Works in a process of their own, and what interrupts them; signals put off for a moment."""

import io
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
import works

from fea.machine import isolated
from fea.machine.isolated import CrashError, IsolatedProcess, fresh
from fea.machine.system import interrupt_once
from geometry.signals import ENDS, held_back

SIGNALS = pytest.mark.skipif(sys.platform == "win32", reason="a signal of another process ends it at once")


@pytest.fixture
def interruptible():
    # Other tests may have called the program here, or a shell have made the suite ignore Ctrl-C.
    before = {number: signal.signal(number, signal.SIG_DFL) for number in ENDS}
    interrupt_once()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_results_and_errors_come_back_and_a_crash_is_an_error():
    with fresh() as process:
        assert process.run(works.twice, 21) == 42
        with pytest.raises(ValueError, match="no figure"):
            process.run(works.fails)
        process.begin(works.fails)  # nobody asks for its result
        assert process.run(works.twice, "a") == "aa"
        with pytest.raises(CrashError, match=r"crashed \((SIGKILL|Windows' status 0xc0000005)\)"):
            process.run(works.dies)
        assert not process.alive


def test_a_job_finds_standard_input_empty():
    """And can look at it while a thread waits for orders: Windows would make it wait too."""
    with fresh() as process:
        assert process.run(os.read, 0, 1, seconds=20) == b""


def test_where_processes_cannot_be_copied_a_fresh_one_does_the_job(monkeypatch):
    monkeypatch.setattr(isolated.system, "CAN_FORK", False)
    told = []
    with isolated.begun(works.tells, seconds=60) as process:
        assert process.result(told.append) != os.getpid()
    assert told == ["at work"]


def test_a_pipe_stays_open_while_another_thread_reads_from_it():
    """It would read into memory that was freed: "info->buf must not be NULL"."""
    reading = threading.Event()

    class Answers:
        closed = False

        def read(self, _size):
            reading.set()
            time.sleep(0.1)
            assert not self.closed
            return b""

        readline = read

        def close(self):
            self.closed = True

    ended = SimpleNamespace(poll=lambda: -9, wait=lambda: -9, kill=lambda: None)
    process = IsolatedProcess(ended, io.BytesIO(), Answers())
    with ThreadPoolExecutor(1) as pool:
        asked = pool.submit(process.run, works.twice, 1)
        reading.wait()
        process.close()
    for answer in (asked.result, lambda: process.run(works.twice, 1)):  # then it is closed
        with pytest.raises(CrashError, match="SIGKILL"):
            answer()


@SIGNALS
@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_lets_the_work_clean_up(tmp_path):
    with pytest.raises(KeyboardInterrupt), fresh(patient=True) as process:
        process.run(works.asks_its_parent_to_end, tmp_path / "end", os.getpid())
    assert (tmp_path / "end").read_text() == "cleaned up"


@SIGNALS
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("after", [0.9, 1.3, 1.8])
def test_an_interrupt_while_a_comparison_starts_is_one_line(tmp_path, after):
    """From a terminal all processes get it, those too that are still importing."""
    command = [sys.executable, "-m", "fea", "converge", "leon-2001", "--minutes", "1"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0
    ) as process:
        time.sleep(after)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=30)[1]  # until all that can write there have ended
    assert (process.returncode, said) == (130, "fea: interrupted; no incomplete result was left behind\n")
    assert not list(tmp_path.iterdir())


@SIGNALS
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("number", ENDS)
def test_signals_are_put_off_whichever_thread_gets_them(number):
    at_work, done = threading.Event(), []

    def elsewhere():
        at_work.wait()
        signal.pthread_kill(threading.get_ident(), number)

    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        other = pool.submit(elsewhere)
        with held_back():
            at_work.set()
            other.result()
            os.kill(os.getpid(), number)
            time.sleep(0.01)
            done.append("to the end")
    assert done == ["to the end"]


@SIGNALS
def test_an_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with held_back():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@SIGNALS
@pytest.mark.parametrize("patient", [True, False])
def test_kill_9_takes_the_work_along(tmp_path, patient):
    code = (
        "import pathlib, works; from fea.machine.isolated import fresh;"
        f"fresh(patient={patient}).run(works.waits, pathlib.Path({str(tmp_path / 'at work')!r}))"
    )
    path = os.pathsep.join(sys.path)
    with subprocess.Popen([sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": path}) as process:
        while not (tmp_path / "at work").exists():
            time.sleep(0.05)
        worker = int((tmp_path / "at work").read_text())
        process.kill()
    for _ in range(100):
        time.sleep(0.05)
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
    pytest.fail("it is still at work")


WITHIN = """
import hashlib, sys
from pathlib import Path
from fea.machine.system import end_in_time, incomplete, interrupt_once
interrupt_once(afresh=True)
end_in_time(130)
part = Path(sys.argv[1])
(part / "file").mkdir(parents=True)
with incomplete(part):
    print("begun", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 10**9)  # minutes within a library
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such thread")
def test_an_interrupt_within_a_long_call_ends_the_program_in_time(tmp_path):
    command = [sys.executable, "-c", WITHIN, tmp_path / "part"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.5)  # until the call has begun
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
        assert time.monotonic() - sent < 4.0  # 1.5 on a quiet machine
    assert (process.returncode, said) == (130, "fea: interrupted; no incomplete result was left behind\n")
    assert not (tmp_path / "part").exists()
