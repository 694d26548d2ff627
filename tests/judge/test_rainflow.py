"""Rainflow of a repeated history against counting it value by value."""

import numpy as np
import pytest

from fea.judge.history import cycle_ends, rainflow


def closed_in_the_second_period(history):
    """Ranges, from low to high, that close while a history that is repeated for ever passes the second time.

    A range that is not larger than the next one is closed by it (ASTM E1049), on a stack of turning points.
    """
    values = np.tile(history, 3)
    changed = np.flatnonzero(np.append(True, np.diff(values) != 0))
    rising = np.diff(values[changed]) > 0
    stack, closed = [], []
    for at in changed[1:-1][rising[1:] != rising[:-1]]:
        stack.append(values[at])
        while len(stack) > 2 and abs(stack[-1] - stack[-2]) >= abs(stack[-2] - stack[-3]):
            if len(history) <= at < 2 * len(history):
                closed.append(tuple(sorted(stack[-3:-1])))
            del stack[-3:-1]
    return sorted(closed)


def test_a_repeated_history_has_the_cycles_that_close_in_its_second_period():
    random = np.random.default_rng(61)
    for number in range(1000):
        size, levels = random.integers(1, 60), random.integers(2, 40)
        history = random.integers(0, levels, size).astype(float)
        mean, amplitude = rainflow(history)
        expected = closed_in_the_second_period(history)
        found = sorted(zip((mean - amplitude).tolist(), (mean + amplitude).tolist(), strict=True))
        assert found == expected, f"history {number}"


def test_equal_ranges_side_by_side_are_as_many_cycles_as_periods():
    assert cycle_ends(np.tile([0.0, 1.0, 0.0, 2.0], 500)).shape == (2, 1000)
    _, amplitude = rainflow(np.tile([0.0, 1.0], 1000))
    assert amplitude == pytest.approx(np.full(1000, 0.5))


def test_the_ends_are_numbers_of_values_of_the_history():
    history = np.array([-2.0, 1, -3, 5, -1, 3, -4, 4])
    ends = history[cycle_ends(history)]
    assert sorted(np.abs(np.ptp(ends, axis=0))) == [3, 4, 7, 9]


def test_a_history_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="finite"):
        rainflow(np.array([0.0, np.nan, 1.0, 0.5]))
