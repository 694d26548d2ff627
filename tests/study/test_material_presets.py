from pathlib import Path

import pytest

from fea.study.material_table import MaterialTable
from fea.study.presets import MATERIALS, SOURCES

FATIGUE = Path(__file__).parents[2] / "results" / "fatigue.md"


def test_every_preset_has_a_source_that_the_document_gives():
    text = FATIGUE.read_text(encoding="utf-8")
    assert MATERIALS.keys() == SOURCES.keys()
    for name, constants in MATERIALS.items():
        (row,) = (line for line in text.splitlines() if line.startswith(f"| `{name}` |"))
        assert [float(cell) for cell in row.split("|")[2:-1] if cell.strip() != "–"] == list(
            constants.values()
        )
        assert f"- `{name}`: {SOURCES[name]}" in text


@pytest.mark.parametrize("name", MATERIALS)
def test_every_preset_is_a_material_with_strengths_in_order(name):
    material = MaterialTable(preset=name).material()
    strengths = (material.endurance_limit, material.yield_strength, material.ultimate_strength)
    known = [strength for strength in strengths if strength is not None]
    assert known == sorted(known)
    if material.torsion_limit is not None:
        # Nishihara & Kawamoto's hard steel: 0.625 (Tveit et al. 2026, Procedia Structural Integrity 82, 112).
        assert material.torsion_limit / material.endurance_limit == pytest.approx(0.625, rel=1e-3)
