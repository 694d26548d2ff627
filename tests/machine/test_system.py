"""What differs between operating systems, with the calls of another system in place of its own."""

import os
import sys

import pytest

from fea.machine import system

fcntl = pytest.importorskip("fcntl", reason="not on Windows")


@pytest.mark.parametrize("refused", [False, True])
def test_macos_flushes_the_cache_of_the_disk_where_it_can(monkeypatch, tmp_path, refused):
    calls = []

    def control(descriptor, command):
        calls.append(command)
        if refused:
            raise OSError("not supported")

    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(fcntl, "F_FULLFSYNC", 51, raising=False)
    monkeypatch.setattr(fcntl, "fcntl", control)
    monkeypatch.setattr(os, "fsync", lambda _descriptor: calls.append("fsync"))
    with (tmp_path / "f").open("wb") as file:
        system.flush(file.fileno())
    assert calls == ([51, "fsync"] if refused else [51])
