"""Units as data sheets of several countries write them: the values are by hand, from the units' definitions.

An inch is 25.4 mm, a pound 0.45359237 kg, and a kilogram weighs 9.80665 N (NIST SP 811, appendix B).
"""

from pathlib import Path

import pytest

from fea.apps.sweep.sampling import read_designs
from fea.apps.sweep.sweep_file import parse_sweep
from fea.study.flags import Flags
from fea.study.speed_tables import parse_speeds
from fea.study.study import TABLES, load_study, parse_study
from fea.study.tables import Written, keys_of, own_unit, quantity
from geometry.errors import InvalidValue

READ = {
    ("Nm", 60.0): "60 Nm|60Nm|60 N m|60 N·m|60 N*m|60 N.m|60 N-m|60 N⋅m|60\u00a0N\u202fm|６０ Ｎｍ"
    "|60 newton meters|60 Newtonmeter|60 Newton-metres|60 NM|6 daNm|6000 Ncm|60000 N·mm|0.06 kNm",
    ("Nm", 58.8399): "6 kgm|6 kgf·m|6 m·kg|6 mkg|6 kgf-m|6 mkp|6 kpm|600 kgf cm|600 kg-cm",
    ("Nm", 61.01180767): "45 lbf·ft|45 lb-ft|45 ft-lb|45 ft lbs|45 ft. lbs.|45 lbft|45 foot-pounds|45 FT-LBS",
    ("Nm", 11.29848290): "100 in-lb|100 in·lbf|100 inlb|100 in. lbs.|1600 oz-in",
    ("mPas", 9.0): "9 mPas|9 mPa·s|9 mPa.s|9 cP|9 cps|0.009 Pas|0.009 N·s/m²|0.09 P|9 mpas|0.009 kg/(m·s)",
    ("rpm", 6000.0): "6000 1/min|6000 rpm|6000 RPM|6000 r.p.m.|6000 min⁻¹|6000 min^-1|6000 min-1|6000 U/min"
    "|6000 /min|6000 rev/min|6000 r/min|6000 tr/min|6000 giri/min|6'000 rpm|6 000 rpm|100 Hz|100 rev/s",
    ("kg_m3", 7850.0): "7.85 g/cm3|7.85 g/cm³|7.85 g/cm^3|7.85 g/cc|7.85 kg/dm³|7.85 kg/l|7850 kg/m3"
    "|7850 kg/m³|7850 kg·m⁻³|7.85 t/m3|7.85e-9 t/mm³",
    ("kg_m3", 7861.092938): "0.284 lb/in3|0.284 lb/in³|0.284 lb/cu in|0.284 lbs per cubic inch",
    ("MPa", 7.0): "7 N/mm2|7 N/mm²|7 N/mm^2|7 MPa|7 Mpa|70 bar|0.7 daN/mm²|0.7 hbar|7 MN/m²",
    ("MPa", 7.0019481): "71.4 kgf/cm2|71.4 kp/cm²|71.4 kg/cm2|0.714 kp/mm²|0.714 kg/mm2|0.714 kgf/mm²",
    ("MPa", 620.5281564): "90 ksi|90000 psi|90000 PSI|90000 p.s.i.|90000 lb/in²|90000 lbs/sq in|90 kpsi",
    ("GPa", 210.0): "2.1e5 MPa|2.1·10^5 MPa|2.1×10⁵ N/mm²|2.1x10^5 MPa|210 kN/mm²|21·10^10 Pa",
    ("GPa", 206.8427188): "30 Msi|30 Mpsi|30x10^6 psi|30 × 10⁶ psi",
    ("kN", 9.0): "900 daN|9000 N|9 KN|9 kN|9000 Newton",
    ("kN", 8.825985): "900 kgf|900 kp|900 kilogram-force",
    ("kN", 8.896443231): "2000 lbf|2 kip|2000 pounds force",
    ("bar", 60.0): "60 bar|60 bar(a)|60 bara|60 bar abs|60 BAR|6 MPa|6000 kPa|6 MPa abs|60000 mbar",
    ("bar", 1.01325): "760 Torr|1 atm|1013.25 hPa|1013.25 mbar|14.69594878 psia|14.69594878 psi",
    ("bar", 0.980665): "1 at|1 ata|1 kg/cm² abs|10000 mmH2O|10000 mm WS|10 m H2O",
    ("kg", 0.008): "8 g|8 G|8 gm|8 grams|8 Gramm|0.008 kg|0.008 Kg|8e-6 t",
    ("kg", 0.45359237): "1 lb|1 lbs|1 lbm|1 LB|16 oz|1 pound",
    ("mm", 149.225): '5 7/8 in|5 7/8"|5-7/8 in|5⅞″|5.875 inch|5.875 in.|5.875 Zoll|5875 thou|5875 mil',
    ("mm", 9.525): "3/8 in|3⁄8 in|0.375\u2033|.375 IN",
    ("mm", 0.05): "50 µm|50 μm|50 um|50 micron|0.05 mm|0.05 MM|0.05 millimetres|5e-5 m",
    ("mm", -5.0): "−5 mm|-5 mm|–5 ㎜",
    ("mm", 1000.0): "1'000 mm|1’000 mm|1 000 mm|1\u202f000 mm|1000 mm|100 cm",
    ("um", 12.7): "0.5 thou|12.7 µm|12.7 micron|0.0005 in",
    ("deg", 30.0): "30 °|30°|30 deg|30 degrees|30 DEG|30 °CA|30 °KW|30 Grad",
    ("C", 100.0): "100 °C|100 C|100 degC|100 deg C|100 ℃|212 °F|212 F|373.15 K|100 Grad Celsius",
    ("1_K", 12e-6): "12e-6 1/K|12e-6 /K|12e-6 K⁻¹|12e-6 1/°C|12 µm/(m·K)|12 µm/m·K|12 µm/m/K|12 ppm/K"
    "|12·10⁻⁶/K",
    ("kg_m2", 0.002): "0.002 kg m2|0.002 kg·m²|0.002 kgm²|20 kgcm²|20000 gcm2|2000 kg·mm²",
    ("bar_V", 20.0): "20 bar/V|0.02 bar/mV|2 MPa/V",
    ("percent", 5.0): "5 %|5%|5 percent",
    ("hours", 1.5): "1.5 h|1.5 hrs|90 min|1.5 Std",
    ("V", 0.5): "0.5 V|500 mV",
    ("1_GPa", 20.0): "20 1/GPa|20 GPa^-1|20 /GPa",
}  # fmt: skip
REFUSED = {
    ("mPas", "kinematic"): "9 cSt|9 cst|9 mm²/s",
    ("rpm", "revolutions or radians"): "100 1/s|100 s⁻¹",
    ("rpm", "comma in its number"): "6,000 rpm|6,5 rpm",
    ("mm", "point, not a comma: 12.5"): "12,5 mm|12,5mm",
    ("mm", "the comma may mean either"): "1,000 mm|12,345,678 mm",
    ("mm", "cannot be read|must be a number"): "1.000.000 mm|5-6 mm|5 ± 0.1 mm|5' 6\"|5 ft 6 in"
    "|5 mm 3|M8|3/8-24|1 00 mm|~5 mm|5 x 3 mm|mm|5",
    ("mm", "more meanings"): "5 Mm",
    ("kg", "more meanings"): "8 gr|1 ton",
    ("MPa", "more meanings"): "600 mPa",
    ("MPa", "gauge"): "7 bar(g)|100 psig",
    ("bar", "gauge pressure, but this key takes absolute pressure. Write 61.01325 bar"): "60 bar(g)|60 barg"
    "|60 bar g|6 MPaG|60 bar Überdruck",
    ("deg", "more meanings"): "30 grad",
    ("Nm", "right kind"): "60 N|80 ft/lbs|60 mN|5 lb|5 kW|5 PS|5 hp",
    ("kN", "right kind"): "5 kg|2000 lb|60 Nm",
    ("kg", "right kind"): "2 lbf|9 daN|5 cc|5 l",
    ("hours", "right kind"): "5 PS|5 bhp|5 kW",
    ("mm", "right kind"): "5 lb|5 mm²|5 cm³|5 ccm|60 NM",
}  # fmt: skip


