"""Everything that a run says of a rod agrees; `tests/benchmarks/verdict_campaign.py` has more draws."""

from dataclasses import replace

import pytest
from agreeing import disagreements, random_asked

from fea.output.tables import PEAKS

pytestmark = pytest.mark.slow


def asked(seed, size, pressure):
    study = random_asked(seed, size)
    return replace(study, analysis=replace(study.analysis, pressure=pressure))


# With a required factor, and with the whole cycle and what is asked with it.
@pytest.mark.parametrize(("seed", "pressure"), [(33, "contact"), (57, "cosine-180")])
def test_a_random_study_says_one_thing_everywhere(seed, pressure, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert disagreements(asked(seed, 3.0, pressure), tmp_path) == []


def test_a_table_with_another_factor_is_found(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    forms = {"safety factor": lambda value: f"{1.1 * value:.2f}"}
    columns = tuple(replace(column, form=forms.get(column.title, column.form)) for column in PEAKS)
    monkeypatch.setattr("fea.output.tables.PEAKS", columns)
    wrong = disagreements(asked(25, 3.5, "cosine-180"), tmp_path)
    assert len(wrong) == 5
    assert all("the table has no" in text for text in wrong)
