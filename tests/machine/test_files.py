"""A file is replaced whole or not at all."""

import os
import sys

import pytest

from fea.machine.system import replaced

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="links need rights there, and pipes have no path")


def test_a_failure_keeps_what_was_there(tmp_path):
    path = tmp_path / "a"
    path.write_text("earlier")
    with pytest.raises(OSError, match=r"No space left.*a'"), replaced(path) as place:
        place.write_text("half of i")
        raise OSError(28, "No space left")
    assert path.read_text() == "earlier"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]


@POSIX
def test_what_is_written_takes_the_place_and_a_link_stays_one(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with replaced(tmp_path / "link") as place:
        place.write_text("new")
    assert (tmp_path / "a").read_text() == "new"
    assert (tmp_path / "link").is_symlink()


@POSIX
def test_a_pipe_is_written_directly(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with replaced(tmp_path / "pipe") as place:
        assert place == tmp_path / "pipe"
    assert (tmp_path / "pipe").is_fifo()
