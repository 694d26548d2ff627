"""Curves of the history plot lie where their stress is."""

import numpy as np
import pytest
from PIL import Image, ImageColor

from fea.output.plots import history as history_plot
from fea.output.plots.history import plot_histories
from fea.output.target import PictureError

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


@pytest.mark.parametrize(
    "degrees", [(4, 432, 466, 483), (350, 355, 360, 365), (719, 432, 466, 483), (0, 180, 400, 600)]
)
def test_names_of_cases_touch_neither_each_other_nor_a_line_nor_the_edge(degrees, tmp_path, monkeypatch):
    marks = dict(zip(("tension", "bending", "compression", "side"), np.radians(degrees), strict=True))
    boxes, lines = [], []
    panel = history_plot._Panel
    text, line = panel.text, panel._line

    def noted(self, place, words, size, anchor, *colour):
        if words in marks:
            width = history_plot._font(size).getlength(words)
            left = place[0] - (width if anchor[0] == "r" else 0)
            boxes.append((left, place[1] - size, left + width, place[1]))
        text(self, place, words, size, anchor, *colour)

    def drawn(self, points, colour, width):
        (x, top), (end, bottom) = points[0], points[-1]
        if x == end and colour == history_plot._GREY and len(points) == 2:
            lines.append((x, top, end, bottom))
        line(self, points, colour, width)

    monkeypatch.setattr(panel, "text", noted)
    monkeypatch.setattr(panel, "_line", drawn)
    plot_histories(tmp_path / "h.png", "a rod", ANGLES, [((0.0, 0.0, 0.0), np.zeros(721))], marks)
    assert len(boxes) == 4
    for k, box in enumerate(boxes):
        assert box[0] > 0
        assert box[2] < history_plot._SIZE[0]
        for other in boxes[:k] + boxes[k + 1 :] + lines:
            apart = box[2] < other[0] or other[2] < box[0] or box[3] < other[1] or other[3] < box[1]
            assert apart, (box, other)


def test_a_rod_without_stress_has_a_plot(tmp_path):
    plot_histories(tmp_path / "none.png", "a rod", ANGLES, [((0.0, 0.0, 0.0), np.zeros(721))], {})
    assert (tmp_path / "none.png").stat().st_size > 5000


def test_what_cannot_be_written_is_said(tmp_path):
    with pytest.raises(PictureError, match="could not be written"):
        plot_histories(tmp_path / "no" / "history.png", "a rod", ANGLES, [((0, 0, 0), np.zeros(721))], {})
