import signal
import subprocess
import sys
import threading
import time

import gmsh
import pytest

from geometry.session import session


def test_the_session_is_closed_and_ctrl_c_given_back_after_an_error():
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(ZeroDivisionError), session():
        assert gmsh.isInitialized()
        raise ZeroDivisionError
    assert not gmsh.isInitialized()
    assert signal.getsignal(signal.SIGINT) is handler


def test_messages_survive_the_session():
    with session() as log:
        gmsh.logger.write("a hint", "warning")
        gmsh.logger.write("a remark", "info")
        gmsh.logger.write("a hint", "warning")
        assert log.warnings() == ("Warning: a hint",)
    assert log.warnings() == ("Warning: a hint",)
    assert any("a remark" in line for line in log.lines)


def test_options_do_not_outlive_a_session():
    with session():
        before = gmsh.option.getNumber("Mesh.MeshSizeMax")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.5)
    with session():
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == before
        assert gmsh.option.getNumber("General.NumThreads") == 1


def test_a_second_session_is_refused():
    with session(), pytest.raises(RuntimeError, match="already open"), session():
        pass
    assert not gmsh.isInitialized()


def test_a_session_opens_in_a_worker_thread():
    opened = []

    def work():
        with session():
            opened.append(gmsh.isInitialized())

    worker = threading.Thread(target=work)
    worker.start()
    worker.join()
    assert opened == [1]


@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="there are no such signals")
def test_a_broken_pipe_does_not_end_the_process_after_a_session_in_a_thread():
    code = (
        "import os, threading; from geometry.session import session\n"
        "def work():\n with session(): os.write(pipe, b'.')\n"
        "read, pipe = os.pipe(); os.close(read)\n"
        "worker = threading.Thread(target=work); worker.start(); worker.join(); print('alive')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "alive\n")
    assert "BrokenPipeError" in done.stderr


@pytest.mark.parametrize("module", ["option", "logger"])
def test_an_interrupt_while_gmsh_opens_waits_until_it_is_open(monkeypatch, capfd, module):
    name = {"option": "setNumber", "logger": "start"}[module]
    plain = getattr(getattr(gmsh, module), name)

    def interrupted(*arguments):
        signal.raise_signal(signal.SIGINT)
        time.sleep(0.05)  # it has come
        plain(*arguments)

    monkeypatch.setattr(getattr(gmsh, module), name, interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), session():
            pytest.fail("it is told at once")
    finally:
        signal.signal(signal.SIGINT, before)
    assert not gmsh.isInitialized()
    assert capfd.readouterr().err == ""
