"""The library of engines: every figure has an origin, and a study with an engine of it is complete."""

import dataclasses
import math
import re
from functools import cache
from pathlib import Path

import pytest

from fea.analysis.engine_study import engine_study
from fea.analysis.forces import study_forces
from fea.base.units import BAR, KG, KG_M2, KG_M3, RPM
from fea.rod.loading import EngineLoading
from fea.study.engine_library import engine_aliases, engine_names, engine_preset
from fea.study.engine_table import EngineTable, engine_notes, layout_notes
from fea.study.flags import Flags, python_flags
from fea.study.rod_table import RodKeys
from fea.study.study import load_study, parse_study
from fea.study.tables import keys_of
from geometry.errors import InvalidValue
from geometry.section import HeightField
from loads.combustion import peak_interval

MID_INTAKE = 90  # degrees after the dead centre of gas exchange
ROD = "[rod]\npreset = 'leon-2001'\n"


def parsed(text):
    return parse_study(text, "test", Path.cwd())


@cache
def of_engine(name):
    """The study that `fea init --engine` writes, and the mass properties of its rod."""
    study = parsed(engine_study(name))
    density = study.material.resolved().density_kg_m3 * KG_M3
    return study, HeightField(study.rod.dimensions).mass().times(density)


def test_there_are_enough():
    assert len(engine_names()) >= 40


@pytest.mark.parametrize("name", engine_names())
def test_every_figure_has_a_source_or_is_an_estimate(name):
    preset = engine_preset(name)
    figures = [*preset.engine.values(), *preset.rod.values(), preset.redline]
    cited = {figure.origin for figure in figures if not figure.assumed}
    assert cited == preset.sources.keys()
    assert all(preset.sources.values())
    read = (preset.engine["stroke_mm"], preset.engine["bore_mm"], preset.rod["length_mm"])
    assert not any(figure.assumed for figure in read)
    assert preset.layout in {"in-line", "V", "flat"}
    assert preset.engine.keys() <= {field.name for field in dataclasses.fields(EngineTable)}
    assert preset.rod.keys() <= keys_of(RodKeys).keys()


@pytest.mark.parametrize("name", engine_names())
def test_estimates_follow_the_rules_that_they_name(name):
    preset = engine_preset(name)
    values = preset.entries()
    bore, ratio = values["bore_mm"], values.get("compression_ratio", 0)
    intake = 1.01325 + values.get("boost_bar", 0)  # bar, absolute
    rules = {
        "0.6 g/cm³ × bore³": 0.6e-6 * bore**3,
        "1.5 g/cm³ × bore³, as usual for a diesel engine": 1.5e-6 * bore**3,
        "6.5 bar × compression ratio": 6.5 * ratio,
        "6.5 bar × compression ratio × absolute intake pressure in bar, an upper bound": 6.5 * ratio * intake,
        "0.62 × bore": 0.62 * bore,
        "0.25 × bore": 0.25 * bore,
        "0.35 × bore, as usual for a diesel engine": 0.35 * bore,
    }
    for figure in (*preset.engine.values(), *preset.rod.values()):
        if figure.assumed and figure.origin in rules:
            assert figure.value == pytest.approx(rules[figure.origin], rel=0.02)


def test_the_rule_for_pistons_lies_among_those_of_petrol_engines_that_are_known():
    """Except León's 1.33 kg, which is that of a piston of three times the volume."""
    known = []
    for name in set(engine_names()) - {"leon-2001", "sd195"}:
        values = engine_preset(name).engine
        if not values["piston_mass_kg"].assumed:
            known.append(values["piston_mass_kg"].value / values["bore_mm"].value ** 3 * 1e6)
    assert len(known) >= 4
    assert min(known) < 0.6 < max(known)


@pytest.mark.parametrize("name", engine_names())
def test_its_figures_are_in_proportion(name):
    """In bounds that a slip of a digit, an inch taken for mm or a swapped figure of another engine leaves.

    Rods of cars are 3 to 4 crank radii long; 2.8 to 5 are the ends of all engines of this size, from long
    strokes to racing. Strokes are 0.7 to 1.3 bores. Mean piston speeds at the redline are 7 m/s in governed
    engines to 25 m/s in sports cars (Heywood 1988, section 2.2: 8 to 15 m/s at rated power). Small ends are
    0.2 to 0.3 bores wide in petrol and up to 0.43 with a bushing in diesel engines, big ends 0.35 (without
    shells) to 0.72. Pistons weigh 0.5 to 0.9 g/cm³ × bore³ in petrol and twice that in diesel engines. Peaks
    are those that combustion from late to early gives.
    """
    preset = engine_preset(name)
    values = preset.entries()
    bore, stroke, ratio = (values.get(key) for key in ("bore_mm", "stroke_mm", "compression_ratio"))
    assert 2.8 <= preset.rod_length / (stroke / 2) <= 5.0
    assert 0.7 <= stroke / bore <= 1.3
    assert 7.0 <= preset.redline_rpm * stroke / 30e3 <= 25.0
    assert 0.2 <= preset.rod["small_end_bore_mm"].value / bore <= 0.43
    assert 0.35 <= preset.rod["big_end_bore_mm"].value / bore <= 0.72
    heaviest = (
        3.1 if name == "leon-2001" else 1.7 if ratio > 13 else 0.9
    )  # León's piston is of another engine
    assert 0.5 <= values["piston_mass_kg"] / bore**3 * 1e6 <= heaviest
    if ratio:
        assert 7.0 <= ratio <= 22.0
        intake = (1.01325 + values.get("boost_bar", 0)) * BAR
        fuel = "diesel" if "diesel" in preset.title else "petrol"
        late, early = peak_interval(fuel, ratio, intake, stroke / 2 / preset.rod_length)
        assert late <= values["peak_pressure_bar"] * BAR <= early


