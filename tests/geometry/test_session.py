import signal
import threading

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
        assert log.warnings == ("Warning: a hint",)
    assert log.warnings == ("Warning: a hint",)
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
