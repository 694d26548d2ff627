import json
import math
import shutil
from dataclasses import replace
from itertools import pairwise

import pytest
from studies import plain_study

from fea.__main__ import call
from fea.output.inp import read_frd
from fea.output.pictures.picture import is_complete_png
from fea.output.plots.figure import log_ticks, new_figure
from fea.study.study import load_study
from fea.verify.converge import converge as module
from fea.verify.converge.converge import series
from fea.verify.converge.measurement import (
    Computation,
    ConvergenceRow,
    Measured,
    Reference,
    calculix_refuses,
    compute,
    extrapolated,
)
from fea.verify.converge.series import (
    advice,
    equal_error,
    equal_time,
    error_after,
    fastest_within,
    pareto,
    same_mesh,
    seconds_to,
    settled,
)


def row(seconds, error, tool="fea", element="p2", size=1.0):
    computation = Computation(tool, element, "rod", size)
    return ConvergenceRow(computation, Measured(size, 3000, seconds, 100.0, 700.0), "peak", error)


def test_richardson_finds_the_limit_of_a_power_law():
    sizes = [4.0, 2.0, 1.0]
    found = extrapolated(sizes, [100 - 3 * size**2 for size in sizes])
    assert found.value == pytest.approx(100)
    # Grid convergence index: 1.25 times the distance from the finest, here 3 of 97.
    assert found.uncertainty_percent == pytest.approx(100 * 1.25 * 3 / 97)


def test_values_that_scatter_are_uncertain_by_their_spread():
    found = extrapolated([4.0, 2.0, 1.0], [99.0, 101.0, 100.0])
    assert found.value == 100.0
    assert found.uncertainty_percent == pytest.approx(2.0)


def test_two_meshes_tell_nothing_of_the_uncertainty():
    assert extrapolated([2.0, 1.0], [99.0, 100.0]).uncertainty_percent == math.inf


def test_the_front_has_what_nothing_beats():
    cheap, better, worse, best = row(1, -9.0), row(2, 3.0), row(3, 4.0), row(5, -0.5)
    assert pareto([best, worse, better, cheap]) == [cheap, better, best]
    assert pareto([row(1, 0.02), row(2, 0.01)]) == [row(1, 0.02)]  # both below the floor


def test_a_coarse_mesh_that_happens_to_be_right_does_not_count():
    lucky, bad, good = row(1, 0.1, size=4.0), row(2, 5.0, size=2.0), row(4, 0.5, size=1.0)
    assert fastest_within([lucky, bad, good], 1.0) == {("fea", "p2"): good}


def test_a_tolerance_is_advised_with_its_figure():
    adaptive = [row(1, 4.0, tool="fea --tolerance", size=10.0), row(2, 0.5, tool="fea --tolerance", size=3.0)]
    assert "use `fea --tolerance 3` with P2" in advice(adaptive)[2]


def test_the_time_is_the_median_of_the_runs(monkeypatch):
    times, computation = iter([9.0, 1.0, 5.0, 2.0]), Computation("fea", "p2", "rod", 1.0)
    monkeypatch.setattr(module, "series", lambda *_, **__: [[computation]])
    monkeypatch.setattr(module, "_apart", lambda *_: Measured(1.0, 9, next(times), 100.0, 700.0))
    outcomes = module._computed(load_study(), "rod", 5.0, 60.0, None)
    assert outcomes[computation].seconds == 2.0  # of three runs, after one that is not counted


def test_the_advice_is_three_sentences_on_what_was_measured():
    rows = [row(1, 4.0, size=2.0), row(3, 0.5), row(50, 1.5, tool="CalculiX"), row(9, 20.0, element="p1")]
    five, two, one = advice(rows)
    assert "within 5 %, confirmed by all finer meshes, use `fea` with P2 elements: 1.0 s" in five
    assert "within 2 %, the finest mesh of the comparison, use `fea` with P2 elements: 3.0 s" in two
    assert "CalculiX takes" in two
    assert "CalculiX did not reach this" in one
    assert all("No first-order mesh" in line for line in (five, two, one))


def test_what_the_reference_does_not_tell_is_not_advised():
    assert "reference is not accurate enough" in advice([row(1, 0.1)], floor=1.5)[2]


def test_the_error_of_a_mesh_is_the_worst_of_it_and_all_finer_ones():
    rows = [row(1, -9.0, size=8.0), row(2, 0.0, size=4.0), row(4, 3.0, size=2.0), row(8, 1.0)]
    assert settled(rows) == [9.0, 3.0, 3.0, 1.0]
    assert settled(rows[:2]) == [9.0, pytest.approx(9 / 2**4)]  # no better than twice the rate of P2
    assert settled([row(1, 0.01)]) == [0.05]