@pytest.mark.parametrize("name", engine_names())
def test_bore_stroke_and_cylinders_make_the_displacement_that_the_engine_is_known_by(name):
    values, title = engine_preset(name).entries(), engine_preset(name).title
    volume = math.pi / 4 * values["bore_mm"] ** 2 * values["stroke_mm"] * values["cylinders"]
    known = float(re.search(r"(\d+) cm³", title)[1])
    assert volume / 1e3 == pytest.approx(known, rel=2.5e-3)  # makers round bores, strokes and displacements


@pytest.mark.parametrize("name", engine_names())
def test_it_turns_and_its_load_cases_are_its_own(name):
    """The gas presses with p A at most, on intake with the boost; the piston pulls with m r ω² (1 + λ)."""
    study, mass = of_engine(name)
    table, rod = study.require_engine(), study.rod.dimensions
    loading, rpm = EngineLoading.of(table, rod.length), engine_preset(name).redline_rpm
    cases = loading.at(mass, rpm).cases
    assert {"tension", "compression", "side", "bending"} <= set(cases.names)
    degrees = loading.crank_cycle(mass, rpm).degrees
    radius, area = table.stroke_mm / 2, math.pi / 4 * table.bore_mm**2
    pull = table.piston_mass_kg * KG * radius * (rpm * RPM) ** 2 * (1 + radius / rod.length)
    computed, two_stroke = table.gas == "otto", table.strokes == 2
    assert two_stroke or degrees.pin_axial.max() == pytest.approx(
        pull, rel=3e-3 if computed else 0.05
    )  # a trace presses
    if computed:
        peak = (table.peak_pressure_bar * BAR - table.atmosphere) * area
        assert degrees.gas.max() == pytest.approx(peak, rel=0.02)  # at whole degrees
        values = engine_preset(name).entries()
        boost = values.get("boost_bar", 0) + values.get("intake_pressure_bar", 1.01325) - 1.01325
        assert degrees.gas[180 if two_stroke else MID_INTAKE] == pytest.approx(
            boost * BAR * area, abs=1e-6 * peak
        )


@pytest.mark.parametrize("name", engine_names())
def test_its_study_is_complete_and_has_the_mass_that_is_published(name):
    preset, (study, mass) = engine_preset(name), of_engine(name)
    rod, engine = study.rod.dimensions, study.require_engine()
    assert rod.length == preset.rod_length
    assert study.speeds() == (preset.redline_rpm,)
    assert engine.preset == name
    assert study.unusual() == []
    assert engine.gas_model(engine.engine(rod.length)) is not None
    weighed = {
        "mass_kg": mass.mass / KG,
        "center_of_gravity_mm": mass.center[0],
        "inertia_kg_m2": mass.inertia_z / KG_M2,
    }
    for key, figure in preset.rod.items():
        if key in weighed and not figure.assumed:
            assert weighed[key] == pytest.approx(figure.value, rel=1e-3)
    again = parsed(study.text())
    assert again.engine == engine
    assert again.text() == study.text()


def test_an_alias_means_one_engine():
    known = [known for name in engine_names() for known in (name, *engine_preset(name).aliases)]
    plain = [known.casefold().replace("-", "") for known in known]
    assert len(set(plain)) == len(known)
    assert engine_aliases().keys().isdisjoint(engine_names())


@pytest.mark.parametrize(
    ("asked", "name"),
    [
        ("k20", "honda-k20a"),
        ("K20A", "honda-k20a"),
        ("LS 3", "gm-ls3"),
        ("ej207", "subaru-ej20"),
        ("2JZ", "toyota-2jz"),
    ],
)
def test_aliases_are_read_in_any_case_wherever_an_engine_is_named(asked, name):
    whole = parsed(f'engine = "{name}"\n' + ROD).engine
    assert parsed(f'engine = "{asked}"\n' + ROD).engine == whole
    assert parsed(ROD + f'[engine]\npreset = "{asked}"').engine == whole
    assert Flags(engine=asked).applied(load_study("leon-2001")).engine == whole
    assert f'preset = "{name}"' in engine_study(asked)
    assert whole.preset == name


