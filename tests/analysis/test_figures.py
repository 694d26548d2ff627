"""Figures for JSON follow from the types of the domain, in the units that their names say."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fea.analysis.figures import Figures, WhereKnown, figures


class Some(Figures):
    length_mm: float
    turn_deg: float
    mass_kg: float
    open_percent: float
    at_mm: tuple[float, ...]
    factor: float | None
    name: WhereKnown[str] = None


THING = SimpleNamespace(
    length=2.0, turn=math.pi, mass=0.5e-3, open_share=0.3, at=np.array([1.0, 2.0]), factor=math.nan, name="?"
)


def test_units_follow_from_names():
    found = figures(Some, THING)
    assert (found.length_mm, found.turn_deg, found.mass_kg) == (2.0, 180.0, 0.5)
    assert found.open_percent == 100 * THING.open_share
    assert found.at_mm == (1.0, 2.0)
    assert found.factor is None  # not a number: it does not apply
    assert found.name is None  # left out unless it is given


def test_what_is_given_is_taken_as_it_is():
    found = figures(Some, THING, length_mm=3.0, name="bore")
    assert (found.length_mm, found.name) == (3.0, "bore")


def test_what_rounding_leaves_of_nothing_is_nothing():
    found = figures(Some, THING, length_mm=-2.6e-15, turn_deg=1e-10)
    assert (found.length_mm, found.turn_deg) == (0.0, 1e-10)


def test_a_figure_without_a_source_is_an_error():
    with pytest.raises(AttributeError, match="mass"):
        figures(Some, SimpleNamespace(length=1.0, turn=0.0))
