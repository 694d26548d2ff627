"""`fea init` explains every key, tells true defaults, and its examples are ones that work."""

import dataclasses
import re

import pytest

from fea.study.documents import template
from fea.study.study import TABLES, Study, load_study
from geometry.dimensions import dimensions, options

TEXT = template()
GIVEN = {"length", "big_end_bore", "small_end_bore"}
DEFAULTS = [name for name in dimensions() if name not in {*options(), *GIVEN}]


def keys(table: str) -> set[str]:
    """The keys under the headings of a table, commented or not."""
    parts = re.split(r"(?m)^(?:# )?\[([\w.]+)\]$", TEXT)
    own = [text for name, text in zip(parts[1::2], parts[2::2], strict=True) if name == table]
    return set(re.findall(r"(?m)^(?:# )?(\w+) = ", "\n".join(own)))


def study(tmp_path, *uncommented: str) -> Study:
    text = TEXT
    for key in uncommented:
        text, found = re.subn(rf"(?m)^# ({key} = )", r"\1", text)
        assert found == 1, key
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    return load_study(str(tmp_path / "mine.toml"))


@pytest.mark.parametrize("table", TABLES)
def test_every_key_of_a_table_is_there(table):
    assert {field.name for field in dataclasses.fields(TABLES[table])} <= keys(table)


@pytest.mark.parametrize("name", DEFAULTS)
def test_dimensions_that_are_shown_are_those_that_follow(name, tmp_path):
    key = name if name == "shank_section" else f"{name}_mm"
    plain = getattr(study(tmp_path).rod.dimensions, name)
    given = getattr(study(tmp_path, key).rod.dimensions, name)
    assert given == (plain if name == "shank_section" else pytest.approx(plain, rel=3e-3))


def test_its_options_and_other_defaults_work(tmp_path):
    for excluded in ("small_end_crown_width", "small_end_chamfer"):  # not both of them
        chosen = [name for name in options() if name not in {excluded, "shank_bore"}]  # of a tubular shank
        rod = study(tmp_path, *(f"{name}_mm" for name in chosen)).rod.dimensions
        assert all(getattr(rod, name) > 0 for name in chosen)
    plain = study(tmp_path)
    shown = study(tmp_path, "intake_pressure_bar", "atmosphere_bar", "heat_ratio", "phase_deg")
    engine = plain.engine.engine(141.0)
    assert shown.engine.engine(141.0) == engine
    assert shown.engine.gas_model(engine) == plain.engine.gas_model(engine)