def test_a_name_is_enough_and_keys_override_it():
    plain = parsed('engine = "toyota-2jz"\n' + ROD)
    assert plain.engine == parsed(ROD + '[engine]\npreset = "toyota-2jz"').engine
    assert plain.engine.stroke_mm == 86.0
    heavier = parsed(ROD + '[engine]\npreset = "toyota-2jz"\npiston_mass_kg = 0.5').engine
    assert heavier == dataclasses.replace(plain.engine, piston_mass_kg=0.5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('engine = "toyota-3jz"\n' + ROD, r"^engine = 'toyota-3jz': .*Did you mean toyota-2jz\?.*jeep-4\.0"),
        ('engine = "k21"\n' + ROD, r"^engine = 'k21': .*Did you mean honda-k2.a or honda-k2.a\?.*toyota-2jz"),
        (ROD + '[engine]\npreset = "3jz"', r"^engine\.preset = '3jz': is not an engine of the library"),
        (ROD + "[engine]\npreset = 2", r"engine\.preset = 2: must be text"),
        ("engine = 3\n" + ROD, r"engine = 3: must be a table"),
        (ROD + '[engine]\npreset = "toyota-2jz"\nbor_mm = 3.0', r"bor_mm.*unknown key.*preset"),
    ],
)
def test_other_engines_are_refused(text, says):
    with pytest.raises(InvalidValue, match=says):
        parsed(text)


def test_the_redline_is_the_speed_unless_one_is_given():
    assert parsed('engine = "suzuki-hayabusa"\n' + ROD).speeds() == (11000,)
    given = parsed('engine = "suzuki-hayabusa"\n' + ROD + "[speed]\nrpm = 6000")
    assert given.speeds() == (6000,)
    assert "rpm = 11000.0" in parsed('engine = "suzuki-hayabusa"\n' + ROD).text()


@pytest.mark.parametrize("source", ["leon-2001", "columba-2022", "molina-2024"])
def test_the_flag_replaces_the_engine_and_nothing_else(source):
    study = load_study(source)
    asked = Flags(engine="toyota-2jz").applied(study)
    assert asked.engine == parsed('engine = "toyota-2jz"\n' + ROD).engine
    assert dataclasses.replace(asked, engine=study.engine) == study
    assert python_flags({"engine": "toyota-2jz"}).applied(study) == asked


def test_the_flag_gives_a_rod_alone_an_engine_and_its_redline():
    bare = parsed(ROD)
    assert Flags(engine="jeep-4.0").applied(bare).speeds() == (5250,)
    assert Flags(engine="jeep-4.0", rpm="800").applied(bare).speeds() == (800,)
    forces = parsed(ROD + "[forces]\npin_N = [1.0, 0.0]")
    with pytest.raises(InvalidValue, match=r"--engine = 'jeep-4\.0': cannot be used with \[forces\]"):
        Flags(engine="jeep-4.0").applied(forces)


def test_what_is_assumed_is_said_but_not_what_the_study_gives():
    table = parsed('engine = "toyota-2jz"\n' + ROD).engine
    said = " ".join(map(str, engine_notes(table, 142.0, 6000)))
    assert "assumed piston_mass_kg = 0.38 (0.6 g/cm³ × bore³)" in said
    assert "assumed peak_pressure_bar = 68" in said
    assert "stroke_mm" not in said
    weighed = dataclasses.replace(table, piston_mass_kg=0.4, gas="none")
    assert engine_notes(weighed, 142.0, 6000) == []
    assert engine_notes(dataclasses.replace(table, preset=None), 1.0, 9e3) == []


def test_another_rod_and_too_high_a_speed_are_said():
    table = parsed('engine = "leon-2001"\n' + ROD).engine
    assert engine_notes(table, 141.0, 6000) == []
    length, speed = engine_notes(table, 150.0, 6001)
    assert "141 mm long, the one of this study 150 mm" in str(length)
    assert "6001 rpm is above the redline of the leon-2001 engine, 6000 rpm" in str(speed)


def test_the_sums_of_an_engine_in_v_are_marked():
    study = parsed('engine = "chevrolet-454"\n' + engine_rod("chevrolet-454"))
    (whole,) = study_forces(study, every_cylinder=True)
    (one,) = study_forces(study, every_cylinder=False)
    assert "8 cylinders in line, but the chevrolet-454 engine is of V layout" in whole.note
    assert "layout" not in one.note
    assert "assumed peak_pressure_bar" in one.note
    assert layout_notes(parsed('engine = "toyota-2jz"\n' + ROD).engine) == []


