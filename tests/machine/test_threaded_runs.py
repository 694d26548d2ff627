"""Runs from Python by several threads at once, and what they leave of the process's state."""

import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from fea import run
from geometry.errors import InvalidValue
from geometry.session import session
from geometry.signals import ENDS

pytestmark = pytest.mark.slow


def test_two_threads_at_once_give_what_one_gives(tmp_path):
    def results(name):
        return run(Path("leon-2001"), size=20, out=tmp_path / name)["results"]

    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(results, ["a", "b"])
    assert first == second
    assert {entry.name for entry in tmp_path.iterdir()} == {"a", "b"}


@pytest.mark.parametrize("flags", [{"study": 3}, {"study": None}, {"out": 3}, {"out": b"x"}, {"animate": 5}])
def test_what_is_no_path_is_refused(flags):
    with pytest.raises(InvalidValue, match=r"must be a (name or a )?path"):
        run(**flags)


@pytest.mark.parametrize("number", ENDS)
def test_gmsh_keeps_no_signal(number):
    caught = []
    earlier = signal.signal(number, lambda *_: caught.append(number))
    try:
        with session():
            signal.raise_signal(number)
        signal.raise_signal(number)
    finally:
        signal.signal(number, earlier)
    assert caught == [number, number]
