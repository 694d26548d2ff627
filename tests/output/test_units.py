"""What a reader is shown in US units is what is computed; without them nothing changes."""

import re
from io import StringIO

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from written_figures import load, result, summary

from fea.analysis.forces import study_forces
from fea.base.choices import UnitSystem
from fea.output.pictures.shown import field_of
from fea.output.plots import forces as plots
from fea.output.plots.chart import chart
from fea.output.report.sections import input_tables
from fea.output.tables import case_table, load_table
from fea.output.terminal.run import print_runs
from fea.output.units import (
    _US,
    Verbatim,
    in_heading,
    in_text,
    in_unit,
    scale,
    shown_in,
    study_value,
    unit,
)
from fea.study.study import load_study

# Exact by definition (NIST SP 811, appendix B); 1 hp = 550 ft·lbf/s.
KNOWN = {
    "mm": 1 / 25.4, "kg": 1 / 0.45359237, "kN": 1e3 / (0.45359237 * 9.80665),
    "MPa": 1e3 * 0.0254**2 / (0.45359237 * 9.80665), "N·m": 1 / (0.3048 * 0.45359237 * 9.80665),
    "kW": 1e3 / (550 * 0.3048 * 0.45359237 * 9.80665), "m/s": 1 / 0.3048,
    "kg/m³": 0.0254**3 / 0.45359237, "kg·m²": 1 / (0.45359237 * 0.0254**2),
}  # fmt: skip
SI_LEFT = re.compile(rf"(?<![\w/])({'|'.join(map(re.escape, _US))})(?![\w/²³⁴·])")


@pytest.fixture
def us():
    with shown_in(UnitSystem.US):
        yield


@pytest.mark.parametrize("name", KNOWN)
def test_factors_are_those_of_the_definitions(us, name):
    assert scale(name) == pytest.approx(KNOWN[name], rel=1e-9)


@pytest.mark.usefixtures("us")
@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("(now 620 MPa)", "(now 89.9 ksi)"),
        ("at (100.4, 0.0, −2.5) mm, tension", "at (3.95, 0.00, −0.10) in, tension"),
        ("x, y, z = 100.4, 0.0, -2.5 mm", "x, y, z = 3.95, 0.00, -0.10 in"),
        ("22416 elements (p2, 10.1 mm, refined)", "22416 elements (p2, 0.398 in, refined)"),
        ("bushing 7–14 MPa, 12 %", "bushing 1.0–2.0 ksi, 12 %"),
        ("between 3 and 7.5 mm", "between 0.12 and 0.295 in"),
        ("207 GPa, 7700 kg/m³", "30.0 Mpsi, 0.27818 lb/in³"),
        ("up to 63 ± 42 bar (0.5 bar of boost)", "up to 910 ± 610 psi (7 psi of boost)"),
        ("733.5 MPa ± 2.1 %, 0.85 ± 0.02", "106.39 ksi ± 2.1 %, 0.85 ± 0.02"),
        ("relief [15, 0.02] mm, +80 K, 11.5e-6/K", "relief [0.59, 0.0008] in, +144 °F, 6.39e-06/°F"),
        ("20.0 °C", "68.0 °F"),
        ("factor 0.85, 120 mm", "factor 0.85, 4.72 in"),
        ("0.0144 mm (contact.clearance_mm)", "0.000567 in (contact.clearance_mm)"),
        ("12,345 N", "2,775.3 lbf"),
        ("2.1e-05 mm", "8.3e-07 in"),
        ("M9x1, 42.0 kN at 6000 rpm", "M9x1, 9440 lbf at 6000 rpm"),
        ("size_mm = 3", "size_mm = 3"),
        ("yield_MPa, 5 % of cosine-180", "yield_MPa, 5 % of cosine-180"),
    ],
)
def test_sentences_are_converted_to_the_digits_that_they_have(said, shown):
    assert in_text(said) == shown
    assert in_text(Verbatim(said)) == said


@given(st.sampled_from(sorted(_US)), st.floats(-1e6, 1e6), st.integers(0, 4))
def test_a_converted_figure_is_within_its_resolution(name, value, decimals):
    text = f"{value:.{decimals}f} {name}"
    assert in_text(text) == text
    with shown_in(UnitSystem.US):
        number, _, shown = in_text(text).partition(" ")
        assert shown == unit(name)
        assert float(number) == pytest.approx(in_unit(value, name), abs=10**-decimals * scale(name) * 1.01)
        assert in_heading(f"a, {name}") == f"a, {shown}"


