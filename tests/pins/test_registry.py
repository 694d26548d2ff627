"""A pin model is one file and one entry of the registry: everything else asks the model itself.

A further pressure over an arc is one line of `loads.bearing.PROFILES`.
"""

import numpy as np
import pytest
from studies import plain_study
from toy_pins import EvenPins

from fea import analyse, run
from fea.output.report.scene import pressure_kind
from fea.pins.model import PinModel
from fea.study import pin_models
from fea.study.pin_models import PIN_MODELS, PinModelEntry, pin_model
from geometry.errors import InvalidValue
from loads import bearing

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]


@pytest.fixture
def registered(monkeypatch):
    """The registry with one more line."""
    line = PinModelEntry("even", "toy_pins:EvenPins", assumption="The traction is the same everywhere.")
    monkeypatch.setattr(pin_models, "PIN_MODELS", (*PIN_MODELS, line))


@pytest.mark.parametrize("symmetry", ["quarter", "half"])
def test_a_registered_model_loads_cases_and_the_whole_cycle(registered, symmetry):
    """On plain bores, an even traction is that of a bonded pin."""
    asked = {"size": 20, "cycle": True, "symmetry": symmetry}
    even, bonded = (analyse(plain_study(), pressure=name, **asked) for name in ("even", "bonded"))
    assert even.trusted
    assert even.summary.model.pressure == "even"
    for name, case in bonded.cases.items():
        # An oil hole or a facet moves the centroid of a bore, which a bonded pin allows for.
        assert np.abs(even.cases[name].stress - case.stress).max() < 1e-6 * np.abs(case.stress).max()
    one, other = (found.summary.envelope.min_safety_factor for found in (even, bonded))
    assert one == pytest.approx(other, rel=1e-6)


def test_a_report_tells_what_a_registered_model_assumes(registered, tmp_path):
    run(plain_study(), pressure="even", size=20, report=True, out=tmp_path / "run")
    assert "The traction is the same everywhere." in (tmp_path / "run" / "report.html").read_text("utf-8")


@pytest.fixture
def parabola(monkeypatch):
    """A further pressure profile."""
    profile = bearing.PressureProfile("a parabola of pressure", lambda t: 1 - t**2)
    monkeypatch.setitem(bearing.PROFILES, "parabola", profile)
    pressed = PIN_MODELS[0]._replace(pattern=r"parabola-\d+")
    monkeypatch.setattr(pin_models, "PIN_MODELS", (*PIN_MODELS, pressed))


def test_a_further_profile_loads_cases_and_the_whole_cycle(parabola, tmp_path):
    """Superposed stress agrees with that of the cases, as the series of a continuous pressure does."""
    run(plain_study(), pressure="parabola-160", size=20, report=True, out=tmp_path / "run")
    found = analyse(plain_study(), pressure="parabola-160", size=20, cycle=True, symmetry="half")
    assert found.trusted
    assert found.cycle.superposition < 0.01
    assert "a parabola of pressure over 160°" in (tmp_path / "run" / "report.html").read_text("utf-8")
    shares = pressure_kind("parabola-160")["tension"]["shares"]
    assert shares == pytest.approx([1 - (k / 16) ** 2 for k in range(17)], abs=1e-4)


def test_every_profile_is_a_pin_model():
    for name in bearing.PROFILES:
        assert pin_model(f"{name}-90").arcs(f"{name}-90").tension.profile is bearing.PROFILES[name]


class OneSided(EvenPins):
    """A load in proportion to the force that is not linear in its components."""

    def load(self, bore, force):
        return super().load(bore, (abs(force[0]), force[1]))


def test_a_load_that_is_not_linear_needs_a_span_of_its_own(monkeypatch):
    line = PinModelEntry("one-sided", f"{__name__}:OneSided")
    monkeypatch.setattr(pin_models, "PIN_MODELS", (*PIN_MODELS, line))
    with pytest.raises(TypeError, match=r"OneSided\.load is not linear .* a span of its own"):
        analyse(plain_study(), pressure="one-sided", size=20, cycle=True)


def test_an_unknown_model_is_refused_with_the_names_of_all(registered):
    with pytest.raises(InvalidValue, match=r"cosine-180, .*, bonded, contact, oil-film or even"):
        pin_model("glued")
    with pytest.raises(InvalidValue, match="between 1 and 180"):
        pin_model("cosine-200")


@pytest.mark.parametrize("entry", PIN_MODELS, ids=lambda entry: entry.implementation)
def test_every_line_names_a_pin_model(entry):
    assert issubclass(entry.load(), PinModel)