def test_times_and_errors_are_interpolated_by_their_logarithms():
    rows = [row(10.0**k, 10.0 ** (1 - k), size=4.0**-k) for k in range(3)]  # error = 10 / seconds
    assert seconds_to(rows, 2.0) == pytest.approx(5.0)
    assert error_after(rows, 5.0) == pytest.approx(2.0)
    assert seconds_to(rows, 20.0) == 1.0
    assert seconds_to(rows, 0.05) == math.inf
    assert error_after(rows, 0.5) == math.inf
    assert error_after(rows, 1e4) == pytest.approx(0.1)


def test_ours_is_held_against_calculix_at_equal_error_and_equal_time():
    ours = [row(10.0**k / 20, 10.0 ** (1 - k), size=4.0**-k) for k in range(4)]
    theirs = [row(10.0**k, 10.0 ** (1 - k), "CalculiX", size=4.0**-k) for k in range(2)]
    five, two, one = equal_error(ours + theirs)
    assert (five.ratio, two.ratio) == (pytest.approx(20), pytest.approx(20))
    assert five.goal_met
    assert five.whole == math.inf
    assert one.theirs == pytest.approx(10)
    (within,) = (found for found in equal_error([*ours, *theirs[:1]]) if found.percent == 1)
    assert within.theirs == math.inf
    assert within.ratio == pytest.approx(2)  # at least: its only mesh took 1 s, ours 0.5 s
    assert not within.goal_met
    after = {seconds: (mine, other) for seconds, mine, other in equal_time(ours + theirs)}
    assert after[3.0] == (pytest.approx(10 / 60), pytest.approx(10 / 3))
    assert equal_error(ours) == []


def test_the_plan_holds_what_is_to_be_compared():
    found = {(c.tool, c.element) for computations in series("rod", 5.0) for c in computations}
    ours = {("fea", "p1"), ("fea", "p2"), ("fea, mean", "p1"), ("fea, mean", "p2"), ("fea, whole", "p2")}
    assert ours | {("fea --tolerance", "p2"), ("fea --size 12 --tolerance", "p2")} <= found
    for computations in series("lame", 5.0):
        sizes = [c.size for c in computations]
        assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize("problem", ["lame", "goodier"])
def test_surface_recovery_beats_the_mean_on_exact_problems(problem):
    size = 2.0 if problem == "lame" else 0.25
    truth = module.EXACT[problem]
    error = {
        tool: abs(compute(Computation(tool, "p2", problem, size), load_study()).value / truth - 1)
        for tool in ("fea", "fea, mean")
    }
    assert error["fea"] < error["fea, mean"] < 0.1


def test_quarter_and_whole_give_the_same_peak():
    study = plain_study()
    quarter, whole = (compute(Computation(tool, "p2", "rod", 14.0), study) for tool in ("fea", "fea, whole"))
    assert quarter.value == pytest.approx(whole.value, rel=1e-6)
    assert quarter.dofs == whole.dofs


def study_in_contact():
    study = plain_study()
    return replace(study, analysis=replace(study.analysis, pressure="contact"))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
@pytest.mark.parametrize("study", [plain_study(), study_in_contact()], ids=["prescribed", "contact"])
def test_calculix_is_given_the_forces_of_the_pins(study):
    # Both solve the same equations of first order; CalculiX prints six digits of the stress.
    ours, theirs = (compute(Computation(tool, "p1", "rod", 8.0), study) for tool in ("fea, mean", "CalculiX"))
    assert theirs.value == pytest.approx(ours.value, rel=1e-4)
    assert ours.bar_percent > 0
    assert theirs.bar_percent is None


def test_a_rod_of_separate_parts_is_not_given_to_calculix():
    study = load_study("leon-2001-bolted")
    assert "separate parts" in calculix_refuses(study)
    assert {c.tool for some in series("rod", 5.0, calculix=False) for c in some}.isdisjoint({"CalculiX"})
    assert calculix_refuses(plain_study()) == ""


def test_two_programs_are_compared_on_the_meshes_that_both_solved():
    def of(tool, size, value, bar=None):
        return ConvergenceRow(
            Computation(tool, "p2", "rod", size), Measured(size, 9, 1.0, 100.0, value, bar), "peak", 0.0
        )

    rows = [of("fea", 8.0, 100.0, 5.0), of("CalculiX", 8.0, 103.0), of("fea", 6.0, 100.0, 1.0)]
    rows += [of("CalculiX", 6.0, 98.0), of("fea", 4.0, 100.0, 1.0), of("fea, mean", 6.0, 99.0, 1.0)]
    found = [(at.size, round(at.difference_percent, 6), at.within) for at in same_mesh(rows)]
    assert found == [(8.0, 3.0, True), (6.0, -2.0, False)]


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
    monkeypatch.setattr(module, "_apart", fake)
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
    return Measured(computation.size, dofs, 1 / computation.size, 200.0, value, bar)


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
