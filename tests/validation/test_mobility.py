"""The Mobility method of a short bearing, with which films are compared, against its film's integrals."""

import math

import numpy as np
import pytest

from fea.film.constitutive import Oil
from fea.film.cycle import FilmCycle, JournalLoads
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing
from fea.film.reynolds import Reynolds
from fea.verify.cases.film import _by_mobility, _mobility

RADIUS, CLEARANCE, VISCOSITY, OMEGA, RATIO = 25.0, 0.025, 1e-8, 300.0, 0.1


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.8, 0.0), (-0.5, 0.0), (0.3, 0.4), (0.7, 0.5), (-0.4, 0.7)])
def test_mobility_gives_the_load_back(place):
    """∫ p dz = μ L³ (v·n)₊/h³ of a squeezed short film: its resultant is the load that moves it so."""
    along, across = place
    angle = np.linspace(-math.pi, math.pi, 4000, endpoint=False)
    normal = np.stack([np.cos(angle), np.sin(angle)])
    speed = np.array(_mobility(across, along, RATIO)) * 2 * RATIO**2  # under the load μ L³ R/C², over C
    pressing = np.maximum(speed @ normal, 0) / (1 - np.array(place) @ normal) ** 3
    load = 2 * math.pi * (pressing * normal).mean(axis=1)
    # It is a fit: 2 % where it matters, 10 % far from the load's own direction.
    assert load == pytest.approx([1.0, 0.0], abs=0.1)


@pytest.mark.parametrize("turning", [0.0, 0.25, -0.25])
def test_a_steady_load_and_one_that_turns_have_the_eccentricity_of_ocvirk(turning):
    """Ocvirk 1952 in closed form; a load that turns by λ acts as a journal that is slower by 2 λ."""
    eccentricity, steps = 0.6, 48
    width, square = RATIO * 2 * RADIUS, 1 - eccentricity**2
    slower = VISCOSITY * (1 - 2 * turning) * OMEGA * RADIUS * width**3 / (4 * CLEARANCE**2)
    load = slower * eccentricity / square**2 * math.hypot(4 * eccentricity, math.pi * math.sqrt(square))
    angle = math.copysign(2 * math.pi, turning) * np.arange(steps) / steps * bool(turning)
    acting = JournalLoads(
        period=2 * math.pi / (abs(turning or 0.25) * OMEGA),
        load=load * np.stack([np.cos(angle), np.sin(angle)], axis=1),
        speed=np.full(steps, OMEGA * RADIUS),
        inlet=0.1,
    )
    bearing = Bearing(Reynolds(FilmGrid(RADIUS, width, 16, 4), Oil(VISCOSITY)), CLEARANCE)
    thinnest = _by_mobility(FilmCycle(bearing, acting, (), 0.0))
    assert 1 - thinnest / CLEARANCE == pytest.approx(eccentricity, rel=0.03)
