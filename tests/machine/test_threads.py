import sys
import threading

import pytest

from fea.machine import threads
from fea.machine.threads import imported_meanwhile


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """Three modules of their own: one takes its time, one is broken, one is sound."""
    (tmp_path / "slow_module.py").write_text("import time\ntime.sleep(0.1)\n")
    (tmp_path / "broken_module.py").write_text("raise OSError('no such library')\n")
    (tmp_path / "sound_module.py").write_text("import threading\nthread = threading.current_thread()\n")
    monkeypatch.syspath_prepend(tmp_path)
    names = ("slow_module", "broken_module", "sound_module")
    yield names
    for name in names:
        sys.modules.pop(name, None)


def test_modules_are_imported_by_another_thread_which_ends_with_the_block(modules):
    before = threading.active_count()
    with imported_meanwhile(modules):
        assert threading.active_count() == before + 1
    assert threading.active_count() == before
    assert sys.modules["sound_module"].thread is not threading.main_thread()


def test_what_is_broken_says_so_where_it_is_needed_and_not_before(modules, capfd):
    with imported_meanwhile(modules):
        pass
    assert capfd.readouterr() == ("", "")
    with pytest.raises(OSError, match="no such library"):
        import broken_module  # noqa: F401


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_error_of_the_block_is_raised_without_the_rest_of_the_imports(modules, error):
    before = threading.active_count()
    with pytest.raises(error), imported_meanwhile(modules):
        raise error
    assert threading.active_count() == before
    assert "sound_module" not in sys.modules


def test_nothing_is_imported_where_memory_or_threads_are_scarce(modules, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(threads, "memory_limit", lambda: 2**30)
        with imported_meanwhile(modules):
            pass

    def refused(_thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refused)
    with imported_meanwhile(modules):
        pass
    assert not set(modules) & set(sys.modules)