def test_tables_and_terminal_are_without_si_units(tmp_path, us):
    loads = {"tension": load(crank_deg=4.0, pin_axial_N=31512.0, crank_axial_N=48100.0, wall_N=-212.0)}
    one = result(max_von_mises_MPa=312.04, at_mm=(25.4, -0.0, 7.5), max_displacement_mm=0.10912)
    found = summary(loads=loads, results={"tension": one}, files=("tension.vtu",))
    console = Console(file=StringIO(), width=100)
    print_runs([(tmp_path, found)], console, verbose=True)
    said = console.file.getvalue()
    assert "+7080" in said
    assert "45.26" in said
    assert "1.00, 0.00, 0.30" in said
    assert "0.00430" in said
    for table in (case_table(found), load_table(found)):
        assert not any(SI_LEFT.search(text) for text in table.head)
    assert not SI_LEFT.search(said.replace(str(tmp_path), ""))
    assert case_table(found).rows[0][2] == "45.26"


def test_fields_curves_and_inputs_are_converted(us):
    stress = field_of("von_mises")
    assert (stress.label, stress.extreme(45.257)) == ("von Mises stress, ksi", "max 45.26 ksi")
    assert stress.values({"von_mises": np.array([689.4757])}) == pytest.approx(100.0)
    angles = np.arange(721.0)
    drawn = chart(("id", "Force", "kN"), angles, {"": np.sin(np.radians(angles))}, {})
    assert drawn.unit == "lbf"
    assert max(drawn.series[0]) == pytest.approx(224.8, rel=1e-3)
    rod = next(table for table in input_tables(load_study()) if table.caption == "Rod")
    length = next(row for row in rod.rows if row[0] == "length")
    assert length[1:3] == ("5.55118", "in")


@pytest.mark.parametrize("system", UnitSystem)
def test_plotted_forces_are_those_of_the_table_in_the_unit_of_the_axis(monkeypatch, system, tmp_path):
    """Each panel draws its column (SI) times the factor of the unit that stands at its axis."""
    figures = []
    monkeypatch.setattr(plots, "save", lambda figure, *_: figures.append(figure))
    (report,) = study_forces(load_study("leon-2001"), every_cylinder=False)
    with shown_in(system):
        plots.plot_forces(tmp_path / "forces.png", [report], "leon-2001")
    axes = [panel for panel in figures[0].axes if panel.lines]
    assert len(axes) == 8
    force = KNOWN["kN"] if system is UnitSystem.US else 1.0
    torque = KNOWN["N·m"] if system is UnitSystem.US else 1.0
    for number, column, factor in ((0, "gas_N", 1e-3 * force), (6, "torque_Nm", torque)):
        drawn = max(
            np.abs(line.get_ydata()).max() for line in axes[number].lines if len(line.get_ydata()) > 2
        )
        assert drawn == pytest.approx(np.abs(report.first[column]).max() * factor, rel=1e-9)


# Of units as they are shown, and as `pint` reads them.
PLAIN = {"·": "*", " gauge": "", " m²": "*m²", "²": "**2", "³": "**3", "⁴": "**4"}


def test_what_is_shown_is_as_large_as_pint_says(us):
    registry = pint.UnitRegistry()
    for name, shown in _US.items():
        if "K" in name or "°" in name:
            continue
        own, other = name, shown.name
        for written, plain in PLAIN.items():
            own, other = own.replace(written, plain), other.replace(written, plain)
        expected = registry.Quantity(1.0, own).to(other).magnitude
        assert scale(name) == pytest.approx(expected, rel=1e-12), name


def test_temperatures_and_their_differences(us):
    assert [in_unit(value, "°C") for value in (0.0, 100.0)] == pytest.approx([32.0, 212.0], rel=1e-12)
    assert (scale("K"), scale("1/K"), scale("/K")) == pytest.approx((1.8, 1 / 1.8, 1 / 1.8), rel=1e-12)


def test_values_of_a_study_in_words_and_units(us):
    assert [study_value(value, "") for value in (True, False, None)] == ["yes", "no", "–"]
    assert study_value([25.4, 50.8], "mm") == "1, 2"
