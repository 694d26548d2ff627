"""A bowed column that yields, against Perry, Euler, squash and the exact interaction of a rectangle."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from fea.judge.bent_column import Fibres, bent_column
from fea.judge.column import Plane

E, STRENGTH, WIDTH, HEIGHT = 207e3, 600.0, 20.0, 12.0
AREA, SECOND = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
COUNT, FIBRES = 48, 60


def rectangle(plane, slenderness, bow=1e-3):
    """A column of rectangular section; the bow over its length."""
    length = slenderness * HEIGHT / math.sqrt(12) / plane.length_factor
    at = (np.arange(FIBRES) + 0.5) / FIBRES * HEIGHT - HEIGHT / 2
    at *= math.sqrt(SECOND / (AREA / FIBRES * (at**2).sum()))  # with the exact second moment
    fibres = Fibres(
        np.tile(at, (COUNT, 1)), np.full((COUNT, FIBRES), AREA / FIBRES), np.full(COUNT, HEIGHT / 2)
    )
    ends, bearing = np.linspace(0, length, COUNT + 1), np.ones(COUNT, dtype=bool)
    law = {"youngs_modulus": E, "yield_strength": STRENGTH, "bow": bow * length}
    return length, bent_column(plane, ends, fibres, bearing, **law)


@pytest.mark.parametrize("plane", list(Plane))
@pytest.mark.parametrize("slenderness", [15.0, 40.0, 60.0, 100.0, 200.0])
def test_the_limit_lies_between_perry_and_the_lesser_of_euler_and_squash(plane, slenderness):
    length, found = rectangle(plane, slenderness)
    euler = math.pi**2 * E * SECOND / (length * plane.length_factor) ** 2
    assert found.euler == pytest.approx(euler, rel=1e-3)
    assert found.squash == pytest.approx(STRENGTH * AREA, rel=1e-9)
    # Perry's formula with the bow of the part between two points of inflection. Built in at both ends, the
    # mode 1 − cos departs from the line between these by half of its amplitude.
    bow = found.bow * (1.0 if plane is Plane.IN_PLANE else 0.5)

    def stress(load):
        return load / AREA + load * bow * HEIGHT / 2 / (SECOND * (1 - load / euler))

    perry = brentq(lambda load: stress(load) - STRENGTH, 0, min(euler * (1 - 1e-9), STRENGTH * AREA))
    assert found.perry == pytest.approx(perry, rel=2e-3)
    assert found.perry <= found.limit <= min(found.euler, found.squash)


def test_a_short_column_fails_where_its_section_is_fully_plastic():
    # M = M_p (1 − (P/P_s)²) of a rectangle, with M_p = σ_y b h²/4 and hardly any deflection.
    _, found = rectangle(Plane.IN_PLANE, 2.0, bow=1.0)
    squash, plastic = STRENGTH * AREA, STRENGTH * WIDTH * HEIGHT**2 / 4
    load = brentq(lambda load: plastic * (1 - (load / squash) ** 2) - load * found.bow, 0, squash)
    assert found.limit == pytest.approx(load, rel=0.01)
    assert found.limit < load


def curvature(moment, load):
    """Curvature of a rectangle of perfectly plastic fibres under a moment and a compressive force."""
    force, elastic = load / (STRENGTH * AREA), moment / (STRENGTH * WIDTH * HEIGHT**2 / 6)
    yielding = 2 * STRENGTH / (E * HEIGHT)
    if elastic <= 1 - force:
        return yielding * elastic
    if elastic <= (1 - force) * (1 + 2 * force):  # one side yields (Chen & Atsuta 1976)
        return yielding * 4 * (1 - force) ** 3 / (3 - 3 * force - elastic) ** 2
    return yielding / math.sqrt(max(3 * (1 - force**2) - 2 * elastic, 1e-9))


@pytest.mark.parametrize("slenderness", [30.0, 60.0, 90.0])
def test_the_limit_is_a_little_below_that_of_the_exact_deflection(slenderness):
    length, found = rectangle(Plane.IN_PLANE, slenderness)

    def load_at(middle):
        """Load at which a column that deflects by so much in the middle meets its supports."""

        def missed(load):
            def slope(x, state):
                bow = found.bow * math.cos(math.pi * x / length)
                return [state[1], -curvature(load * max(state[0] + bow, 0.0), load)]

            return solve_ivp(slope, (0, length / 2), [middle, 0.0], rtol=1e-6, atol=1e-9).y[0, -1]

        most = 0.999 * min(found.euler, found.squash)
        return brentq(missed, 0.5 * found.limit, most, xtol=1.0) if missed(most) < 0 else most

    first = found.deflection[found.load.argmax()]
    best = minimize_scalar(lambda middle: -load_at(middle), bounds=(first / 3, 3 * first), method="bounded")
    exact = -best.fun
    # The elastic mode is stiffer than the deflection that yielding makes, by up to 2 % of the load.
    assert 0.97 * exact < found.limit <= exact * 1.0005