def each(table):
    return [(text, *rest) for rest, texts in table.items() for text in texts.split("|")]


def test_the_tables_have_120_notations():
    assert len({(text, unit) for text, unit, _ in (*each(READ), *each(REFUSED))}) >= 120


@pytest.mark.parametrize(("text", "unit", "value"), each(READ))
def test_a_notation_is_read(text, unit, value):
    key = "engine.peak_pressure_bar" if unit == "bar" else ""
    assert quantity("key", text, unit, key=key) == pytest.approx(value, rel=2e-9, abs=1e-12)


@pytest.mark.parametrize(("text", "unit", "why"), each(REFUSED))
def test_a_notation_is_refused_with_the_reason(text, unit, why):
    key = "engine.peak_pressure_bar" if unit == "bar" else ""
    with pytest.raises(InvalidValue, match=why):
        quantity("key", text, unit, key=key)


def test_the_unit_in_a_key_is_read_beside_its_value():
    units = {own_unit(key) for cls in TABLES.values() for key in keys_of(cls)} - {""}
    assert len(units) > 15
    assert {unit: quantity("key", f"7 {unit}", unit) for unit in units} == pytest.approx(
        dict.fromkeys(units, 7.0)
    )


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("engine.intake_pressure_bar", "1.5 bara", "0.5 barg"),
        ("atmosphere_bar", "0.9 bar abs", "0 bar g"),
        ("film.inlet_bar", "4 bar(g)", "5 bar(a)"),
        ("small_end_inlet_bar", "0.5 barg", "15 psia"),
    ],
)
def test_a_pressure_is_gauge_or_absolute_by_its_key(key, right, wrong):
    assert quantity("key", right, "bar", key=key) == float(right.split()[0].rstrip("bargu()"))
    with pytest.raises(InvalidValue, match=r"this key takes .* pressure. Write .* bar"):
        quantity("key", wrong, "bar", key=key)


