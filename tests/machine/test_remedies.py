"""What the program tells the user to install, by system."""

import platform
import sys

import pytest

from fea.machine.remedies import solver_remedy, system_remedy


@pytest.mark.parametrize(
    ("system", "release", "meshing", "pictures"),
    [
        ("linux", {"ID": "debian"}, "apt-get install libglu1-mesa", "apt-get install libegl1"),
        ("linux", {"ID": "mint", "ID_LIKE": "ubuntu debian"}, "libglu1-mesa", "libegl1"),
        (
            "linux",
            {"ID": "rocky", "ID_LIKE": "rhel centos fedora"},
            "dnf install mesa-libGLU",
            "libglvnd-egl",
        ),
        ("linux", {"ID": "arch"}, "install libGLU", "install libEGL"),
        ("linux", OSError("no such file"), "install libGLU", "install libEGL"),
        ("freebsd14", {}, "install libGLU", "install libEGL"),
        ("darwin", {}, "pip install", "desktop"),
        ("win32", {}, "Visual C++", "osmesa.dll"),
    ],
)
def test_remedies_are_those_of_the_system(monkeypatch, system, release, meshing, pictures):
    def read():
        if isinstance(release, OSError):
            raise release
        return release

    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "freedesktop_os_release", read)
    assert meshing in system_remedy("meshing")
    assert pictures in system_remedy("pictures")
    assert ("apt-get" in system_remedy("meshing")) == (
        meshing in ("apt-get install libglu1-mesa", "libglu1-mesa")
    )


@pytest.mark.parametrize(("machine", "package"), [("AMD64", "pypardiso"), ("arm64", "cvxopt")])
def test_mkl_is_for_intel_alone(monkeypatch, machine, package):
    monkeypatch.setattr(platform, "machine", lambda: machine)
    assert package in solver_remedy()
