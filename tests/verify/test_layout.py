"""Tables of reports on a narrow terminal: lines may break, figures and words are whole."""

import pytest

from fea.verify.computations import Computation, ConvergenceRow, Reference
from fea.verify.converge import Comparison, print_comparison
from fea.verify.reproduce.report import print_reproduction, reproduce

TOOLS = ("fea", "fea --tolerance", "fea --size 12.1 --tolerance", "CalculiX")


@pytest.mark.parametrize("width", [60, 80])
def test_error_against_run_time(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    measured = {"size": 12.1, "dofs": 2012345, "seconds": 123.45, "peak_memory": 12345.0, "value": 717.9}
    rows = [
        ConvergenceRow(Computation(tool, "p2", "goodier", 5.0), **measured, error_percent=-12.34)
        for tool in TOOLS
    ]
    print_comparison(Comparison(rows, {"rod": Reference(733.8)}))
    text = capsys.readouterr().out
    assert "…" not in text
    for figure in ("2012345", "123.45", " 12345 ", "717.9", "-12.34"):
        assert text.count(figure) == len(rows)
    assert ("fea --tolerance 5, p2" in text) == (width == 80)


@pytest.mark.parametrize("width", [60, 80])
def test_published_figures(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    print_reproduction(reproduce("molina-2024"))
    text = capsys.readouterr().out
    assert "…" not in text
    assert "displacement" in text
