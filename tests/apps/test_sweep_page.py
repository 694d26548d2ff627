import json
import re

import numpy as np
import pytest

from fea.apps.sweep.run_sweep import (
    SweepPage,
    label,
    main_effects,
    matrix,
    pareto,
    sweep_page,
)
from fea.apps.sweep.statistics import Influence, Probability, Samples, Sensitivity, Statistics

STUDY = '[rod]\nweb_thickness_mm = {}\nname = "</script><b>"\n'


def swept(factors, masses=None, keys=(), **more):
    """A sweep of a web's thickness, and more `keys` with their values."""
    count = len(factors)
    figures = {"factor": np.array(factors, float)} if count else {}
    if masses is not None:
        figures["mass_kg"] = np.array(masses, float)
    varied = {"rod.web_thickness_mm": np.linspace(4, 6, count), **dict(keys)} if count else {}
    designs = tuple({key: values[n] for key, values in varied.items()} for n in range(count))
    return SweepPage(
        title="a <b>sweep</b>",
        counts="All are done.",
        samples=Samples(tuple(varied), designs, tuple(range(10, 10 + count)), figures),
        studies=[STUDY.format(n) for n in range(count)],
        **{"statistics": Statistics((), ())} | more,
    )


def embedded(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page)[1])


def test_each_point_leads_to_its_study():
    run = swept([0.9, 1.1, 1.2], [0.7, 0.8, 0.9])
    page = sweep_page(run)
    data = embedded(page)
    studies = ["\n".join(data["lines"][line] for line in lines) + "\n" for lines in data["studies"]]
    assert studies == run.studies
    assert data["rows"] == [10, 11, 12]
    assert {n for *_, n in pareto(run).points} == {0, 1, 2}
    assert set(re.findall(r'data-n="(\d+)"', page)) == {"0", "1", "2"}
    assert re.search(r'data-n="0" class="fails"', page)
    assert not re.search(r'data-n="1" class="fails"', page)


def test_what_a_study_says_is_text():
    page = sweep_page(swept([1.1], [0.7], failures=[(3, "<script>", 2)]))
    assert "<b>" not in page
    assert page.count("<script") == 2
    assert "https://" not in page


@pytest.mark.parametrize(
    ("factors", "masses"),
    [
        ([], None),
        ([np.nan] * 3, [np.nan] * 3),
        ([1.0], [0.7]),
        ([1.0] * 3, [0.7] * 3),
        ([1.0, np.nan], [0.7, np.nan]),
    ],
)
def test_whatever_there_is_makes_a_page(factors, masses):
    bare = Sensitivity(
        figure="factor", influences=(Influence(key="one"),), linear_share=None, without_total=""
    )
    run = swept(factors, masses, statistics=Statistics((), (bare,)))
    assert "a &lt;b&gt;sweep" in sweep_page(run)


def test_statistics_are_told_with_their_bars():
    influences = (Influence(key="one", first=0.25, first_bar=0.125), Influence(key="other", first=-0.004))
    of_factor = Sensitivity(figure="factor", influences=influences, linear_share=0.5, without_total="too few")
    risk = Probability(name="factor", below=1, rods=8, missing=2, estimate=0.125, low=0.01, high=0.5)
    page = sweep_page(swept([1.1], [0.7], statistics=Statistics((risk,), (of_factor,))))
    row = "<th>factor</th><td>0.125</td><td>0.01 to 0.5</td><td>8</td><td>2</td>"
    for said in (row, "<td>0.25 ± 0.12</td>", "<td>0.00</td>", "explains 50 %. Too few", 'width="30.0"'):
        assert said in page
    assert "total index" not in page


def test_scatters_leave_out_what_has_no_result():
    plots = matrix(swept([1.0, np.nan, 2.0], [0.7, 0.75, 0.8]))
    assert len(plots) == 3
    assert all({n for *_, n in plot.points} == {0, 2} for plot in plots)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("rod.web_thickness_mm", "web thickness (mm)"),
        ("material.density_kg_m3", "material density (kg/m³)"),
        ("material.bushing.E_GPa", "material bushing E (GPa)"),
        ("speed.rpm", "speed rpm"),
        ("mass_kg", "mass (kg)"),
        ("factor", "least factor"),
        ("buckling_factor", "buckling factor"),
    ],
)
def test_axes_say_their_units(name, said):
    assert label(name) == said


def test_a_mean_is_drawn_where_there_are_rods_for_it():
    few, many = ([1.0, 1.2] * 4, [0.7] * 8), ([1.0, 1.2] * 8, [0.7] * 16)
    assert main_effects(swept(*few))[0].line.count(",") == 8  # no other key varies
    for run, bins in ((few, 0), (many, 3)):
        width = {"rod.shank_width_mm": np.cos(np.arange(len(run[0])))}
        assert [plot.line.count(",") for plot in main_effects(swept(*run, width))] == [bins, bins]
    ring = {"rod.shank_width_mm": np.cos(np.arange(16)), "rod.big_end_ring_mm": np.arange(16.0) % 4}
    assert main_effects(swept(*many, ring))[-1].line.count(",") == 4  # at each value


def test_one_rod_has_no_pairs():
    assert matrix(swept([1.0], [0.7])) == []
