import numpy as np
import pytest

from fea.study.traces import parse_trace, read_trace, shipped_trace
from geometry.errors import InvalidValue

GOOD = "crank_deg,pressure_bar\n" + "\n".join(f"{d},{60 if d == 370 else 1}" for d in range(0, 720, 10))
BY_SPEED = "crank_deg,pressure_bar_9rpm,pressure_bar_8rpm\n" + "\n".join(
    f"{d},1,2" for d in range(0, 720, 10)
)


def test_the_shipped_trace_is_leons_table():
    trace = shipped_trace("leon-2001")
    assert trace.pressures.shape == (3, 72)
    # 70 bar at 380° and 6000 rpm; 720° is 0°.
    assert trace.pressure(np.radians(380), np.array(2 * np.pi * 100)) == pytest.approx(7.0)
    assert trace.pressure(np.radians(720), np.array(2 * np.pi * 100)) == pytest.approx(0.41)


def test_a_users_trace_with_comments_blanks_and_a_byte_order_mark(tmp_path):
    file = tmp_path / "trace.csv"
    file.write_text("\ufeff# measured today\n\n" + GOOD + "\n\n", encoding="utf-8")
    trace = read_trace(file).trace
    assert trace.crank_angles.size == 72
    assert trace.pressures.max() == pytest.approx(6.0)
    assert trace.speeds.size == 0


def test_one_column_a_speed():
    text = GOOD.replace("pressure_bar", "pressure_bar_1000rpm,pressure_bar_2500.5rpm").replace(
        ",60", ",60,70"
    )
    text = text.replace(",1\n", ",1,2\n") + ",2"
    assert parse_trace(text, "t.csv").trace.speeds == pytest.approx(np.array([1000, 2500.5]) * np.pi / 30)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "contains no data"),
        ("crank_deg,pressure_bar\n", "no table with two columns"),
        ("crank_deg,pressure_bar\n0,1\n", "1 sample'"),
        ("angle,bar\n0,1\n", "at least three crank angles"),
        ("crank_deg;pressure_bar\n0;1\n", "at least three crank angles"),
        (BY_SPEED, r"speeds \[9\.0, 8\.0\] rpm"),
        (GOOD.replace("\n30,1", "\n30,one"), r"t\.csv line 5, pressure_bar = 'one'"),
        (GOOD.replace("\n30,1", "\n30,nan"), r"t\.csv line 5, pressure_bar = 'nan'"),
        (GOOD.replace("\n30,1", "\n30"), r"t\.csv line 5 .* 2 columns"),
        (GOOD.replace("\n30,1", "\n3,1"), r"t\.csv: line 5, crank_deg = 3: .* follows 20"),
        (GOOD.replace(",60", ",6000"), r"t\.csv: .* in kPa, convert them: the peak is then 60 bar"),
    ],
)
def test_a_bad_file_is_refused_with_its_line(text, match):
    with pytest.raises(InvalidValue, match=match):
        parse_trace(text, "t.csv")


def test_a_missing_or_binary_file_is_refused(tmp_path):
    with pytest.raises(InvalidValue, match=r"none\.csv.*cannot be read \(.*[Ff]ile"):  # the system's words
        read_trace(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\x00\x81")
    with pytest.raises(InvalidValue, match="not a text file"):
        read_trace(tmp_path / "binary.csv")


def test_an_unknown_name_lists_the_shipped_ones():
    with pytest.raises(InvalidValue, match="leon-2001"):
        shipped_trace("leon")
