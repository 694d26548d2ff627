"""Studies, traces and speeds that nobody would write: each is read, or refused in a line or two."""

import warnings
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from studies import LEON

from fea.__main__ import exit_code
from fea.machine.exit_codes import USAGE
from fea.study.files import toml_text
from fea.study.speed_tables import parse_speeds
from fea.study.study import parse_study, shipped_studies
from fea.study.traces import parse_trace
from geometry.errors import InvalidValue

STUDY = f"""{LEON}[speed]
rpm = [800, 6000]
[mesh]
size_mm = 12
[analysis]
pressure = "cosine-180"
"""
TRACE = "crank_deg,pressure_bar_800rpm,pressure_bar_3000rpm\n0,1,2\n180,3,4\n360,20.5,30\n540,2,3\n"
FOREIGN = "CA [deg],Pcyl [bar],note\n" + "".join(
    f"{a},{2e3 / (abs(a - 9) + 40):.3f},x\n" for a in range(-360, 360, 9)
)
WORST_LETTERS = "\0\x1b\r\n\t[]{}.,:;#=\"'\\-+0123456789eEinfaxo_ \u0661\u2028\ufeff"


def damaged(text):
    """Text with some stretches replaced by others."""
    stretch = st.tuples(
        st.integers(0, len(text)), st.integers(0, 8), st.text(st.sampled_from(WORST_LETTERS), max_size=6)
    )

    def cut(stretches):
        result = text
        for start, length, other in stretches:
            result = result[:start] + other + result[start + length :]
        return result

    return st.lists(stretch, min_size=1, max_size=6).map(cut)


def refused_or_read(parse, *arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return parse(*arguments)
        except InvalidValue as error:
            refusal = error
    assert exit_code(refusal) == USAGE
    assert len(str(refusal)) < 3000
    assert refusal.rule
    return None


@settings(max_examples=1000)
@given(damaged(STUDY))
@pytest.mark.slow
def test_damaged_studies(tmp_path_factory, text):
    study = refused_or_read(parse_study, text, "damaged", tmp_path_factory.getbasetemp())
    if study is not None:
        again = parse_study(study.text(), "damaged", study.folder)
        assert again.text() == study.text()


VALUES = st.recursive(
    st.integers() | st.floats() | st.text(max_size=8) | st.booleans() | st.sampled_from([10**400, -(2**63)]),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=4,
)
KEYS = {
    "engine": ["stroke_mm", "bore_mm", "piston_mass_kg", "cylinders", "phase_deg", "friction", "gas"],
    "rod": ["preset", "length_mm", "web_thickness_mm", "shank_section", "step", "mass_kg"],
    "material": ["E_GPa", "nu", "density_kg_m3", "yield_MPa", "preset"],
    "speed": ["rpm"],
    "forces": ["pin_N"],
    "mesh": ["size_mm", "element"],
    "analysis": ["support", "symmetry", "pressure", "solver", "min_safety"],
    "output": ["directory", "screenshot"],
}


@settings(max_examples=500)
@given(st.data())
def test_any_value_at_any_key(tmp_path_factory, data):
    table = data.draw(st.sampled_from(sorted(KEYS)))
    key = data.draw(st.sampled_from(KEYS[table]))
    text = toml_text({"rod": {"preset": "leon-2001"}} | {table: {key: data.draw(VALUES)}})
    refused_or_read(parse_study, text, "any", tmp_path_factory.getbasetemp())


@settings(max_examples=1000)
@given(damaged(TRACE))
def test_damaged_traces(text):
    refused_or_read(parse_trace, text, "damaged.csv")


@settings(max_examples=300)
@given(
    st.sampled_from([",", ";", "\t", " "])
    .map(lambda s: damaged(FOREIGN.replace(",", s)))
    .flatmap(lambda t: t)
)
def test_damaged_tables(text):
    refused_or_read(parse_trace, text, "damaged.txt")


@settings(max_examples=300)
@given(st.text(st.sampled_from(WORST_LETTERS), max_size=100))
def test_any_table(text):
    refused_or_read(parse_trace, "CA,p\n" + text, "any.txt")


@settings(max_examples=300)
@given(st.text(st.sampled_from("0123456789:,.eE-+ nif_"), max_size=20))
def test_any_speeds(text):
    refused_or_read(parse_speeds, text)


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 5_000_000 + "]" * 5_000_000,
        "[" + "a." * 1_000_000 + "a]",
        "a" + ".a" * 1_000_000 + " = 1",
        "x = " + "{a = " * 100_000 + "1" + "}" * 100_000,
        STUDY + "[output]\ndirectory = 'a'\nx = 1" + "0" * 5000,
        STUDY.replace("94.0", "1" + "0" * 400),
        STUDY.replace("94.0", "0x" + "f" * 9000),
        STUDY.replace("94.0", "inf"),
        STUDY.replace('"leon-2001"\n[speed]', '"a\\u0000.csv"\n[speed]'),
        STUDY.replace('"leon-2001"\n[speed]', '"' + "a" * 9000 + '.csv"\n[speed]'),
        STUDY + "[output]\ndirectory = 'a\\u0000'\n".replace("'", '"'),
        STUDY + '"\\u001b[31m' + "z" * 1_000_000 + '" = 1\n',
        STUDY.replace('preset = "leon-2001"', 'step = "a\\u0000.step"'),
    ],
    ids=lambda text: text[:12] + text[-12:],
)
def test_hostile_studies_are_refused_at_once(text, tmp_path):
    with pytest.raises(InvalidValue) as refused:
        parse_study(text, "hostile", tmp_path)
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize(
    "text",
    [
        "crank_deg,pressure_bar\n0," + "1" * 200_000,
        "",
        "\0",
        '"crank_deg,pressure_bar\n0,1',
        TRACE.replace("180", "360"),
        TRACE.replace("20.5", "nan"),
        TRACE.replace("800rpm", "9" * 400 + "rpm"),
        TRACE.replace("20.5", "1e308"),
    ],
    ids=lambda text: text[:20],
)
def test_hostile_traces_are_refused(text):
    with pytest.raises(InvalidValue):
        parse_trace(text, "hostile.csv")


def test_what_ships_is_still_read():
    assert len(shipped_studies()) >= 4
    assert refused_or_read(parse_study, STUDY, "plain", Path.cwd())
    assert refused_or_read(parse_trace, TRACE, "plain.csv")
