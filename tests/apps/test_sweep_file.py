import re
import tomllib

import pytest

from fea.__main__ import exit_code
from fea.apps.sweep import sweep_file
from fea.apps.sweep.sampling import Sampling
from fea.apps.sweep.sweep_file import load_sweep, parse_sweep, require_extra, rows
from geometry.errors import InvalidValue

WEB = "rod.web_thickness_mm"


def sweep(text, folder, **more):
    return parse_sweep({"study": "leon-2001", **tomllib.loads(text), **more}, "trial", folder)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sampels = 3", "Did you mean samples?"),
        ("[vary.rod]\nweb_thicknes_mm = [4.0, 5.0]", "Did you mean web_thickness_mm?"),
        ("[vary.rodd]\nweb_thickness_mm = [4.0]", "Did you mean rod?"),
        ("[vary]\nweb_thickness_mm = [4.0]", "'web_thickness_mm' is an unknown key"),
        ("[vary.output]\ndirectory = ['a', 'b']", "is an unknown key"),
        ("[vary.rod]\nweb_thickness_mm = {from = 6.0, to = 4.0, steps = 3}", "must be above from, 6"),
        ("[vary.rod]\nweb_thickness_mm = {from = 4.0, steps = 3}", "has no bound 'to'"),
        ("[vary.rod]\nweb_thickness_mm = {from = 4.0, to = 6.0}", "a range has steps"),
        ("[vary.rod]\nweb_thickness_mm = {form = 4.0, to = 6.0}", "Did you mean from?"),
        ("[vary.rod]\nweb_thickness_mm = []", "must contain at least one value"),
        ("[vary.rod]\nweb_thickness_mm = [4.0, 4.0]", "contains a value twice"),
        ("[vary.rod]\nweb_thickness_mm = ['thin']", "must be a number"),
        ("[vary.rod]\nweb_thickness_mm = 4.0", "Move it to [set]"),
        ("[vary.engine]\ncylinders = {from = 2, to = 4, steps = 3}", "Give a list of values"),
        ("samples = 4\n[vary.rod]\nweb_thickness_mm = [4.0]", "has no effect on a grid"),
        ("sampling = 'sobol'\n[vary.rod]\nweb_thickness_mm = [4.0]", "samples is missing"),
        ("sampling = 'sobl'\nsamples = 4\n[vary.rod]\nweb_thickness_mm = [4.0]", "is not a valid choice"),
        ("[set.rod]\nweb_thickness_mm = 4.0\n[vary.rod]\nweb_thickness_mm = [4.0]", "is varied as well"),
        ("designs = 'a.csv'\n[vary.rod]\nweb_thickness_mm = [4.0]", "cannot be combined with designs"),
        ("frequencies = -1\n[vary.rod]\nweb_thickness_mm = [4.0]", "whole number from 0"),
        ("seed = 1", "nothing varies"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, said):
    with pytest.raises(InvalidValue, match=re.escape(said)):
        sweep(text, tmp_path)


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ('distribution = "normal", mean = 5.0, deviation = 0.1', "has no bound 'from'"),
        ('distribution = "normal", from = 4.0, to = 6.0', "mean is missing"),
        ('distribution = "normal", mean = 7.0, deviation = 0.1, from = 4.0, to = 6.0', "between the bounds"),
        ('distribution = "normal", mean = 5.0, deviation = 0.0, from = 4.0, to = 6.0', "must be positive"),
        ('distribution = "triangular", mode = 3.0, from = 4.0, to = 6.0', "between the bounds"),
        ("mean = 5.0, from = 4.0, to = 6.0", "is not of a uniform distribution"),
        ("from = 4.0, to = 6.0, steps = 3", 'sampling = "grid" only'),
    ],
)
def test_a_distribution_needs_bounds_and_its_numbers(tmp_path, spec, said):
    text = f'sampling = "random"\nsamples = 2\n[vary.rod]\nweb_thickness_mm = {{ {spec} }}'
    with pytest.raises(InvalidValue, match=re.escape(said)):
        sweep(text, tmp_path)