def engine_rod(name):
    """A [rod] table of the engine's own length with masses alone, which need no solid."""
    length = engine_preset(name).rod_length
    return f"[rod]\nlength_mm = {length}\nmass_kg = 0.8\ncenter_of_gravity_mm = 50.0\ninertia_kg_m2 = 4e-3\n"


BOOSTED = "[engine]\nstroke_mm = 80.0\nbore_mm = 80.0\npiston_mass_kg = 0.4\ncompression_ratio = 9.0\n"


@pytest.mark.parametrize(
    ("keys", "bar"),
    [
        ('gas = "motored"\nboost = "1.5 bar"', 2.51325),
        ('gas = "motored"\nboost = "20 psi"', 2.39220),  # 1 psi = 6.894757 kPa
        ('gas = "motored"\nboost_bar = -0.4\natmosphere_bar = 0.9', 0.5),
        ('gas = "motored"\nintake_pressure_bar = 2.5', 2.5),
        ('gas = "leon-2001"\nboost_bar = 1.0', 2.01325),
    ],
)
def test_boost_is_the_gauge_pressure_in_the_intake(keys, bar):
    table = parsed(ROD + BOOSTED + keys + "\n").engine
    assert 10 * table.intake == pytest.approx(bar, rel=1e-5)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            'gas = "otto"\nboost_bar = 1.0\nintake_pressure_bar = 2.0',
            "beside intake_pressure_bar.*Remove one",
        ),
        ('gas = "otto"\nboost_bar = 1.0\ngas_scale = 2.0', "beside gas_scale.*Remove one"),
        ('gas = "none"\nboost_bar = 1.0', 'does nothing for gas = "none"'),
        ('gas = "otto"\nboost_bar = -1.2', "above vacuum"),
        ('gas = "otto"\nturbo = 1.0', "Did you mean boost_bar"),
        ('gas = "otto"\nboost_pressure = 1.0', "Did you mean boost_bar"),
    ],
)
def test_what_contradicts_boost_is_refused(keys, message):
    with pytest.raises(InvalidValue, match=message):
        parsed(ROD + BOOSTED + keys + "\n")


def test_a_fuel_or_a_peak_burns_unless_another_gas_is_asked_for():
    bare = "[engine]\nstroke_mm = 54.0\nbore_mm = 54.0\npiston_mass_kg = 0.2\n"
    keys = f"{bare}compression_ratio = 8.0\n"
    for burns in ('fuel = "petrol"', "peak_pressure_bar = 60.0", 'peak_pressure = "900 psi"'):
        assert parsed(f"{ROD}{keys}{burns}\n").engine.gas == "otto"
        assert parsed(f'{ROD}{keys}{burns}\ngas = "none"\n').engine.gas == "none"
    again = parsed(f"{ROD}{bare}")
    assert again.engine.gas == "none"
    assert again.with_(engine={"compression_ratio": 8, "peak_pressure": "900 psi"}).engine.gas == "otto"


@pytest.mark.parametrize(
    "key", ["compression_ratio = 8.0", "intake_pressure_bar = 1.0", "heat_ratio = 1.4", "gas_scale = 1.5"]
)
def test_what_needs_a_gas_is_refused_without_one(key):
    bare = "[engine]\nstroke_mm = 54.0\nbore_mm = 54.0\npiston_mass_kg = 0.2\n"
    with pytest.raises(InvalidValue, match=r"has no effect without gas.*Give peak_pressure_bar or fuel"):
        parsed(f"{ROD}{bare}{key}\n")
    assert parsed(f'{ROD}{bare}{key}\ngas = "none"\n').engine.gas == "none"  # which is what was asked for
    with pytest.raises(InvalidValue, match="has no effect without gas"):
        parsed(f"{ROD}{bare}").with_(engine={key.partition(" ")[0]: 2.0})


def test_boost_over_an_engine_of_the_library_raises_its_peak_unless_that_is_given():
    """The peak of the library is that of its own charge: 1 bar of boost about doubles it."""

    def table(preset, **keys):
        return load_study("leon-2001").with_(engine={"preset": preset, **keys}).require_engine()

    def peak(**keys):
        engine = table("k20", **keys)
        return engine.gas_model(engine.engine(139.0)).peak / BAR

    own, computed = peak(), peak(fuel="petrol")
    assert peak(boost="1 bar") == pytest.approx(2 * computed, rel=0.02)
    assert peak(intake_pressure_bar=2.0265) == pytest.approx(2 * computed, rel=1e-6)
    assert own < computed < 1.3 * own
    assert peak(boost="1 bar", peak_pressure_bar=120.0) == pytest.approx(120.0)
    assert (
        table("ej207", boost="1.5 bar").boost_bar
        == 1.5
        != engine_preset("subaru-ej20").entries()["boost_bar"]
    )
