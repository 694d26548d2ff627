import pytest

from fea.apps.sweep.journal import RodResult
from fea.apps.sweep.run_sweep import Progress
from fea.machine.clock import by_the_minute, duration


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0, "0 s"), (59, "59 s"), (60, "1 min"), (3599, "1 h 00 min"), (11_100, "3 h 05 min")],
)
def test_durations(seconds, text):
    assert duration(seconds) == text


def test_rate_and_time_left_follow_the_last_results():
    clock = Clock()
    progress = Progress(1000, clock)
    assert progress.text(2) == "0 of 1000 rods, 2 at a time"
    clock.now += 100  # the first one waits for libraries
    progress.add(1)
    for _ in range(99):
        clock.now += 2
        progress.add(1)
    assert progress.text(2) == "100 of 1000 rods, 30 a minute, 30 min left"
    assert progress.text(0).endswith("waiting for a worker")


def test_elsewhere_than_on_a_terminal_there_is_a_line_a_minute(capsys):
    clock = Clock()
    show = Progress(300, clock).shown_by(by_the_minute(clock))
    for _ in range(300):
        clock.now += 1
        show([RodResult("rod", {}, 2.0)], 2)
    cost, *said = capsys.readouterr().err.splitlines()
    assert cost == "fea: about 5 min for 300 rods of 2 s, 2 at a time"
    assert len(said) == 5
    assert said[0] == "fea: 60 of 300 rods, 1 a second, 4 min left"
