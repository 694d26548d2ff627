import json
import math
from pathlib import Path

import numpy as np
import pytest
from engines import LEON, LEON_ROD

from fea.analysis.forces import force_columns
from fea.output.folder import write_columns
from fea.output.json_file import json_text
from geometry.surfaces import Surface
from loads.gas import NoGas


def test_numbers_keep_six_digits_and_whole_numbers_all():
    assert json.loads(json_text({"a": 123.456789, "b": 1.23456789e-16, "c": 123456789, "d": True})) == {
        "a": 123.457,
        "b": 1.23457e-16,
        "c": 123456789,
        "d": True,
    }


def test_a_vector_is_rounded_to_the_digits_of_its_largest_component():
    assert json.loads(json_text([141.23456789, 3.1e-15, -0.1234567])) == [141.235, 0.0, -0.123]
    assert json.loads(json_text(np.array([1.0, 2.5]))) == [1.0, 2.5]
    assert json.loads(json_text([math.nan, 0.0])) == [None, 0.0]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float64("nan")])
def test_what_is_not_finite_is_null(value):
    assert json.loads(json_text({"value": value, "list": [value] * 5})) == {"value": None, "list": [None] * 5}


def test_there_is_no_minus_zero():
    assert "-0" not in json_text({"a": -0.0, "b": [1.0, -1e-30]})


def test_numpy_enums_and_paths_become_plain_json():
    value = {
        Surface.FREE: np.int64(3),
        "surface": Surface.BIG_END_BORE,
        "path": Path("a/b"),
        "on": np.bool_(1),
    }
    assert json.loads(json_text(value)) == {
        "free": 3,
        "surface": "big_end_bore",
        "path": str(Path("a/b")),
        "on": True,
    }


def test_the_text_is_the_same_for_the_same_figures_and_reads_well():
    value = {
        "schema": "fea/summary/1",
        "rod": {"at_mm": [1.0, 2.0]},
        "left_out": [{"what": "gas", "why": "ü"}],
        "n": {},
    }
    assert json_text(value) == (
        '{\n  "schema": "fea/summary/1",\n  "rod": {\n    "at_mm": [1.0, 2.0]\n  },\n'
        '  "left_out": [\n    {\n      "what": "gas",\n      "why": "ü"\n    }\n  ],\n  "n": {}\n}\n'
    )


def test_what_json_cannot_say_is_an_error():
    with pytest.raises(TypeError, match="has no JSON form"):
        json_text({"a": object()})


def test_the_cycle_has_the_promised_columns_and_a_row_an_angle(tmp_path):
    columns = dict.fromkeys(force_columns(LEON, LEON_ROD, NoGas(), 6000.0), 0.0) | {
        "rpm": 6000,
        "crank_deg": np.arange(3.0),
        "pin_axial_N": [31512.3456, -0.0, 1],
    }
    write_columns(tmp_path / "loads.csv", columns)
    header, *rows = (tmp_path / "loads.csv").read_bytes().decode().split("\n")
    assert header == (
        "rpm,crank_deg,gas_N,piston_position_mm,piston_velocity_m_s,piston_acceleration_m_s2,rod_deg,"
        "rod_angular_velocity_rad_s,rod_angular_acceleration_rad_s2,pin_axial_N,pin_transverse_N,crank_axial_N,"
        "crank_transverse_N,wall_N,torque_Nm,shaking_x_N,shaking_y_N"
    )
    assert rows == [
        "6000,0,0,0,0,0,0,0,0,31512.35,0,0,0,0,0,0,0",
        "6000,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        "6000,2,0,0,0,0,0,0,0,1,0,0,0,0,0,0,0",
        "",
    ]
