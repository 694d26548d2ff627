"""Flaws and hardness that make no sense are refused with what, value, rule and remedy."""

import pytest

from fea.study.defect_table import DefectTable, Flaw
from fea.study.flags import python_flags
from fea.study.material_table import MaterialTable
from fea.study.study import load_study
from geometry.errors import InvalidValue


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("0.4x6", Flaw(0.4, 6.0)),
        (" .4 × 6. ", Flaw(0.4, 6.0)),
        ("0.4x6@70,-6.6,3", Flaw(0.4, 6.0, (70.0, -6.6, 3.0))),
        ("0.4x6 @ 70, 0, 3", Flaw(0.4, 6.0, (70.0, 0.0, 3.0))),
    ],
)
def test_a_flaw_is_read(text, known):
    assert DefectTable(size=text).flaw == known


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"size": "0x6"}, r"defect.size = '0x6': must be larger than 0. Write --defect 0.4x6"),
        ({"size": "0.4x-6"}, "must be larger than 0"),
        ({"size": "0.4"}, "must be DEPTHxLENGTH in mm"),
        ({"size": "0.4x6@70,0"}, "must be DEPTHxLENGTH in mm"),
        ({"size": "0.4mmx6mm"}, "must be DEPTHxLENGTH in mm"),
        ({"size": "1.2.3x6"}, "must be DEPTHxLENGTH in mm"),
        ({"normal": (0.0, 0.0, 0.0)}, "defect.normal.*not all 0"),
        ({"normal": (1.0, 0.0)}, "defect.normal.*three components"),
        ({"growth_exponent": 3.0}, "defect.growth_exponent.*growth_coefficient"),
        ({"threshold_MPa_m05": -1.0}, "defect.threshold_MPa_m05"),
    ],
)
def test_flaws_that_make_no_sense_are_refused(keys, message):
    with pytest.raises(InvalidValue, match=message):
        DefectTable(**keys)


@pytest.mark.parametrize("preset", ["Ti-6Al-4V", "7075-T6"])
def test_hardness_is_that_of_a_steel(preset):
    with pytest.raises(InvalidValue, match=r"material.hardness_HV = 340.*low-alloy steel only.*Leave it out"):
        MaterialTable(preset=preset, hardness_HV=340.0).material()
    assert MaterialTable(preset=preset).material().hardness is None


def test_hardness_is_given_or_follows_from_the_strength():
    given = MaterialTable(preset="4340", hardness_HV=340.0).material()
    assert (given.hardness, given.hardness_estimated) == (340.0, False)
    # 36 HRC is about 354 HV.
    estimated = MaterialTable(preset="4340").material()
    assert estimated.hardness_estimated
    assert estimated.hardness == pytest.approx(354, rel=0.03)


def test_growth_is_assumed_of_steel_and_aluminium_alone():
    steel = DefectTable(threshold_MPa_m05=4.0).metal(MaterialTable(preset="4340"))
    assert (steel.threshold, steel.slope, steel.least) == (4.0, 0.0, 0.0)
    assert len(steel.assumed) == 3
    aluminium = DefectTable().metal(MaterialTable(preset="7075-T6"))
    assert aluminium.coefficient > 20 * steel.coefficient
    with pytest.raises(
        InvalidValue, match=r"growth_coefficient is missing.*steel and aluminium only.*Give it"
    ):
        DefectTable().metal(MaterialTable(preset="Ti-6Al-4V"))


def test_a_flaw_needs_the_cycle():
    with pytest.raises(InvalidValue, match=r"defect.size.*no effect without the crank cycle. Add --cycle"):
        python_flags({"defect": "0.4x6"}).applied(load_study())
    study = python_flags({"defect": "0.4x6", "cycle": True}).applied(load_study())
    assert '[defect]\nsize = "0.4x6"' in study.text()
    assert load_study().with_(defect={"size": "0.4x6"}).analysis.cycle  # the table switches it on
