"""A pin model is one file and one line of the registry: everything else asks the model itself."""

import numpy as np
import pytest
from studies import plain_study

from fea import run
from fea.apps.result import analyse
from fea.pins.model import PinModel
from fea.study import pin_models
from fea.study.pin_models import PIN_MODELS, PinModelEntry, pin_model
from geometry.errors import InvalidValue

pytestmark = pytest.mark.usefixtures("coarse_bores")


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


def test_an_unknown_model_is_refused_with_the_names_of_all(registered):
    with pytest.raises(InvalidValue, match=r"cosine-180, .*, bonded, contact, oil-film or even"):
        pin_model("glued")
    with pytest.raises(InvalidValue, match="between 1 and 180"):
        pin_model("cosine-200")


@pytest.mark.parametrize("entry", PIN_MODELS, ids=lambda entry: entry.implementation)
def test_every_line_names_a_pin_model(entry):
    assert issubclass(entry.load(), PinModel)