@pytest.mark.parametrize(
    ("text", "speeds"),
    [
        ("6000 rpm", (6000,)),
        ("100 Hz", (6000,)),
        ("6000 1/min", (6000,)),
        ("800,3000 min⁻¹", (800, 3000)),
        ("80,100 Hz", (4800, 6000)),
        ("80:100:10 rev/s", (4800, 5400, 6000)),
        ("5000 rpm,100 Hz", (5000, 6000)),
        (["6000 rpm", 7000], (6000, 7000)),
        ("95,105", (95, 105)),
    ],
)
def test_speeds_have_units(text, speeds):
    assert parse_speeds(text) == pytest.approx(speeds)
    assert Flags(rpm=text).applied(load_study()).speeds() == pytest.approx(speeds)


@pytest.mark.parametrize("text", ["6,000", "12,500", "6,000 rpm", "6 000", "5 psi", "rpm", "100 1/s"])
def test_what_is_no_speed_is_refused(text):
    with pytest.raises(InvalidValue, match="--rpm"):
        parse_speeds(text)


def test_designs_of_a_file_and_spans_of_a_sweep_have_units(tmp_path):
    designs = tmp_path / "designs.csv"
    designs.write_text("rod.web_thickness_mm,speed.rpm\n0.2 in,6000 1/min\n5,6000\n", "utf-8")
    assert read_designs(designs) == [
        {"rod.web_thickness_mm": pytest.approx(5.08), "speed.rpm": pytest.approx(6000)},
        {"rod.web_thickness_mm": 5, "speed.rpm": 6000},
    ]
    span = {"from": "8 g", "to": "9 g"}
    raw = {
        "study": "leon-2001",
        "sampling": "random",
        "samples": 2,
        "vary": {"engine": {"piston_mass": span}},
    }
    drawn = parse_sweep(raw, "test", Path.cwd()).designs()
    assert all(isinstance(design["engine.piston_mass_kg"], Written) for design in drawn)


SMALL = """
[rod]
length = "30 mm"
big_end_bore = "6 mm"
small_end_bore = "4 mm"
[engine]
stroke = "15 mm"
{bore}
{piston}
[speed]
rpm = 12000
"""


def small(bore="bore_mm = 16", piston='piston_mass = "8 g"'):
    return parse_study(SMALL.format(bore=bore, piston=piston), "small", Path.cwd())


@pytest.mark.parametrize("mass", ["8 g", "0.3 oz", "60 g"])
def test_a_unit_that_was_written_is_not_doubted(mass):
    study = small(piston=f'piston_mass = "{mass}"')
    assert not any("seems to be in" in found.text or found.refused for found in study.unusual())
    again = parse_study(Flags().applied(study).text(), "again", Path.cwd())
    assert again.unusual() == study.unusual()
    assert again.engine == study.engine


def test_a_value_beside_one_with_its_unit_is_still_doubted():
    with pytest.raises(InvalidValue, match=r"engine.bore_mm = 0.63: seems to be in inches"):
        Flags().applied(small(bore="bore_mm = 0.63"))
    with pytest.raises(InvalidValue, match=r"engine.piston_mass_kg = 8: seems to be in g"):
        Flags().applied(small(piston="piston_mass_kg = 8"))


def test_pistons_are_judged_by_the_bore():
    two_stroke = (
        '[rod]\npreset = "leon-2001"\nlength_mm = 110\n[engine]\nstroke_mm = 54.5\nbore_mm = 54\n{}\n'
    )
    gas = 'gas = "otto"\ncompression_ratio = 12\npeak_pressure_bar = 60\n[speed]\nrpm = 11000'
    keys = [
        {
            found.key
            for found in parse_study(
                two_stroke.format(f"piston_mass_kg = {mass}\n{gas}"), "t", Path.cwd()
            ).unusual()
        }
        for mass in (0.19, 0.42)
    ]
    assert ["engine.piston_mass_kg" in each for each in keys] == [False, True]
