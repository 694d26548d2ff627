"""Adding a study key touches one place: its declaration on a table."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from fea.cli.options import takes
from fea.study import documents, flags, study
from fea.study.option_tables import MeshTable
from fea.study.study import TABLES, Study, load_study, parse_study
from fea.study.tables import key, within
from geometry.errors import InvalidValue

ROD = '[rod]\npreset = "leon-2001"\n'


@dataclass(frozen=True)
class Toy(MeshTable, table="mesh"):
    """[mesh] with one key more."""

    growth_mm: float | None = key("0.5", "from one element to the next", within(0, 2), flag="growth")


@pytest.fixture(autouse=True)
def toy(monkeypatch):
    tables = {**TABLES, "mesh": Toy}
    for module in (study, documents, flags):
        monkeypatch.setattr(module, "TABLES", tables)


def read(text) -> Study:
    return parse_study(ROD + text, "toy", Path.cwd())


def test_it_is_read_and_checked():
    assert read("[mesh]\ngrowth_mm = 1").mesh.growth_mm == 1.0
    assert "growth_mm = 1.0" in read("[mesh]\ngrowth_mm = 1").text()
    with pytest.raises(InvalidValue, match=r"mesh.growth_mm = 3: must lie between 0 and 2"):
        read("[mesh]\ngrowth_mm = 3")
    with pytest.raises(InvalidValue, match=r"mesh.growth_mm = 'x': must be a number"):
        read('[mesh]\ngrowth_mm = "x"')


def test_it_has_a_flag_in_the_shell_and_in_python():
    @takes("growth")
    def command(*, flags):
        """Nothing."""

    hint = command.__annotations__["flags"]
    parsed = hint.__origin__(growth=0.7)
    assert parsed.applied(read("[mesh]\ngrowth_mm = 1")).mesh.growth_mm == 0.7
    assert flags.python_flags({"growth": 0.7}, writes=False).applied(read("[mesh]")).mesh.growth_mm == 0.7


def test_it_is_in_the_commented_study_and_the_schema():
    (line,) = (line for line in documents.template().splitlines() if "growth_mm" in line)
    assert line == "# growth_mm = 0.5          # from one element to the next"
    entry = documents.study_schema()["$defs"]["mesh"]["properties"]["growth_mm"]
    assert entry["description"] == "growth, mm: from one element to the next"
    assert entry["type"] == ["number", "string"]


@pytest.mark.parametrize("name", ["matrix_assembly", "assembly"])
def test_the_matrix_assembly_has_an_older_name(name):
    given = read(f'[analysis]\n{name} = "scikit-fem"')
    assert given == read('[analysis]\nmatrix_assembly = "scikit-fem"')
    asked = flags.python_flags({name: "scikit-fem"}).applied(load_study())
    assert asked.analysis.matrix_assembly == "scikit-fem"
    assert tomllib.loads(asked.text())["analysis"]["matrix_assembly"] == "scikit-fem"


def test_a_key_by_both_of_its_names_is_refused():
    with pytest.raises(InvalidValue, match="given twice"):
        read('[analysis]\nassembly = "batched"\nmatrix_assembly = "batched"')