def test_a_preset_is_not_changed_beside_keys_that_override_it(tmp_path):
    study = tmp_path / "own.toml"
    study.write_text('[rod]\npreset = "leon-2001"\n[material]\npreset = "leon-2001"\nyield_MPa = 500.0\n')
    text = '[vary.material]\npreset = ["leon-2001", "c70-2005"]'
    with pytest.raises(InvalidValue, match=re.escape("[material] of the study gives yield_MPa")):
        rows(sweep(text, tmp_path, study=str(study)))


def test_a_grid_shares_a_rod_among_its_speeds(tmp_path):
    found = sweep("[vary]\nrod.web_thickness_mm = [4.0, 5.0]\nspeed.rpm = [3000.0, 6000.0]", tmp_path)
    table = rows(found)
    assert [(row.design[WEB], row.rpm) for row in table] == [(4, 3000), (4, 6000), (5, 3000), (5, 6000)]
    assert [table[0].job, table[2].job] == [table[1].job, table[3].job]
    assert len({row.job for row in table}) == 2
    assert len({row.key for row in table}) == 4
    assert found.base.study(table[0].design, [3000.0, 6000.0]).speeds() == (3000, 6000)


def test_speeds_of_the_study_are_rows_of_one_rod(tmp_path):
    table = rows(sweep("set.speed.rpm = [3000.0, 6000.0]\nvary.rod.web_thickness_mm = [4.0, 5.0]", tmp_path))
    assert [row.rpm for row in table] == [3000, 6000, 3000, 6000]
    assert [row.sample for row in table] == [0, 0, 1, 1]
    assert len({row.job for row in table}) == 2


def test_an_impossible_design_is_a_row_that_says_why(tmp_path):
    table = rows(sweep("vary.rod.web_thickness_mm = [5.0, 500.0]", tmp_path))
    assert not table[0].reason
    assert "web_thickness" in table[1].reason


def test_designs_come_from_a_file(tmp_path):
    (tmp_path / "designs.csv").write_text(f"{WEB},material.preset\n4.5,leon-2001\n5.5,c70-2005\n")
    found = sweep("designs = 'designs.csv'", tmp_path)
    assert found.designs() == [
        {WEB: 4.5, "material.preset": "leon-2001"},
        {WEB: 5.5, "material.preset": "c70-2005"},
    ]
    studies = [found.base.study(design) for design in found.designs()]
    assert [study.material.preset for study in studies] == ["leon-2001", "c70-2005"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("rod.web_mm\n4\n", "is an unknown key"),
        (f"{WEB}\nthin\n", "must be a number"),
        (f"{WEB}\n4,5\n", "must have 1 values"),
        (f"{WEB},{WEB}\n4,5\n", "each of its columns once"),
        (f"{WEB}\n", "1 to 1000000 designs"),
    ],
)
def test_a_wrong_file_of_designs_is_refused(tmp_path, text, said):
    (tmp_path / "designs.csv").write_text(text)
    with pytest.raises(InvalidValue, match=re.escape(said)):
        sweep("designs = 'designs.csv'", tmp_path).designs()


def test_a_changed_file_is_another_sweep(tmp_path):
    (tmp_path / "designs.csv").write_text(f"{WEB}\n4.5\n")
    before = sweep("designs = 'designs.csv'", tmp_path).identity
    assert sweep("designs = 'designs.csv'", tmp_path).identity == before
    (tmp_path / "designs.csv").write_text(f"{WEB}\n4.75\n")
    assert sweep("designs = 'designs.csv'", tmp_path).identity != before


def test_the_file_itself(tmp_path):
    path = tmp_path / "web.toml"
    path.write_text('study = "leon-2001"\nsampling = "latin-hypercube"\nsamples = 3\n'
                    "[vary.rod]\nweb_thickness_mm = { from = 4.0, to = 6.0 }\n")  # fmt: skip
    found = load_sweep(path)
    assert (found.name, found.sampling, len(found.designs())) == ("web", Sampling.LATIN, 3)
    with pytest.raises(InvalidValue, match="is not an existing file"):
        load_sweep(tmp_path / "none.toml")


def test_the_line_to_type_is_said_where_a_library_is_missing(monkeypatch):
    monkeypatch.setattr(sweep_file, "find_spec", lambda name: None if name == "pyarrow" else name)
    with pytest.raises(ImportError, match=r"needs pyarrow, .*pip install pyarrow") as caught:
        require_extra()
    assert exit_code(caught.value) == 7
