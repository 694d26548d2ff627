"""How a printed figure is judged, and what a formula may say."""

import math

import pytest

from fea.verify.reproduce import molina
from fea.verify.reproduce.tables import (
    Cell,
    PrintedColumn,
    PrintedFigure,
    PublishedStudy,
    Slip,
    Status,
    column,
    wrong_digit,
)


def test_one_unit_of_the_last_digit_decides():
    row = PrintedFigure("s", "t", "q", "", "", 4.84, 0.01, 4.8499, 4.84)
    assert row.status is Status.AGREES
    assert PrintedFigure("s", "t", "q", "", "", 4.84, 0.01, 4.8501, 4.84).status is Status.UNEXPLAINED


def test_a_slip_must_reproduce_the_printed_figure():
    slip = Slip("wrong guess", 4.9)
    assert PrintedFigure("s", "t", "q", "", "", 4.84, 0.01, 5.0, 4.84, slip=slip).status is Status.UNEXPLAINED
    assert PrintedFigure("s", "t", "q", "", "", 4.90, 0.01, 5.0, 4.84, slip=slip).status is Status.EXPLAINED


def test_two_wrong_digits_are_no_misprint():
    assert wrong_digit("18.15", 18.254).value == 18.15
    assert wrong_digit("18.37", 18.254).value != 18.37


def test_a_bare_zero_has_the_finest_digit_of_its_column():
    first = column("columba2022_torque", "T12_800rpm_Nm")[0]
    assert first == Cell("0", "0", 1e-8)


def test_a_formula_is_an_expression_of_cells_units_and_the_study():
    study = PublishedStudy("molina-2024", {"R": 2.0})
    cells = PrintedColumn([Cell("0", "1.5", 0.1), Cell("90", "2.5", 0.1)])
    assert study.evaluate("R * sin(theta) + cells.values + rpm", cells, 10) == pytest.approx([11.5, 14.5])
    assert study.evaluate("omega / RPM", cells, 10) == pytest.approx([10.0, 10.0])
    assert study.evaluate(math.nan, cells, 0) == pytest.approx([math.nan] * 2, nan_ok=True)
    assert molina.STUDY.text("{fastest:.1f} at {rpm} rpm, {key}°", 780, "90") == "74.8 at 780 rpm, 90°"
    with pytest.raises(NameError, match="no_such"):
        study.evaluate("no_such(theta)", cells, 0)
