"""Works in a process of their own, and what interrupts them; signals put off for a moment."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import works

from fea.machine.fresh_process import in_fresh_process
from fea.machine.streams import interrupt_once
from geometry.system import ENDS, held_back


@pytest.fixture
def interruptible():
    # Other tests may have called the program here, or a shell have made the suite ignore Ctrl-C.
    before = {number: signal.signal(number, signal.SIG_DFL) for number in ENDS}
    interrupt_once()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_what_a_work_returns_and_none_where_it_fails():
    assert in_fresh_process("works", works.twice, 21) == 42
    assert in_fresh_process("works", works.fails) is None
    assert in_fresh_process("works", works.dies) is None
    assert in_fresh_process("works", works.twice, "a") == "aa"


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_lets_the_work_clean_up(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        in_fresh_process("works", works.asks_its_parent_to_end, tmp_path / "end", os.getpid())
    assert (tmp_path / "end").read_text() == "cleaned up"


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("after", [0.9, 1.1, 1.3, 1.6, 2.0])
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


def test_an_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with held_back():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_kill_9_takes_the_work_along(tmp_path):
    code = (
        "import pathlib, works; from fea.machine.fresh_process import in_fresh_process;"
        f"in_fresh_process('works', works.waits, pathlib.Path({str(tmp_path / 'at work')!r}))"
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
