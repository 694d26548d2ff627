"""What holds for all tests."""

import os
import signal
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from drawn_by_copies import drawn_by_copies
from hypothesis import settings
from meshed_once import meshed_once

# The same examples every time, and no clock: a test that fails today failed yesterday.
# `--hypothesis-profile default` looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

# Tests run the program in copies of their process (`program.fea`), in which threads of OpenMP are missing.
for library in ("OMP", "MKL", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# From so many tests on, it pays to load what draws beforehand.
MANY = 300

# Who starts the tests in the background may have told them to ignore Ctrl-C; those that send it need it.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="module")
def coarse_bores():
    """Mesh bores that pins touch with 24 elements around instead of 36.

    They are most of the nodes of a coarse mesh, whatever its size: half of the time of a test in contact that
    is about something else than accuracy.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fea.rod.discretise.PER_TOUCHED_BORE", 24)
        yield


@pytest.fixture(scope="session", autouse=True)
def meshes():
    """Mesh each rod once, whichever tests need it."""
    with TemporaryDirectory(prefix="fea-meshes-") as folder, meshed_once(Path(folder)):
        yield


@pytest.fixture(scope="session", autouse=True)
def drawing(request):
    """Start the processes that draw from one that is ready, if there are many tests."""
    if request.session.testscollected < MANY or not hasattr(os, "fork"):
        yield
        return
    with TemporaryDirectory(prefix="fea-draws-") as folder, drawn_by_copies(Path(folder)):
        yield
