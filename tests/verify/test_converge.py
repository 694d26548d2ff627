import json
import math
import shutil
from itertools import pairwise

import pytest
from studies import plain_study

from fea.__main__ import call
from fea.output.inp import read_frd
from fea.output.pictures.picture import is_complete_png
from fea.output.plots.figure import log_ticks, new_figure
from fea.study.study import load_study
from fea.verify import converge as module
from fea.verify.computations import Computation, ConvergenceRow, Reference, calculix_refuses, compute
from fea.verify.converge import series


def test_the_time_is_the_median_of_the_runs(monkeypatch):
    times, computation = iter([9.0, 1.0, 5.0, 2.0]), Computation("fea", "p2", "rod", 1.0)
    monkeypatch.setattr(module, "series", lambda *_, **__: [[computation]])
    monkeypatch.setattr(
        module, "_in_process", lambda *_: ConvergenceRow(computation, 1.0, 9, next(times), 100.0, 700.0)
    )
    (outcome,) = module._computed(load_study(), "rod", 5.0, 60.0, None)
    assert outcome.seconds == 2.0  # of three runs, after one that is not counted


def test_the_plan_holds_what_is_to_be_compared():
    found = {(c.tool, c.element) for computations in series("rod", 5.0) for c in computations}
    ours = {("fea", "p1"), ("fea", "p2"), ("fea, mean", "p1"), ("fea, mean", "p2"), ("fea, whole", "p2")}
    assert ours | {("fea --tolerance", "p2"), ("fea --size 12 --tolerance", "p2")} <= found
    for computations in series("lame", 5.0):
        sizes = [c.size for c in computations]
        assert sizes == sorted(sizes, reverse=True)


def test_a_rod_of_separate_parts_is_not_given_to_calculix():
    study = load_study("leon-2001-bolted")
    assert "separate parts" in calculix_refuses(study)
    assert {c.tool for some in series("rod", 5.0, calculix=False) for c in some}.isdisjoint({"CalculiX"})
    assert calculix_refuses(plain_study()) == ""


def test_two_programs_are_compared_on_the_meshes_that_both_solved():
    def of(tool, size, value, bar=None):
        return ConvergenceRow(Computation(tool, "p2", "rod", size), size, 9, 1.0, 100.0, value, bar)

    rows = [of("fea", 8.0, 100.0, 5.0), of("CalculiX", 8.0, 103.0), of("fea", 6.0, 100.0, 1.0)]
    rows += [of("CalculiX", 6.0, 98.0), of("fea", 4.0, 100.0, 1.0), of("fea, mean", 6.0, 99.0, 1.0)]
    *_, table = module._same_mesh(module.Comparison(rows, {}))
    assert table.splitlines()[2:] == [
        "| P2 | 8 | 100.00 | 5 | 103.00 | 3.00 | yes |",
        "| P2 | 6 | 100.00 | 1 | 98.00 | −2.00 | **no** |",
    ]


@pytest.mark.parametrize("decades", [0.3, 1.0, 1.9, 2.5, 6.0])
def test_labels_of_logarithmic_axes_do_not_overlap(decades):
    figure = new_figure(13, 5)
    for axes in figure.subplots(1, 3):
        axes.loglog([0.3, 0.3 * 10**decades], [0.07, 0.07 * 10**decades])
        log_ticks(axes)
    figure.canvas.draw()
    for axes in figure.axes:
        for axis, side in ((axes.xaxis, 0), (axes.yaxis, 1)):
            boxes = [
                label.get_window_extent() for label in axis.get_ticklabels(which="both") if label.get_text()
            ]
            ends = sorted(box.get_points()[:, side].tolist() for box in boxes)
            assert len(ends) >= 2 or decades < 0.5
            assert all(low[1] < high[0] for low, high in pairwise(ends))


def test_the_command_writes_rows_and_a_report(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(module, "_in_process", fake)
    report = tmp_path / "deep" / "error-vs-runtime.md"
    assert call(["converge", "--minutes", "0.01", "--json", "--report", str(report)]) == 0
    rows = json.loads(capsys.readouterr().out)
    names = {"tool", "element", "size_mm", "dofs", "seconds", "peak_memory_MiB", "quantity", "value"}
    assert all(set(row) == names | {"error_percent", "error_bar_percent"} for row in rows)
    text = report.read_text()
    assert text.startswith("# Error against run time")
    assert "| fea | P2 |" in text
    assert "(−0." in text  # an error below the reference's uncertainty
    assert ("## The same mesh and forces" in text) == bool(shutil.which("ccx"))
    assert ("## Against CalculiX" in text) == bool(shutil.which("ccx"))
    assert is_complete_png(report.with_suffix(".png"))
    assert report.with_suffix(".png").stat().st_size < 300_000


def fake(work, *arguments):
    if work is not compute:
        return Reference(700.0, 0.5)
    computation = arguments[0]
    truth = module.EXACT.get(computation.problem, 700.0)
    value = truth * (1 - 0.001 * computation.size**computation.order)
    bar = None if computation.tool == "CalculiX" else 0.01 * value
    dofs = round(1e6 / computation.size**3)
    return ConvergenceRow(computation, computation.size, dofs, 1 / computation.size, 200.0, value, bar)


def test_a_time_limit_is_positive(capsys):
    assert call(["converge", "--minutes", "0"]) == 2
    assert "--minutes" in capsys.readouterr().err


def test_calculix_results_are_read_node_by_node(tmp_path):
    path = tmp_path / "a.frd"
    path.write_text(
        " -4  DISP        4    1\n -5  D1          1    2    1    0\n"
        " -1         3 1.00000E+00-2.00000E+00 3.00000E-01\n"
        " -1         1 4.00000E+00 5.00000E+00 6.00000E+00\n -3\n"
    )
    found = read_frd(path, "DISP", 3)
    assert found[0].tolist() == [4, 5, 6]
    assert found[2].tolist() == [1, -2, 0.3]
    assert math.isnan(found[1, 0])
    with pytest.raises(ValueError, match="no field STRESS"):
        read_frd(path, "STRESS", 3)
