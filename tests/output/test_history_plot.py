"""Curves of a chart lie where their stress is, and names of load cases where they can be read."""

import numpy as np
import pytest
from PIL import Image, ImageColor

from fea.output.folder import PictureError
from fea.output.plots import chart as charts
from fea.output.plots.chart import chart, save_picture

DEGREES = np.arange(721.0)


def drawn(curves, marks):
    return chart(("history", "a rod", "MPa"), DEGREES, curves, marks)


def test_curves_lie_where_their_stress_is(tmp_path):
    stress = {"A": np.full(721, 100.0), "B": np.where(DEGREES < 360, 50.0, -50.0)}
    path = tmp_path / "history.png"
    laid_out = drawn(stress, {"tension": 6.0, "side": 12.0})
    save_picture(path, laid_out, "remark")
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    (bottom, low), (top, high) = (
        (y, float(label.replace("−", "-"))) for y, label in (laid_out.ticks[0], laid_out.ticks[-1])
    )

    def row(degrees, colour):
        """Height at a crank angle by the middle of the pixels of a curve, in the units of the layout."""
        column = pixels[:, round(charts.across(degrees) * 11 / 6)]
        mine = np.flatnonzero(np.abs(column - ImageColor.getrgb(colour)).sum(axis=1) < 30)
        return mine[mine > 100].mean() / (11 / 6)

    first, second = charts.COLOURS[:2]
    upper, middle, lower = row(300, first), row(300, second), row(400, second)
    per_MPa = (bottom - top) / (high - low)
    assert lower - upper == pytest.approx(150 * per_MPa, abs=1)
    assert middle - upper == pytest.approx(50 * per_MPa, abs=1)


@pytest.mark.parametrize(
    "degrees", [(4, 432, 466, 483), (350, 355, 360, 365), (719, 432, 466, 483), (0, 180, 400, 600)]
)
def test_names_of_cases_touch_neither_each_other_nor_a_line_nor_the_edge(degrees):
    marks = dict(zip(("tension", "bending", "compression", "side"), degrees, strict=True))
    places = drawn({"": np.zeros(721)}, marks).marks
    widths = {name: charts.font(36).getlength(name) / 5.5 + 2 for name in marks}
    boxes = {
        name: (x, x + widths[name], row) if fits else (x - widths[name], x, row)
        for x, row, name, fits in places
    }
    assert len(boxes) == 4
    for name, (left, right, row) in boxes.items():
        assert left > 0
        assert right < charts.WIDTH
        for other, (x, top, _, _) in ((place[2], place) for place in places if place[2] != name):
            begin, end, level = boxes[other]
            assert level != row or right <= begin or end <= left, (name, other)
            assert top < row or x <= left or x >= right, (name, other)  # lines end below their own names


def test_a_rod_without_stress_has_a_plot(tmp_path):
    save_picture(tmp_path / "none.png", drawn({"A": np.zeros(721)}, {}), "")
    assert (tmp_path / "none.png").stat().st_size > 5000


def test_what_cannot_be_written_is_said(tmp_path):
    with pytest.raises(PictureError, match="could not be written"):
        save_picture(tmp_path / "no" / "history.png", drawn({"A": np.zeros(721)}, {}), "")
