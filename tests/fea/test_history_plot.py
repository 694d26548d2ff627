"""Curves of the history plot lie where their stress is."""

import numpy as np
import pytest
from PIL import Image, ImageColor

from fea.output import history_plot
from fea.output.errors import PictureError
from fea.output.history_plot import plot_histories

ANGLES = np.radians(np.arange(721.0))


def test_curves_lie_where_their_stress_is(tmp_path):
    stress = [np.full(721, 100.0), np.where(np.arange(721) < 360, 50.0, -50.0)]
    places = [(1.0, 2.0, 3.0), (4.0, -0.04, 0.0)]
    marks = {"tension": 0.1, "side": 0.2}
    path = tmp_path / "history.png"
    plot_histories(path, "a rod", ANGLES, list(zip(places, stress, strict=True)), marks)
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    low, high = -50 - 0.05 * 150, 100 + 0.05 * 150

    def row(degrees, colour):
        """Stress at a crank angle by the middle of the pixels of a curve."""
        left, right = history_plot._LEFT, history_plot._RIGHT
        column = pixels[:, round(left + degrees / 720 * (right - left))]
        mine = np.flatnonzero(np.abs(column - ImageColor.getrgb(colour)).sum(axis=1) < 30)
        mine = mine[mine > history_plot._TOP]
        share = (history_plot._BOTTOM - mine.mean()) / (history_plot._BOTTOM - history_plot._TOP)
        return low + share * (high - low)

    first, second = history_plot._COLOURS[:2]
    assert row(300, first) == pytest.approx(100, abs=1)
    assert row(300, second) == pytest.approx(50, abs=1)
    assert row(400, second) == pytest.approx(-50, abs=1)


def test_a_rod_without_stress_has_a_plot(tmp_path):
    plot_histories(tmp_path / "none.png", "a rod", ANGLES, [((0.0, 0.0, 0.0), np.zeros(721))], {})
    assert (tmp_path / "none.png").stat().st_size > 5000


def test_what_cannot_be_written_is_said(tmp_path):
    with pytest.raises(PictureError, match="could not be written"):
        plot_histories(tmp_path / "no" / "history.png", "a rod", ANGLES, [((0, 0, 0), np.zeros(721))], {})
