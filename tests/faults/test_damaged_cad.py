"""CAD files damaged at random, through the program: read or refused; the CAD kernel's death is not ours."""

import os
import random
import signal
import time

import pytest
from cad_files import CAD_ENDINGS, cad_file
from damage import mutated
from program import contained

from fea.machine.isolated import allow, say
from fea.rod.reading import read_isolated
from geometry.errors import GeometryError, InvalidValue
from geometry.presets import PRESETS

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def whole():
    return {ending: cad_file(PRESETS["leon-2001"], ending).decode("latin-1") for ending in CAD_ENDINGS}


@pytest.mark.parametrize(
    ("ending", "seed"),
    [*(("step", seed) for seed in range(6)), *((ending, 1) for ending in CAD_ENDINGS[1:])],
)
def test_a_damaged_file_is_meshed_or_refused(whole, ending, seed):
    text = mutated(whole[ending], random.Random(seed), most=3)  # noqa: S311
    name = f"rod.{ending}"
    ended = contained(["rod", name, "--size", 14, "--quiet"], {name: text.encode("latin-1")}, seconds=120)
    assert not ended.fault(), ended


def test_results_and_errors_come_back():
    assert read_isolated(lambda: {"a": 1}, "add") == {"a": 1}
    with pytest.raises(InvalidValue, match=r"rod.length_mm = 3") as raised:
        read_isolated(_refuse, "refuse")
    assert raised.value.name == "rod.length_mm"


def _refuse():
    raise InvalidValue("rod.length_mm", 3.0, "is short")


def _crashes_reading():
    say("reading x.step")
    os.kill(os.getpid(), signal.SIGSEGV)


def _never_ends():
    allow(0.1)
    while True:
        pass


@pytest.mark.parametrize(
    ("death", "words"),
    [
        (lambda: os.kill(os.getpid(), signal.SIGSEGV), r"could not read x: it crashed \(SIGSEGV\)"),
        (_crashes_reading, r"could not read x: it crashed \(SIGSEGV\), while reading x\.step"),
        (lambda: os._exit(3), "could not read x: it stopped without a message"),
        (_never_ends, r"could not read x: it did not finish within 0\.1\d* s of processor time"),
    ],
)
def test_a_death_is_told(death, words):
    with pytest.raises(GeometryError, match=words):
        read_isolated(death, "read x")


def test_a_job_has_a_time_limit_from_its_start(monkeypatch):
    def stuck():
        while True:
            pass

    monkeypatch.setattr("fea.rod.reading.SECONDS", 0.1)
    with pytest.raises(GeometryError, match=r"it did not finish within 0\.1\d* s of processor time"):
        read_isolated(stuck, "read x")


def test_an_interrupt_leaves_no_orphan(tmp_path):
    def wait():
        (tmp_path / "child").write_text(str(os.getpid()))
        os.kill(os.getppid(), signal.SIGINT)
        time.sleep(60)

    with pytest.raises(KeyboardInterrupt):
        read_isolated(wait, "wait")
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "child").read_text()), 0)
